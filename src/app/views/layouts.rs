//! Layouts of the views, and the set of open views.

use eframe::egui::Id;
use egui_tiles::{Container, Linear, LinearDir, Tile, TileId, Tiles, Tree};

use crate::app::model::layout::ViewLayout;
use crate::app::model::view::View;

/// The tree of a layout's views.
pub(crate) fn tree_of(layout: ViewLayout) -> Tree<View> {
    let mut tiles = Tiles::default();
    let mut shares = Vec::new();
    let rows: Vec<TileId> = layout
        .rows()
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
    // Without compared settings, ground truth or external results these views are empty.
    for view in View::ALL {
        if !(view.is_open_at_first() || view.compares() && layout == ViewLayout::Compare) {
            set_open(&mut tree, view, false);
        }
    }
    tree
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
        for layout in [
            ViewLayout::All,
            ViewLayout::Figure,
            ViewLayout::Tuning,
            ViewLayout::Compare,
            ViewLayout::Inspect,
        ] {
            let tree = tree_of(layout);
            let panes = tree.tiles.tiles().filter(|tile| matches!(tile, Tile::Pane(_))).count();
            assert_eq!(panes, View::ALL.len(), "{layout:?}");
            let expected =
                |view: View| view.is_open_at_first() || view.compares() && layout == ViewLayout::Compare;
            assert!(View::ALL.iter().all(|&view| is_open(&tree, view) == expected(view)), "{layout:?}");
        }
    }

    #[test]
    fn a_reopened_view_is_the_active_tab() {
        let mut tree = tree_of(ViewLayout::All);
        set_open(&mut tree, View::Difference, false);
        assert!(!is_open(&tree, View::Difference) && is_open(&tree, View::Background));
        set_open(&mut tree, View::Difference, true);
        let tile = tree.tiles.find_pane(&View::Difference).unwrap();
        assert!(tree.active_tiles().contains(&tile), "the background's tab was active");
    }
}
