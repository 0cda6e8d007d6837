//! Counts of right and wrong decisions on pixels.

use std::iter::Sum;
use std::ops::AddAssign;

use serde::Serialize;

use super::masks::TrueMask;
use crate::frame::{Frame, Mask};
use crate::mixture::{BATCH, Mixture, Parameters};

/// The confusion matrix of foreground against truth, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Decisions {
    /// True positives: foreground that is found.
    pub tp: u64,
    /// False positives: background that is taken for foreground.
    pub fp: u64,
    /// False negatives: foreground that is missed.
    #[serde(rename = "fn")]
    pub fn_: u64,
    /// True negatives: background that is left as such.
    pub tn: u64,
}

impl Decisions {
    /// The sum of all counts.
    pub const fn all(self) -> u64 {
        self.tp + self.fp + self.fn_ + self.tn
    }

    /// The share of right decisions (accuracy), 0..=1; 0 without decisions.
    pub fn right(self) -> f64 {
        share(self.tp + self.tn, self.all())
    }

    /// 2·precision·recall / (precision + recall), 0..=1; 0 without foreground.
    pub fn f_measure(self) -> f64 {
        share(2 * self.tp, 2 * self.tp + self.fp + self.fn_)
    }
}

/// A measure for comparing decisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// The share of right decisions.
    Right,
    /// The harmonic mean of precision and recall.
    F,
}

impl Measure {
    /// All measures.
    pub const ALL: [Self; 2] = [Self::Right, Self::F];

    /// Its value, 0..=1.
    pub fn of(self, decisions: Decisions) -> f64 {
        match self {
            Self::Right => decisions.right(),
            Self::F => decisions.f_measure(),
        }
    }

    /// Its name in two words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Right => "accuracy",
            Self::F => "F-measure",
        }
    }

    /// Its name in one word.
    pub const fn short(self) -> &'static str {
        match self {
            Self::Right => "accuracy",
            Self::F => "F",
        }
    }

    /// Its meaning in a sentence.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Right => "Accuracy: (TP + TN)/all evaluated pixels",
            Self::F => {
                "F-measure: harmonic mean of precision and recall. True negatives do not count, so rare \
                 foreground weighs as much as frequent foreground"
            }
        }
    }
}

/// part / whole; 0 where `whole` is 0.
pub(super) fn share(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}

impl AddAssign for Decisions {
    fn add_assign(&mut self, other: Self) {
        self.tp += other.tp;
        self.fp += other.fp;
        self.fn_ += other.fn_;
        self.tn += other.tn;
    }
}

impl Sum for Decisions {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |mut sum, one| {
            sum += one;
            sum
        })
    }
}

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
        mixture.replay(&frames, &mut masks[..frames.len()]);
        for (mask, truth) in masks.iter().zip(truth) {
            if let Some(truth) = truth {
                let mut judge = truth.judge();
                mask.runs().for_each(|run| judge.take(run));
                decisions += judge.decisions();
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
    fn measures_follow_from_counts() {
        let decisions = Decisions { tp: 6, fp: 2, fn_: 4, tn: 88 };
        assert_eq!((decisions.all(), decisions.right()), (100, 0.94));
        assert!((decisions.f_measure() - 2.0 * 0.6 * 0.75 / 1.35).abs() < 1e-12);
        assert_eq!((Decisions::default().right(), Decisions::default().f_measure()), (0.0, 0.0));
    }

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
