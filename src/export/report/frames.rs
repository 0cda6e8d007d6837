//! The measure of each frame over time, and the worst frames as pictures.

use std::io::{self, Write};
use std::ops::Range;

use serde::Serialize;

use super::escape::html;
use super::pictures::{self, Views};
use super::{Report, counted};
use crate::sweep::sequence_frames::{FrameMeasure, SequenceFrames};

/// Largest number of points of a curve; a point is the lowest of several frames where there are more.
const MAX_POINTS: usize = 600;
/// Most frames of all sequences that are shown as pictures.
const MAX_SHOWN: usize = 100;
/// The drawing's width and height, which the page stretches.
const SIZE: [f64; 2] = [1000.0, 100.0];

/// The points of a curve, for the script.
#[derive(Serialize)]
pub(super) struct Curve {
    /// Frame numbers.
    numbers: Vec<u32>,
    values: Vec<f64>,
}

/// The curve of a sequence: of each part of its frames the lowest.
pub(super) fn curve(frames: &SequenceFrames) -> Curve {
    let lowest = parts(frames.values.len()).filter_map(|part| {
        let values = frames.values[part].iter();
        values.copied().reduce(|lowest, next| if next.1 < lowest.1 { next } else { lowest })
    });
    let (numbers, values) =
        lowest.map(|(number, value)| (number, (f64::from(value) * 1e4).round() / 1e4)).unzip();
    Curve { numbers, values }
}

/// Equal parts of a number of frames, at most as many as a curve has points.
fn parts(count: usize) -> impl Iterator<Item = Range<usize>> {
    let points = count.min(MAX_POINTS);
    (0..points).map(move |at| at * count / points..(at + 1) * count / points)
}

/// Writes the curve and the pictures of each sequence.
pub(super) fn write(out: &mut impl Write, report: &Report<'_>) -> io::Result<()> {
    if report.frames.is_empty() {
        return Ok(());
    }
    writeln!(out, "<section id=\"frames\">\n<h2>Frames</h2>")?;
    let shown: usize = report.frames.iter().map(|frames| frames.worst.len()).sum();
    let each = if shown > MAX_SHOWN { (MAX_SHOWN / report.frames.len()).max(1) } else { usize::MAX };
    let width = pictures::width(shown.min(MAX_SHOWN));
    if report.frames.iter().any(|frames| frames.measure == FrameMeasure::Mask) {
        write!(out, "<p class=\"legend\">")?;
        for (colour, meaning) in pictures::LEGEND {
            let [r, g, b] = colour;
            write!(out, "<span><i style=\"background:rgb({r},{g},{b})\"></i>{meaning}</span> ")?;
        }
        writeln!(out, "</p>")?;
    }
    for (at, frames) in report.frames.iter().enumerate() {
        write_sequence(out, report, (at, frames), each, width)?;
    }
    if shown > MAX_SHOWN {
        writeln!(out, "<p class=\"note\">Of {shown} worst frames the first of each sequence are shown.</p>")?;
    }
    writeln!(out, "</section>")
}

fn write_sequence(
    out: &mut impl Write,
    report: &Report<'_>,
    (at, frames): (usize, &SequenceFrames),
    each: usize,
    width: u32,
) -> io::Result<()> {
    let name = report.table.sequences.get(frames.sequence).map_or("", String::as_str);
    let measure = match frames.measure {
        FrameMeasure::Mask => "F of the mask",
        FrameMeasure::Boxes => "F of the boxes",
    };
    let settings = report.table.grid.name(frames.combination);
    writeln!(
        out,
        "<article id=\"frames-{at}\">\n<h3>{} <span class=\"settings\">{}</span></h3>",
        html(name),
        html(&settings)
    )?;
    write_curve(out, at, frames, measure, each)?;
    for shown in frames.worst.iter().take(each) {
        let number = shown.input.number;
        writeln!(
            out,
            "<div class=\"frame\" id=\"frame-{at}-{number}\"><h4>Frame {number} <span>{measure} {:.3}</span></h4>\n\
             <div class=\"views\">",
            shown.value
        )?;
        let Views { input, truth, ours, size: (width, height) } =
            pictures::views(shown, frames.measure, width)?;
        for (caption, picture) in [("input", input), ("truth", truth), ("ours", ours)] {
            writeln!(
                out,
                "<figure><img src=\"{picture}\" alt=\"{caption} of frame {number}\" width=\"{width}\" \
                 height=\"{height}\" decoding=\"async\">\
                 <figcaption>{caption}</figcaption></figure>"
            )?;
        }
        writeln!(out, "</div></div>")?;
    }
    writeln!(out, "</article>")
}

