//! Heat maps of a sweep as pictures: a measure over two settings, the best over the others in each cell.

use super::canvas::{Canvas, Paint, text_width};
use crate::frame::{Frame, Size};
use crate::palette::ramp;
use crate::regions::{Rect, Rgb};
use crate::settings::Setting;
use crate::sweep::heat_map::{HeatMap, MapAxes, Subject, mapped_measures, maps_of};
use crate::sweep::table::SweepTable;
use crate::truth::measures::{self, MeasureColumn};

/// Largest number of pictures of a sweep.
const MAX_PICTURES: usize = 200;
/// Height of text, in pixels.
const TEXT: f32 = 24.0;
/// Height of the title.
const TITLE: f32 = 30.0;
/// Space around the picture and between its parts.
const GAP: f32 = 24.0;
/// Smallest width of a cell and its height.
const CELL: [f32; 2] = [96.0, 60.0];
/// Distance of the hatching of cells without a value.
const HATCH: f32 = 12.0;
/// Number of colours of the scale.
const SCALE: usize = 120;

const PAPER: Rgb = [255; 3];
const INK: Rgb = [20, 22, 26];
const GRAY: Rgb = [88, 92, 100];
const PALE: Rgb = [200, 204, 210];

/// A picture of a sweep.
#[derive(Clone, Debug)]
pub struct HeatMapFile {
    /// The name of its file.
    pub name: String,
    /// What it is of.
    pub subject: Subject,
    /// Its measure.
    pub measure: &'static MeasureColumn,
    /// Its axes.
    pub axes: MapAxes,
}

/// The pictures of a sweep, at most 200: of all sequences first, then of each, by measure. There is none of a measure that no
/// combination has. With them the number of those that are left out.
pub fn files(table: &SweepTable) -> (Vec<HeatMapFile>, usize) {
    let mut subjects = vec![Subject::All];
    if table.sequences.len() > 1 {
        subjects.extend((0..table.sequences.len()).map(Subject::Sequence));
    }
    let (measures, maps) = (mapped_measures(table), maps_of(&table.grid));
    let has_values = |subject: Subject, measure: &MeasureColumn| {
        (0..table.grid.combinations()).any(|at| subject.value(table, at, measure).is_some())
    };
    let mut files = Vec::new();
    // Of all sequences every measure, then measure by measure every sequence.
    let (all, each) = subjects.split_at(1);
    for part in [all, each] {
        for &measure in &measures {
            for &subject in part.iter().filter(|subject| has_values(**subject, measure)) {
                files.extend(maps.iter().map(|&axes| HeatMapFile::new(table, subject, measure, axes)));
            }
        }
    }
    let left_out = files.len().saturating_sub(MAX_PICTURES);
    files.truncate(MAX_PICTURES);
    (files, left_out)
}

/// Whether a file of this name can be a heat map of another sweep.
pub fn is_name_of_map(name: &str) -> bool {
    let Some(mut rest) = name.strip_suffix(".png") else { return false };
    let mut settings = 0;
    while settings < 2
        && let Some((before, setting)) = rest.rsplit_once('-')
        && Setting::named(setting).is_some_and(|found| found.name == setting)
    {
        rest = before;
        settings += 1;
    }
    let (sequence, measure) = rest.rsplit_once('-').unwrap_or(("", rest));
    let is_numbered = sequence
        .split_once('-')
        .is_some_and(|(number, _)| number.len() >= 3 && number.bytes().all(|digit| digit.is_ascii_digit()));
    settings > 0 && (sequence.is_empty() || is_numbered) && measures::is_name(measure)
}

impl HeatMapFile {
    fn new(table: &SweepTable, subject: Subject, measure: &'static MeasureColumn, axes: MapAxes) -> Self {
        let setting = |axis: usize| table.grid.axes().get(axis).map_or("", |axis| axis.setting.name);
        let mut name = format!("{}-{}", measure.name, setting(axes.across));
        if let Some(down) = axes.down {
            name = format!("{name}-{}", setting(down));
        }
        if let Subject::Sequence(at) = subject {
            // The number keeps names apart that are equal without their special characters.
            let safe = |sign: char| if sign.is_alphanumeric() || "-_.".contains(sign) { sign } else { '_' };
            let sequence: String = subject.name(table).chars().map(safe).take(80).collect();
            name = format!("{:03}-{sequence}-{name}", at + 1);
        }
        Self { name: format!("{name}.png"), subject, measure, axes }
    }

