//! One pixel through many frames: what the inspector plots and `occluscope pixel` writes.

use std::sync::Arc;

use super::pixel::{Outcome, Parameters, Pixel, Value};
use crate::frame::Frame;
use crate::registration::{Applied, ObservedColour};
use crate::settings::Space;

/// A pixel's mixture after one frame's update, and what the update did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelState {
    /// The frame's number in its source.
    pub number: u32,
    /// t, how many frames the model has seen, this one and those that were learnt from before the first included.
    pub t: u32,
    /// The pixel's colour in the frame.
    pub rgb: [u8; 3],
    /// X, the value that the model saw: three channels, or luma and two zeros.
    pub value: Value,
    /// The mixture after the update, in rank order.
    pub pixel: Pixel,
    /// What the update did.
    pub outcome: Outcome,
    /// Whether the frame shows the pixel: false where it came in from outside as a shake was taken out, or is cut off by
    /// too much light. Then nothing is learnt, and colour and value are those of component 1.
    pub known: bool,
    /// What was taken out of the frame here before the mixture saw it.
    pub applied: Applied,
}

/// The state of one pixel after the frames that are only learnt from.
#[derive(Clone, Debug, PartialEq)]
pub struct LearntState {
    values: Vec<Value>,
    /// The mixture after the last of them.
    pixel: Pixel,
    /// The mixture as it begins with that.
    start: Pixel,
}

/// The states of one pixel, a state a frame that is judged.
#[derive(Clone, Debug, PartialEq)]
pub struct PixelHistory {
    /// The pixel: column and row.
    pub at: (u32, u32),
    /// The parameters under which the states came about.
    pub parameters: Parameters,
    /// What was learnt before the first state; `None` where that is of an unseen pixel.
    pub learnt: Option<Arc<LearntState>>,
    /// One state a frame, in order.
    pub states: Vec<PixelState>,
}

impl PixelHistory {
    /// A history that starts with the next frame.
    pub fn new(at: (u32, u32), parameters: Parameters) -> Self {
        Self { at, parameters, learnt: None, states: Vec::new() }
    }

    /// Learns from one more frame before the first that is judged. A frame that does not hold the pixel is passed over.
    pub fn learn(&mut self, frame: &Frame) {
        if let Some(seen) = self.parameters.registration.pixel(frame, self.at) {
            self.learn_seen([seen]);
        }
    }

    /// Learns from more colours before the first that is judged.
    pub fn learn_colours(&mut self, colours: impl IntoIterator<Item = [u8; 3]>) {
        self.learn_seen(
            colours.into_iter().map(|rgb| ObservedColour { colour: Some(rgb), applied: Applied::NOTHING }),
        );
    }

    /// Learns from the colours of more frames before the first that is classified; a frame may not show the pixel.
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

    /// The values that were learnt from, and those of the first states up to the one at `index`: all that the mixture
    /// after that one has seen; `None` where there is no such state.
    pub fn values_until(&self, index: usize) -> Option<Vec<Value>> {
        let judged = self.states.get(..=index)?.iter().map(|state| state.value);
        Some(self.learnt.iter().flat_map(|learnt| learnt.values.iter().copied()).chain(judged).collect())
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
            // No frame before it that it could have moved against.
            (None, None) => self.push_colour(number, [0; 3]),
        }
        if let Some(state) = self.states.last_mut() {
            state.applied = applied;
        }
    }

    /// Takes one more colour in, that of frame `number`.
    pub fn push_colour(&mut self, number: u32, rgb: [u8; 3]) {
        let t = self.parameters.learnt + self.states.len() as u32 + 1;
        let value = self.parameters.value(rgb);
        let before = self.before(self.states.len());
        let mut pixel = before.copied().unwrap_or_else(|| Pixel::unseen(self.parameters.k));
        let outcome = pixel.update(value, t, &self.parameters);
        let applied = Applied::NOTHING;
        self.states.push(PixelState { number, t, rgb, value, pixel, outcome, known: true, applied });
    }

    /// Where the pixel is in the frame of the state at `index`: elsewhere than in the reference where the camera moved and
    /// that was taken out.
    pub fn place(&self, index: usize) -> (u32, u32) {
        let (x, y) = self.at;
        let [dx, dy] = self.states.get(index).map_or([0.0; 2], |state| state.applied.shift);
        let moved = |at: u32, by: f32| (at as f32 + by).round().max(0.0) as u32;
        (moved(x, dx), moved(y, dy))
    }

    /// Whether it extends `before`: the same pixel, under the same parameters and over the same first frames.
    ///
    /// A state follows from all before it, so that the last one of `before` stands for them.
    pub fn extends(&self, before: &Self) -> bool {
        let last = before.states.len().checked_sub(1);
        (self.at, self.parameters) == (before.at, before.parameters)
            && self.before(0) == before.before(0)
            && last.is_none_or(|last| self.states.get(last) == before.states.last())
    }

    /// The mixture before the update of the state at `index`; `None` where that is the first frame it sees.
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
    fn what_was_learnt_is_before_the_first_state_and_not_among_the_states() {
        let parameters = Parameters::new(&Settings::preset(Preset::Plain));
        let colour = |n: u32| [if n < 30 { 90 } else { 180 } + (n % 3) as u8; 3];
        let mut history = PixelHistory::new((3, 4), parameters);
        assert_eq!((history.before(0), history.values_until(0)), (None, None));
        // In parts or at once.
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
    fn a_history_goes_on_from_an_earlier_one_of_the_same_frames_alone() {
        let of = |settings: &Settings, frames: std::ops::Range<u32>, level: u8| {
            let colours = frames.map(|n| (n, [if n == 7 { level } else { 90 }; 3]));
            PixelHistory::of_colours((3, 4), Parameters::new(settings), colours)
        };
        let settings = Settings::preset(Preset::Plain);
        let before = of(&settings, 1..20, 200);
        assert!(of(&settings, 1..50, 200).extends(&before));
        assert!(of(&settings, 1..20, 200).extends(&before));
        assert!(before.extends(&of(&settings, 1..1, 200)), "anything goes on from nothing");
        assert!(!of(&settings, 1..19, 200).extends(&before), "it is shorter");
        assert!(!of(&settings, 1..50, 210).extends(&before), "another value long ago");
        assert!(!of(&settings, 2..50, 200).extends(&before), "begun later");
        assert!(!of(&Settings { alpha: 0.2, ..settings.clone() }, 1..50, 200).extends(&before));
        assert!(!PixelHistory { at: (4, 4), ..of(&settings, 1..50, 200) }.extends(&before));
    }
}
