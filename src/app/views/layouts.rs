//! Layouts of the views, and the set of open views.

use std::collections::HashSet;

use eframe::egui::Id;
use egui_tiles::{Container, Linear, LinearDir, Tile, TileId, Tiles, Tree};

use crate::app::model::layout::ViewLayout;
use crate::app::model::view::View;

/// Largest share of a view in the space of its row or column; one is usual.
const MAX_SHARE: f32 = 1e6;

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

/// A stored tree of views, if it can be shown: with each view, every tile in one place, and shares that can be summed.
pub(crate) fn restored(mut tree: Tree<View>) -> Option<Tree<View>> {
    let has_all = View::ALL.iter().all(|view| tree.tiles.find_pane(view).is_some());
    let containers = || {
        tree.tiles.tiles().filter_map(|tile| match tile {
            Tile::Container(container) => Some(container),
            Tile::Pane(_) => None,
        })
    };
    let mut children = HashSet::new();
    let is_tree = containers().flat_map(Container::children).all(|child| children.insert(*child));
    let is_share = |share: &f32| (0.0..=MAX_SHARE).contains(share);
    let can_be_divided = containers().all(|container| match container {
        Container::Tabs(_) => true,
        Container::Linear(linear) => linear.shares.iter().all(|(_, share)| is_share(share)),
        Container::Grid(grid) => grid.col_shares.iter().chain(&grid.row_shares).all(is_share),
    });
    if !(has_all && is_tree && can_be_divided) {
        return None;
    }
    // All of the space that there is.
    tree.set_width(f32::INFINITY);
    tree.set_height(f32::INFINITY);
    Some(tree)
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

    #[test]
    fn only_a_layout_that_can_be_shown_is_restored() {
        let restore = |change: &dyn Fn(&mut Linear)| {
            let mut tree = tree_of(ViewLayout::Compare);
            let root = tree.root.unwrap();
            if let Some(Tile::Container(Container::Linear(column))) = tree.tiles.get_mut(root) {
                change(column);
            }
            restored(tree)
        };
        assert!(restore(&|_| {}).is_some());
        for share in [f32::NAN, f32::INFINITY, f32::MAX, -1.0] {
            assert!(
                restore(&|column| column.shares.set_share(column.children[0], share)).is_none(),
                "{share}"
            );
        }
        assert!(restore(&|column| column.children.push(column.children[0])).is_none(), "a row twice");
        let mut tree = tree_of(ViewLayout::All);
        tree.tiles.remove(tree.tiles.find_pane(&View::Tracks).unwrap());
        assert!(restored(tree).is_none(), "no view of the tracks");
    }
}
