//! The measures of all sequences under all combinations.

use std::collections::BTreeMap;

use super::grid::Grid;
use crate::truth::measures::{MeasureColumn, Measures};

/// The result of a sequence under a combination.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// The index of the sequence.
    pub sequence: usize,
    /// The index of the combination in the grid.
    pub combination: usize,
    /// The measures that the ground truth of the sequence permits.
    pub measures: Measures,
    /// The share of the combination in the computing time, in seconds.
    pub seconds: f64,
}

/// The rows of a sweep, by sequence and combination. It can be incomplete.
#[derive(Clone, Debug)]
pub struct SweepTable {
    /// The combinations.
    pub grid: Grid,
    /// The names of the sequences; in a data set with categories `category/sequence`.
    pub sequences: Vec<String>,
    /// The rows, ordered by sequence and combination.
    pub rows: Vec<Row>,
    /// The measure by which combinations are ranked.
    pub by: &'static MeasureColumn,
}

impl SweepTable {
    /// The row of a sequence and a combination, if it is there.
    pub fn row(&self, sequence: usize, combination: usize) -> Option<&Row> {
        let key = (sequence, combination);
        let at = self.rows.binary_search_by_key(&key, |row| (row.sequence, row.combination)).ok()?;
        self.rows.get(at)
    }

    /// The value of a measure of a sequence under a combination.
    pub fn value(&self, sequence: usize, combination: usize, measure: &MeasureColumn) -> Option<f64> {
        (measure.of)(&self.row(sequence, combination)?.measures)
    }

    /// The value of a measure of all sequences under a combination: the mean of the categories' means, as in
    /// [`DataSetMeasures`](crate::truth::mask_measures::DataSetMeasures). `None` where no sequence has it, or one that
    /// has it under another combination has no row under this one.
    pub fn overall(&self, combination: usize, measure: &MeasureColumn) -> Option<f64> {
        let categories = self.categories();
        let categories = categories
            .into_iter()
            .filter(|(_, sequences)| sequences.iter().any(|&sequence| self.has(sequence, measure)));
        let means = categories.map(|(_, sequences)| self.mean(&sequences, combination, measure));
        mean(&means.collect::<Option<Vec<_>>>()?)
    }

    /// The categories by name, the part of a sequence's name before its last `/`, with the indices of their sequences.
    pub fn categories(&self) -> BTreeMap<&str, Vec<usize>> {
        let mut categories: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (sequence, name) in self.sequences.iter().enumerate() {
            let category = name.rsplit_once('/').map_or("", |(category, _)| category);
            categories.entry(category).or_default().push(sequence);
        }
        categories
    }

    /// The mean of a measure of those of the sequences that permit it, under a combination. `None` where one of them has no
    /// row, or none permits it.
    pub fn mean(&self, sequences: &[usize], combination: usize, measure: &MeasureColumn) -> Option<f64> {
        let having = sequences.iter().filter(|&&sequence| self.has(sequence, measure));
        let values = having.map(|&sequence| self.value(sequence, combination, measure));
        mean(&values.collect::<Option<Vec<_>>>()?)
    }

    /// Whether the ground truth of a sequence permits a measure.
    pub fn has(&self, sequence: usize, measure: &MeasureColumn) -> bool {
        let start = self.rows.partition_point(|row| row.sequence < sequence);
        let rows = self.rows[start..].iter().take_while(|row| row.sequence == sequence);
        rows.into_iter().any(|row| (measure.of)(&row.measures).is_some())
    }

    /// The combination with the best value of a measure of a sequence, the first of equal ones.
    pub fn best(&self, sequence: usize, measure: &MeasureColumn) -> Option<usize> {
        self.best_by(measure, |combination| self.value(sequence, combination, measure))
    }

    /// The combination with the best value of a measure of all sequences, the first of equal ones.
    pub fn best_overall(&self, measure: &MeasureColumn) -> Option<usize> {
        self.best_by(measure, |combination| self.overall(combination, measure))
    }

    /// Number of combinations with the best value of a measure of all sequences.
    pub fn equally_best_overall(&self, measure: &MeasureColumn) -> usize {
        let best = self.best_overall(measure).and_then(|best| self.overall(best, measure));
        let values =
            (0..self.grid.combinations()).filter_map(|combination| self.overall(combination, measure));
        values.filter(|value| Some(*value) == best).count()
    }

    /// Number of sequences whose ground truth permits a measure.
    pub fn sequences_with(&self, measure: &MeasureColumn) -> usize {
        (0..self.sequences.len()).filter(|&sequence| self.has(sequence, measure)).count()
    }

    fn best_by(&self, measure: &MeasureColumn, value: impl Fn(usize) -> Option<f64>) -> Option<usize> {
        let values = (0..self.grid.combinations()).filter_map(|at| Some((at, value(at)?)));
        let best = values.reduce(|best, next| if measure.is_better(next.1, best.1) { next } else { best });
        best.map(|(combination, _)| combination)
    }
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::sweep::grid::Axis;
    use crate::truth::mask_measures::MaskMeasures;
    use crate::truth::measures::{self, OBJECTIVE};

    /// A table of two combinations with these F of each sequence.
    fn table(sequences: &[(&str, [f64; 2])]) -> SweepTable {
        let row = |sequence: usize, combination: usize, f: f64| {
            let masks = MaskMeasures { f, pwc: 100.0 * (1.0 - f), ..MaskMeasures::default() };
            let measures = Measures { masks: Some(masks), ..Measures::default() };
            Row { sequence, combination, measures, seconds: 1.0 }
        };
        let rows = sequences.iter().enumerate().flat_map(|(sequence, (_, values))| {
            values.iter().enumerate().map(move |(combination, f)| row(sequence, combination, *f))
        });
        SweepTable {
            grid: Grid::new(vec![Axis::of_text("k=3,4").unwrap()]).unwrap(),
            sequences: sequences.iter().map(|(name, _)| (*name).to_owned()).collect(),
            rows: rows.collect(),
            by: &OBJECTIVE,
        }
    }

    #[test]
    fn the_best_overall_weighs_categories_the_same() {
        let mut table = table(&[("a/1", [0.5, 0.75]), ("a/2", [0.5, 0.75]), ("b/3", [0.75, 0.25])]);
        let [f, pwc] = ["f", "pwc"].map(|name| measures::column(name).unwrap());
        assert_eq!((table.overall(0, f), table.overall(1, f)), (Some(0.625), Some(0.5)));
        assert_eq!(
            (table.best_overall(f), table.best(0, f), table.best(2, pwc)),
            (Some(0), Some(1), Some(0))
        );
        assert_eq!(table.best_overall(&OBJECTIVE), Some(0));
        assert_eq!(table.best_overall(measures::column("mota").unwrap()), None);
        // Without a row of a sequence the mean would be of others.
        table.rows.remove(0);
        assert_eq!((table.overall(0, f), table.best_overall(f)), (None, Some(1)));
    }
}
