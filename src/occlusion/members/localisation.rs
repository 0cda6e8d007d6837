//! Localisation of the members within their group's region: their templates, layered over one another, are moved
//! until they explain the region's cells best.

use std::cell::OnceCell;

use crate::frame::Size;
use crate::occlusion::state::template::Template;
use crate::regions::{Mosaic, Rect};

/// Likelihood of a pixel of exactly the expected colour, relative to a random colour,
const EXACT_COLOUR_RATIO: f32 = 8.0;
/// and of any other colour: people turn, and light changes.
const OTHER_COLOUR_RATIO: f32 = 0.25;
/// A difference of colours, in RGB, at which the likelihood is down to a quarter.
const COLOUR_SPREAD_RGB: f32 = 45.0;
/// Likelihood of foreground without an object, or of none where an object is, relative to a random colour.
const STRAY_RATIO: f32 = 0.03;
/// Weight of a full cell: neighbouring pixels are correlated.
const CELL_WEIGHT: f32 = 0.1;
/// Greatest contribution of a cell, in nats.
const MAX_CELL_NATS: f32 = 5.5;
/// Greatest number of cells of a field; larger fields join cells, as templates are no finer.
const MAX_CELLS: u32 = 8000;
/// Greatest number of rounds in which each object is moved in turn.
const MAX_ROUNDS: usize = 3;

/// An object to be localised.
#[derive(Clone, Debug)]
pub(super) struct LocalisedObject<'a> {
    /// Its appearance.
    pub(super) template: &'a Template,
    /// Width and height of its box.
    pub(super) size: (f32, f32),
    /// Its predicted centre, and the standard deviation of that in pixels.
    pub(super) predicted: [f32; 2],
    /// See `predicted`.
    pub(super) position_sigma: f32,
    /// Its centre.
    pub(super) centre: [f32; 2],
    /// Its visible share there: 0..=1.
    pub(super) visible_share: f32,
}

impl LocalisedObject<'_> {
    /// Whether their boxes overlap, so that one can hide a part of the other.
    pub(super) fn overlaps(&self, other: &Self) -> bool {
        self.bbox().intersection(&other.bbox()).area() > 0.0
    }

    fn bbox(&self) -> Rect {
        Rect::around(self.centre, self.size.0, self.size.1)
    }

    fn prior(&self, [x, y]: [f32; 2]) -> f32 {
        let (dx, dy) = (x - self.predicted[0], y - self.predicted[1]);
        -0.5 * (dx * dx + dy * dy) / (self.position_sigma * self.position_sigma)
    }
}

/// The cells of some regions, and those around them.
pub(super) struct Field {
    side: f32,
    left: u32,
    top: u32,
    columns: u32,
    rows: u32,
    cells: Vec<FieldCell>,
    /// The weight of a full cell.
    weight: f32,
}

#[derive(Clone, Copy, Default)]
struct FieldCell {
    cover: f32,
    colour: [f32; 3],
}

impl Field {
    /// The cells of a group's regions, and those within `reach`, inside an image of this size;
    /// `None` where there are none.
    pub(super) fn new(mosaic: &Mosaic, reach: &Rect, size: Size) -> Option<Self> {
        let side = mosaic.side.max(1);
        let cell = |value: f32, most: u32| (value.max(0.0) as u32).min(most) / side;
        let left = cell(reach.x, size.width).min(mosaic.left);
        let top = cell(reach.y, size.height).min(mosaic.top);
        let right = (cell(reach.right(), size.width) + 1).max(mosaic.left + mosaic.columns);
        let bottom = (cell(reach.bottom(), size.height) + 1).max(mosaic.top + mosaic.rows());
        let (columns, rows) = (right.checked_sub(left)?, bottom.checked_sub(top)?);
        let coarseness = ((columns * rows) as f32 / MAX_CELLS as f32).sqrt().ceil().max(1.0) as u32;
        let (left, top) = (left / coarseness, top / coarseness);
        let (columns, rows) = (right.div_ceil(coarseness) - left, bottom.div_ceil(coarseness) - top);
        let mut cells = vec![FieldCell::default(); (columns * rows) as usize];
        let full = (side * side * coarseness * coarseness) as f32;
        for (column, row, cell) in mosaic.filled() {
            let (column, row) = (column / coarseness, row / coarseness);
            let Some(here) = cells.get_mut(((row - top) * columns + column - left) as usize) else {
                continue;
            };
            let share = cell.pixels as f32 / full;
            here.cover += share;
            for (mean, colour) in here.colour.iter_mut().zip(cell.colour) {
                *mean += share / here.cover * (f32::from(colour) - *mean);
            }
        }
        for cell in &mut cells {
            cell.cover = cell.cover.min(1.0);
        }
        let weight = CELL_WEIGHT * (coarseness * coarseness) as f32;
        Some(Self { side: (side * coarseness) as f32, left, top, columns, rows, cells, weight })
    }

