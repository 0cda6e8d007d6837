//! What is remembered of an object: how large it is, what colours it wears, how it moves.

use std::sync::Arc;

use nalgebra::Vector3;

use super::event::{Comparison, EventKind};
use super::perspective::Perspective;
use super::template::Template;
use crate::regions::colour::delta_e;
use crate::regions::{Histogram, Mosaic, Rect, Rgb};
use crate::settings::{ColourMemory, Placing, Settings};
use crate::tracking::Key;
use crate::tracking::kalman::Model;
use crate::tracking::pool::Observation;

/// How fast the memory of clear frames follows a new one, once it has seen a few.
const CLEAR_RATE: f32 = 0.1;
/// A frame is clear when the region has at least this share of the pixels that are remembered.
const NEAR_FULL: f32 = 0.7;
/// And at least this share of the height, which changes less than the width of somebody who walks.
const NEAR_TALL: f32 = 0.8;

/// What is left of the speed of somebody unseen after a frame.
const SLOWING: f32 = 0.9;

/// An object has moved once the centre of its box is this part of √area from where it was first seen. What the mask leaves of
/// a passing light, or where somebody stood in the first frame, stays in its place. Tried on four real sequences and 24
/// variations of them: .75 gives the same, .25 half of the gain.
const LEAST_TRAVEL: f32 = 0.5;

/// What is seen for so many frames in succession is no flicker of the mask.
pub(super) const LASTS: u32 = 3;

/// The region, or the regions taken together, by which an object was seen in a frame.
#[derive(Clone, Debug)]
pub struct View {
    /// Box of its regions.
    pub bbox: Rect,
    /// Pixels of its regions.
    pub area: f32,
    /// Colours of its pixels.
    pub histogram: Histogram,
    /// The labels of its regions.
    pub labels: Vec<u32>,
    /// Where in them which colours are.
    pub mosaic: Arc<Mosaic>,
}

impl View {
    /// Views of parts of one thing as one.
    pub fn join(parts: &[&Self]) -> Self {
        let mut histogram = Histogram::default();
        for part in parts {
            histogram.add_scaled(&part.histogram, 1.0);
        }
        let mosaics: Vec<Arc<Mosaic>> = parts.iter().map(|part| Arc::clone(&part.mosaic)).collect();
        let mosaic = match &mosaics[..] {
            [only] => Arc::clone(only),
            _ => Arc::new(Mosaic::join(&mosaics)),
        };
        Self {
            bbox: parts.iter().map(|part| part.bbox).reduce(|a, b| a.union(&b)).unwrap_or_default(),
            area: parts.iter().map(|part| part.area).sum(),
            histogram,
            labels: parts.iter().flat_map(|part| part.labels.iter().copied()).collect(),
            mosaic,
        }
    }

    /// What the tracker takes of it.
    pub fn observation(&self) -> Observation {
        Observation { bbox: self.bbox, area: self.area }
    }
}

/// What an object looks like when nothing hides it: averages over its clear frames.
#[derive(Clone, Debug)]
pub struct Appearance {
    /// Width of its box in pixels.
    pub w: f32,
    /// Height of its box.
    pub h: f32,
    /// Pixels.
    pub area: f32,
    /// Where the centre of its box was, in pixels from the top of the image.
    pub y: f32,
    /// Share of each colour.
    pub histogram: Histogram,
    /// Pixels a frame to the right and down. The box of somebody who goes behind something shrinks
    /// at its front, so that its centre falls behind.
    pub velocity: [f32; 2],
    /// Clear frames seen.
    pub frames: u32,
}

impl Appearance {
    /// From one sight of it.
    pub fn first(view: &View, velocity: [f32; 2]) -> Self {
        let mut histogram = Histogram::default();
        histogram.add_scaled(&view.histogram, 1.0 / view.area.max(1.0));
        let Rect { w, h, .. } = view.bbox;
        let [_, y] = view.bbox.centre();
        Self { w, h, area: view.area, y, histogram, velocity, frames: 1 }
    }

    fn follow(&mut self, view: &View, velocity: [f32; 2]) {
        let rate = CLEAR_RATE.max(1.0 / (self.frames + 1) as f32);
        self.w += rate * (view.bbox.w - self.w);
        self.h += rate * (view.bbox.h - self.h);
        self.area += rate * (view.area - self.area);
        self.y += rate * (view.bbox.centre()[1] - self.y);
        for (mean, now) in self.velocity.iter_mut().zip(velocity) {
            *mean += rate * (now - *mean);
        }
        let mut histogram = Histogram::default();
        histogram.add_scaled(&self.histogram, 1.0 - rate);
        histogram.add_scaled(&view.histogram, rate / view.area.max(1.0));
        histogram.forget_below(0.002);
        self.histogram = histogram;
        self.frames += 1;
    }
}

