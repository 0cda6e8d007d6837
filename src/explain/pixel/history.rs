//! The history of one pixel: the data that the inspector plots and `occluscope pixel` writes.

use std::sync::Arc;

use crate::frame::Frame;
use crate::mixture::pixel::{Outcome, Parameters, Pixel, PixelValue};
use crate::placement::Placement;
use crate::registration::{Applied, ObservedColour};
use crate::settings::Space;

/// A pixel's mixture after one frame's update, and the outcome of the update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelState {
    /// The frame's number in its source.
    pub number: u32,
    /// t, the number of frames that the model has seen, including this one and those that were learned from before
    /// the first.
    pub t: u32,
    /// The pixel's colour in the frame.
    pub rgb: [u8; 3],
    /// X, the mixture's input: three channels, or luma and two zeros.
    pub value: PixelValue,
    /// The mixture after the update, in rank order.
    pub pixel: Pixel,
    /// The outcome of the update.
    pub outcome: Outcome,
    /// Whether the frame shows the pixel: false where the pixel lies outside a frame that was corrected for shake, or
    /// is clipped by overexposure. Nothing is then learned, and colour and value are those of component 1.
    pub known: bool,
    /// The correction of the frame at this pixel.
    pub applied: Applied,
}

/// The state of one pixel after the frames that are only learned from.
#[derive(Clone, Debug, PartialEq)]
pub struct LearntState {
    values: Vec<PixelValue>,
    /// The mixture after the last of them.
    pixel: Pixel,
    /// The mixture with which classification starts.
    start: Pixel,
}

/// The states of one pixel, one per classified frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelHistory {
    /// The pixel of the frames: column and row.
    pub at: (u32, u32),
    /// Where the frames lie in the source's images, if they are not these images.
    pub placement: Option<Placement>,
    /// The parameters of the mixture.
    pub parameters: Parameters,
    /// The state before the first classified frame; `None` if no frames were learned from.
    pub learnt: Option<Arc<LearntState>>,
    /// One state per frame, in order.
    pub states: Vec<PixelState>,
}

impl PixelHistory {
    /// A history that starts with the next frame.
    pub fn new(at: (u32, u32), parameters: Parameters) -> Self {
        Self { at, placement: None, parameters, learnt: None, states: Vec::new() }
    }

    /// The pixel of the source's images, which is what users see.
    pub fn source_pixel(&self) -> (u32, u32) {
        self.placement.map_or(self.at, |placement| placement.source_pixel(self.at))
    }

    /// Learns from one frame before the first classified one. Ignores a frame that does not contain the pixel.
    pub fn learn(&mut self, frame: &Frame) {
        if let Some(seen) = self.parameters.registration.pixel(frame, self.at) {
            self.learn_seen([seen]);
        }
    }

    /// Learns from colours before the first classified frame.
    #[cfg(test)]
    pub(crate) fn learn_colours(&mut self, colours: impl IntoIterator<Item = [u8; 3]>) {
        self.learn_seen(
            colours.into_iter().map(|rgb| ObservedColour { colour: Some(rgb), applied: Applied::NOTHING }),
        );
    }

    /// Learns from the colours of frames before the first that is classified; a frame may not show the pixel.
    pub fn learn_seen(&mut self, all: impl IntoIterator<Item = ObservedColour>) {
        let unseen = Pixel::unseen(self.parameters.k);
        let unseen = || LearntState { values: Vec::new(), pixel: unseen, start: unseen };
        let mut learnt = self.learnt.take().map_or_else(unseen, Arc::unwrap_or_clone);
        for seen in all {
            let mean = learnt.pixel.components()[0].mean;
            let value = seen.colour.map_or(mean, |rgb| self.parameters.value(rgb));
            learnt.values.push(value);
            self.parameters.learnt = learnt.values.len() as u32;
            if seen.colour.is_none() {
                continue;
            }
            learnt.pixel.step(value, self.parameters.learnt, &self.parameters);
        }
        learnt.start = learnt.pixel;
        learnt.start.begin(&self.parameters);
        self.learnt = (!learnt.values.is_empty()).then(|| Arc::new(learnt));
    }

    /// The values that were learned from, and those of the states up to `index`: all inputs of the mixture after that
    /// state. `None` where there is no such state.
    pub fn values_until(&self, index: usize) -> Option<Vec<PixelValue>> {
        let judged = self.states.get(..=index)?.iter().map(|state| state.value);
        Some(self.learnt.iter().flat_map(|learnt| learnt.values.iter().copied()).chain(judged).collect())
    }