    /// The cells whose middle lies in a box: their indices and middles.
    fn within(&self, bbox: &Rect) -> impl Iterator<Item = (usize, f32, f32)> + use<> {
        let side = self.side;
        let place = |low: f32, high: f32, first: u32, count: u32| {
            let cell = |value: f32| (value / side - 0.5).ceil() as i64 - i64::from(first);
            (cell(low).clamp(0, i64::from(count)), cell(high).clamp(0, i64::from(count)))
        };
        let (left, right) = place(bbox.x, bbox.right(), self.left, self.columns);
        let (top, bottom) = place(bbox.y, bbox.bottom(), self.top, self.rows);
        let (columns, first) = (i64::from(self.columns), (self.left, self.top));
        (top..bottom).flat_map(move |row| {
            (left..right).map(move |column| {
                let x = (column as f32 + first.0 as f32 + 0.5) * side;
                let y = (row as f32 + first.1 as f32 + 0.5) * side;
                ((row * columns + column) as usize, x, y)
            })
        })
    }
}

/// How all objects but one explain a cell.
#[derive(Clone, Copy)]
struct OtherObjects {
    /// Likelihood of its colour from the objects in front of the one, and from those behind.
    front: f32,
    behind: f32,
    /// Probability that none of those covers it.
    free_front: f32,
    free_behind: f32,
}

impl OtherObjects {
    const NONE: Self = Self { front: 0.0, behind: 0.0, free_front: 1.0, free_behind: 1.0 };

    /// The log-likelihood of a cell that the one object covers with probability `cover`, with likelihood `colour` of
    /// its colour.
    fn likelihood(&self, cell: FieldCell, cover: f32, colour: f32) -> f32 {
        let seen = self.front + self.free_front * (cover * colour + (1.0 - cover) * self.behind);
        let free = self.free_front * (1.0 - cover) * self.free_behind;
        // Most cells are full or empty, and the logarithm dominates the cost.
        let weighed = |share: f32, likelihood: f32| {
            if share > 0.0 { share * (likelihood + STRAY_RATIO).ln() } else { 0.0 }
        };
        weighed(cell.cover, seen) + weighed(1.0 - cell.cover, free)
    }
}

fn colour_likelihood(a: [f32; 3], b: [f32; 3]) -> f32 {
    let squared: f32 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    let near = 1.0 / (1.0 + squared / (COLOUR_SPREAD_RGB * COLOUR_SPREAD_RGB));
    OTHER_COLOUR_RATIO + EXACT_COLOUR_RATIO * near * near
}

/// Moves objects, given front first, until together they explain the field best, and measures the visible share of
/// each.
pub(super) fn localise(objects: &mut [LocalisedObject], field: &Field) {
    for _ in 0..MAX_ROUNDS {
        let mut moved = false;
        for index in 0..objects.len() {
            moved |= hill_climb(objects, index, field);
        }
        if !moved {
            break;
        }
    }
    for index in 0..objects.len() {
        measure_visible_share(objects, index, field);
    }
}

/// Moves the last object alone, and measures its visible share.
pub(super) fn localise_last(objects: &mut [LocalisedObject], field: &Field) {
    let Some(last) = objects.len().checked_sub(1) else { return };
    hill_climb(objects, last, field);
    measure_visible_share(objects, last, field);
}