/// An object, from its first region to its last.
#[derive(Clone, Debug)]
pub struct Object {
    /// Under which its tracks are recorded; changes where who it is has yet to be decided.
    pub key: Key,
    /// The frame in which it was first seen.
    pub born: u32,
    /// Its first box.
    pub birthplace: Rect,
    /// Frames in which it had a region.
    pub seen: u32,
    /// Whether it has an identity.
    pub named: bool,
    /// The last event that told of it or of its group: in which frame what happened.
    pub told: Option<(u32, EventKind)>,
    /// Its own motion: the blob's while it is alone, its own prediction otherwise.
    pub model: Model,
    /// What it looks like when nothing hides it, `None` before its first clear frame.
    pub clear: Option<Appearance>,
    /// How much larger it is where it is now than where it was seen clearly.
    pub scale: f32,
    /// What it looks like place by place, `None` before it was seen alone.
    pub template: Option<Template>,
    /// For how many frames its region has shown more heads than it has members.
    pub crowded: u32,
    /// How much of it was last seen in the region that it shares, 0..=1.
    pub seen_share: f32,
    /// Log odds that it exists where it is believed to be, in nats.
    pub existence: f32,
    /// For how many frames nothing was seen of it in the region that it shares.
    pub unseen: u32,
    /// How it was last seen alone.
    pub last: View,
    /// For how many frames it has been seen in part only, or not at all.
    pub partial: u32,
    /// Where it was when only a part of it began to be seen.
    pub partial_from: [f32; 2],
    /// Why others that came in with it were taken for fragments of it, until its first event tells.
    pub fragments: Vec<Comparison>,
    /// In how many frames more than not it has been seen as two who stand side by side.
    pub beside: u32,
    /// Where its own motion put it in this frame, if it was held inside a region from there.
    pub held_from: Option<[f32; 2]>,
}

impl Object {
    /// Somebody new, under a key, whose first box was in frame `born`, with nothing known but how
    /// they are seen and move.
    pub fn new(key: Key, (born, birthplace): (u32, Rect), model: Model, last: View) -> Self {
        Self {
            key,
            born,
            birthplace,
            seen: 1,
            named: false,
            told: None,
            partial_from: model.centre(),
            held_from: None,
            model,
            clear: None,
            scale: 1.0,
            template: None,
            crowded: 0,
            unseen: 0,
            seen_share: 1.0,
            existence: 0.0,
            last,
            partial: 0,
            fragments: Vec::new(),
            beside: 0,
        }
    }

    /// Whether it is away from where it was first seen.
    pub fn has_moved(&self) -> bool {
        let ([x, y], [from_x, from_y]) = (self.last.bbox.centre(), self.birthplace.centre());
        (x - from_x).hypot(y - from_y) >= LEAST_TRAVEL * self.last.area.sqrt()
    }

    /// Whether it may turn out to be `known`, one who is hidden. Of what has not moved only who is nearly whole.
    pub fn may_be(&self, known: &Self) -> bool {
        self.has_moved() || known.is_nearly_whole(&self.last)
    }

    /// The size that its box should have: width and height.
    pub fn size(&self) -> (f32, f32) {
        let size = |clear: &Appearance| (self.scale * clear.w, self.scale * clear.h);
        self.clear.as_ref().map_or((self.last.bbox.w, self.last.bbox.h), size)
    }

    /// The pixels that it should have.
    pub fn area(&self) -> f32 {
        self.clear.as_ref().map_or(self.last.area, |clear| self.scale * self.scale * clear.area)
    }

    /// Takes in how size changes with place.
    pub fn rescale(&mut self, perspective: &Perspective) {
        if let Some(clear) = &self.clear {
            let [_, y] = self.model.centre();
            self.scale = perspective.scale(y, clear.y);
        }
    }

    /// Where its own motion puts it.
    pub fn predicted_box(&self) -> Rect {
        let (w, h) = self.size();
        Rect::around(self.model.centre(), w, h)
    }

    /// Goes on by its own motion for a frame.
    pub fn go_on(&mut self) {
        self.held_from = None;
        self.model.predict();
    }

    /// Moves as a blob does that is its own.
    pub fn follow(&mut self, model: &Model) {
        self.held_from = None;
        self.model = model.clone();
    }

    /// Goes on with the velocity that it had when it was last seen clearly.
    pub fn keep_pace(&mut self) {
        if let Some(Appearance { velocity: [x, y], .. }) = self.clear {
            self.model.set_velocity(Vector3::new(x, y, 0.0));
        }
    }