    /// The history of pixel `at` from its colours, `(frame number, colour)` in order.
    #[cfg(test)]
    pub(crate) fn of_colours(
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

    /// Adds a frame. Ignores a frame that does not contain the pixel.
    pub fn push(&mut self, frame: &Frame) {
        if let Some(seen) = self.parameters.registration.pixel(frame, self.at) {
            self.push_seen(frame.number, seen);
        }
    }

    /// Processes the colour of the pixel in frame `number`; the frame may not show it.
    pub fn push_seen(&mut self, number: u32, ObservedColour { colour, applied }: ObservedColour) {
        match (colour, self.states.last()) {
            (Some(rgb), _) => self.push_colour(number, rgb),
            (None, Some(last)) => {
                let pixel = last.pixel;
                let mean = pixel.components()[0].mean;
                let rgb = match self.parameters.space {
                    Space::Rgb => mean.map(|level| level.round() as u8),
                    Space::Gray => [mean[0].round() as u8; 3],
                };
                let outcome = pixel.skip(&self.parameters);
                let value = self.parameters.value(rgb);
                let t = self.parameters.learnt + self.states.len() as u32 + 1;
                self.states.push(PixelState { number, t, rgb, value, pixel, outcome, known: false, applied });
            }
            // There is no earlier frame, hence no motion.
            (None, None) => self.push_colour(number, [0; 3]),
        }
        if let Some(state) = self.states.last_mut() {
            state.applied = applied;
        }
    }

    /// Adds the pixel's colour in frame `number`.
    pub fn push_colour(&mut self, number: u32, rgb: [u8; 3]) {
        let t = self.parameters.learnt + self.states.len() as u32 + 1;
        let value = self.parameters.value(rgb);
        let before = self.before(self.states.len());
        let mut pixel = before.copied().unwrap_or_else(|| Pixel::unseen(self.parameters.k));
        let outcome = pixel.update(value, t, &self.parameters);
        let applied = Applied::NOTHING;
        self.states.push(PixelState { number, t, rgb, value, pixel, outcome, known: true, applied });
    }

    /// The pixel's position in the frame of the state at `index`, which differs from the reference where camera
    /// motion was corrected.
    pub fn place(&self, index: usize) -> (u32, u32) {
        let (x, y) = self.at;
        let [dx, dy] = self.states.get(index).map_or([0.0; 2], |state| state.applied.shift);
        let moved = |at: u32, by: f32| (at as f32 + by).round().max(0.0) as u32;
        (moved(x, dx), moved(y, dy))
    }

    /// Whether it extends `before`: the same pixel, the same parameters and the same first frames.
    ///
    /// A state depends on all earlier ones, so that comparing the last one of `before` is sufficient.
    pub fn extends(&self, before: &Self) -> bool {
        let last = before.states.len().checked_sub(1);
        (self.at, self.parameters) == (before.at, before.parameters)
            && self.before(0) == before.before(0)
            && last.is_none_or(|last| self.states.get(last) == before.states.last())
    }

    /// The mixture before the update of the state at `index`; `None` for the first frame of the mixture.
    pub fn before(&self, index: usize) -> Option<&Pixel> {
        match index.checked_sub(1) {
            Some(previous) => self.states.get(previous).map(|state| &state.pixel),
            None => self.learnt.as_ref().map(|learnt| &learnt.start),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::settings::{Preset, Settings};

    #[test]
    fn learned_frames_have_no_states() {
        let parameters = Parameters::new(&Settings::preset(Preset::Plain));
        let colour = |n: u32| [if n < 30 { 90 } else { 180 } + (n % 3) as u8; 3];
        let mut history = PixelHistory::new((3, 4), parameters);
        assert_eq!((history.before(0), history.values_until(0)), (None, None));
        // Learning in parts is equal to learning at once.
        history.learn_colours((1..=7).map(colour));
        history.learn_colours((8..=40).map(colour));
        let mut at_once = PixelHistory::new((3, 4), parameters);
        at_once.learn_colours((1..=40).map(colour));
        assert_eq!(history, at_once);
        let mut pixel = Pixel::unseen(parameters.k);
        let parameters = Parameters { learnt: 40, ..parameters };
        for t in 1..=40 {
            pixel.update(parameters.value(colour(t)), t, &parameters);
        }
        assert!(pixel.used() > 1);
        pixel.begin(&parameters);
        assert_eq!((history.before(0), history.parameters), (Some(&pixel), parameters));
        for n in 1..=5 {
            history.push_colour(n, colour(n));
            let outcome = pixel.update(parameters.value(colour(n)), 40 + n, &parameters);
            let state = history.states.last().unwrap();
            assert_eq!((state.number, state.t, state.pixel, state.outcome), (n, 40 + n, pixel, outcome));
        }
        let values: Vec<_> = (1..=40).chain(1..=2).map(|n| parameters.value(colour(n))).collect();
        assert_eq!(history.values_until(1), Some(values));
        assert!(history.extends(&PixelHistory { states: Vec::new(), ..history.clone() }));
        assert!(!history.extends(&PixelHistory::new((3, 4), history.parameters)));
    }

    #[test]
    fn a_history_extends_only_an_earlier_one_of_the_same_frames() {
        let of = |settings: &Settings, frames: std::ops::Range<u32>, level: u8| {
            let colours = frames.map(|n| (n, [if n == 7 { level } else { 90 }; 3]));
            PixelHistory::of_colours((3, 4), Parameters::new(settings), colours)
        };
        let settings = Settings::preset(Preset::Plain);
        let before = of(&settings, 1..20, 200);
        assert!(of(&settings, 1..50, 200).extends(&before));
        assert!(of(&settings, 1..20, 200).extends(&before));
        assert!(before.extends(&of(&settings, 1..1, 200)), "every history extends an empty one");
        assert!(!of(&settings, 1..19, 200).extends(&before), "the history is shorter");
        assert!(!of(&settings, 1..50, 210).extends(&before), "an earlier value differs");
        assert!(!of(&settings, 2..50, 200).extends(&before), "begun later");
        assert!(!of(&Settings { alpha: 0.2, ..settings.clone() }, 1..50, 200).extends(&before));
        assert!(!PixelHistory { at: (4, 4), ..of(&settings, 1..50, 200) }.extends(&before));
    }
}
