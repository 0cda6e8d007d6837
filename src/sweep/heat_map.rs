//! A measure over two settings of a sweep: in each cell the best value over all other settings.

use super::grid::Grid;
use super::table::SweepTable;
use crate::truth::measures::{self, MeasureColumn, OBJECTIVE};

/// Largest number of values of an axis of a map.
const MAX_VALUES: usize = 100;

/// Least difference of worst and best that takes all colours, as a share of the greater.
const MIN_SPAN: f64 = 0.05;

/// What a map is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// All sequences.
    All,
    /// A sequence, by its index.
    Sequence(usize),
}

impl Subject {
    /// Its name on the screen.
    pub fn name(self, table: &SweepTable) -> &str {
        match self {
            Self::All => "all sequences",
            Self::Sequence(at) => table.sequences.get(at).map_or("", String::as_str),
        }
    }

    /// The value of a measure under a combination.
    pub fn value(self, table: &SweepTable, combination: usize, measure: &MeasureColumn) -> Option<f64> {
        match self {
            Self::All => table.overall(combination, measure),
            Self::Sequence(at) => table.value(at, combination, measure),
        }
    }
}

/// The axes of a map, as indices into those of the grid. A map of one axis is one row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapAxes {
    /// The horizontal axis.
    pub across: usize,
    /// The vertical axis, its first value at the top.
    pub down: Option<usize>,
}

/// The axes of the grid that a map can have: those of 2 to 100 values.
pub fn mapped_axes(grid: &Grid) -> Vec<usize> {
    let counts = grid.axes().iter().map(|axis| axis.values.len()).enumerate();
    counts.filter(|(_, count)| (2..=MAX_VALUES).contains(count)).map(|(at, _)| at).collect()
}

/// The maps of a grid: each pair of its mapped axes, or its only one.
pub fn maps_of(grid: &Grid) -> Vec<MapAxes> {
    let axes = mapped_axes(grid);
    if let [across] = axes[..] {
        return vec![MapAxes { across, down: None }];
    }
    let mut maps = Vec::new();
    for (at, &across) in axes.iter().enumerate() {
        maps.extend(axes[at + 1..].iter().map(|&down| MapAxes { across, down: Some(down) }));
    }
    maps
}

/// The measures that are mapped, the one that ranks combinations first, then those of F, MOTA and HOTA that the ground
/// truth of some sequence permits. [`OBJECTIVE`] is left out where it equals F or HOTA.
pub fn mapped_measures(table: &SweepTable) -> Vec<&'static MeasureColumn> {
    let present = |name: &str| {
        let measure = measures::column(name)?;
        table.rows.iter().any(|row| (measure.of)(&row.measures).is_some()).then_some(measure)
    };
    let [f, mota, hota] = ["f", "mota", "hota"].map(present);
    let mut mapped: Vec<_> = match (f, hota) {
        (Some(_), Some(_)) => [Some(&OBJECTIVE), f, mota, hota].into_iter().flatten().collect(),
        _ => [f, hota, mota].into_iter().flatten().collect(),
    };
    if table.by.name != OBJECTIVE.name {
        mapped.retain(|measure| measure.name != table.by.name);
        mapped.insert(0, table.by);
    }
    mapped
}

/// A cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// The best value.
    pub value: f64,
    /// The combination that has it, the first of equal ones.
    pub combination: usize,
}

/// A measure over two axes.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatMap {
    /// Number of columns.
    pub columns: usize,
    /// The cells, row by row from the top; `None` where no combination has a value.
    pub cells: Vec<Option<Cell>>,
    /// The worst and the best value; `None` without values.
    pub ends: Option<[f64; 2]>,
}

impl HeatMap {
    /// The map of a measure.
    pub fn new(table: &SweepTable, subject: Subject, measure: &MeasureColumn, axes: MapAxes) -> Self {
        let count = |axis: usize| table.grid.axes().get(axis).map_or(1, |axis| axis.values.len());
        let (columns, rows) = (count(axes.across), axes.down.map_or(1, count));
        let mut cells: Vec<Option<Cell>> = vec![None; columns * rows];
        let mut ends: Option<[f64; 2]> = None;
        for combination in 0..table.grid.combinations() {
            let Some(value) = subject.value(table, combination, measure) else { continue };
            let indices = table.grid.indices(combination);
            let index = |axis: usize| indices.get(axis).copied().unwrap_or(0);
            let cell = &mut cells[axes.down.map_or(0, index) * columns + index(axes.across)];
            if cell.is_none_or(|cell| measure.is_better(value, cell.value)) {
                *cell = Some(Cell { value, combination });
            }
        }
        for Cell { value, .. } in cells.iter().flatten() {
            let [worst, best] = ends.get_or_insert([*value; 2]);
            if measure.is_better(*worst, *value) {
                *worst = *value;
            }
            if measure.is_better(*value, *best) {
                *best = *value;
            }
        }
        Self { columns, cells, ends }
    }

    /// The index of the best cell, the first of equal ones.
    pub fn best(&self) -> Option<usize> {
        let [_, best] = self.ends?;
        self.cells.iter().position(|cell| cell.is_some_and(|cell| cell.value == best))
    }