    /// Goes on more slowly: somebody of whom nothing is seen may have stopped or turned.
    pub fn slow_down(&mut self) {
        let velocity = self.model.velocity();
        self.model.set_velocity(SLOWING * velocity);
    }

    /// The share of its full size that a region of `area` pixels shows, 0..=1.
    pub fn visible_share(&self, area: f32) -> f32 {
        (area / self.area().max(1.0)).min(1.0)
    }

    /// Takes in that only a part of it is seen: its own motion goes on, and its full extent holds
    /// what is seen.
    pub fn see_part(&mut self, view: &View) {
        self.seen += 1;
        if self.partial == 0 {
            self.partial_from = self.model.centre();
        }
        self.partial += 1;
        self.last = view.clone();
        if self.template.is_none() {
            self.keep_pace();
        }
        let (w, h) = self.size();
        let [x, y] = self.model.centre();
        let [middle_x, middle_y] = view.bbox.centre();
        self.hold_at([
            close_to(middle_x, (w - view.bbox.w) / 2.0, x),
            close_to(middle_y, (h - view.bbox.h) / 2.0, y),
        ]);
    }

    /// Is found at a place, whatever its own motion says.
    pub fn stand_at(&mut self, centre: [f32; 2]) {
        self.held_from = None;
        self.model.set_centre(centre);
    }

    /// Is held at a place that its own motion did not put it at.
    pub fn hold_at(&mut self, centre: [f32; 2]) {
        self.held_from.get_or_insert(self.model.centre());
        self.model.set_centre(centre);
    }

    /// Takes in where its looks show it, and how much of it is seen there, above 0 to 1. Its own motion is held
    /// against that: against where it was held, whatever holds it back would speed it up frame by frame.
    pub fn sight(&mut self, [x, y]: [f32; 2], seen: f32) {
        self.unseen = 0;
        if let Some(predicted) = self.held_from.take() {
            self.model.set_centre(predicted);
        }
        let scale = self.model.scale();
        self.model.update(&Vector3::new(x, y, scale), 1.0 / seen);
    }

    /// Takes in whether it is seen as two side by side. When that is so in three frames more than not, it was two from
    /// the start, who came in together: how the two looked as one is forgotten.
    pub fn note_beside(&mut self, beside: bool) {
        self.beside = if beside { self.beside + 1 } else { self.beside.saturating_sub(1) };
        if self.beside >= LASTS {
            self.forget_looks();
        }
    }

    /// Forgets how large it is and what it looks like: it is not what it was taken for.
    pub fn forget_looks(&mut self) {
        self.clear = None;
        self.template = None;
        self.scale = 1.0;
        self.partial = 0;
    }

    /// Takes in that it is not seen: its own motion goes on.
    pub fn miss(&mut self) {
        self.partial += 1;
        self.keep_pace();
    }

    /// Takes in how it is seen, alone. `cut_off` says that the image edge may hide a part of it.
    pub fn see(&mut self, view: &View, cut_off: bool, settings: &Settings) {
        self.seen += 1;
        self.partial = 0;
        self.last = view.clone();
        let [x, y, _] = self.model.velocity().into();
        match &mut self.clear {
            // Until its whole was seen once, larger is clearer.
            Some(clear) if cut_off && view.area > clear.area => clear.follow(view, [x, y]),
            Some(clear) if !cut_off => clear.follow(view, [x, y]),
            None if !cut_off => self.clear = Some(Appearance::first(view, [x, y])),
            Some(_) | None => {}
        }
        match &mut self.template {
            Some(template) if !cut_off => template.follow(&view.mosaic, &view.bbox),
            Some(_) => {}
            None => self.template = template_of(view, settings),
        }
    }

    /// Whether it went far while a part of it was seen: past anything that could hide the rest.
    pub fn went_far(&self, view: &View) -> bool {
        let [x, y] = self.model.centre();
        (x - self.partial_from[0]).hypot(y - self.partial_from[1])
            > self.size().0.min(view.bbox.w.max(0.5 * self.size().0))
    }

    /// What seemed a part of it has been the whole for long: what it looked like before is forgotten.
    pub fn relearn(&mut self, view: &View, settings: &Settings) {
        let [x, y, _] = self.model.velocity().into();
        self.clear = Some(Appearance::first(view, [x, y]));
        self.template = template_of(view, settings);
        self.scale = 1.0;
    }

