//! Layouts of the views, and the set of open views.

use eframe::egui::Id;
use egui_tiles::{Container, Linear, LinearDir, Tile, TileId, Tiles, Tree};

use super::View;

/// A layout for a purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Layout {
    /// All views: the initial layout.
    All,
    /// Six images of equal size without panels.
    Figure,
    /// Settings beside the views that they affect.
    Tuning,
    /// The results of two sets of settings on the same frame.
    Compare,
    /// One large image beside the pixel inspector.
    Inspect,
}

impl Layout {
    /// Whether the settings panel and the inspector panel are open.
    pub(crate) const fn panels(self) -> (bool, bool) {
        match self {
            Self::All => (true, true),
            Self::Figure => (false, false),
            Self::Tuning | Self::Compare => (true, false),
            Self::Inspect => (false, true),
        }
    }

    /// The tree of views. It contains each view once, some as background tabs.
    pub(crate) fn tree(self) -> Tree<View> {
        use View::{
            Agreement, Background, ComparedBackground, ComparedForeground, ComparedTracks, Difference,
            Foreground, Input, Map, MaskErrors, Regions, Tracks,
        };
        let rows: &[(f32, &[&[View]])] = match self {
            Self::All => &[
                (1.0, &[&[Input], &[Background, Difference, Map, ComparedBackground]]),
                (1.0, &[&[Foreground, ComparedForeground], &[Regions, MaskErrors, Agreement]]),
                (1.6, &[&[Tracks, ComparedTracks]]),
            ],
            Self::Figure => &[
                (
                    1.0,
                    &[&[Input], &[Background, ComparedBackground], &[Difference, Map, MaskErrors, Agreement]],
                ),
                (1.0, &[&[Foreground, ComparedForeground], &[Regions], &[Tracks, ComparedTracks]]),
            ],
            Self::Tuning => &[
                (
                    1.0,
                    &[
                        &[Input, Background, Difference, Map, ComparedBackground],
                        &[Foreground, MaskErrors, Regions, ComparedForeground, Agreement],
                    ],
                ),
                (1.0, &[&[Tracks, ComparedTracks]]),
            ],
            Self::Compare => &[
                (
                    1.0,
                    &[
                        &[Foreground, MaskErrors, Background, Regions],
                        &[Agreement, Input, Difference, Map],
                        &[ComparedForeground, ComparedBackground],
                    ],
                ),
                (1.0, &[&[Tracks], &[ComparedTracks]]),
            ],
            Self::Inspect => &[
                (1.6, &[&[Input, Tracks, ComparedTracks]]),
                (
                    1.0,
                    &[
                        &[Background, Difference, ComparedBackground],
                        &[Foreground, MaskErrors, Regions, ComparedForeground],
                        &[Map, Agreement],
                    ],
                ),
            ],
        };
        let mut tiles = Tiles::default();
        let mut shares = Vec::new();
        let rows: Vec<TileId> = rows
            .iter()
            .map(|(share, columns)| {
                let columns = columns.iter().map(|tabs| {
                    let panes = tabs.iter().map(|&view| tiles.insert_pane(view)).collect();
                    tiles.insert_tab_tile(panes)
                });
                let columns: Vec<TileId> = columns.collect();
                let row = match columns[..] {
                    [alone] => alone,
                    _ => tiles.insert_horizontal_tile(columns),
                };
                shares.push((row, *share));
                row
            })
            .collect();
        let mut column = Linear::new(LinearDir::Vertical, rows);
        for (row, share) in shares {
            column.shares.set_share(row, share);
        }
        let root = tiles.insert_container(Container::Linear(column));
        let mut tree = Tree::new(Id::unique("views"), root, tiles);
        // Without compared settings or ground truth these views are empty.
        for view in View::ALL {
            if !(view.is_there_at_first() || view.compares() && self == Self::Compare) {
                set_open(&mut tree, view, false);
            }
        }
        tree
    }
}

/// Whether a view is open, possibly as a background tab.
pub(crate) fn is_open(tree: &Tree<View>, view: View) -> bool {
    tree.tiles.find_pane(&view).is_some_and(|tile| tree.tiles.is_visible(tile))
}

/// Opens a view in its place as the active tab, or closes it and retains its place.
pub(crate) fn set_open(tree: &mut Tree<View>, view: View, open: bool) {
    let Some(tile) = tree.tiles.find_pane(&view) else { return };
    tree.tiles.set_visible(tile, open);
    if open {
        tree.make_active(|_, tile| matches!(tile, Tile::Pane(other) if *other == view));
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn every_layout_has_every_view_once() {
        for layout in [Layout::All, Layout::Figure, Layout::Tuning, Layout::Compare, Layout::Inspect] {
            let tree = layout.tree();
            let panes = tree.tiles.tiles().filter(|tile| matches!(tile, Tile::Pane(_))).count();
            assert_eq!(panes, View::ALL.len(), "{layout:?}");
            let expected =
                |view: View| view.is_there_at_first() || view.compares() && layout == Layout::Compare;
            assert!(View::ALL.iter().all(|&view| is_open(&tree, view) == expected(view)), "{layout:?}");
        }
    }

    #[test]
    fn a_reopened_view_is_the_active_tab() {
        let mut tree = Layout::All.tree();
        set_open(&mut tree, View::Difference, false);
        assert!(!is_open(&tree, View::Difference) && is_open(&tree, View::Background));
        set_open(&mut tree, View::Difference, true);
        let tile = tree.tiles.find_pane(&View::Difference).unwrap();
        assert!(tree.active_tiles().contains(&tile), "the background's tab was active");
    }
}
