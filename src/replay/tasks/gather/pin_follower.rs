//! The histories of the pinned pixels.

use std::sync::Arc;

use crate::explain::pixel::PixelHistory;
use crate::frame::Frame;
use crate::replay::tasks::gather::frame_consumer::FrameConsumer;
use crate::replay::tasks::gather::pixel_follower::PixelFollower;
use crate::settings::Settings;
use crate::source::SourceInfo;

/// Follows several pixels. They consume frames together, so that each frame is decoded once.
#[derive(Default)]
pub(crate) struct PinFollower(Vec<((u32, u32), PixelFollower)>);

impl PinFollower {
    /// Chooses the pixels to follow. The colours of pixels that were followed before are kept.
    pub(crate) fn choose(&mut self, pixels: &[(u32, u32)], settings: &Settings, info: &SourceInfo) {
        let mut before = std::mem::take(&mut self.0);
        for &at in pixels {
            let known = before.iter().position(|(pixel, _)| *pixel == at);
            let pixel_follower = known.map(|known| before.swap_remove(known).1).unwrap_or_default();
            self.0.push((at, pixel_follower));
        }
        self.run_again(settings, info);
    }

    /// Runs the mixtures again if their parameters differ.
    pub(crate) fn run_again(&mut self, settings: &Settings, info: &SourceInfo) {
        for (at, pixel_follower) in &mut self.0 {
            pixel_follower.choose(Some(*at), settings, info);
        }
    }

    /// Drops all colours, after the sequence's first frame has changed.
    pub(crate) fn forget(&mut self, settings: &Settings, info: &SourceInfo) {
        for (_, pixel_follower) in &mut self.0 {
            *pixel_follower = PixelFollower::default();
        }
        self.run_again(settings, info);
    }

    /// The pixels whose histories are unavailable.
    pub(crate) fn lost(&self) -> impl Iterator<Item = (u32, u32)> {
        self.0.iter().filter_map(|(_, pixel_follower)| pixel_follower.lost())
    }

    /// The histories over all known frames, without those that are unavailable.
    pub(crate) fn latest(&mut self) -> Vec<Arc<PixelHistory>> {
        self.0.iter_mut().filter_map(|(_, pixel_follower)| pixel_follower.latest()).collect()
    }
}

impl FrameConsumer for PinFollower {
    /// The first frame that one of the pixels needs.
    fn next(&self) -> Option<u32> {
        self.0.iter().filter_map(|(_, pixel_follower)| pixel_follower.next()).min()
    }

    fn push(&mut self, position: u32, frame: &Frame) {
        for (_, pixel_follower) in &mut self.0 {
            pixel_follower.push(position, frame);
        }
    }

    fn end(&mut self) -> bool {
        self.0.iter_mut().fold(false, |news, (_, pixel_follower)| pixel_follower.end() || news)
    }

    fn lose(&mut self) {
        let lost = self.next();
        for (_, pixel_follower) in
            self.0.iter_mut().filter(|(_, pixel_follower)| pixel_follower.next() == lost)
        {
            pixel_follower.lose();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Size;
    use crate::replay::tests::info_of;

    #[test]
    fn a_pixel_that_stays_pinned_keeps_its_colours() {
        let size = Size::new(2, 1);
        let info = info_of(size);
        let settings = Settings::default();
        let mut pins = PinFollower::default();
        assert_eq!(pins.next(), None);
        pins.choose(&[(0, 0)], &settings, &info);
        for position in 0..3 {
            pins.push(position, &Frame::new(position + 1, size, vec![90; 6]));
        }
        assert_eq!(pins.next(), Some(3));
        pins.choose(&[(1, 0), (0, 0)], &settings, &info);
        assert_eq!(pins.next(), Some(0), "the new pixel needs all frames");
        pins.choose(&[(0, 0)], &settings, &info);
        assert_eq!(pins.next(), Some(3));
        pins.forget(&settings, &info);
        assert_eq!((pins.next(), pins.latest().len()), (Some(0), 1));
        pins.lose();
        assert_eq!(
            (pins.next(), pins.lost().collect::<Vec<_>>(), pins.latest().len()),
            (None, vec![(0, 0)], 0)
        );
    }
}