    /// Draws the picture.
    pub fn draw(&self, table: &SweepTable) -> Frame {
        let map = HeatMap::new(table, self.subject, self.measure, self.axes);
        Layout::new(self, table, &map).draw()
    }
}

/// A setting as the title of an axis: its label, and its symbol if it has one.
pub fn axis_title(setting: &Setting) -> String {
    if setting.symbol.is_empty() {
        setting.label()
    } else {
        format!("{} {}", setting.label(), setting.symbol)
    }
}

/// What the cells of a map leave open: `best over components K and background ratio T`; empty if nothing.
pub fn open_axes(table: &SweepTable, axes: MapAxes) -> String {
    let several = table.grid.axes().iter().enumerate().filter(|(_, axis)| axis.values.len() > 1);
    let open = several.filter(|(at, _)| *at != axes.across && Some(*at) != axes.down);
    let titles: Vec<String> = open.map(|(_, axis)| axis_title(axis.setting)).collect();
    match titles.split_last() {
        None => String::new(),
        Some((last, [])) => format!("best over {last}"),
        Some((last, rest)) => format!("best over {} and {last}", rest.join(", ")),
    }
}

/// Whether text on this colour is dark.
pub fn needs_dark_text([r, g, b]: Rgb) -> bool {
    // The luminance at which black and white have the same contrast.
    let linear = |channel: u8| (f32::from(channel) / 255.0).powf(2.2);
    0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b) > 0.18
}

/// Texts and places of a picture.
struct Layout<'a> {
    map: &'a HeatMap,
    measure: &'a MeasureColumn,
    title: String,
    /// What a cell is, if settings are left open, and the best one.
    notes: Vec<String>,
    across: (String, Vec<String>),
    down: (String, Vec<String>),
    cell: [f32; 2],
    /// The upper left corner of the cells.
    corner: [f32; 2],
    size: [f32; 2],
}

impl<'a> Layout<'a> {
    fn new(file: &'a HeatMapFile, table: &SweepTable, map: &'a HeatMap) -> Self {
        let axis = |at: usize| {
            let Some(axis) = table.grid.axes().get(at) else { return (String::new(), Vec::new()) };
            (axis_title(axis.setting), axis.values.iter().map(ToString::to_string).collect())
        };
        let (across, down) = (axis(file.axes.across), file.axes.down.map_or_else(Default::default, axis));
        let title = format!("{}, {}", file.measure.label, file.subject.name(table));
        let open = open_axes(table, file.axes);
        let best = map.best().and_then(|at| map.cells[at]).map(|cell| {
            format!("best {}: {}", file.measure.text(cell.value), table.grid.name(cell.combination))
        });
        let notes: Vec<String> = (!open.is_empty()).then_some(open).into_iter().chain(best).collect();
        let values = map.cells.iter().flatten().map(|cell| file.measure.text(cell.value));
        let widest = |texts: &[String]| texts.iter().map(|text| text_width(TEXT, text)).fold(0.0, f32::max);
        let width = widest(&across.1).max(widest(&values.collect::<Vec<_>>())) + GAP;
        let cell = [width.max(CELL[0]), CELL[1]];
        let left = GAP + widest(&down.1) + if down.1.is_empty() { 0.0 } else { TEXT / 2.0 };
        // The title of the vertical axis is above its values.
        let title_height = if down.0.is_empty() { 0.0 } else { TEXT + 8.0 };
        let top = GAP + TITLE + notes.len() as f32 * (TEXT + 6.0) + GAP + title_height;
        let rows = map.cells.len() / map.columns.max(1);
        let cells = [cell[0] * map.columns as f32, cell[1] * rows as f32];
        let scale = GAP + 28.0 + 10.0 + 7.0 * text_width(TEXT, "0");
        let title_width = GAP + text_width(TITLE, &title);
        let width = (left + cells[0] + scale).max(title_width).max(GAP + widest(&notes));
        let size = [width + GAP, top + cells[1] + 2.0 * (TEXT + 10.0) + GAP];
        Self { map, measure: file.measure, title, notes, across, down, cell, corner: [left, top], size }
    }

