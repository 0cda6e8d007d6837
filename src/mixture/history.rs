//! One pixel through many frames: what the inspector plots and `occluscope pixel` writes.

use super::pixel::{Outcome, Parameters, Pixel, Value};
use crate::frame::Frame;

/// A pixel's mixture after one frame's update, and what the update did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelState {
    /// The frame's number in its source.
    pub number: u32,
    /// t, the frame's place since the model started, from 1.
    pub t: u32,
    /// The pixel's colour in the frame.
    pub rgb: [u8; 3],
    /// X, the value that the model saw: three channels, or luma and two zeros.
    pub value: Value,
    /// The mixture after the update, in rank order.
    pub pixel: Pixel,
    /// What the update did.
    pub outcome: Outcome,
}

/// The states of one pixel, a state a frame from the model's start.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelHistory {
    /// The pixel: column and row.
    pub at: (u32, u32),
    /// The parameters under which the states came about.
    pub parameters: Parameters,
    /// One state a frame, in order.
    pub states: Vec<PixelState>,
}

impl PixelHistory {
    /// A history that starts with the next frame.
    pub fn new(at: (u32, u32), parameters: Parameters) -> Self {
        Self { at, parameters, states: Vec::new() }
    }

    /// The history of pixel `at` from its colours, `(frame number, colour)` in order.
    pub fn of_colours(
        at: (u32, u32),
        parameters: Parameters,
        colours: impl IntoIterator<Item = (u32, [u8; 3])>,
    ) -> Self {
        let mut history = Self::new(at, parameters);
        for (number, rgb) in colours {
            history.push_colour(number, rgb);
        }
        history
    }

    /// Takes one more frame in. A frame that does not hold the pixel is passed over.
    pub fn push(&mut self, frame: &Frame) {
        if let Some(rgb) = frame.pixel(self.at.0, self.at.1) {
            self.push_colour(frame.number, rgb);
        }
    }

    /// Takes one more colour in, that of frame `number`.
    pub fn push_colour(&mut self, number: u32, rgb: [u8; 3]) {
        let t = self.states.len() as u32 + 1;
        let value = self.parameters.value(rgb);
        let mut pixel =
            self.states.last().map_or_else(|| Pixel::unseen(self.parameters.k), |state| state.pixel);
        let outcome = pixel.update(value, t, &self.parameters);
        self.states.push(PixelState { number, t, rgb, value, pixel, outcome });
    }

    /// Whether it is a later `before` of the same pixel, under the same parameters and over the same frames.
    ///
    /// A state follows from all before it, so that the last one of `before` stands for them.
    pub fn goes_on_from(&self, before: &Self) -> bool {
        let last = before.states.len().checked_sub(1);
        (self.at, self.parameters) == (before.at, before.parameters)
            && last.is_none_or(|last| self.states.get(last) == before.states.last())
    }

    /// The mixture before the update of the state at `index`; `None` in the first frame.
    pub fn before(&self, index: usize) -> Option<&Pixel> {
        index.checked_sub(1).and_then(|previous| self.states.get(previous)).map(|state| &state.pixel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Preset, Settings};

    #[test]
    fn a_history_goes_on_from_an_earlier_one_of_the_same_frames_alone() {
        let of = |settings: &Settings, frames: std::ops::Range<u32>, level: u8| {
            let colours = frames.map(|n| (n, [if n == 7 { level } else { 90 }; 3]));
            PixelHistory::of_colours((3, 4), Parameters::new(settings), colours)
        };
        let settings = Settings::preset(Preset::Plain);
        let before = of(&settings, 1..20, 200);
        assert!(of(&settings, 1..50, 200).goes_on_from(&before));
        assert!(of(&settings, 1..20, 200).goes_on_from(&before));
        assert!(before.goes_on_from(&of(&settings, 1..1, 200)), "anything goes on from nothing");
        assert!(!of(&settings, 1..19, 200).goes_on_from(&before), "it is shorter");
        assert!(!of(&settings, 1..50, 210).goes_on_from(&before), "another value long ago");
        assert!(!of(&settings, 2..50, 200).goes_on_from(&before), "begun later");
        assert!(!of(&Settings { alpha: 0.2, ..settings.clone() }, 1..50, 200).goes_on_from(&before));
        assert!(!PixelHistory { at: (4, 4), ..of(&settings, 1..50, 200) }.goes_on_from(&before));
    }
}
