//! The best rows, as text: of each sequence, and of the setting that is best overall.

use std::io::{self, Write};

use crate::sweep::table::SweepTable;
use crate::truth::measures::{COLUMNS, MeasureColumn, OBJECTIVE};

/// Writes a table: the best row of each sequence, then, of several sequences, the row of the combination that
/// is best overall for each category, and for all.
pub(super) fn write(out: &mut impl Write, table: &SweepTable) -> io::Result<()> {
    let by = table.by;
    let mut columns: Vec<&MeasureColumn> =
        COLUMNS.iter().filter(|column| table.sequences_with(column) > 0).collect();
    let ranks_by_both = ["f", "hota"].iter().all(|name| columns.iter().any(|column| column.name == *name));
    if by.name == OBJECTIVE.name && ranks_by_both {
        columns.insert(0, &OBJECTIVE);
    }
    let setting = |combination: usize| match table.grid.name(combination) {
        name if name.is_empty() => "as they are".to_owned(),
        name => name,
    };
    let header = ["sequence", "best settings"].map(ToOwned::to_owned).into_iter();
    let mut lines = vec![header.chain(columns.iter().map(|column| column.label.to_owned())).collect()];
    for (sequence, name) in table.sequences.iter().enumerate() {
        if let Some(best) = table.best(sequence, by) {
            let value = |column: &&MeasureColumn| number(table.value(sequence, best, column), column);
            lines.push(line(name.clone(), setting(best), columns.iter().map(value)));
        }
    }
    if let Some(best) = table.best_overall(by).filter(|_| table.sequences.len() > 1) {
        let categories = table.categories();
        let equal = table.equally_best_overall(by);
        let name =
            if equal > 1 { format!("{}, of {equal} equal ones", setting(best)) } else { setting(best) };
        if categories.len() > 1 {
            for (category, sequences) in categories {
                let value = |column: &&MeasureColumn| number(table.mean(&sequences, best, column), column);
                let category = if category.is_empty() { "(no category)" } else { category };
                lines.push(line(format!("{category}: mean"), name.clone(), columns.iter().map(value)));
            }
        }
        let value = |column: &&MeasureColumn| number(table.overall(best, column), column);
        lines.push(line("overall".to_owned(), name, columns.iter().map(value)));
    }
    write_aligned(out, &lines)
}

fn line(name: String, setting: String, values: impl Iterator<Item = String>) -> Vec<String> {
    [name, setting].into_iter().chain(values).collect()
}

fn number(value: Option<f64>, column: &MeasureColumn) -> String {
    match value {
        None => "–".to_owned(),
        Some(value) if column.name == "switches" && value.fract() == 0.0 => value.to_string(),
        Some(value) => format!("{value:.4}"),
    }
}

/// Writes columns apart by two blanks: the first two to the left, the numbers to the right.
fn write_aligned(out: &mut impl Write, lines: &[Vec<String>]) -> io::Result<()> {
    let widest = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..lines.first().map_or(0, Vec::len)).map(widest).collect();
    for line in lines {
        let cells = line.iter().zip(&widths).enumerate().map(|(column, (text, &width))| {
            if column < 2 { format!("{text:width$}") } else { format!("{text:>width$}") }
        });
        writeln!(out, "{}", cells.collect::<Vec<_>>().join("  ").trim_end())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::tests::written;
    use crate::sweep::grid::{Axis, Grid};
    use crate::sweep::table::Row;
    use crate::truth::mask_measures::MaskMeasures;
    use crate::truth::measures::Measures;

    #[test]
    fn the_best_of_each_sequence_and_the_best_overall_are_told() {
        let row = |sequence, combination, f| {
            let masks = Some(MaskMeasures { f, ..MaskMeasures::default() });
            Row { sequence, combination, measures: Measures { masks, ..Measures::default() }, seconds: 1.0 }
        };
        let table = SweepTable {
            grid: Grid::new(Axis::of_text("k=3,4").into_iter().collect()).unwrap_or_default(),
            sequences: vec!["a/one".to_owned(), "b/two".to_owned()],
            rows: vec![row(0, 0, 0.5), row(0, 1, 0.75), row(1, 0, 0.875), row(1, 1, 0.25)],
            by: &OBJECTIVE,
        };
        let text = written(|out| write(out, &table));
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split_whitespace().collect()).collect();
        assert_eq!(lines[0][..4], ["sequence", "best", "settings", "F"]);
        let expected = [
            ["a/one", "k=4", "0.7500"],
            ["b/two", "k=3", "0.8750"],
            ["a:", "mean", "k=3"],
            ["b:", "mean", "k=3"],
            ["overall", "k=3", "0.6875"],
        ];
        for (line, expected) in lines[1..].iter().zip(expected) {
            assert_eq!(line[..3], expected, "{text}");
        }
    }
}