    fn draw(&self) -> Frame {
        let size = Size::new(self.size[0].ceil() as u32, self.size[1].ceil() as u32);
        let mut frame = Frame::new(1, size, [PAPER].repeat(size.pixels()).concat());
        let canvas = &mut Canvas::new(&mut frame);
        canvas.text([GAP, GAP], TITLE, &self.title, Paint::solid(INK));
        for (line, note) in (0_u8..).zip(&self.notes) {
            let y = GAP + TITLE + 6.0 + f32::from(line) * (TEXT + 6.0);
            canvas.text([GAP, y], TEXT, note, Paint::solid(GRAY));
        }
        let [left, top] = self.corner;
        canvas.text([GAP, top - TEXT - 8.0], TEXT, &self.down.0, Paint::solid(INK));
        for (row, value) in self.down.1.iter().enumerate() {
            let y = self.cell_place(row * self.map.columns).y + (self.cell[1] - TEXT) / 2.0;
            canvas.text([left - TEXT / 2.0 - text_width(TEXT, value), y], TEXT, value, Paint::solid(INK));
        }
        let bottom = top + self.cell[1] * (self.map.cells.len() / self.map.columns.max(1)) as f32;
        for (column, value) in self.across.1.iter().enumerate() {
            let middle = self.cell_place(column).x + self.cell[0] / 2.0;
            canvas.text(
                [middle - text_width(TEXT, value) / 2.0, bottom + 8.0],
                TEXT,
                value,
                Paint::solid(INK),
            );
        }
        let middle =
            left + self.cell[0] * self.map.columns as f32 / 2.0 - text_width(TEXT, &self.across.0) / 2.0;
        canvas.text([middle.max(GAP), bottom + 8.0 + TEXT + 8.0], TEXT, &self.across.0, Paint::solid(INK));
        for at in 0..self.map.cells.len() {
            self.draw_cell(canvas, at);
        }
        if let Some(best) = self.map.best() {
            let place = self.cell_place(best);
            let inside = Rect::new(place.x + 5.0, place.y + 5.0, place.w - 10.0, place.h - 10.0);
            canvas.outline(&inside, 6.0, 0.0, Paint::solid(PAPER));
            canvas.outline(&inside, 3.0, 0.0, Paint::solid(INK));
        }
        self.draw_scale(canvas, bottom);
        frame
    }

    fn cell_place(&self, at: usize) -> Rect {
        let columns = self.map.columns.max(1);
        let (column, row) = ((at % columns) as f32, (at / columns) as f32);
        let [width, height] = self.cell;
        Rect::new(self.corner[0] + column * width, self.corner[1] + row * height, width, height)
    }

    fn draw_cell(&self, canvas: &mut Canvas<'_>, at: usize) {
        let place = self.cell_place(at);
        let inside = Rect::new(place.x + 1.0, place.y + 1.0, place.w - 2.0, place.h - 2.0);
        let Some(cell) = self.map.cells[at] else {
            let mut along = HATCH;
            while along < inside.w + inside.h {
                // From the left or lower edge to the upper or right one.
                let from = [inside.x + (along - inside.h).max(0.0), inside.y + along.min(inside.h)];
                let to = [inside.x + along.min(inside.w), inside.y + (along - inside.w).max(0.0)];
                canvas.line(from, to, 1.5, Paint::solid(PALE));
                along += HATCH;
            }
            canvas.outline(&inside, 1.5, 0.0, Paint::solid(PALE));
            return;
        };
        let colour = ramp(self.map.share(cell.value));
        canvas.fill(&inside, Paint::solid(colour));
        let (text, ink) = (self.measure.text(cell.value), if needs_dark_text(colour) { INK } else { PAPER });
        let x = place.x + (place.w - text_width(TEXT, &text)) / 2.0;
        canvas.text([x, place.y + (place.h - TEXT) / 2.0], TEXT, &text, Paint::solid(ink));
    }

