//! The report of a sweep: one HTML file that needs no network and reads without scripts too.
//!
//! `results` writes what is best overall and for each sequence, `rows` the table of all rows, `maps` the heat maps,
//! `frames` the measure over time and the worst frames, of `pictures`. `report.js` sorts, filters, draws the other heat
//! maps and shows values under the pointer.

mod escape;
mod frames;
mod maps;
mod pictures;
mod results;
mod rows;
#[cfg(test)]
pub(crate) mod tests;

use std::io::{self, Write};

use self::escape::html;
use crate::settings::Settings;
use crate::sweep::sequence_frames::SequenceFrames;
use crate::sweep::table::SweepTable;
use crate::truth::measures::MeasureColumn;

/// What a report shows.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// The title, such as the name of the data set.
    pub title: &'a str,
    /// The measures of all sequences and combinations.
    pub table: &'a SweepTable,
    /// The frames of sequences, in the order in which they are shown.
    pub frames: &'a [SequenceFrames],
    /// The settings that the grid changes.
    pub base: &'a Settings,
    /// Where the results are from: names and values such as the version, the input, the ground truth and the options.
    pub facts: &'a [(&'a str, String)],
    /// The warnings of the sweep, a line each.
    pub warnings: &'a [String],
}

impl Report<'_> {
    /// The combination that others are compared with: the one that equals the base settings, or else the first.
    fn baseline(&self) -> Baseline {
        match self.table.grid.combination_of(self.base) {
            Some(combination) => Baseline { combination, name: "base settings" },
            None => Baseline { combination: 0, name: "first settings" },
        }
    }

    /// A text that leads to the frames of a sequence, if the report shows them.
    fn link(&self, sequence: usize, text: &str) -> String {
        match self.frames.iter().position(|frames| frames.sequence == sequence) {
            Some(at) => format!("<a href=\"#frames-{at}\">{}</a>", html(text)),
            None => html(text),
        }
    }

    /// A combination in words.
    fn settings_name(&self, combination: usize) -> String {
        let name = self.table.grid.name(combination);
        if name.is_empty() { "the settings as they are".to_owned() } else { name }
    }
}

/// What other combinations are compared with.
struct Baseline {
    combination: usize,
    name: &'static str,
}

/// Writes the report.
pub fn write(out: &mut impl Write, report: &Report<'_>) -> io::Result<()> {
    let title = html(report.title);
    writeln!(out, "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">")?;
    // The page loads nothing, whatever names are in it.
    writeln!(
        out,
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; \
         style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n\
         <title>{title}</title>\n<script>document.documentElement.classList.add(\"js\")</script>\n<style>\n{}</style>\n</head>\n<body>",
        include_str!("report.css")
    )?;
    writeln!(out, "<header>\n<h1>{title}</h1>")?;
    results::write_headline(out, report)?;
    if !report.warnings.is_empty() {
        writeln!(out, "<ul class=\"warnings\" aria-label=\"Warnings\">")?;
        for warning in report.warnings {
            writeln!(out, "<li>{}</li>", html(warning))?;
        }
        writeln!(out, "</ul>")?;
    }
    writeln!(out, "</header>\n<main>")?;
    results::write(out, report)?;
    rows::write(out, report)?;
    maps::write(out, report.table)?;
    frames::write(out, report)?;
    write_provenance(out, report)?;
    writeln!(out, "</main>")?;
    writeln!(
        out,
        "<script type=\"application/json\" id=\"data\">{}</script>\n<script>\n{}</script>\n</body>\n</html>",
        escape::json(&maps::data(report))?,
        include_str!("report.js")
    )
}

fn write_provenance(out: &mut impl Write, report: &Report<'_>) -> io::Result<()> {
    writeln!(out, "<section id=\"provenance\">\n<h2>Settings and provenance</h2>\n<dl>")?;
    for (name, value) in report.facts {
        writeln!(out, "<dt>{}</dt><dd>{}</dd>", html(name), html(value))?;
    }
    for axis in report.table.grid.axes() {
        let values: Vec<String> = axis.values.iter().map(ToString::to_string).collect();
        writeln!(out, "<dt><code>{}</code></dt><dd>{}</dd>", axis.setting.name, html(&values.join(", ")))?;
    }
    writeln!(out, "</dl>\n<h3>Base settings</h3>\n<pre>")?;
    let toml = report.base.to_toml();
    for line in toml.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
        writeln!(out, "{}", html(line))?;
    }
    writeln!(out, "</pre>\n</section>")
}

/// A value in a cell of a table; a dash without one.
fn value_cell(measure: &MeasureColumn, value: Option<f64>) -> String {
    match value {
        Some(value) => format!("<td class=\"n\">{}</td>", measure.text(value)),
        None => "<td class=\"n none\">\u{2013}</td>".to_owned(),
    }
}

/// A header cell of a measure, with its meaning.
fn measure_header(measure: &MeasureColumn) -> String {
    let better = if measure.more_is_better { "" } else { "; less is better" };
    format!(
        "<th scope=\"col\" class=\"n\"{} title=\"{}{better}\">{}</th>",
        more_mark(measure),
        html(measure.meaning),
        html(measure.label)
    )
}

/// The attribute by which the script sorts a column from the greatest value at first.
const fn more_mark(measure: &MeasureColumn) -> &'static str {
    if measure.more_is_better { " data-more" } else { "" }
}

/// The part of a sequence's name before its last `/`, its category; empty if it has none.
fn category(name: &str) -> &str {
    name.rsplit_once('/').map_or("", |(category, _)| category)
}

/// `7 sequences`.
fn counted(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}
