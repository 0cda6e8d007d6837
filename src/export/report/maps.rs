//! The heat maps: one as a table, all others drawn from data by the script.

use std::io::{self, Write};

use serde::Serialize;

use super::escape::html;
use super::frames::{self, Curve};
use super::{Report, rows};
use crate::export::heat_map::{axis_title, needs_dark_text, open_axes};
use crate::palette::ramp;
use crate::regions::Rgb;
use crate::sweep::grid::Axis;
use crate::sweep::heat_map::{HeatMap, Subject, mapped_measures, maps_of};
use crate::sweep::table::SweepTable;
use crate::truth::measures::MeasureColumn;

/// Number of colours that the script gets of the ramp.
const COLOURS: usize = 64;

/// What the script reads.
#[derive(Serialize)]
pub(super) struct Data<'a> {
    axes: Vec<AxisData>,
    measures: Vec<MeasureData>,
    /// The maps, as indices of axes: across and down.
    maps: Vec<(usize, Option<usize>)>,
    sequences: &'a [String],
    /// Of each row its sequence, its combination, its measures and its time.
    rows: Vec<(usize, usize, Vec<Option<f64>>, f64)>,
    /// The mapped measures of all sequences, by combination.
    overall: Vec<Vec<Option<f64>>>,
    /// The colours of the ramp, and whether text on them is dark.
    ramp: Vec<(String, bool)>,
    curves: Vec<Curve>,
}

#[derive(Serialize)]
struct AxisData {
    name: &'static str,
    title: String,
    values: Vec<String>,
}

#[derive(Serialize)]
struct MeasureData {
    label: &'static str,
    more: bool,
    /// Decimals on the screen.
    decimals: usize,
    /// The index among the mapped measures, if it is one.
    mapped: Option<usize>,
}

/// The data of a report.
pub(super) fn data<'a>(report: &Report<'a>) -> Data<'a> {
    let table = report.table;
    let (columns, mapped) = (rows::columns(table), mapped_measures(table));
    let axis = |axis: &Axis| AxisData {
        name: axis.setting.name,
        title: axis_title(axis.setting),
        values: axis.values.iter().map(ToString::to_string).collect(),
    };
    let measure = |measure: &&MeasureColumn| MeasureData {
        label: measure.label,
        more: measure.more_is_better,
        decimals: measure.decimals(),
        mapped: mapped.iter().position(|other| other.name == measure.name),
    };
    let values =
        |combination| mapped.iter().map(|measure| table.overall(combination, measure).map(short)).collect();
    Data {
        axes: table.grid.axes().iter().map(axis).collect(),
        measures: columns.iter().map(measure).collect(),
        maps: maps_of(&table.grid).iter().map(|axes| (axes.across, axes.down)).collect(),
        sequences: &table.sequences,
        rows: table
            .rows
            .iter()
            .map(|row| {
                let measures = columns.iter().map(|column| (column.of)(&row.measures).map(short)).collect();
                (row.sequence, row.combination, measures, short(row.seconds))
            })
            .collect(),
        overall: (0..table.grid.combinations()).map(values).collect(),
        ramp: (0..COLOURS)
            .map(|step| {
                let colour = ramp(step as f32 / (COLOURS - 1) as f32);
                (hex(colour), needs_dark_text(colour))
            })
            .collect(),
        curves: report.frames.iter().map(frames::curve).collect(),
    }
}

/// A number without invisible digits.
fn short(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Writes the first map of all sequences; nothing if no setting has several values.
pub(super) fn write(out: &mut impl Write, table: &SweepTable) -> io::Result<()> {
    let (Some(&axes), Some(&measure)) = (maps_of(&table.grid).first(), mapped_measures(table).first()) else {
        return Ok(());
    };
    let map = HeatMap::new(table, Subject::All, measure, axes);
    let axis = |at: usize| table.grid.axes().get(at);
    let (Some(across), down) = (axis(axes.across), axes.down.and_then(axis)) else { return Ok(()) };
    writeln!(
        out,
        "<section id=\"maps\">\n<h2>Heat maps</h2>\n<div class=\"controls\"></div>\n\
         <div class=\"scroll\" id=\"map\"><table class=\"map\">\n<caption>{}, all sequences<span>{}</span></caption>\n<thead>",
        html(measure.label),
        html(&open_axes(table, axes))
    )?;
    let corner = down.map_or_else(String::new, |down| html(&axis_title(down.setting)));
    writeln!(
        out,
        "<tr><td></td><th scope=\"colgroup\" colspan=\"{}\">{}</th></tr>\n<tr><th scope=\"col\">{corner}</th>",
        map.columns,
        html(&axis_title(across.setting))
    )?;
    for value in &across.values {
        write!(out, "<th scope=\"col\">{value}</th>")?;
    }
    writeln!(out, "</tr></thead>\n<tbody>")?;
    let best = map.best();
    for (row, cells) in map.cells.chunks(map.columns.max(1)).enumerate() {
        let value = down.and_then(|down| down.values.get(row)).map_or_else(String::new, ToString::to_string);
        write!(out, "<tr><th scope=\"row\">{value}</th>")?;
        for (column, cell) in cells.iter().enumerate() {
            let Some(cell) = cell else {
                write!(out, "<td class=\"missing\"></td>")?;
                continue;
            };
            let colour = ramp(map.share(cell.value));
            let class = if best == Some(row * map.columns + column) { " class=\"best\"" } else { "" };
            let ink = if needs_dark_text(colour) { "#000" } else { "#fff" };
            write!(
                out,
                "<td{class} style=\"background:{};color:{ink}\" title=\"{}\">{}</td>",
                hex(colour),
                html(&table.grid.name(cell.combination)),
                measure.text(cell.value)
            )?;
        }
        writeln!(out, "</tr>")?;
    }
    writeln!(
        out,
        "</tbody></table></div>\n<p class=\"note\">The value of a cell is the best over all other settings; brighter is \
         better, and a small difference takes a part of the colours. A frame marks the best cell, hatching cells without a value.</p>\n</section>"
    )
}
