//! Pinned pixels through time, beside the chosen one.

use std::sync::Arc;
use std::time::Instant;

use super::inspector::{Inspector, TURN};
use crate::frame::Frame;
use crate::mixture::PixelHistory;
use crate::settings::Settings;
use crate::source::SourceError;
use crate::source::cache::{Fetched, FrameCache, Keep};

/// Follows several pixels. They go through the frames together, so that each frame is decoded once for all of them.
#[derive(Default)]
pub(super) struct Pins(Vec<((u32, u32), Inspector)>);

impl Pins {
    /// Follows these pixels and no others. Of those that were followed before, what was seen stays.
    pub(super) fn choose(&mut self, pixels: &[(u32, u32)], settings: &Settings) {
        let mut before = std::mem::take(&mut self.0);
        for &at in pixels {
            let known = before.iter().position(|(pixel, _)| *pixel == at);
            let inspector = known.map(|known| before.swap_remove(known).1).unwrap_or_default();
            self.0.push((at, inspector));
        }
        self.run_again(settings);
    }

    /// Takes what was seen through the mixture anew where its parameters are others.
    pub(super) fn run_again(&mut self, settings: &Settings) {
        for (at, inspector) in &mut self.0 {
            inspector.choose(Some(*at), settings);
        }
    }

    /// Forgets what was seen, as after another first frame.
    pub(super) fn forget(&mut self, settings: &Settings) {
        for (_, inspector) in &mut self.0 {
            *inspector = Inspector::default();
        }
        self.run_again(settings);
    }

    /// Takes in the frame at `position`, of each pixel for which it is the next.
    pub(super) fn push(&mut self, position: u32, frame: &Frame) {
        for (_, inspector) in &mut self.0 {
            inspector.push(position, frame);
        }
    }

    /// Takes in frames that were decoded before, for a short while; whether there was anything to do.
    pub(super) fn gather(&mut self, frames: &mut FrameCache) -> Result<bool, SourceError> {
        let started = Instant::now();
        let mut worked = false;
        let end = frames.numbers().len() as u32;
        while let Some(next) = self.next().filter(|&next| next < end) {
            worked = true;
            match frames.fetch(next, Keep::IfRoom)? {
                Fetched::Frame(frame) => self.push(next, &frame),
                Fetched::OnTheWay => {}
                // A camera's first frames are no longer there, and the mixture depends on all of them.
                Fetched::Gone | Fetched::End => {
                    for (_, inspector) in &mut self.0 {
                        if inspector.frames() == Some(next) {
                            *inspector = Inspector::default();
                        }
                    }
                }
            }
            if started.elapsed() > TURN {
                break;
            }
        }
        Ok(worked)
    }

    /// The first frame that some pixel lacks.
    fn next(&self) -> Option<u32> {
        self.0.iter().filter_map(|(_, inspector)| inspector.frames()).min()
    }

    /// Their histories, brought up to date; those that cannot be known are left out.
    pub(super) fn latest(&mut self) -> Vec<Arc<PixelHistory>> {
        self.0.iter_mut().filter_map(|(_, inspector)| inspector.latest()).collect()
    }
}