/// One of the objects between those in front of it and those behind it.
struct LayeredObject<'a, 'b> {
    front: &'a [LocalisedObject<'b>],
    object: &'a mut LocalisedObject<'b>,
    behind: &'a [LocalisedObject<'b>],
}

impl<'a, 'b> LayeredObject<'a, 'b> {
    fn new(objects: &'a mut [LocalisedObject<'b>], index: usize) -> Option<Self> {
        let (front, rest) = objects.split_at_mut_checked(index)?;
        let (object, behind) = rest.split_first_mut()?;
        Some(Self { front, object, behind })
    }
}

/// The middle of the foreground that no object covers, `None` where there is none.
pub(super) fn unexplained_centre(objects: &[LocalisedObject], field: &Field) -> Option<[f32; 2]> {
    let whole = Rect::new(
        field.left as f32 * field.side,
        field.top as f32 * field.side,
        field.columns as f32 * field.side,
        field.rows as f32 * field.side,
    );
    let mut free = vec![1.0f32; field.cells.len()];
    for object in objects {
        for (at, x, y) in field.within(&object.bbox()) {
            if let Some(free) = free.get_mut(at) {
                *free *= 1.0 - template_element(object, object.centre, x, y).cover;
            }
        }
    }
    let (mut sum, mut middle) = (0.0, [0.0; 2]);
    for ((_, x, y), (cell, free)) in field.within(&whole).zip(field.cells.iter().zip(free)) {
        let weight = cell.cover * free;
        if weight > 0.5 {
            sum += weight;
            middle[0] += weight * x;
            middle[1] += weight * y;
        }
    }
    (sum > 0.0).then(|| middle.map(|value| value / sum))
}

/// Measures the visible share of one object.
fn measure_visible_share(objects: &mut [LocalisedObject], index: usize, field: &Field) {
    let Some(amid) = LayeredObject::new(objects, index) else { return };
    let without = without(&amid, field);
    let object = amid.object;
    let covers =
        field.within(&object.bbox()).map(|(_, x, y)| template_element(object, object.centre, x, y).cover);
    let full: f32 = covers.sum();
    let gain = log_likelihood_gain(object, object.centre, &without, field);
    object.visible_share = (gain / (field.weight * MAX_CELL_NATS * full.max(1.0))).clamp(0.0, 1.0);
}

/// How well all objects together explain the field, in nats; comparable between orders of the same objects.
pub(super) fn log_likelihood(objects: &[LocalisedObject], field: &Field) -> f32 {
    let mut cells = vec![OtherObjects::NONE; field.cells.len()];
    for object in objects {
        for (at, x, y) in field.within(&object.bbox()) {
            let (Some(cell), Some(seen)) = (cells.get_mut(at), field.cells.get(at)) else { continue };
            let element = template_element(object, object.centre, x, y);
            let colour = colour_likelihood(seen.colour, element.colour);
            cell.front += cell.free_front * element.cover * colour;
            cell.free_front *= 1.0 - element.cover;
        }
    }
    let likelihood = |(others, &cell): (&OtherObjects, &FieldCell)| others.likelihood(cell, 0.0, 0.0);
    let seen: f32 = cells.iter().zip(&field.cells).map(likelihood).sum();
    field.weight * seen + objects.iter().map(|object| object.prior(object.centre)).sum::<f32>()
}

fn template_element(
    object: &LocalisedObject,
    [cx, cy]: [f32; 2],
    x: f32,
    y: f32,
) -> crate::occlusion::state::template::Element {
    let (w, h) = object.size;
    object.template.at(((x - cx) / w + 0.5).max(0.0), ((y - cy) / h + 0.5).max(0.0))
}

/// A cell, and how it is explained without one of the objects.
struct CellWithoutObject {
    others: OtherObjects,
    /// Its log-likelihood without the object, computed on first use.
    likelihood: OnceCell<f32>,
}

