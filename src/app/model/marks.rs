//! Marks in a video: start and end of playback, bookmarks, and pinned pixels.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::app::model::pins::Pins;

/// The marks: frames by position from 0, and pixels.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Marks {
    /// First position of playback.
    pub(crate) start: Option<u32>,
    /// Last position of playback, after which it restarts.
    pub(crate) end: Option<u32>,
    /// Bookmarked positions.
    pub(crate) bookmarks: BTreeSet<u32>,
    /// Pinned pixels.
    pub(crate) pins: Pins,
}

impl Marks {
    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Sets the start of playback, or clears it if it is already here.
    pub(crate) fn toggle_start(&mut self, position: u32) {
        self.start = if self.start == Some(position) { None } else { Some(position) };
        self.end = self.end.filter(|&end| end > position);
    }

    /// Sets the end of playback, or clears it if it is already here.
    pub(crate) fn toggle_end(&mut self, position: u32) {
        self.end = if self.end == Some(position) { None } else { Some(position) };
        self.start = self.start.filter(|&start| start < position);
    }

    /// Adds or removes a bookmark.
    pub(crate) fn toggle_bookmark(&mut self, position: u32) {
        if !self.bookmarks.remove(&position) {
            self.bookmarks.insert(position);
        }
    }

    /// The next bookmark after a position, or the one before it.
    pub(crate) fn adjacent_bookmark(&self, position: u32, forward: bool) -> Option<u32> {
        if forward {
            self.bookmarks.range(position.saturating_add(1)..).next().copied()
        } else {
            self.bookmarks.range(..position).next_back().copied()
        }
    }

    /// The position at which playback restarts once the end is reached; `None` before the end, or without a playback
    /// range.
    pub(crate) fn loop_restart(&self, position: u32, last: bool) -> Option<u32> {
        let over = self.end.is_some_and(|end| position >= end) || (last && self.start.is_some());
        over.then(|| self.start.unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_playback_range_never_ends_before_it_starts() {
        let mut marks = Marks::default();
        marks.toggle_start(10);
        marks.toggle_end(30);
        assert_eq!((marks.start, marks.end), (Some(10), Some(30)));
        assert_eq!([20, 30, 35].map(|at| marks.loop_restart(at, false)), [None, Some(10), Some(10)]);
        marks.toggle_start(40);
        assert_eq!((marks.start, marks.end), (Some(40), None));
        assert_eq!((marks.loop_restart(50, false), marks.loop_restart(50, true)), (None, Some(40)));
        marks.toggle_end(5);
        assert_eq!((marks.start, marks.end, marks.loop_restart(6, false)), (None, Some(5), Some(0)));
        marks.toggle_end(5);
        assert!(marks.is_empty() && marks.loop_restart(50, true).is_none());
    }

    #[test]
    fn bookmarks_are_visited_in_order() {
        let mut marks = Marks::default();
        for position in [30, 10, 20, 10] {
            marks.toggle_bookmark(position);
        }
        assert_eq!([0, 20, 30].map(|at| marks.adjacent_bookmark(at, true)), [Some(20), Some(30), None]);
        assert_eq!([0, 20, 31].map(|at| marks.adjacent_bookmark(at, false)), [None, None, Some(30)]);
    }
}