    /// Whether a view shows nearly the whole of it.
    pub fn is_nearly_whole(&self, view: &View) -> bool {
        self.clear.is_none()
            || (view.area >= NEAR_FULL * self.area() && view.bbox.h >= NEAR_TALL * self.size().1)
    }

    /// Its dominant colours as Algorithm 1 compares them, the most frequent first.
    pub fn colours(&self, settings: &Settings) -> Vec<Rgb> {
        dominant_colours(self.histogram(settings), settings)
    }

    /// Its colours as Algorithm 1 compares them.
    pub fn histogram(&self, settings: &Settings) -> &Histogram {
        match (&self.clear, settings.colour_memory) {
            (Some(clear), ColourMemory::Clear) => &clear.histogram,
            _ => &self.last.histogram,
        }
    }

    /// How well a view's colours agree with its own, 0..=1.2, and the least ΔE between two of
    /// their dominant colours.
    pub fn agreement(&self, seen: &Histogram, settings: &Settings) -> (f32, f32) {
        let mine = self.histogram(settings);
        let least = dominant_colours(mine, settings)
            .iter()
            .flat_map(|&a| dominant_colours(seen, settings).into_iter().map(move |b| delta_e(a, b)))
            .fold(f32::INFINITY, f32::min);
        let same = if least <= settings.same_colour { 1.0 } else { 0.0 };
        let agreement = match settings.colour_memory {
            ColourMemory::Frame => same,
            // Several dominant colours often share one, dark trousers say; the whole histogram
            // tells by how much they agree.
            ColourMemory::Clear => mine.likeness(seen) + 0.2 * same,
        };
        (agreement, least)
    }
}

/// `value`, or the nearest to it that is at most `slack` away from `middle`; `middle` where `slack`
/// is negative.
pub(super) fn close_to(middle: f32, slack: f32, value: f32) -> f32 {
    let slack = slack.max(0.0);
    middle + (value - middle).clamp(-slack, slack)
}

/// What a first view says of the looks, where these are asked.
pub(super) fn template_of(view: &View, settings: &Settings) -> Option<Template> {
    (settings.placing == Placing::Looks).then(|| Template::first(&view.mosaic, &view.bbox))
}

fn dominant_colours(histogram: &Histogram, settings: &Settings) -> Vec<Rgb> {
    match settings.colour_memory {
        ColourMemory::Frame => histogram.dominant().into_iter().collect(),
        ColourMemory::Clear => histogram.dominant_at_least(0.5),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracking::kalman::Noise;

    #[test]
    fn who_is_held_back_frame_by_frame_does_not_gather_speed() {
        let bbox = Rect::around([100.0, 100.0], 40.0, 100.0);
        let (histogram, mosaic) = (Histogram::default(), Arc::default());
        let view = View { bbox, area: 2500.0, histogram, labels: vec![1], mosaic };
        let noise = Noise { process: 0.5, measurement: 2.0 };
        let model = Model::new(Vector3::new(100.0, 100.0, 50.0), Vector3::zeros(), 1.0, noise);
        let mut object = Object::new(1, (1, bbox), model, view);
        // Its region is smaller than itself, and each frame its looks are found a little beside the region's middle.
        for _ in 0..100 {
            object.go_on();
            object.hold_at([100.0, 100.0]);
            object.sight([106.0, 112.0], 0.5);
        }
        let ([x, y], velocity) = (object.model.centre(), object.model.velocity());
        assert!(velocity.norm() < 0.1, "it stands still: {velocity}");
        assert!((x - 106.0).abs() < 0.5 && (y - 112.0).abs() < 0.5, "where it is seen: {x} {y}");
    }

    #[test]
    fn its_size_follows_from_its_place_and_not_from_itself() {
        let mut perspective = Perspective::default();
        for n in 0..500 {
            let y = (100 + n % 50) as f32;
            perspective.see(y, 100.0 * (0.01 * (y - 100.0)).exp(), 100.0, 100.0);
        }
        let bbox = Rect::around([100.0, 100.0], 40.0, 100.0);
        let view = View {
            bbox,
            area: 2500.0,
            histogram: Histogram::default(),
            labels: vec![1],
            mosaic: Arc::default(),
        };
        let noise = Noise { process: 0.5, measurement: 2.0 };
        let model = Model::new(Vector3::new(100.0, 100.0, 50.0), Vector3::zeros(), 1.0, noise);
        let mut object = Object::new(1, (1, bbox), model, view.clone());
        object.see(&view, false, &Settings::default());
        object.stand_at([100.0, 110.0]);
        for _ in 0..20 {
            object.rescale(&perspective);
        }
        assert!((object.scale.ln() - 0.1).abs() < 0.01, "{}", object.scale);
    }
}