/// How all objects but the one explain the field's cells.
fn without(amid: &LayeredObject, field: &Field) -> Vec<CellWithoutObject> {
    let mut cells = vec![OtherObjects::NONE; field.cells.len()];
    let front = amid.front.iter().map(|object| (object, true));
    for (object, in_front) in front.chain(amid.behind.iter().map(|object| (object, false))) {
        for (at, x, y) in field.within(&object.bbox()) {
            let (Some(cell), Some(seen)) = (cells.get_mut(at), field.cells.get(at)) else { continue };
            let element = template_element(object, object.centre, x, y);
            let colour = colour_likelihood(seen.colour, element.colour);
            if in_front {
                cell.front += cell.free_front * element.cover * colour;
                cell.free_front *= 1.0 - element.cover;
            } else {
                cell.behind += cell.free_behind * element.cover * colour;
                cell.free_behind *= 1.0 - element.cover;
            }
        }
    }
    cells.into_iter().map(|others| CellWithoutObject { others, likelihood: OnceCell::new() }).collect()
}

/// How much better the field is explained with the object there than without it, in nats.
fn log_likelihood_gain(
    object: &LocalisedObject,
    centre: [f32; 2],
    without: &[CellWithoutObject],
    field: &Field,
) -> f32 {
    let (w, h) = object.size;
    let gained = field.within(&Rect::around(centre, w, h)).filter_map(|(at, x, y)| {
        let (&cell, without) = (field.cells.get(at)?, without.get(at)?);
        let element = template_element(object, centre, x, y);
        let colour = colour_likelihood(cell.colour, element.colour);
        let alone = without.likelihood.get_or_init(|| without.others.likelihood(cell, 0.0, 0.0));
        Some(without.others.likelihood(cell, element.cover, colour) - alone)
    });
    field.weight * gained.sum::<f32>()
}

