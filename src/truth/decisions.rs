//! Counts of correct and wrong decisions on pixels, and the measures computed from them.

use std::iter::Sum;
use std::ops::AddAssign;

use serde::Serialize;

use super::share::share_or_zero;

/// The confusion matrix of foreground against truth, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Decisions {
    /// True positives: foreground that is classified as such.
    pub tp: u64,
    /// False positives: background that is classified as foreground.
    pub fp: u64,
    /// False negatives: foreground that is classified as background.
    #[serde(rename = "fn")]
    pub fn_: u64,
    /// True negatives: background that is classified as such.
    pub tn: u64,
}

impl Decisions {
    /// The sum of all counts.
    pub const fn all(self) -> u64 {
        self.tp + self.fp + self.fn_ + self.tn
    }

    /// The share of correct decisions (accuracy), 0..=1; 0 without decisions.
    pub fn right(self) -> f64 {
        share_or_zero(self.tp + self.tn, self.all())
    }

    /// 2·precision·recall / (precision + recall), 0..=1; 0 without foreground.
    pub fn f_measure(self) -> f64 {
        share_or_zero(2 * self.tp, 2 * self.tp + self.fp + self.fn_)
    }
}

/// A measure for comparing decisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// The share of correct decisions (accuracy).
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_follow_from_counts() {
        let decisions = Decisions { tp: 6, fp: 2, fn_: 4, tn: 88 };
        assert_eq!((decisions.all(), decisions.right()), (100, 0.94));
        assert!((decisions.f_measure() - 2.0 * 0.6 * 0.75 / 1.35).abs() < 1e-12);
        assert_eq!((Decisions::default().right(), Decisions::default().f_measure()), (0.0, 0.0));
    }
}
