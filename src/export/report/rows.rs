//! The table of all rows.

use std::io::{self, Write};

use super::escape::html;
use super::{Report, counted, measure_header};
use crate::export::heat_map::axis_title;
use crate::export::sweep_csv;
use crate::sweep::heat_map::mapped_measures;
use crate::sweep::table::SweepTable;
use crate::truth::measures::{MeasureColumn, OBJECTIVE};

/// Number of rows that the page shows at first, where it can show more on demand.
const SHOWN_FIRST: usize = 200;

/// The measures of the table.
pub(super) fn columns(table: &SweepTable) -> Vec<&'static MeasureColumn> {
    let mut columns = sweep_csv::columns(table);
    if mapped_measures(table).iter().any(|measure| measure.name == OBJECTIVE.name) {
        columns.insert(0, &OBJECTIVE);
    }
    columns
}

/// Writes the table; the script makes its headers sort.
pub(super) fn write(out: &mut impl Write, report: &Report<'_>) -> io::Result<()> {
    let table = report.table;
    let columns = columns(table);
    writeln!(
        out,
        "<section id=\"all\">\n<h2>All rows</h2>\n<div class=\"controls\"></div>\n\
         <div class=\"scroll tall\" tabindex=\"0\" role=\"region\" aria-label=\"All rows\"><table id=\"rows\" class=\"sortable\">\n\
         <caption>{}</caption>\n<thead><tr><th scope=\"col\">sequence</th>",
        counted(table.rows.len(), "row")
    )?;
    for axis in table.grid.axes() {
        write!(
            out,
            "<th scope=\"col\" class=\"n\" title=\"{}\">{}</th>",
            html(&format!("{}: {}", axis_title(axis.setting), axis.setting.meaning.trim())),
            axis.setting.name
        )?;
    }
    for measure in &columns {
        write!(out, "{}", measure_header(measure))?;
    }
    writeln!(
        out,
        "<th scope=\"col\" class=\"n\" title=\"Computing time\">seconds</th></tr></thead>\n<tbody>"
    )?;
    for (at, row) in table.rows.iter().enumerate() {
        if at == SHOWN_FIRST {
            writeln!(out, "</tbody>\n<tbody class=\"rest\">")?;
        }
        let sequence = table.sequences.get(row.sequence).map_or("", String::as_str);
        write!(out, "<tr><td>{}</td>", report.link(row.sequence, sequence))?;
        for value in table.grid.values(row.combination) {
            write!(out, "<td>{value}</td>")?;
        }
        for measure in &columns {
            let value = (measure.of)(&row.measures)
                .map_or_else(|| "\u{2013}".to_owned(), |value| measure.text(value));
            write!(out, "<td>{value}</td>")?;
        }
        writeln!(out, "<td>{:.2}</td></tr>", row.seconds)?;
    }
    writeln!(out, "</tbody></table></div>\n</section>")
}