/// Moves one object by hill climbing, in steps that grow shorter; whether it moved.
fn hill_climb(objects: &mut [LocalisedObject], index: usize, field: &Field) -> bool {
    let Some(amid) = LayeredObject::new(objects, index) else { return false };
    let without = without(&amid, field);
    let object = amid.object;
    // A step leads to a place whose neighbours were evaluated before.
    let mut known: Vec<([f32; 2], f32)> = Vec::new();
    let mut value = |centre| {
        if let Some((_, value)) = known.iter().find(|(place, _)| *place == centre) {
            return *value;
        }
        let value = log_likelihood_gain(object, centre, &without, field) + object.prior(centre);
        known.push((centre, value));
        value
    };
    let start = object.centre;
    let mut best = (value(start), start);
    let mut step = 2.0 * field.side;
    while step >= 0.5 * field.side {
        let [x, y] = best.1;
        let around = [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)];
        let next = around
            .map(|(dx, dy)| [x + step * dx, y + step * dy])
            .into_iter()
            .map(|centre| (value(centre), centre))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        match next {
            Some(next) if next.0 > best.0 => best = next,
            _ => step /= 2.0,
        }
    }
    object.centre = best.1;
    best.1 != start
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;
    use crate::regions::mosaic::Cell;

    const SIZE: Size = Size { width: 400, height: 300 };

    /// A person of 32 by 80 pixels in a shirt and trousers, painted onto cells of 4 pixels.
    fn paint(cells: &mut Mosaic, left: u32, top: u32, shirt: u8, trousers: u8) {
        for row in 0..20 {
            for column in 0..8 {
                let corner = !(4..10).contains(&row) && !(1..7).contains(&column);
                let grey = if row < 10 { shirt } else { trousers };
                let index = (top + row) * cells.columns + left + column;
                if !corner {
                    cells.cells[index as usize] = Cell { pixels: 16, colour: [grey, grey / 2, 90] };
                }
            }
        }
    }

    fn blank() -> Mosaic {
        Mosaic { side: 4, left: 0, top: 0, columns: 100, cells: vec![Cell::default(); 100 * 75] }
    }

    fn template(shirt: u8, trousers: u8) -> Template {
        let mut alone = blank();
        paint(&mut alone, 20, 20, shirt, trousers);
        Template::new(&alone, &Rect::new(80.0, 80.0, 32.0, 80.0))
    }

    fn at(template: &Template, centre: [f32; 2]) -> LocalisedObject<'_> {
        let size = (32.0, 80.0);
        LocalisedObject {
            template,
            size,
            predicted: centre,
            position_sigma: 10.0,
            centre,
            visible_share: 0.0,
        }
    }

    fn field(mosaic: &Mosaic) -> Field {
        Field::new(mosaic, &Rect::new(0.0, 0.0, 400.0, 300.0), SIZE).unwrap()
    }

    #[test]
    fn two_overlapping_objects_are_localised_in_their_depth_order() {
        let (bright, dark) = (template(220, 160), template(60, 20));
        let mut both = blank();
        paint(&mut both, 44, 30, 60, 20);
        paint(&mut both, 40, 30, 220, 160);
        let field = field(&both);
        // True centres (176, 160) in front and (192, 160) behind; both start some pixels off.
        let mut right = [at(&bright, [170.0, 166.0]), at(&dark, [199.0, 154.0])];
        localise(&mut right, &field);
        let near = |localised: &LocalisedObject, x: f32| {
            (localised.centre[0] - x).abs() <= 3.0 && (localised.centre[1] - 160.0).abs() <= 3.0
        };
        assert!(near(&right[0], 176.0), "{:?}", right[0].centre);
        assert!(near(&right[1], 192.0), "{:?}", right[1].centre);
        assert!(
            right[0].visible_share > 0.7 && right[1].visible_share > 0.2,
            "{} {}",
            right[0].visible_share,
            right[1].visible_share
        );
        let mut wrong = [at(&dark, [199.0, 154.0]), at(&bright, [170.0, 166.0])];
        localise(&mut wrong, &field);
        assert!(log_likelihood(&right, &field) > log_likelihood(&wrong, &field) + 1.0);
    }

    #[test]
    fn an_absent_object_has_no_visible_share() {
        let (bright, dark) = (template(220, 160), template(60, 20));
        let mut one = blank();
        paint(&mut one, 40, 30, 220, 160);
        let mut localised = [at(&bright, [176.0, 160.0]), at(&dark, [180.0, 158.0])];
        localise(&mut localised, &field(&one));
        assert!(localised[0].visible_share > 0.5, "{}", localised[0].visible_share);
        assert!(localised[1].visible_share < 0.1, "{}", localised[1].visible_share);
    }

    #[test]
    fn an_unexplained_part_belongs_to_another_object() {
        let bright = template(220, 160);
        let mut both = blank();
        paint(&mut both, 10, 30, 220, 160);
        paint(&mut both, 60, 30, 60, 20);
        let field = field(&both);
        let [x, y] = unexplained_centre(&[at(&bright, [56.0, 160.0])], &field).unwrap();
        assert!((x - 256.0).abs() < 3.0 && (y - 160.0).abs() < 3.0, "{x} {y}");
        assert_eq!(unexplained_centre(&[], &self::field(&blank())), None);
    }

    #[test]
    fn large_objects_are_localised_with_no_more_cells() {
        let (bright, dark) = (template(220, 160), template(60, 20));
        let mut small = blank();
        paint(&mut small, 44, 30, 60, 20);
        paint(&mut small, 40, 30, 220, 160);
        // The same picture, eight times as large.
        let cells = (0..600 * 800).map(|at| small.cells[at / 800 / 8 * 100 + at % 800 / 8]).collect();
        let large = Mosaic { side: 4, left: 0, top: 0, columns: 800, cells };
        let size = Size { width: 3200, height: 2400 };
        let field = Field::new(&large, &Rect::new(0.0, 0.0, 3200.0, 2400.0), size).unwrap();
        assert!(field.cells.len() <= MAX_CELLS as usize, "{}", field.cells.len());
        let start = |template, centre| LocalisedObject {
            size: (256.0, 640.0),
            position_sigma: 80.0,
            ..at(template, centre)
        };
        let mut localised = [start(&bright, [1360.0, 1328.0]), start(&dark, [1592.0, 1232.0])];
        localise(&mut localised, &field);
        for (localised, x) in localised.iter().zip([1408.0, 1536.0]) {
            let [found_x, found_y] = localised.centre;
            assert!(
                (found_x - x).abs() <= 32.0 && (found_y - 1280.0).abs() <= 32.0,
                "{:?}",
                localised.centre
            );
        }
    }

    fn close(found: f32, expected: f32) -> bool {
        (found - expected).abs() <= 1e-4 * expected.abs().max(1.0)
    }

    #[test]
    fn a_place_is_the_less_likely_the_farther_from_the_predicted_one() {
        let template = template(220, 160);
        let object = at(&template, [100.0, 80.0]);
        assert_eq!(object.prior([100.0, 80.0]), 0.0);
        assert_eq!(object.prior([106.0, 72.0]), -0.5);
        assert_eq!(object.prior([80.0, 80.0]), -2.0);
        let beside = |x: f32, y: f32| object.overlaps(&at(&template, [100.0 + x, 80.0 + y]));
        assert!(beside(31.0, -79.0) && beside(-31.0, 79.0));
        assert!(!beside(32.0, 0.0) && !beside(0.0, 80.0));
    }

    /// Two cells next to each other in columns 20 and 21 of row 30, of 4 pixels, of which half of the second is filled.
    fn pair() -> Mosaic {
        let cells = vec![Cell { pixels: 16, colour: [100, 0, 8] }, Cell { pixels: 8, colour: [40, 0, 8] }];
        Mosaic { side: 4, left: 20, top: 30, columns: 2, cells }
    }

    #[test]
    fn a_field_has_the_cells_of_the_regions_and_of_the_reach() {
        let size = Size { width: 100, height: 200 };
        let within = |reach: Rect| Field::new(&pair(), &reach, size).unwrap();
        let extent = |field: &Field| (field.left, field.top, field.columns, field.rows);
        let own = within(Rect::new(82.0, 122.0, 4.0, 2.0));
        assert_eq!(extent(&own), (20, 30, 2, 2), "of the row below one is reached");
        assert_eq!((own.side, own.weight), (4.0, CELL_WEIGHT));
        assert_eq!(extent(&within(Rect::new(70.0, 100.0, 28.0, 42.0))), (17, 25, 8, 11));
        assert_eq!(extent(&within(Rect::new(-50.0, -50.0, 900.0, 900.0))), (0, 0, 26, 51), "in the image");
        let cover = |field: &Field, column: u32, row: u32| {
            field.cells[((row - field.top) * field.columns + column - field.left) as usize]
        };
        let field = within(Rect::new(70.0, 100.0, 28.0, 42.0));
        assert_eq!((cover(&field, 20, 30).cover, cover(&field, 20, 30).colour), (1.0, [100.0, 0.0, 8.0]));
        assert_eq!((cover(&field, 21, 30).cover, cover(&field, 21, 30).colour), (0.5, [40.0, 0.0, 8.0]));
        assert_eq!(field.cells.iter().map(|cell| cell.cover).sum::<f32>(), 1.5);
    }

    #[test]
    fn a_large_field_joins_cells() {
        let size = Size { width: 2000, height: 2000 };
        // Columns 11 to 161 and rows 15 to 115: 15,000 cells.
        let field = Field::new(&pair(), &Rect::new(44.0, 60.0, 596.0, 396.0), size).unwrap();
        assert_eq!((field.side, field.left, field.top, field.columns, field.rows), (8.0, 5, 7, 76, 51));
        assert!(close(field.weight, 4.0 * CELL_WEIGHT));
        // Three eighths of a cell of 8 pixels, two thirds of them of the first colour.
        let cell = field.cells[(8 * 76 + 5) as usize];
        assert!(close(cell.cover, 0.375) && close(cell.colour[0], 80.0), "{} {:?}", cell.cover, cell.colour);
        assert_eq!(field.cells.iter().filter(|cell| cell.cover > 0.0).count(), 1);
        let (index, x, y) = field.within(&Rect::new(80.0, 120.0, 8.0, 8.0)).next().unwrap();
        assert_eq!((index, x, y), (8 * 76 + 5, 84.0, 124.0));
    }

    #[test]
    fn the_cells_of_a_box_are_those_whose_middles_it_contains() {
        let field = Field::new(&pair(), &Rect::new(70.0, 100.0, 28.0, 42.0), SIZE).unwrap();
        // Columns 17 to 25, rows 25 to 36.
        let cells: Vec<_> = field.within(&Rect::new(82.0, 121.0, 8.5, 5.5)).collect();
        assert_eq!(
            cells,
            [
                (43, 82.0, 122.0),
                (44, 86.0, 122.0),
                (45, 90.0, 122.0),
                (51, 82.0, 126.0),
                (52, 86.0, 126.0),
                (53, 90.0, 126.0)
            ]
        );
        assert_eq!(field.within(&Rect::new(0.0, 0.0, 400.0, 300.0)).count(), field.cells.len());
        assert_eq!(field.within(&Rect::new(0.0, 0.0, 70.0, 300.0)).next(), None);
    }

    #[test]
    fn a_colour_is_the_likelier_the_nearer() {
        assert_eq!(colour_likelihood([10.0, 90.0, 30.0], [10.0, 90.0, 30.0]), 8.25);
        assert!(close(colour_likelihood([10.0, 90.0, 30.0], [10.0, 45.0, 30.0]), 2.25));
        assert!(close(colour_likelihood([10.0, 90.0, 30.0], [46.0, 63.0, 30.0]), 2.25));
    }

    /// The log-likelihood of a field by its definition: through the cells one by one, in each through the objects from
    /// the front.
    fn reference(objects: &[LocalisedObject], field: &Field) -> f64 {
        let mut sum = 0.0;
        for (index, cell) in field.cells.iter().enumerate() {
            let (column, row) =
                (index as u32 % field.columns + field.left, index as u32 / field.columns + field.top);
            let (x, y) = ((column as f32 + 0.5) * field.side, (row as f32 + 0.5) * field.side);
            let (mut colour, mut free) = (0.0, 1.0);
            for object in objects {
                let bbox = object.bbox();
                if x < bbox.x || x >= bbox.right() || y < bbox.y || y >= bbox.bottom() {
                    continue;
                }
                let element = template_element(object, object.centre, x, y);
                let squared: f32 = element.colour.iter().zip(cell.colour).map(|(a, b)| (a - b).powi(2)).sum();
                let near = 1.0 / (1.0 + f64::from(squared) / 2025.0);
                colour += free * f64::from(element.cover) * (0.25 + 8.0 * near * near);
                free *= 1.0 - f64::from(element.cover);
            }
            let cover = f64::from(cell.cover);
            sum += cover * (colour + 0.03).ln() + (1.0 - cover) * (free + 0.03).ln();
        }
        0.1 * sum + objects.iter().map(|object| f64::from(object.prior(object.centre))).sum::<f64>()
    }

    /// Three people, one behind the other, in a region that hides and frays parts of them.
    fn crowd(templates: &[Template; 3]) -> ([LocalisedObject<'_>; 3], Field) {
        let mut all = blank();
        paint(&mut all, 44, 30, 60, 20);
        paint(&mut all, 40, 30, 220, 160);
        for (index, cell) in all.cells.iter_mut().enumerate() {
            cell.pixels = cell.pixels.saturating_sub(index as u32 * 7 % 12);
        }
        let mut objects = [
            at(&templates[0], [171.0, 166.0]),
            at(&templates[1], [183.0, 158.0]),
            at(&templates[2], [199.0, 154.0]),
        ];
        objects[0].predicted = [180.0, 160.0];
        objects[2].size = (40.0, 90.0);
        (objects, field(&all))
    }

    fn templates() -> [Template; 3] {
        // Elements that are covered in a part of the frames only.
        let mut other = blank();
        paint(&mut other, 20, 20, 140, 90);
        other
            .cells
            .iter_mut()
            .enumerate()
            .for_each(|(at, cell)| cell.pixels = cell.pixels.min(at as u32 % 17));
        let mut frayed = [template(220, 160), template(120, 90), template(60, 20)];
        for template in &mut frayed {
            template.update(&other, &Rect::new(80.0, 80.0, 32.0, 80.0));
        }
        frayed
    }

    #[test]
    fn the_log_likelihood_is_that_of_the_cells_one_by_one() {
        let templates = templates();
        let (mut objects, field) = crowd(&templates);
        for _ in 0..3 {
            let (found, expected) = (log_likelihood(&objects, &field), reference(&objects, &field));
            assert!((f64::from(found) - expected).abs() < 0.02, "{found} {expected}");
            objects.rotate_left(1);
        }
    }

    #[test]
    fn the_gain_of_an_object_is_the_difference_that_it_makes() {
        let templates = templates();
        let (objects, field) = crowd(&templates);
        for index in 0..3 {
            let mut all = objects.clone();
            let mut others = objects.to_vec();
            others.remove(index);
            let amid = LayeredObject::new(&mut all, index).unwrap();
            let others_alone = without(&amid, &field);
            let object = &objects[index];
            for centre in [object.centre, [object.centre[0] + 6.0, object.centre[1] - 4.0]] {
                let gain = log_likelihood_gain(object, centre, &others_alone, &field) + object.prior(centre);
                let mut moved = objects.to_vec();
                moved[index].centre = centre;
                let expected = reference(&moved, &field) - reference(&others, &field);
                assert!((f64::from(gain) - expected).abs() < 0.02, "{index}: {gain} {expected}");
            }
        }
    }

    #[test]
    fn the_visible_share_is_the_gain_per_cell_relative_to_the_largest() {
        let templates = templates();
        let (mut objects, field) = crowd(&templates);
        let [front, middle, _] = [0, 1, 2].map(|index| {
            let mut others = objects.to_vec();
            others.remove(index);
            let gain = reference(&objects, &field) - reference(&others, &field);
            let object = &objects[index];
            let covers = field.within(&object.bbox());
            let full: f32 = covers.map(|(_, x, y)| template_element(object, object.centre, x, y).cover).sum();
            let gain = gain - f64::from(object.prior(object.centre));
            let expected = (gain / f64::from(0.1 * 5.5 * full)).clamp(0.0, 1.0);
            measure_visible_share(&mut objects, index, &field);
            assert!(
                (f64::from(objects[index].visible_share) - expected).abs() < 0.002,
                "{index}: {expected}"
            );
            expected
        });
        assert!(front > 0.1 && middle < 1.0 && front < 1.0, "{front} {middle}");
    }

    #[test]
    fn an_object_is_moved_until_no_neighbouring_place_is_better() {
        let templates = templates();
        let (mut objects, field) = crowd(&templates);
        let before = reference(&objects, &field);
        assert!(hill_climb(&mut objects, 0, &field));
        let found = reference(&objects, &field);
        assert!(found > before + 1.0, "{before} {found}");
        for (dx, dy) in [(-2.0, 0.0), (2.0, 0.0), (0.0, -2.0), (0.0, 2.0)] {
            let mut moved = objects.clone();
            moved[0].centre = [moved[0].centre[0] + dx, moved[0].centre[1] + dy];
            assert!(reference(&moved, &field) < found + 1e-3, "{dx} {dy}");
        }
        let at_best = objects[0].centre;
        assert!(!hill_climb(&mut objects, 0, &field));
        assert_eq!(objects[0].centre, at_best);
        localise(&mut objects, &field);
        let together = objects.each_ref().map(|object| object.centre);
        localise(&mut objects, &field);
        assert_eq!(objects.each_ref().map(|object| object.centre), together, "all are at their best places");
    }

    #[test]
    fn the_unexplained_part_has_the_mean_place_of_its_cells() {
        // In columns 20 to 22 of row 30: full, three quarters, and a quarter, which is too little.
        let cells = [16, 12, 4].map(|pixels| Cell { pixels, colour: [90; 3] });
        let mosaic = Mosaic { side: 4, left: 20, top: 30, columns: 3, cells: cells.to_vec() };
        let field = Field::new(&mosaic, &Rect::new(60.0, 100.0, 60.0, 40.0), SIZE).unwrap();
        let [x, y] = unexplained_centre(&[], &field).unwrap();
        assert!(close(x, (82.0 + 0.75 * 86.0) / 1.75) && close(y, 122.0), "{x} {y}");
        let template = template(220, 160);
        // Its box ends between the two, so that the second alone is left.
        let [x, y] = unexplained_centre(&[at(&template, [68.0, 130.0])], &field).unwrap();
        assert!(close(x, 86.0) && close(y, 122.0), "{x} {y}");
    }
}
