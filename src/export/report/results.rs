//! What is best: overall, by category, and for each sequence.

use std::io::{self, Write};

use super::escape::html;
use super::{Report, category, counted, measure_header, more_mark, value_cell};
use crate::export::sweep_csv;
use crate::sweep::heat_map::mapped_measures;
use crate::truth::mask_measures::DataSetMeasures;
use crate::truth::measures::{self, MeasureColumn, Measures, OBJECTIVE};

/// Largest number of combinations that are drawn as marks of their own.
const MAX_MARKS: usize = 400;
/// The width of the drawing of a sequence's values.
const STRIP: f64 = 120.0;

/// The measure by which combinations are ranked.
fn ranking(report: &Report<'_>) -> &'static MeasureColumn {
    mapped_measures(report.table).first().copied().unwrap_or(&OBJECTIVE)
}

/// The result in one sentence, and the flags of the best combination.
pub(super) fn write_headline(out: &mut impl Write, report: &Report<'_>) -> io::Result<()> {
    let (table, measure) = (report.table, ranking(report));
    let combinations = table.grid.combinations();
    let sequences = counted(table.sequences_with(measure), "sequence");
    let Some(best) = table.best_overall(measure) else {
        return writeln!(
            out,
            "<p class=\"result\">No combination of the {combinations} has a score of all {sequences}.</p>"
        );
    };
    let text = |combination| {
        table.overall(combination, measure).map_or_else(|| "none".to_owned(), |v| measure.text(v))
    };
    let label = html(measure.label);
    if combinations == 1 {
        let name = html(&report.settings_name(best));
        writeln!(
            out,
            "<p class=\"result\">The {label} of {sequences} is <strong>{}</strong> with {name}.</p>",
            text(best)
        )?;
        return write_meaning(out, measure);
    }
    let equal = table.equally_best_overall(measure);
    if equal > 1 {
        writeln!(
            out,
            "<p class=\"result\">Of {combinations} combinations of settings {equal} are equally good over {sequences}: \
             {label} <strong>{}</strong>. The first of them is shown below: <strong>{}</strong>.</p>",
            text(best),
            html(&report.settings_name(best))
        )?;
        return write_meaning(out, measure);
    }
    let baseline = report.baseline();
    let comparison = if best == baseline.combination {
        format!("these are the {}", baseline.name)
    } else {
        let [ours, theirs] =
            [best, baseline.combination].map(|combination| table.overall(combination, measure));
        let gain =
            ours.zip(theirs).map_or_else(String::new, |(ours, theirs)| format!(" ({:+.3})", ours - theirs));
        format!(
            "against {} with the {}{}",
            text(baseline.combination),
            baseline.name,
            gain.replace('-', "\u{2212}")
        )
    };
    writeln!(
        out,
        "<p class=\"result\">Of {combinations} combinations of settings <strong>{}</strong> is the best over {sequences}: \
         {label} <strong>{}</strong>, {comparison}.</p>",
        html(&report.settings_name(best)),
        text(best)
    )?;
    let flags = table.grid.axes().iter().zip(table.grid.values(best));
    let flags: Vec<String> =
        flags.map(|(axis, value)| format!("--{} {value}", axis.setting.flag())).collect();
    writeln!(out, "<p class=\"flags\"><code>{}</code></p>", html(&flags.join(" ")))?;
    write_meaning(out, measure)
}

/// What the measure by which settings are ranked is.
fn write_meaning(out: &mut impl Write, measure: &MeasureColumn) -> io::Result<()> {
    writeln!(
        out,
        "<p class=\"note\">{}: {}. Of all sequences it is the mean, in which categories weigh the same.</p>",
        html(measure.label),
        html(measure.meaning)
    )
}

/// The tables of all sequences, of each, and of categories.
pub(super) fn write(out: &mut impl Write, report: &Report<'_>) -> io::Result<()> {
    let measure = ranking(report);
    writeln!(out, "<section id=\"results\">\n<h2>Results</h2>")?;
    write_overall(out, report, measure)?;
    if report.table.sequences.len() > 1 && report.table.grid.combinations() > 1 {
        write_sequences(out, report, measure)?;
    }
    write_categories(out, report, measure)?;
    writeln!(out, "</section>")
}

/// The combinations that are compared: the best overall and the baseline, each with its name.
fn compared(report: &Report<'_>, measure: &MeasureColumn) -> Vec<(&'static str, usize)> {
    let baseline = report.baseline();
    let mut compared = vec![(baseline.name, baseline.combination)];
    if let Some(best) = report.table.best_overall(measure).filter(|best| *best != baseline.combination) {
        compared.insert(0, ("best overall", best));
    }
    compared
}

fn write_overall(out: &mut impl Write, report: &Report<'_>, ranking: &MeasureColumn) -> io::Result<()> {
    let table = report.table;
    let mut measures = sweep_csv::columns(table);
    if ranking.name == OBJECTIVE.name {
        measures.insert(0, &OBJECTIVE);
    }
    writeln!(
        out,
        "<div class=\"scroll\"><table>\n<caption>All sequences</caption>\n<thead><tr><th scope=\"col\">settings</th>"
    )?;
    for measure in &measures {
        write!(out, "{}", measure_header(measure))?;
    }
    writeln!(out, "</tr></thead>\n<tbody>")?;
    for (name, combination) in compared(report, ranking) {
        let settings = html(&table.grid.name(combination));
        write!(out, "<tr><th scope=\"row\">{name} <span class=\"settings\">{settings}</span></th>")?;
        for measure in &measures {
            write!(out, "{}", value_cell(measure, table.overall(combination, measure)))?;
        }
        writeln!(out, "</tr>")?;
    }
    writeln!(out, "</tbody></table></div>")
}

fn write_sequences(out: &mut impl Write, report: &Report<'_>, measure: &MeasureColumn) -> io::Result<()> {
    let table = report.table;
    let (compared, ends) = (compared(report, measure), ends(report, measure));
    writeln!(
        out,
        "<div class=\"scroll\"><table class=\"sortable\">\n<caption>{} of each sequence</caption>",
        html(measure.label)
    )?;
    write!(out, "<thead><tr><th scope=\"col\">sequence</th>")?;
    let more = more_mark(measure);
    for (name, _) in &compared {
        write!(out, "<th scope=\"col\" class=\"n\"{more}>{name}</th>")?;
    }
    writeln!(
        out,
        "<th scope=\"col\" class=\"n\"{more}>its best</th><th scope=\"col\">its best settings</th>\
         <th scope=\"col\" data-unsorted title=\"The dot is the best overall\">all settings, {} to {}</th></tr></thead>\n<tbody>",
        measure.text(ends.0),
        measure.text(ends.1)
    )?;
    let columns = compared.len() + 4;
    let mut last = None;
    for at in in_categories(&table.sequences) {
        let name = &table.sequences[at];
        let category = category(name);
        if last != Some(category) && !category.is_empty() {
            writeln!(
                out,
                "</tbody>\n<tbody><tr class=\"group\"><th colspan=\"{columns}\" scope=\"rowgroup\">{}</th></tr>",
                html(category)
            )?;
        }
        last = Some(category);
        let (above, shown) = name.split_at(if category.is_empty() { 0 } else { category.len() + 1 });
        let above = if above.is_empty() {
            String::new()
        } else {
            // Shown where sorting removes the categories' own lines.
            format!("<span class=\"category\">{}</span>", html(above))
        };
        write!(out, "<tr><th scope=\"row\">{above}{}</th>", report.link(at, shown))?;
        for (_, combination) in &compared {
            write!(out, "{}", value_cell(measure, table.value(at, *combination, measure)))?;
        }
        let best = table.best(at, measure);
        let value = best.and_then(|best| table.value(at, best, measure));
        let settings = best.map(|best| table.grid.name(best)).unwrap_or_default();
        writeln!(
            out,
            "{}<td class=\"settings\">{}</td><td>{}</td></tr>",
            value_cell(measure, value),
            html(&settings),
            strip(report, at, measure, ends, &compared)
        )?;
    }
    writeln!(out, "</tbody></table></div>")
}

/// The indices of sequences, those of a category together, in the order of their first.
fn in_categories(names: &[String]) -> Vec<usize> {
    let first = |name: &str| names.iter().position(|other| category(other) == category(name));
    let mut indices: Vec<usize> = (0..names.len()).collect();
    indices.sort_by_cached_key(|&at| first(&names[at]));
    indices
}

/// The least and the greatest value of all sequences and combinations.
fn ends(report: &Report<'_>, measure: &MeasureColumn) -> (f64, f64) {
    let values = report.table.rows.iter().filter_map(|row| (measure.of)(&row.measures));
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

/// The values of a sequence under all combinations, as marks on a line between `low` and `high`, that of the best overall
/// as a dot.
fn strip(
    report: &Report<'_>,
    sequence: usize,
    measure: &MeasureColumn,
    (low, high): (f64, f64),
    compared: &[(&str, usize)],
) -> String {
    let table = report.table;
    let value = |combination| table.value(sequence, combination, measure);
    let place = |value: f64| if high > low { (value - low) / (high - low) * STRIP } else { STRIP / 2.0 };
    let values: Vec<f64> = (0..table.grid.combinations()).filter_map(value).collect();
    let Some(least) = values.iter().copied().reduce(f64::min) else { return String::new() };
    let greatest = values.iter().copied().fold(least, f64::max);
    let drawn = if values.len() <= MAX_MARKS { &values[..] } else { &[] };
    let marks: Vec<String> = drawn.iter().map(|&value| format!("M{:.1} 4v8", place(value))).collect();
    let dot = compared.first().and_then(|(_, combination)| value(*combination));
    let dot = dot
        .map_or_else(String::new, |value| format!("<circle cx=\"{:.1}\" cy=\"8\" r=\"3.5\"/>", place(value)));
    format!(
        "<svg class=\"strip\" viewBox=\"-4 0 {} 16\" role=\"img\" aria-label=\"{} to {}\">\
         <path class=\"axis\" d=\"M0 8H{STRIP}\"/><path class=\"span\" d=\"M{:.1} 8H{:.1}\"/>\
         <path class=\"marks\" d=\"{}\"/>{dot}</svg>",
        STRIP + 8.0,
        measure.text(least),
        measure.text(greatest),
        place(least),
        place(greatest),
        marks.concat()
    )
}

/// CDnet's measures of each category under the best combination, where masks are in categories.
fn write_categories(out: &mut impl Write, report: &Report<'_>, measure: &MeasureColumn) -> io::Result<()> {
    // CDnet's order.
    const NAMES: [&str; 7] = ["recall", "specificity", "fpr", "fnr", "pwc", "precision", "f"];
    let columns = NAMES.map(measures::column);
    let columns: Vec<&MeasureColumn> = columns.into_iter().flatten().collect();
    let table = report.table;
    let Some(&(name, combination)) = compared(report, measure).first() else { return Ok(()) };
    let sequences = table.sequences.iter().enumerate().filter(|(_, name)| !category(name).is_empty());
    let masks = sequences
        .filter_map(|(at, name)| Some((category(name), table.row(at, combination)?.measures.masks?)));
    let Some(DataSetMeasures { categories, overall }) = DataSetMeasures::new(masks) else { return Ok(()) };
    writeln!(
        out,
        "<div class=\"scroll\"><table class=\"sortable\">\n<caption>Masks by category, {name}: means of sequences, and their mean, as CDnet \
         ranks</caption>\n<thead><tr><th scope=\"col\">category</th>"
    )?;
    for column in &columns {
        write!(out, "{}", measure_header(column))?;
    }
    writeln!(out, "</tr></thead>\n<tbody>")?;
    let overall = ("mean of categories".to_owned(), overall);
    let count = categories.len();
    for (at, (category, masks)) in categories.into_iter().chain([overall]).enumerate() {
        let class = if at == count { " class=\"total\"" } else { "" };
        write!(out, "<tr{class}><th scope=\"row\">{}</th>", html(&category))?;
        let measures = Measures { masks: Some(masks), ..Measures::default() };
        for value in columns.iter().filter_map(|column| (column.of)(&measures)) {
            write!(out, "<td class=\"n\">{value:.4}</td>")?;
        }
        writeln!(out, "</tr>")?;
    }
    writeln!(out, "</tbody></table></div>")
}
