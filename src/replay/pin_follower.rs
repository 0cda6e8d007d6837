//! Pinned pixels through time, beside the chosen one.

use std::sync::Arc;

use super::gather::Follower;
use super::inspector::Inspector;
use crate::frame::Frame;
use crate::mixture::PixelHistory;
use crate::settings::Settings;
use crate::source::SourceInfo;

/// Follows several pixels. They go through the frames together, so that each frame is decoded once for all of them.
#[derive(Default)]
pub(super) struct Pins(Vec<((u32, u32), Inspector)>);

impl Pins {
    /// Follows these pixels and no others. Of those that were followed before, what was seen stays.
    pub(super) fn choose(&mut self, pixels: &[(u32, u32)], settings: &Settings, info: &SourceInfo) {
        let mut before = std::mem::take(&mut self.0);
        for &at in pixels {
            let known = before.iter().position(|(pixel, _)| *pixel == at);
            let inspector = known.map(|known| before.swap_remove(known).1).unwrap_or_default();
            self.0.push((at, inspector));
        }
        self.run_again(settings, info);
    }

    /// Takes what was seen through the mixture anew where its parameters are others.
    pub(super) fn run_again(&mut self, settings: &Settings, info: &SourceInfo) {
        for (at, inspector) in &mut self.0 {
            inspector.choose(Some(*at), settings, info);
        }
    }

    /// Forgets what was seen, as after another first frame.
    pub(super) fn forget(&mut self, settings: &Settings, info: &SourceInfo) {
        for (_, inspector) in &mut self.0 {
            *inspector = Inspector::default();
        }
        self.run_again(settings, info);
    }

    /// Those whose histories cannot be known.
    pub(super) fn lost(&self) -> impl Iterator<Item = (u32, u32)> {
        self.0.iter().filter_map(|(_, inspector)| inspector.lost())
    }

    /// Their histories, brought up to date; those that cannot be known are left out.
    pub(super) fn latest(&mut self) -> Vec<Arc<PixelHistory>> {
        self.0.iter_mut().filter_map(|(_, inspector)| inspector.latest()).collect()
    }
}

impl Follower for Pins {
    /// The first frame that some pixel lacks.
    fn next(&self) -> Option<u32> {
        self.0.iter().filter_map(|(_, inspector)| inspector.next()).min()
    }

    fn push(&mut self, position: u32, frame: &Frame) {
        for (_, inspector) in &mut self.0 {
            inspector.push(position, frame);
        }
    }

    fn end(&mut self) -> bool {
        self.0.iter_mut().fold(false, |news, (_, inspector)| inspector.end() || news)
    }

    fn lose(&mut self) {
        let lost = self.next();
        for (_, inspector) in self.0.iter_mut().filter(|(_, inspector)| inspector.next() == lost) {
            inspector.lose();
        }
    }
}