    /// The values of the first and the last colour: the last is that of the best value, the first that of the worst or,
    /// where it is close to the best, of one farther off, as a small difference is no contrast. `None` where there is one
    /// value only, or none.
    pub fn scale(&self) -> Option<[f64; 2]> {
        let [worst, best] = self.ends.filter(|[worst, best]| worst != best)?;
        let span = (best - worst).abs().max(MIN_SPAN * best.abs().max(worst.abs()));
        Some([best + span.copysign(worst - best), best])
    }

    /// The position of a value on the scale: 0 where it begins, 1 for the best.
    pub fn share(&self, value: f64) -> f32 {
        self.scale().map_or(1.0, |[first, best]| (1.0 - (best - value).abs() / (best - first).abs()) as f32)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::sweep::grid::Axis;
    use crate::sweep::table::Row;
    use crate::truth::mask_measures::MaskMeasures;
    use crate::truth::measures::Measures;

    fn table(axes: &[&str], f: impl Fn(usize) -> Option<f64>) -> SweepTable {
        let axes = axes.iter().map(|text| Axis::of_text(text).unwrap()).collect();
        let grid = Grid::new(axes).unwrap();
        let rows = (0..grid.combinations()).filter_map(|combination| {
            let masks =
                MaskMeasures { f: f(combination)?, pwc: 1.0 - f(combination)?, ..MaskMeasures::default() };
            let measures = Measures { masks: Some(masks), ..Measures::default() };
            Some(Row { sequence: 0, combination, measures, seconds: 1.0 })
        });
        SweepTable { rows: rows.collect(), grid, sequences: vec!["one".to_owned()], by: &OBJECTIVE }
    }

    #[test]
    fn a_cell_is_the_best_over_the_other_axes() {
        // Combination 0..12: k changes slowest, then t, then min_sigma.
        let table = table(&["k=3,4", "t=0.6,0.7,0.8", "min-sigma=4,8"], |at| {
            (at != 4 && at != 5).then(|| at as f64 / 16.0)
        });
        assert_eq!(maps_of(&table.grid).len(), 3);
        let [f, pwc] = ["f", "pwc"].map(|name| measures::column(name).unwrap());
        let axes = MapAxes { across: 0, down: Some(1) };
        let map = HeatMap::new(&table, Subject::Sequence(0), f, axes);
        let combinations: Vec<_> = map.cells.iter().map(|cell| cell.map(|cell| cell.combination)).collect();
        assert_eq!(combinations, [Some(1), Some(7), Some(3), Some(9), None, Some(11)]);
        assert_eq!((map.columns, map.best(), map.ends), (2, Some(5), Some([1.0 / 16.0, 11.0 / 16.0])));
        assert_eq!((map.share(1.0 / 16.0), map.share(11.0 / 16.0)), (0.0, 1.0));
        // A smaller PWC is better.
        let map = HeatMap::new(&table, Subject::All, pwc, axes);
        assert_eq!((map.best(), map.ends), (Some(5), Some([15.0 / 16.0, 5.0 / 16.0])));
        assert!(map.share(5.0 / 16.0) > map.share(0.5));
    }

    #[test]
    fn a_small_difference_takes_a_part_of_the_scale() {
        let table = table(&["k=3,4"], |at| Some([0.5, 0.495][at]));
        let axes = MapAxes { across: 0, down: None };
        for (name, worst, first) in [("f", 0.495, 0.475), ("pwc", 0.505, 0.525_25)] {
            let map = HeatMap::new(&table, Subject::All, measures::column(name).unwrap(), axes);
            assert!((map.scale().unwrap()[0] - first).abs() < 1e-9, "{name}: {:?}", map.scale());
            assert!((map.share(first) - 0.0).abs() < 1e-6 && map.share(worst) > 0.75, "{name}");
        }
    }

    #[test]
    fn maps_need_axes_of_several_values() {
        let maps = |axes: &[&str]| maps_of(&table(axes, |_| Some(0.5)).grid);
        assert_eq!(maps(&[]), []);
        assert_eq!(maps(&["k=3"]), []);
        assert_eq!(maps(&["k=3", "t=0.6,0.7"]), [MapAxes { across: 1, down: None }]);
        assert_eq!(maps(&["alpha=0.01..0.9:101"]), []);
        let row = HeatMap::new(
            &table(&["k=3,4"], |_| Some(0.5)),
            Subject::All,
            &OBJECTIVE,
            MapAxes { across: 0, down: None },
        );
        assert_eq!((row.cells.len(), row.best(), row.share(0.5)), (2, Some(0), 1.0));
    }

    #[test]
    fn the_score_is_mapped_where_it_is_of_two_measures() {
        let masks = table(&["k=3,4"], |_| Some(0.5));
        let names =
            |table: &SweepTable| mapped_measures(table).iter().map(|column| column.name).collect::<Vec<_>>();
        assert_eq!(names(&masks), ["f"]);
        let empty = HeatMap::new(
            &table(&["k=3,4"], |_| None),
            Subject::All,
            &OBJECTIVE,
            MapAxes { across: 0, down: None },
        );
        assert_eq!((empty.ends, empty.best()), (None, None));
    }
}
