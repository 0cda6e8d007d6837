//! CDnet's measures of the categories of a sweep, a row per category and combination: `category`, the settings of the grid,
//! the seven measures as in `sweep.csv`. A measure is the mean of that of the sequences.

use std::io::{self, Write};

use super::number::significant;
use crate::settings::Value;
use crate::sweep::table::SweepTable;
use crate::truth::measures::{COLUMNS, MeasureColumn, OF_MASKS};

/// The first column.
pub const CATEGORY: &str = "category";

/// Whether some category has masks, so that there are rows.
pub fn has_rows(table: &SweepTable) -> bool {
    let of_masks = of_masks();
    categories(table).any(|(_, sequences)| {
        of_masks.iter().any(|column| sequences.iter().any(|&sequence| table.has(sequence, column)))
    })
}

/// Writes header and rows. A category has no row under a combination under which one of its sequences has none.
pub fn write(out: &mut impl Write, table: &SweepTable) -> io::Result<()> {
    let columns = of_masks();
    let settings = table.grid.axes().iter().map(|axis| axis.setting.name);
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record([CATEGORY].into_iter().chain(settings).chain(columns.iter().map(|column| column.name)))?;
    for (category, sequences) in categories(table) {
        for combination in 0..table.grid.combinations() {
            let means: Vec<_> =
                columns.iter().map(|column| table.mean(&sequences, combination, column)).collect();
            if means.iter().all(Option::is_none) {
                continue;
            }
            let mut fields = vec![category.to_owned()];
            fields.extend(table.grid.values(combination).iter().map(Value::to_string));
            fields.extend(means.iter().map(|mean| mean.map_or_else(String::new, significant)));
            csv.write_record(fields)?;
        }
    }
    csv.flush()
}

fn of_masks() -> Vec<&'static MeasureColumn> {
    COLUMNS.iter().filter(|column| OF_MASKS.contains(&column.name)).collect()
}

/// The categories that have a name.
fn categories(table: &SweepTable) -> impl Iterator<Item = (&str, Vec<usize>)> {
    table.categories().into_iter().filter(|(category, _)| !category.is_empty())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::export::tests::written;
    use crate::sweep::grid::{Axis, Grid};
    use crate::sweep::table::Row;
    use crate::truth::mask_measures::MaskMeasures;
    use crate::truth::measures::{Measures, OBJECTIVE};

    fn table(sequences: &[&str]) -> SweepTable {
        let grid = Grid::new(vec![Axis::of_text("k=3,4").unwrap()]).unwrap();
        let mut rows = Vec::new();
        for (sequence, name) in sequences.iter().enumerate() {
            for combination in 0..2 {
                let f = [0.25, 0.75][combination] + 0.125 * sequence as f64;
                let masks = MaskMeasures {
                    f,
                    precision: 0.5,
                    recall: 0.25,
                    pwc: 4.0,
                    specificity: 0.75,
                    fpr: 0.25,
                    fnr: 0.75,
                };
                let masks = (!name.contains("boxed")).then_some(masks);
                let measures = Measures { masks, ..Measures::default() };
                rows.push(Row { sequence, combination, measures, seconds: 1.0 });
            }
        }
        let sequences = sequences.iter().map(|&name| name.to_owned()).collect();
        SweepTable { grid, sequences, rows, by: &OBJECTIVE }
    }

    #[test]
    fn a_category_has_the_means_of_its_sequences_under_each_combination() {
        let mut table = table(&["shadow/a", "alone", "shadow/b", "fog/c", "boxed/d"]);
        // A sequence of `fog` has no row under the second combination.
        table.rows.retain(|row| (row.sequence, row.combination) != (3, 1));
        assert!(has_rows(&table));
        let expected = "category,k,f,precision,recall,pwc,specificity,fpr,fnr\n\
                        fog,3,0.625,0.5,0.25,4,0.75,0.25,0.75\n\
                        shadow,3,0.375,0.5,0.25,4,0.75,0.25,0.75\n\
                        shadow,4,0.875,0.5,0.25,4,0.75,0.25,0.75\n";
        assert_eq!(written(|out| write(out, &table)), expected);
    }

    #[test]
    fn without_masks_in_categories_there_are_no_rows() {
        assert!(!has_rows(&table(&["a", "b"])));
        assert!(!has_rows(&table(&["boxed/a", "b"])));
    }
}
