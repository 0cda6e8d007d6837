//! Literal objects and detections for the unit tests of the stages: upright people of one colour.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use nalgebra::Vector3;

use super::state::context::Context;
use super::state::object::{Appearance, Detection, Object, template_of};
use super::state::object_table::ObjectTable;
use crate::frame::Size;
use crate::regions::mosaic::Cell;
use crate::regions::{Mosaic, Rect, Region, Rgb, Shape};
use crate::settings::Settings;
use crate::tracking::ObjectId;
use crate::tracking::kalman::KalmanModel;
use crate::tracking::pool::Blob;

/// Side of a cell of the mosaics, in pixels.
const CELL: u32 = 2;

pub(super) const RED: Rgb = [200, 40, 40];
pub(super) const BLUE: Rgb = [40, 40, 200];

/// The frame `t` of a video of 320 by 240 pixels at 25 frames a second. The image edge is nearer than 4.8 pixels.
pub(super) fn context(t: u32) -> Context {
    let mut context = Context::new(&Settings::default(), Size::new(320, 240), 25.0);
    for number in 1..=t {
        context.advance(number, f64::from(number) / 25.0);
    }
    context
}

/// A box of 20 by 60 pixels.
pub(super) fn person(x: f32, y: f32) -> Rect {
    Rect::new(x, y, 20.0, 60.0)
}

/// A box filled with one colour; its sides are even numbers of pixels.
pub(super) fn detection(bbox: Rect, colour: Rgb) -> Detection {
    let cells = |length: f32| (length / CELL as f32) as u32;
    let (columns, rows) = (cells(bbox.w), cells(bbox.h));
    let cell = Cell { pixels: CELL * CELL, colour };
    let mosaic = Mosaic {
        side: CELL,
        left: cells(bbox.x),
        top: cells(bbox.y),
        columns,
        cells: vec![cell; (columns * rows) as usize],
    };
    let (area, histogram) = (bbox.area(), mosaic.histogram());
    Detection { bbox, area, histogram, labels: vec![1], mosaic: Arc::new(mosaic) }
}

/// One region of several boxes, each of one colour.
pub(super) fn shared_detection(parts: &[(Rect, Rgb)]) -> Detection {
    let parts: Vec<Detection> = parts.iter().map(|&(bbox, colour)| detection(bbox, colour)).collect();
    Detection::join(&parts.iter().collect::<Vec<_>>())
}

/// A region of one box.
pub(super) fn region(label: u32, bbox: Rect, colour: Rgb) -> Region {
    shared_region(label, &[(bbox, colour)])
}

/// One region of several boxes, each of one colour.
pub(super) fn shared_region(label: u32, parts: &[(Rect, Rgb)]) -> Region {
    let Detection { bbox, area, histogram, mosaic, .. } = shared_detection(parts);
    let shape = Shape { area: area as u32, bbox, centroid: bbox.centre(), extent: 1.0, ..Shape::default() };
    Region { label, shape, colour: histogram.dominant().unwrap(), histogram, mosaic }
}

/// A tentative object that was detected in this frame, with a velocity in pixels a frame.
pub(super) fn object(context: &Context, id: ObjectId, detection: &Detection, [vx, vy]: [f32; 2]) -> Object {
    let noise = context.matcher.noise;
    let velocity = Vector3::new(vx, vy, 0.0);
    let model = KalmanModel::new(detection.observation().measurement(), velocity, 0.1, noise);
    Object::new(id, (context.now(), detection.bbox), model, detection.clone())
}

/// Starts a tentative object in a blob of its own, without an appearance yet.
pub(super) fn start_tentative(
    context: &Context,
    table: &mut ObjectTable,
    bbox: Rect,
    colour: Rgb,
    velocity: [f32; 2],
) -> ObjectId {
    let detection = detection(bbox, colour);
    let model = object(context, 0, &detection, velocity).model;
    let blob = Blob::new(model, &detection.observation());
    table.start_alone(|id| object(context, id, &detection, velocity), blob, detection.clone())
}

/// Starts a confirmed object in a blob of its own, with an appearance and a template.
pub(super) fn start_confirmed(
    context: &Context,
    table: &mut ObjectTable,
    bbox: Rect,
    colour: Rgb,
    velocity: [f32; 2],
) -> ObjectId {
    let id = start_tentative(context, table, bbox, colour, velocity);
    let object = table.get_mut(id).unwrap();
    object.appearance = Some(Appearance::new(&object.last_detection, velocity));
    object.template = template_of(&object.last_detection, &context.settings);
    table.confirm(id).unwrap();
    id
}

/// Starts two confirmed people, a red one on the left and a blue one, in one region, whose merge was emitted.
pub(super) fn start_group(
    context: &Context,
    table: &mut ObjectTable,
    red: Rect,
    blue: Rect,
) -> [ObjectId; 2] {
    let first = table.blobs().len();
    let pair = [(red, RED), (blue, BLUE)];
    let members = pair.map(|(bbox, colour)| start_confirmed(context, table, bbox, colour, [0.0; 2]));
    let detection = shared_detection(&pair);
    let model = object(context, 0, &detection, [0.0; 2]).model;
    let blob = Blob::new(model, &detection.observation());
    table.merge_blobs(&[first, first + 1], blob, detection);
    table.drop_empty_blobs();
    table.groups_mut().merge(&members);
    members
}
