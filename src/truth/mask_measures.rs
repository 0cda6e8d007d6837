//! CDnet's seven measures of masks, and their means over a data set.

use std::collections::BTreeMap;
use std::iter::Sum;

use serde::{Deserialize, Serialize};

use super::mask_score::MaskScore;

/// CDnet's seven measures, each 0..=1 except PWC. One without a denominator is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MaskMeasures {
    /// 2·precision·recall / (precision + recall).
    pub f: f64,
    /// tp / (tp + fp).
    pub precision: f64,
    /// tp / (tp + fn).
    pub recall: f64,
    /// Percentage of wrong classifications, 0..=100.
    pub pwc: f64,
    /// tn / (tn + fp).
    pub specificity: f64,
    /// fp / (fp + tn).
    pub fpr: f64,
    /// fn / (tp + fn).
    pub fnr: f64,
}

impl MaskMeasures {
    /// The mean of each measure; `None` of nothing.
    fn mean(all: &[Self]) -> Option<Self> {
        let count = all.len() as f64;
        let Self { f, precision, recall, pwc, specificity, fpr, fnr } = all.iter().copied().sum();
        (!all.is_empty()).then(|| Self {
            f: f / count,
            precision: precision / count,
            recall: recall / count,
            pwc: pwc / count,
            specificity: specificity / count,
            fpr: fpr / count,
            fnr: fnr / count,
        })
    }
}

impl From<&MaskScore> for MaskMeasures {
    fn from(score: &MaskScore) -> Self {
        let MaskScore { f_measure: f, precision, recall, pwc, specificity, fpr, fnr, .. } = *score;
        Self { f, precision, recall, pwc, specificity, fpr, fnr }
    }
}

impl Sum for MaskMeasures {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |sum, one| Self {
            f: sum.f + one.f,
            precision: sum.precision + one.precision,
            recall: sum.recall + one.recall,
            pwc: sum.pwc + one.pwc,
            specificity: sum.specificity + one.specificity,
            fpr: sum.fpr + one.fpr,
            fnr: sum.fnr + one.fnr,
        })
    }
}

/// The measures of a data set as CDnet ranks by them: a measure of a category is the mean of that of its sequences, that
/// of the data set the mean of that of its categories. So F is a mean of Fs and not the F of mean precision and recall,
/// and long sequences and large categories weigh no more than others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DataSetMeasures {
    /// The means of each category.
    pub categories: BTreeMap<String, MaskMeasures>,
    /// The means of the categories.
    pub overall: MaskMeasures,
}

impl DataSetMeasures {
    /// From the category and the measures of each sequence; `None` without sequences.
    ///
    /// # Examples
    ///
    /// ```
    /// use occluscope::truth::mask_measures::{DataSetMeasures, MaskMeasures};
    ///
    /// let of = |f| MaskMeasures { f, ..MaskMeasures::default() };
    /// let sequences = [("baseline", of(0.9)), ("shadow", of(0.5)), ("shadow", of(0.6))];
    /// let measures = DataSetMeasures::new(sequences).unwrap();
    /// assert_eq!(measures.categories["shadow"].f, 0.55);
    /// assert_eq!(measures.overall.f, (0.9 + 0.55) / 2.0);
    /// ```
    pub fn new<C: Into<String>>(sequences: impl IntoIterator<Item = (C, MaskMeasures)>) -> Option<Self> {
        let mut sequences_of: BTreeMap<String, Vec<MaskMeasures>> = BTreeMap::new();
        for (category, measures) in sequences {
            sequences_of.entry(category.into()).or_default().push(measures);
        }
        let means =
            sequences_of.into_iter().filter_map(|(name, all)| Some((name, MaskMeasures::mean(&all)?)));
        let categories: BTreeMap<_, _> = means.collect();
        let overall = MaskMeasures::mean(&categories.values().copied().collect::<Vec<_>>())?;
        Some(Self { categories, overall })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::truth::decisions::Decisions;

    #[test]
    fn categories_weigh_the_same_whatever_their_sequences() {
        let measures = |frames, [tp, fp, fn_, tn]: [u64; 4]| {
            MaskMeasures::from(&MaskScore::new(frames, Decisions { tp, fp, fn_, tn }))
        };
        let (good, poor, none) =
            (measures(10, [8, 2, 2, 88]), measures(9000, [300, 100, 300, 300]), measures(1, [0, 0, 0, 100]));
        assert_eq!((good.f, good.precision, good.recall, good.pwc), (0.8, 0.8, 0.8, 4.0));
        let all = DataSetMeasures::new([("b", good), ("a", poor), ("b", none)]).unwrap();
        assert_eq!(all.categories.keys().collect::<Vec<_>>(), ["a", "b"]);
        assert_eq!(all.categories["a"], poor);
        let near = |ours: MaskMeasures, expected: [f64; 7]| {
            let MaskMeasures { f, precision, recall, pwc, specificity, fpr, fnr } = ours;
            for (a, b) in [f, precision, recall, pwc, specificity, fpr, fnr].into_iter().zip(expected) {
                assert!((a - b).abs() < 1e-12, "{ours:?}, expected {expected:?}");
            }
        };
        let fpr = 2.0 / 90.0 / 2.0;
        near(all.categories["b"], [0.4, 0.4, 0.4, 2.0, 1.0 - fpr, fpr, 0.1]);
        near(all.overall, [0.5, 0.575, 0.45, 21.0, 0.875 - fpr / 2.0, 0.125 + fpr / 2.0, 0.3]);
        assert_eq!(DataSetMeasures::new::<String>([]), None);
    }
}