    /// The colours from that of the best value, at the top, to the first of the scale.
    fn draw_scale(&self, canvas: &mut Canvas<'_>, bottom: f32) {
        let Some([_, best]) = self.map.ends else { return };
        let first = self.map.scale().map(|[first, _]| first);
        let (left, top) = (self.corner[0] + self.cell[0] * self.map.columns as f32 + GAP, self.corner[1]);
        let height = (bottom - top) / SCALE as f32;
        for step in 0..SCALE {
            let share = if first.is_none() { 1.0 } else { 1.0 - step as f32 / (SCALE - 1) as f32 };
            // One more pixel, so that no seams are between the steps.
            let step = Rect::new(
                left,
                top + step as f32 * height,
                28.0,
                (height + 1.0).min(bottom - top - step as f32 * height),
            );
            canvas.fill(&step, Paint::solid(ramp(share)));
        }
        canvas.text([left + 38.0, top], TEXT, &self.measure.text(best), Paint::solid(INK));
        if let Some(first) = first {
            canvas.text([left + 38.0, bottom - TEXT], TEXT, &self.measure.text(first), Paint::solid(INK));
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::export::picture;
    use crate::export::report::tests::{Data, table};
    use crate::truth::measures::OBJECTIVE;

    #[test]
    fn a_cell_has_the_colour_of_its_value() {
        let table =
            table(&Data { axes: &["k=3,4", "alpha=0.001,0.002,0.004"], sequences: 1, ..Data::default() });
        let (files, left_out) = files(&table);
        let names: Vec<_> = files.iter().map(|file| file.name.as_str()).collect();
        assert_eq!(names, ["score-k-alpha.png", "f-k-alpha.png", "mota-k-alpha.png", "hota-k-alpha.png"]);
        assert_eq!(left_out, 0);
        let file = &files[0];
        let map = HeatMap::new(&table, file.subject, file.measure, file.axes);
        let layout = Layout::new(file, &table, &map);
        let frame = file.draw(&table);
        if let Some(folder) = std::env::var_os("OCCLUSCOPE_REPORTS") {
            picture::write_frame(&std::path::Path::new(&folder).join(&file.name), &frame).unwrap();
        }
        for (at, cell) in map.cells.iter().enumerate() {
            let place = layout.cell_place(at);
            // Inside the mark of the best cell, above the text.
            let pixel = frame.pixel((place.x + place.w / 2.0) as u32, (place.y + 12.0) as u32).unwrap();
            assert_eq!(pixel, ramp(map.share(cell.unwrap().value)), "cell {at}");
        }
        let best = layout.cell_place(map.best().unwrap());
        assert_eq!(frame.pixel((best.x + 5.0) as u32, (best.y + best.h / 2.0) as u32), Some(INK));
    }

    #[test]
    fn the_bar_states_the_scale_of_the_cells() {
        let mut table = table(&Data { axes: &["k=3,4"], sequences: 1, ..Data::default() });
        for (row, hota) in table.rows.iter_mut().zip([0.389, 0.376]) {
            row.measures.tracks.as_mut().unwrap().hota.hota = hota;
        }
        let (files, _) = files(&table);
        let file = files.iter().find(|file| file.measure.name == "hota").unwrap();
        let map = HeatMap::new(&table, file.subject, file.measure, file.axes);
        let layout = Layout::new(file, &table, &map);
        let frame = file.draw(&table);
        let [left, top] = layout.corner;
        let (bar, bottom) = (left + 2.0 * layout.cell[0] + GAP, top + layout.cell[1]);
        // The text at the lower end of the bar is the value that the lowest colour has.
        let first = map.scale().unwrap()[0];
        assert_eq!(map.share(first), 0.0);
        let mut expected = frame.clone();
        let place = [bar + 38.0, bottom - TEXT];
        let canvas = &mut Canvas::new(&mut expected);
        canvas.fill(&Rect::new(place[0], place[1], 6.0 * TEXT, TEXT + 4.0), Paint::solid(PAPER));
        canvas.text(place, TEXT, &file.measure.text(first), Paint::solid(INK));
        assert!(expected.rgb == frame.rgb, "the lower end of the bar is not {first}");
    }

    #[test]
    fn a_row_and_missing_cells_are_drawn() {
        let mut table = table(&Data { axes: &["alpha=0.001,0.002,0.004"], sequences: 2, ..Data::default() });
        table.rows.retain(|row| row.combination != 1);
        let (files, _) = files(&table);
        let file = &files[0];
        let map = HeatMap::new(&table, Subject::All, &OBJECTIVE, file.axes);
        let layout = Layout::new(file, &table, &map);
        let place = layout.cell_place(1);
        let frame = file.draw(&table);
        let row =
            (0..place.w as u32).map(|x| frame.pixel(place.x as u32 + x, (place.y + 30.0) as u32).unwrap());
        let hatched = row.filter(|&colour| colour == PALE).count();
        assert!((5..30).contains(&hatched), "{hatched}");
        if let Some(folder) = std::env::var_os("OCCLUSCOPE_REPORTS") {
            picture::write_frame(&std::path::Path::new(&folder).join("row.png"), &frame).unwrap();
        }
    }

    #[test]
    fn names_are_safe_and_distinct_and_the_number_bounded() {
        let mut table = table(&Data {
            axes: &["k=3,4", "t=0.6,0.7", "alpha=0.001,0.002"],
            sequences: 30,
            ..Data::default()
        });
        table.sequences[0] = "../../a b".to_owned();
        table.sequences[1] = "../../a:b".to_owned();
        let (files, left_out) = files(&table);
        assert_eq!((files.len(), left_out), (200, 31 * 4 * 3 - 200));
        let mut names: Vec<_> = files.iter().map(|file| file.name.clone()).collect();
        assert!(names.contains(&"001-.._.._a_b-score-k-t.png".to_owned()), "{names:?}");
        assert!(names.iter().all(|name| !name.contains(['/', ' ', ':'])));
        names.sort();
        names.dedup();
        assert_eq!(names.len(), 200);
        // Files of earlier sweeps are recognised, others are not.
        assert!(names.iter().all(|name| is_name_of_map(name)));
        for other in ["paper-k.png", "k.png", "score.png", "my-f-k.png", "f-k.pdf", "12-a-f-k.png", "f-K.png"]
        {
            assert!(!is_name_of_map(other), "{other}");
        }
    }

    #[test]
    fn a_sequence_has_no_picture_of_a_measure_without_values() {
        let mut table = table(&Data { axes: &["k=3,4"], sequences: 2, ..Data::default() });
        for row in &mut table.rows {
            if row.sequence == 0 {
                row.measures.masks = None;
            } else {
                (row.measures.tracks, row.measures.episodes) = (None, None);
            }
        }
        let (files, left_out) = files(&table);
        let names: Vec<_> = files.iter().map(|file| file.name.as_str()).collect();
        let of_all = ["score-k.png", "f-k.png", "mota-k.png", "hota-k.png"];
        let of_each = ["score", "score", "f", "mota", "hota"].into_iter().zip([0, 1, 1, 0, 0]);
        let of_each =
            of_each.map(|(measure, at)| format!("{:03}-{}-{measure}-k.png", at + 1, table.sequences[at]));
        let expected: Vec<String> = of_all.into_iter().map(str::to_owned).chain(of_each).collect();
        assert_eq!((names, left_out), (expected.iter().map(String::as_str).collect(), 0));
    }

    #[test]
    fn text_contrasts_with_its_ground() {
        assert!(needs_dark_text([253, 231, 37]) && !needs_dark_text([68, 1, 84]));
        assert!(needs_dark_text(ramp(0.7)) && !needs_dark_text(ramp(0.3)));
    }
}
