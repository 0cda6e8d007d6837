//! The score of a mixture's masks under given parameters, without regions and tracks.

use super::decisions::Decisions;
use super::masks::TrueMask;
use crate::frame::{Frame, Mask};
use crate::mixture::{BATCH, Mixture, Parameters};

/// The decisions of a new mixture under `parameters` in all of `frames`, scored where there is truth. Before, it
/// learns from the first [`Parameters::learnt`] of them.
///
/// # Panics
/// If the frames differ in size.
pub fn of_mixture(frames: &[Frame], truth: &[Option<TrueMask>], parameters: Parameters) -> Decisions {
    let Some(size) = frames.first().map(|frame| frame.size) else { return Decisions::default() };
    let mut mixture = Mixture::new(size, parameters);
    let first = &frames[..frames.len().min(parameters.learnt as usize)];
    mixture.learn(&first.iter().collect::<Vec<_>>());
    let mut masks = vec![Mask::empty(size); BATCH];
    let mut decisions = Decisions::default();
    for (frames, truth) in frames.chunks(BATCH).zip(truth.chunks(BATCH)) {
        let frames: Vec<&Frame> = frames.iter().collect();
        mixture.step_many(&frames, &mut masks[..frames.len()]);
        for (mask, truth) in masks.iter().zip(truth) {
            if let Some(truth) = truth {
                decisions += truth.score(mask);
            }
        }
    }
    decisions
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explain::tuning::run;
    use crate::frame::Size;
    use crate::settings::Settings;
    use crate::truth::masks::Label;

    #[test]
    fn decisions_of_an_image_equal_those_of_its_pixels() {
        let size = Size::new(5, 4);
        let colour = |number: u32, at: u32| {
            let passes = (number + 3 * at) % 23 < 4;
            [if passes { 190 } else { 60 + (number * 7 + at * 13) % 9 } as u8; 3]
        };
        let frames: Vec<Frame> = (1..=70)
            .map(|number| Frame::new(number, size, (0..20).flat_map(|at| colour(number, at)).collect()))
            .collect();
        let label = |number: u32, at: u32| match (number + at) % 7 {
            0 => Label::Uncounted,
            1 | 2 => Label::Foreground,
            _ => Label::Background,
        };
        let truth: Vec<_> = (1..=70)
            .map(|number| (number % 3 != 0).then(|| TrueMask::new(size, (0..20).map(|at| label(number, at)))))
            .collect();
        let settings = Settings { alpha: 0.05, ..Settings::default() };
        let parameters = Parameters::new(&settings);
        let mut expected = Decisions::default();
        for at in 0..20 {
            let values: Vec<_> = (1..=70).map(|number| parameters.value(colour(number, at))).collect();
            for number in (1..=70).filter(|number| number % 3 != 0) {
                let found = run(&values[..number as usize], &parameters).is_foreground(parameters.t);
                match (label(number, at), found) {
                    (Label::Uncounted, _) => {}
                    (Label::Foreground, true) => expected.tp += 1,
                    (Label::Foreground, false) => expected.fn_ += 1,
                    (Label::Background, true) => expected.fp += 1,
                    (Label::Background, false) => expected.tn += 1,
                }
            }
        }
        assert!(expected.tp > 20 && expected.fp > 20 && expected.fn_ > 20, "{expected:?}");
        assert_eq!(of_mixture(&frames, &truth, parameters), expected);
    }
}
