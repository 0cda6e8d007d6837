//! Follows pixels and regions through the frames.

use super::Worker;
use crate::replay::published::ShownFrame;
use crate::replay::tasks::gather::frame_consumer;
use crate::source::SourceError;

impl Worker<'_> {
    /// Chooses the pixel to follow; `None`, or a pixel outside the image, chooses none.
    pub(super) fn inspect(&mut self, pixel: Option<(u32, u32)>) {
        self.pixel = pixel.filter(|&(x, y)| self.info.size.index(x, y).is_some());
        self.pass.inspect(self.pixel);
        if let Some(pass) = &mut self.compared.pass {
            pass.inspect(self.pixel);
        }
        self.show_pixel();
    }

    /// Chooses the pinned pixels, without those outside the image.
    pub(super) fn pin(&mut self, mut pixels: Vec<(u32, u32)>) {
        pixels.retain(|&(x, y)| self.info.size.index(x, y).is_some());
        self.pins.choose(&pixels, self.pass.settings(), &self.info);
        self.outbox.pixel_grew = true;
    }

    /// Follows the chosen pixel through the known frames; returns whether there was work to do.
    pub(super) fn follow_pixel(&mut self) -> Result<bool, SourceError> {
        if frame_consumer::feed_frames(&mut self.pass.pixel_follower, &mut self.frames)? {
            self.outbox.pixel_grew = true;
            if let Some(shown) = &self.view.shown
                && shown.pixel.as_ref().map(|history| history.at) != self.pixel
            {
                self.show_pixel();
            }
            return Ok(true);
        }
        let Some(pass) = &mut self.compared.pass else { return Ok(false) };
        let worked = pass.pixel_follower.copy_colours_from(&self.pass.pixel_follower)
            || frame_consumer::feed_frames(&mut pass.pixel_follower, &mut self.frames)?;
        if let Some(shown) =
            self.view.shown.clone().filter(|_| worked && self.compared.needs_pixel(self.pixel))
        {
            self.show(ShownFrame::clone(&shown));
        }
        Ok(worked)
    }

    /// Follows the pinned pixels through the known frames, counts the foreground around the chosen one, and collects
    /// the colours there; returns whether there was work to do.
    pub(super) fn follow_pins(&mut self) -> Result<bool, SourceError> {
        let model = &self.pass.model;
        let worked = frame_consumer::feed_frames(&mut self.pins, &mut self.frames)?
            || self.region.count(model.record(), model.analysed(), self.info.size);
        self.outbox.pixel_grew |= worked;
        Ok(worked || frame_consumer::feed_frames(&mut self.region_tuner, &mut self.frames)?)
    }
}
