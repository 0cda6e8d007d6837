//! Reports of made-up sweeps. With `OCCLUSCOPE_REPORTS=DIR` they are written into the existing folder `DIR`, to be looked
//! at.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use super::*;
use crate::export::tests::written;
use crate::frame::{Frame, Mask, Size};
use crate::sweep::grid::{Axis, Grid};
use crate::sweep::sequence_frames::{FrameMeasure, ShownFrame};
use crate::sweep::table::Row;
use crate::truth::boxes::Bounds;
use crate::truth::hota::Hota;
use crate::truth::mask_measures::MaskMeasures;
use crate::truth::masks::{Label, TrueMask};
use crate::truth::measures::{EpisodeMeasures, Measures, OBJECTIVE, TrackMeasures};

/// A made-up sweep.
pub(crate) struct Data {
    pub(crate) axes: &'static [&'static str],
    pub(crate) sequences: usize,
    pub(crate) categories: usize,
    pub(crate) tracks: bool,
}

impl Default for Data {
    fn default() -> Self {
        Self { axes: &[], sequences: 1, categories: 0, tracks: true }
    }
}

const AXES: &[&str] = &["k=3,4,5,6", "alpha=log:0.0005..0.05:4", "t=0.6,0.7,0.8,0.9"];

/// A number 0..1 that differs from seed to seed.
fn noise(seed: usize) -> f64 {
    let mixed = (seed as u64).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((mixed ^ (mixed >> 31)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 40) as f64 / (1_u64 << 24) as f64
}

/// Its table: each axis has a best value, and sequences differ in difficulty.
pub(crate) fn table(data: &Data) -> SweepTable {
    let axes = data.axes.iter().map(|text| Axis::of_text(text).unwrap()).collect();
    let grid = Grid::new(axes).unwrap();
    let name = |at: usize| {
        let words = ["canoe", "fall", "highway", "office", "pedestrians", "sofa", "tramCrossroad"];
        let word = format!("{}{:02}", words[at % words.len()], at + 1);
        match data.categories {
            0 => word,
            count => format!(
                "{}/{word}",
                ["baseline", "dynamicBackground", "shadow", "thermal"][at % count.min(4)]
            ),
        }
    };
    let mut rows = Vec::new();
    for sequence in 0..data.sequences {
        for combination in 0..grid.combinations() {
            let distance: f64 = grid
                .indices(combination)
                .iter()
                .enumerate()
                .map(|(axis, &at)| {
                    let best = 1.2 + noise(sequence * 8 + axis);
                    (at as f64 - best).powi(2) * 0.04
                })
                .sum();
            let difficulty = 0.3 * noise(sequence + 77);
            let f = (0.97 - difficulty - distance).max(0.02) + 0.01 * noise(sequence * 99 + combination);
            let masks = MaskMeasures {
                f,
                precision: (f + 0.03).min(1.0),
                recall: f - 0.02,
                pwc: 8.0 * (1.0 - f),
                specificity: 0.99,
                fpr: 0.01,
                fnr: 1.02 - f,
            };
            let hota = Hota { hota: 0.7 * f + 0.05, deta: f, assa: 0.5, loca: 0.8 };
            let switches = (20.0 * (1.0 - f)) as usize;
            let mota = 1.2 * f - 0.3;
            let tracks = TrackMeasures { mota, idf1: 0.8 * f, hota, switches, identities_kept: None };
            let episodes = EpisodeMeasures { episode_recall: f, episode_precision: 0.9 * f };
            let measures = Measures {
                masks: Some(masks),
                tracks: data.tracks.then_some(tracks),
                episodes: data.tracks.then_some(episodes),
            };
            rows.push(Row { sequence, combination, measures, seconds: 3.0 + f });
        }
    }
    SweepTable { grid, sequences: (0..data.sequences).map(name).collect(), rows, by: &OBJECTIVE }
}

/// Discs on a coloured ground, found with an error.
fn shown(number: u32, size: Size, value: f32) -> ShownFrame {
    let disc = |x: u32, y: u32, centre: [f32; 2], radius: f32| {
        (x as f32 - centre[0]).hypot(y as f32 - centre[1]) < radius
    };
    let (width, height) = (size.width as f32, size.height as f32);
    let centres = [[0.3 * width, 0.5 * height], [0.7 * width, 0.4 * height]];
    let radius = 0.18 * height;
    let pixels = || (0..size.height).flat_map(move |y| (0..size.width).map(move |x| (x, y)));
    let is_true = |x, y| centres.iter().any(|&centre| disc(x, y, centre, radius));
    let is_found = |x, y| {
        disc(x, y, [centres[0][0] + 0.08 * width, centres[0][1]], radius)
            || disc(x, y, centres[1], 0.7 * radius)
    };
    let label = |(x, y)| match () {
        () if y < size.height / 10 => Label::Uncounted,
        () if is_true(x, y) => Label::Foreground,
        () => Label::Background,
    };
    let rgb = pixels().flat_map(|(x, y)| {
        let grain = (noise((x + y * size.width) as usize) * 24.0) as u8;
        let ground = [60 + (90 * x / size.width) as u8, 110 + grain, 60 + (90 * y / size.height) as u8];
        if is_true(x, y) { [190 + grain, 60, 50] } else { ground }
    });
    let mut mask = Mask::empty(size);
    for (value, (x, y)) in mask.data.iter_mut().zip(pixels()) {
        *value = if is_found(x, y) { Mask::FOREGROUND } else { Mask::BACKGROUND };
    }
    let bounds = |[x, y]: [f32; 2], r: f32| Bounds([x - r, y - r, 2.0 * r, 2.0 * r].map(f64::from));
    let boxes = |moved: f32| {
        let [a, b] = centres;
        vec![(1, bounds([a[0] + moved, a[1]], radius)), (2, bounds(b, radius))]
    };
    ShownFrame {
        input: Frame::new(number, size, rgb.collect()),
        value,
        true_mask: Some(TrueMask::new(size, pixels().map(label))),
        true_boxes: boxes(0.0),
        mask,
        boxes: boxes(0.08 * width),
    }
}

fn frames_of(data: &Data, count: u32, size: Size, worst: usize) -> Vec<SequenceFrames> {
    let of = |sequence: usize| {
        let numbers = (470..470 + count).filter(|number| !(600..640).contains(number));
        let value = |number: u32| {
            let wave = (f64::from(number) / 40.0 + sequence as f64).sin();
            (0.75 + 0.2 * wave - 0.15 * noise(number as usize + 1000 * sequence)).clamp(0.0, 1.0) as f32
        };
        let values: Vec<(u32, f32)> = numbers.map(|number| (number, value(number))).collect();
        let mut sorted = values.clone();
        sorted.sort_by(|a, b| a.1.total_cmp(&b.1));
        let worst = sorted.iter().take(worst).map(|&(number, value)| shown(number, size, value)).collect();
        let measure = if data.tracks && sequence % 2 == 1 { FrameMeasure::Boxes } else { FrameMeasure::Mask };
        SequenceFrames { sequence, combination: 0, measure, values, worst }
    };
    (0..data.sequences).map(of).collect()
}

fn facts() -> Vec<(&'static str, String)> {
    vec![
        ("version", "0.1.0".to_owned()),
        ("data set", "/data/cdnet".to_owned()),
        ("ground truth", "groundtruth".to_owned()),
        ("options", "--every 1".to_owned()),
    ]
}

/// The report, written for a look under this name.
fn report(
    name: &str,
    data: &Data,
    table: &SweepTable,
    frames: &[SequenceFrames],
    warnings: &[String],
) -> String {
    let facts = facts();
    let base = Settings::default();
    let title = if data.sequences == 1 { "canoe.mp4" } else { "cdnet" };
    let report = Report { title, table, frames, base: &base, facts: &facts, warnings };
    let text = written(|out| write(out, &report));
    if let Some(folder) = std::env::var_os("OCCLUSCOPE_REPORTS") {
        std::fs::write(Path::new(&folder).join(name), &text).unwrap();
    }
    text
}

#[test]
fn a_report_holds_every_row_and_picture() {
    let data = Data { axes: AXES, ..Data::default() };
    let mut sweep = table(&data);
    sweep.rows.retain(|row| row.combination != 17);
    let frames = frames_of(&data, 700, Size::new(720, 480), 4);
    let text =
        report("one.html", &data, &sweep, &frames, &["frame 12 cannot be read; it is left out".to_owned()]);
    assert_eq!(text.matches("<tr><td><a href=\"#frames-0\">canoe01</a></td>").count(), 63);
    assert_eq!(text.matches("<img src=\"data:image/").count(), 4 * 3);
    assert!(text.contains("Of 64 combinations of settings <strong>k=5 "), "the result is told");
    assert!(text.contains("frame 12 cannot be read") && text.contains("k = 3\n"));
}

#[test]
fn a_data_set_has_means_of_its_categories() {
    let data = Data { sequences: 7, categories: 3, ..Data::default() };
    let sweep = table(&data);
    let frames = frames_of(&data, 300, Size::new(360, 240), 3);
    let text = report("seven.html", &data, &sweep, &frames, &[]);
    assert!(text.contains("with the settings as they are.") && !text.contains("id=\"maps\""));
    let masks = sweep.sequences.iter().zip(&sweep.rows);
    let means = masks.map(|(name, row)| (category(name), row.measures.masks.unwrap()));
    let means = crate::truth::mask_measures::DataSetMeasures::new(means).unwrap();
    assert!(text.contains(&format!("<td class=\"n\">{:.4}</td></tr>\n</tbody>", means.overall.f)));
}

#[test]
fn tables_of_sequences_and_categories_sort_as_that_of_rows() {
    let data = Data { axes: &["k=3,4"], sequences: 7, categories: 3, ..Data::default() };
    let text = report("sorted.html", &data, &table(&data), &[], &[]);
    let tables: Vec<&str> = text.split("<table").skip(1).filter(|part| part.contains("</table>")).collect();
    let sortable = tables
        .iter()
        .filter(|table| table.split('>').next().is_some_and(|start| start.contains("class=\"sortable\"")));
    let sortable: Vec<_> = sortable.collect();
    let captions = sortable
        .iter()
        .map(|table| table.split("<caption>").nth(1).unwrap().split(['<', ',']).next().unwrap());
    assert_eq!(captions.collect::<Vec<_>>(), ["score of each sequence", "Masks by category", "14 rows"]);
    // The greatest is first where more is better; a drawing sorts nothing.
    let header = |table: &str, label: &str| {
        table.split("<th ").find(|cell| cell.contains(&format!(">{label}</th>"))).unwrap().to_owned()
    };
    assert!(header(sortable[0], "its best").contains(" data-more"));
    assert!(
        sortable[0].split("<th ").any(|cell| cell.contains("data-unsorted") && cell.contains("all settings"))
    );
    for (label, more) in
        [("recall", true), ("FPR", false), ("FNR", false), ("PWC", false), ("specificity", true)]
    {
        for table in &sortable[1..] {
            assert_eq!(header(table, label).contains(" data-more"), more, "{label}");
        }
    }
    // Without the lines of categories a sequence has its whole name.
    assert_eq!(sortable[0].matches("<span class=\"category\">").count(), 7);
    assert!(sortable[0].contains("<span class=\"category\">baseline/</span>canoe01"));
}

#[test]
fn a_large_data_set_stays_small() {
    let data = Data { axes: AXES, sequences: 50, categories: 4, ..Data::default() };
    let sweep = table(&data);
    let frames = frames_of(&data, 2000, Size::new(320, 240), 4);
    let text = report("large.html", &data, &sweep, &frames, &[]);
    assert!(text.len() < 6_000_000, "{} bytes", text.len());
    assert_eq!(text.matches("<img src=").count(), 50 * 2 * 3);
    assert!(text.contains("Of 200 worst frames"));
    assert_eq!(text.matches("class=\"group\"").count(), 4);
}

#[test]
fn hostile_names_stay_text() {
    const NAME: &str = "</script><script>alert(1)</script>\"'&<img src=x onerror=alert(1)>/<b>";
    let data = Data { axes: &["k=3,4"], sequences: 2, tracks: false, ..Data::default() };
    let mut sweep = table(&data);
    sweep.sequences[1] = NAME.to_owned();
    let frames = frames_of(&data, 20, Size::new(64, 48), 1);
    let base = Settings::default();
    let facts = [("input", NAME.to_owned())];
    let warnings = [NAME.to_owned()];
    let hostile = Report {
        title: NAME,
        table: &sweep,
        frames: &frames,
        base: &base,
        facts: &facts,
        warnings: &warnings,
    };
    let text = written(|out| write(out, &hostile));
    assert_eq!((text.matches("<script").count(), text.matches("</script").count()), (3, 3));
    assert!(!text.contains("<img src=x") && !text.contains("/<b>"));
    let data = text.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(data["sequences"][1], NAME);
    if let Some(folder) = std::env::var_os("OCCLUSCOPE_REPORTS") {
        std::fs::write(Path::new(&folder).join("hostile.html"), &text).unwrap();
    }
}

#[test]
fn nothing_is_loaded_from_elsewhere() {
    let data = Data { axes: &["k=3,4"], sequences: 2, ..Data::default() };
    let text = report("two.html", &data, &table(&data), &frames_of(&data, 50, Size::new(64, 48), 1), &[]);
    assert!(!text.contains("http://") && !text.contains("https://") && !text.contains("url("));
    let addresses = text.split(" src=\"").skip(1).chain(text.split(" href=\"").skip(1));
    for address in addresses {
        assert!(address.starts_with("data:") || address.starts_with('#'), "{}", &address[..40]);
    }
}

#[test]
fn an_empty_sweep_has_a_report() {
    let empty = SweepTable { grid: Grid::default(), sequences: Vec::new(), rows: Vec::new(), by: &OBJECTIVE };
    let text = report("empty.html", &Data::default(), &empty, &[], &[]);
    assert!(text.contains("No combination of the 1 has a score of all 0 sequences"));
    let data = Data { axes: &["k=3,4"], sequences: 2, ..Data::default() };
    let mut incomplete = table(&data);
    incomplete.rows.retain(|row| row.sequence != row.combination);
    let text = report("incomplete.html", &data, &incomplete, &[], &[]);
    assert!(text.contains("No combination of the 2 has a score of all 2 sequences"));
}