fn write_curve(
    out: &mut impl Write,
    at: usize,
    frames: &SequenceFrames,
    measure: &str,
    each: usize,
) -> io::Result<()> {
    let Curve { numbers, values } = curve(frames);
    let (Some(&first), Some(&last)) = (numbers.first(), numbers.last()) else {
        return writeln!(out, "<p class=\"note\">No frame has something true or found in it.</p>");
    };
    let count = frames.values.len();
    let mean = frames.values.iter().map(|(_, value)| f64::from(*value)).sum::<f64>() / count as f64;
    let share = |number: u32| {
        if last > first { f64::from(number - first) / f64::from(last - first) } else { 0.5 }
    };
    let height = |value: f64| (1.0 - value.clamp(0.0, 1.0)) * SIZE[1];
    // A step of three usual ones is a gap, where nothing is judged.
    let mut steps: Vec<u32> = numbers.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_unstable();
    let gap = 3 * steps.get(steps.len() / 2).copied().unwrap_or(1).max(1);
    let mut path = String::new();
    let mut before: Option<u32> = None;
    for (&number, &value) in numbers.iter().zip(&values) {
        let (x, y) = (share(number) * SIZE[0], height(value));
        let apart = before.is_none_or(|before| number - before >= gap);
        // A line of no length makes a frame between gaps visible.
        let point = if apart { format!("M{x:.1} {y:.1}h0") } else { format!("L{x:.1} {y:.1}") };
        path.push_str(&point);
        before = Some(number);
    }
    let points = match count.div_ceil(MAX_POINTS) {
        1 => String::new(),
        each => format!("; a point is the lowest of about {each} frames"),
    };
    writeln!(
        out,
        "<figure class=\"curve\" data-curve=\"{at}\"><figcaption>{measure}, {}, mean {mean:.3}{points}<output></output>\
         </figcaption>\n<div class=\"plot\"><div class=\"area\"><span class=\"y\" style=\"top:0\">1</span>\
         <span class=\"y\" style=\"top:50%\">0.5</span><span class=\"y\" style=\"top:100%\">0</span>\
         <svg viewBox=\"0 0 {} {}\" preserveAspectRatio=\"none\" role=\"img\" aria-label=\"{measure} over frames {first} to \
         {last}, mean {mean:.3}\"><path class=\"grid\" d=\"M0 0H{w}M0 50H{w}M0 100H{w}\"/><path class=\"mean\" d=\"M0 {:.1}H{w}\"/>\
         <path class=\"line\" d=\"{path}\"/></svg>",
        counted(count, "judged frame"),
        SIZE[0],
        SIZE[1],
        height(mean),
        w = SIZE[0]
    )?;
    for shown in frames.worst.iter().take(each) {
        let number = shown.input.number;
        write!(
            out,
            "<a class=\"worst\" href=\"#frame-{at}-{number}\" title=\"frame {number}: {:.3}\" \
             style=\"left:{:.2}%;top:{:.2}%\"></a>",
            shown.value,
            100.0 * share(number.clamp(first, last)),
            height(f64::from(shown.value))
        )?;
    }
    writeln!(
        out,
        "</div><span class=\"x\">{first}</span><span class=\"x middle\">frame</span><span class=\"x last\">{last}</span>\
         </div></figure>"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_the_lowest_of_its_frames() {
        let frames = |count: u32| SequenceFrames {
            sequence: 0,
            combination: 0,
            measure: FrameMeasure::Mask,
            values: (0..count).map(|at| (at + 5, if at == 1234 { 0.25 } else { 0.5 })).collect(),
            worst: Vec::new(),
        };
        let long = curve(&frames(3000));
        assert_eq!(long.numbers.len(), MAX_POINTS);
        let lowest = long.values.iter().position(|&value| value == 0.25).map(|at| long.numbers[at]);
        assert_eq!(lowest, Some(1239));
        let short = curve(&frames(9));
        assert_eq!(short.numbers, (5..14).collect::<Vec<_>>());
        assert!(curve(&frames(0)).numbers.is_empty());
    }
}
