//! The state of one object: size, appearance and motion.

use std::sync::Arc;

use nalgebra::Vector3;

use super::comparable_colours::{ComparableColours, dominant_colours};
use super::context::FrameRef;
use super::perspective::Perspective;
use super::template::Template;
use crate::occlusion::event::{Comparison, EventKind};
use crate::regions::{Histogram, Mosaic, Rect, Rgb};
use crate::settings::{ColourMemory, Placing, Settings};
use crate::tracking::ObjectId;
use crate::tracking::kalman::KalmanModel;
use crate::tracking::pool::Observation;

/// Learning rate of the appearance, once a few clear frames were seen.
const APPEARANCE_LEARNING_RATE: f32 = 0.1;
/// A detection shows nearly the whole object from this share of its expected area on,
const MIN_WHOLE_AREA_SHARE: f32 = 0.7;
/// and from this share of its expected height on, which varies less than the width of a walking person.
const MIN_WHOLE_HEIGHT_SHARE: f32 = 0.8;

/// Factor on the velocity of an unseen member in each frame.
const VELOCITY_DAMPING: f32 = 0.9;

/// An object has moved once its centre is this share of √area away from its first box: ghosts and remains of passing
/// light stay in place. Tried on four real sequences and 24 variations of them: .75 gives the same, .25 half of the
/// gain.
const MIN_TRAVEL_SHARE: f32 = 0.5;

/// Frames in succession after which an observation is no flicker of the mask.
pub(crate) const MIN_STABLE_FRAMES: u32 = 3;

/// The region of an object in one frame, or its joined fragments.
#[derive(Clone, Debug)]
pub(crate) struct Detection {
    /// Box of its regions.
    pub(crate) bbox: Rect,
    /// Pixels of its regions.
    pub(crate) area: f32,
    /// Colours of its pixels.
    pub(crate) histogram: Histogram,
    /// The labels of its regions.
    pub(crate) labels: Vec<u32>,
    /// The colours of its cells by position.
    pub(crate) mosaic: Arc<Mosaic>,
}

impl Detection {
    /// Joins the detections of one object's fragments.
    pub(crate) fn join(parts: &[&Self]) -> Self {
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

    /// What the Kalman models observe of it.
    pub(crate) fn observation(&self) -> Observation {
        Observation { bbox: self.bbox, area: self.area }
    }
}

/// An object's unoccluded appearance: running averages over its clear frames.
#[derive(Clone, Debug)]
pub(crate) struct Appearance {
    /// Width of its box in pixels.
    pub(crate) w: f32,
    /// Height of its box.
    pub(crate) h: f32,
    /// Pixels.
    pub(crate) area: f32,
    /// Mean y of its box's centre, in pixels from the top of the image.
    pub(crate) y: f32,
    /// Share of each colour.
    pub(crate) histogram: Histogram,
    /// Velocity in pixels a frame, to the right and down, from clear frames only: the box of an object that moves
    /// behind an occluder shrinks at its front, so that its centre falls behind.
    pub(crate) velocity: [f32; 2],
    /// Number of clear frames.
    pub(crate) frames: u32,
}

impl Appearance {
    /// From one detection.
    pub(crate) fn new(detection: &Detection, velocity: [f32; 2]) -> Self {
        let mut histogram = Histogram::default();
        histogram.add_scaled(&detection.histogram, 1.0 / detection.area.max(1.0));
        let Rect { w, h, .. } = detection.bbox;
        let [_, y] = detection.bbox.centre();
        Self { w, h, area: detection.area, y, histogram, velocity, frames: 1 }
    }

    fn update(&mut self, detection: &Detection, velocity: [f32; 2]) {
        let rate = APPEARANCE_LEARNING_RATE.max(1.0 / (self.frames + 1) as f32);
        self.w += rate * (detection.bbox.w - self.w);
        self.h += rate * (detection.bbox.h - self.h);
        self.area += rate * (detection.area - self.area);
        self.y += rate * (detection.bbox.centre()[1] - self.y);
        for (mean, now) in self.velocity.iter_mut().zip(velocity) {
            *mean += rate * (now - *mean);
        }
        let mut histogram = Histogram::default();
        histogram.add_scaled(&self.histogram, 1.0 - rate);
        histogram.add_scaled(&detection.histogram, rate / detection.area.max(1.0));
        histogram.forget_below(0.002);
        self.histogram = histogram;
        self.frames += 1;
    }
}

/// An object, from its first to its last detection.
#[derive(Clone, Debug)]
pub(crate) struct Object {
    /// The number under which its tracks are recorded: its own until its first demerge.
    pub(crate) key: ObjectId,
    /// The first frame with a detection.
    pub(crate) first_frame: FrameRef,
    /// Its first box.
    pub(crate) first_bbox: Rect,
    /// Number of frames with a detection.
    pub(crate) seen_frames: u32,
    /// Whether it is confirmed: it has an identity.
    pub(crate) confirmed: bool,
    /// Frame and kind of the last emitted event of it or its group.
    pub(crate) last_event: Option<(u32, EventKind)>,
    /// Its own motion model: the blob's while it is alone, its own prediction otherwise.
    pub(crate) model: KalmanModel,
    /// Its unoccluded appearance, `None` before its first clear frame.
    pub(crate) appearance: Option<Appearance>,
    /// Scale from its mean clear place to its present place, by perspective.
    pub(crate) scale: f32,
    /// Appearance template by position in the box, `None` before it was seen alone.
    pub(crate) template: Option<Template>,
    /// Score of the frames in which its region showed more heads than members.
    pub(crate) extra_head_score: u32,
    /// Its visible share in its group's region at the last localisation, 0..=1.
    pub(crate) visible_share_in_group: f32,
    /// Log odds that it exists at its believed place, in nats.
    pub(crate) existence: f32,
    /// Frames in succession without visible pixels in its group's region.
    pub(crate) unseen_frames: u32,
    /// Its last detection while alone.
    pub(crate) last_detection: Detection,
    /// Frames in succession in which it was partly visible or not visible.
    pub(crate) partial_frames: u32,
    /// Its centre in the first frame of that series.
    pub(crate) partial_start: [f32; 2],
    /// Evidence for fragments that were joined to it, until its first event.
    pub(crate) fragments: Vec<Comparison>,
    /// Counter of frames in which it looked like two objects side by side; others count down.
    pub(crate) side_by_side_frames: u32,
    /// The centre its motion model predicted in this frame, if it was constrained to a region.
    pub(crate) unconstrained_centre: Option<[f32; 2]>,
}

impl Object {
    /// A new tentative object with its key, first frame and box, motion model and detection.
    pub(crate) fn new(
        key: ObjectId,
        (first_frame, first_bbox): (FrameRef, Rect),
        model: KalmanModel,
        last_detection: Detection,
    ) -> Self {
        Self {
            key,
            first_frame,
            first_bbox,
            seen_frames: 1,
            confirmed: false,
            last_event: None,
            partial_start: model.centre(),
            unconstrained_centre: None,
            model,
            appearance: None,
            scale: 1.0,
            template: None,
            extra_head_score: 0,
            unseen_frames: 0,
            visible_share_in_group: 1.0,
            existence: 0.0,
            last_detection,
            partial_frames: 0,
            fragments: Vec::new(),
            side_by_side_frames: 0,
        }
    }

    /// Whether it has moved away from its first box.
    pub(crate) fn has_moved(&self) -> bool {
        let ([x, y], [from_x, from_y]) = (self.last_detection.bbox.centre(), self.first_bbox.centre());
        (x - from_x).hypot(y - from_y) >= MIN_TRAVEL_SHARE * self.last_detection.area.sqrt()
    }

    /// Whether it may be matched to the occluded object `known`: an object that has not moved only if nearly whole.
    pub(crate) fn may_match(&self, known: &Self) -> bool {
        self.has_moved() || known.is_nearly_whole(&self.last_detection)
    }

    /// Expected width and height of its box.
    pub(crate) fn size(&self) -> (f32, f32) {
        let size = |clear: &Appearance| (self.scale * clear.w, self.scale * clear.h);
        self.appearance.as_ref().map_or((self.last_detection.bbox.w, self.last_detection.bbox.h), size)
    }

    /// Expected area in pixels.
    pub(crate) fn area(&self) -> f32 {
        self.appearance
            .as_ref()
            .map_or(self.last_detection.area, |clear| self.scale * self.scale * clear.area)
    }

    /// Updates its scale by its place.
    pub(crate) fn update_scale(&mut self, perspective: &Perspective) {
        if let Some(clear) = &self.appearance {
            let [_, y] = self.model.centre();
            self.scale = perspective.scale(y, clear.y);
        }
    }

    /// Its predicted box.
    pub(crate) fn predicted_box(&self) -> Rect {
        let (w, h) = self.size();
        Rect::around(self.model.centre(), w, h)
    }

    /// Predicts its own motion by a number of frame periods.
    pub(crate) fn predict(&mut self, periods: f32) {
        self.unconstrained_centre = None;
        self.model.predict(periods);
    }

    /// Takes the motion of its blob.
    pub(crate) fn set_model(&mut self, model: &KalmanModel) {
        self.unconstrained_centre = None;
        self.model = model.clone();
    }

    /// Sets the velocity to the mean of its clear frames.
    pub(crate) fn restore_clear_velocity(&mut self) {
        if let Some(Appearance { velocity: [x, y], .. }) = self.appearance {
            self.model.set_velocity(Vector3::new(x, y, 0.0));
        }
    }

    /// Damps the velocity: an unseen object may have stopped or turned.
    pub(crate) fn damp_velocity(&mut self) {
        let velocity = self.model.velocity();
        self.model.set_velocity(VELOCITY_DAMPING * velocity);
    }

    /// The share of its expected area that `area` pixels show, 0..=1.
    pub(crate) fn visible_share(&self, area: f32) -> f32 {
        (area / self.area().max(1.0)).min(1.0)
    }

    /// Updates it with a detection of a part: its own motion continues, and its full extent is placed around the
    /// detection.
    pub(crate) fn update_partial(&mut self, detection: &Detection) {
        self.seen_frames += 1;
        if self.partial_frames == 0 {
            self.partial_start = self.model.centre();
        }
        self.partial_frames += 1;
        self.last_detection = detection.clone();
        if self.template.is_none() {
            self.restore_clear_velocity();
        }
        let (w, h) = self.size();
        let [x, y] = self.model.centre();
        let [middle_x, middle_y] = detection.bbox.centre();
        self.constrain_centre([
            clamp_around(middle_x, (w - detection.bbox.w) / 2.0, x),
            clamp_around(middle_y, (h - detection.bbox.h) / 2.0, y),
        ]);
    }

    /// Continues as the object `seen`, which proved to be this one: with its key, place and detection.
    pub(super) fn continue_as(&mut self, seen: Self) {
        self.key = seen.key;
        self.seen_frames += seen.seen_frames;
        if self.is_nearly_whole(&seen.last_detection) {
            self.model = seen.model;
            self.partial_frames = 0;
        } else {
            self.update_partial(&seen.last_detection);
        }
        self.last_detection = seen.last_detection;
    }

    /// Standard deviation of its predicted place, in pixels. In a group it is larger the longer the object has not
    /// been localised: for its unseen frames, or without a template for all `group_frames` in the group; `None` of
    /// an object alone.
    pub(crate) fn position_sigma(&self, group_frames: Option<u32>) -> f32 {
        let (_, height) = self.size();
        let apart = match (group_frames, &self.template) {
            (None, _) => 0.0,
            (Some(_), Some(_)) => self.unseen_frames as f32,
            (Some(frames), None) => frames as f32,
        };
        let velocity = self.model.velocity();
        0.15 * height + 0.25 * velocity.x.hypot(velocity.y) * apart
    }

    /// Radius in pixels around the predicted place within which it may reappear after so many occluded frames: it
    /// may have slowed down, stopped or turned.
    pub(crate) fn reappearance_radius(&self, frames: u32) -> f32 {
        let velocity = self.model.velocity();
        self.stationary_radius(frames) + 0.5 * velocity.x.hypot(velocity.y) * frames as f32
    }

    /// The radius around any place where it may have stopped.
    pub(crate) fn stationary_radius(&self, frames: u32) -> f32 {
        0.6 * self.size().1 + (frames as f32).sqrt()
    }

    /// The visible share of a group's member: the share of its own colours that the group's region contains.
    pub(crate) fn visible_share_in(&self, region: &Detection) -> f32 {
        self.appearance.as_ref().map_or(1.0, |clear| region.histogram.holds(&clear.histogram, clear.area))
    }

    /// Moves it to a centre, independent of its motion.
    pub(crate) fn set_centre(&mut self, centre: [f32; 2]) {
        self.unconstrained_centre = None;
        self.model.set_centre(centre);
    }

    /// Constrains it to a centre other than the predicted one.
    pub(crate) fn constrain_centre(&mut self, centre: [f32; 2]) {
        self.unconstrained_centre.get_or_insert(self.model.centre());
        self.model.set_centre(centre);
    }

    /// Updates its motion with a localised centre and visible share, above 0 to 1. The innovation is taken against
    /// the unconstrained prediction: against the constrained one, the constraint would accelerate it frame by frame.
    pub(crate) fn update_position(&mut self, [x, y]: [f32; 2], seen: f32) {
        self.unseen_frames = 0;
        if let Some(predicted) = self.unconstrained_centre.take() {
            self.model.set_centre(predicted);
        }
        let scale = self.model.scale();
        self.model.update(&Vector3::new(x, y, scale), 1.0 / seen);
    }

    /// Counts frames in which it looks like two objects side by side. After `MIN_STABLE_FRAMES` more such frames than
    /// others it was two from the start, and its joint appearance is dropped.
    pub(crate) fn record_side_by_side(&mut self, beside: bool) {
        self.side_by_side_frames =
            if beside { self.side_by_side_frames + 1 } else { self.side_by_side_frames.saturating_sub(1) };
        if self.side_by_side_frames >= MIN_STABLE_FRAMES {
            self.reset_appearance();
        }
    }

    /// Drops its size and appearance: they belong to something else.
    pub(crate) fn reset_appearance(&mut self) {
        self.appearance = None;
        self.template = None;
        self.scale = 1.0;
        self.partial_frames = 0;
    }

    /// Coasts for a frame without a detection.
    pub(crate) fn coast(&mut self) {
        self.partial_frames += 1;
        self.restore_clear_velocity();
    }

    /// Updates its appearance with a detection while alone. `cut_off` says that the image edge may hide a part of it.
    pub(crate) fn update_appearance(&mut self, detection: &Detection, cut_off: bool, settings: &Settings) {
        self.seen_frames += 1;
        self.partial_frames = 0;
        self.last_detection = detection.clone();
        let [x, y, _] = self.model.velocity().into();
        match &mut self.appearance {
            // Until its whole was visible once, a larger detection is a clearer one.
            Some(clear) if cut_off && detection.area > clear.area => clear.update(detection, [x, y]),
            Some(clear) if !cut_off => clear.update(detection, [x, y]),
            None if !cut_off => self.appearance = Some(Appearance::new(detection, [x, y])),
            Some(_) | None => {}
        }
        match &mut self.template {
            Some(template) if !cut_off => template.update(&detection.mosaic, &detection.bbox),
            Some(_) => {}
            None => self.template = template_of(detection, settings),
        }
    }

    /// Whether it moved farther while partly visible than an occluder could hide the rest.
    pub(crate) fn has_moved_while_partial(&self, detection: &Detection) -> bool {
        let [x, y] = self.model.centre();
        (x - self.partial_start[0]).hypot(y - self.partial_start[1])
            > self.size().0.min(detection.bbox.w.max(0.5 * self.size().0))
    }

    /// Learns its appearance anew from a detection that seemed a part for long.
    pub(crate) fn relearn_appearance(&mut self, detection: &Detection, settings: &Settings) {
        let [x, y, _] = self.model.velocity().into();
        self.appearance = Some(Appearance::new(detection, [x, y]));
        self.template = template_of(detection, settings);
        self.scale = 1.0;
    }

    /// Whether a detection shows nearly the whole of it.
    pub(crate) fn is_nearly_whole(&self, detection: &Detection) -> bool {
        self.appearance.is_none()
            || (detection.area >= MIN_WHOLE_AREA_SHARE * self.area()
                && detection.bbox.h >= MIN_WHOLE_HEIGHT_SHARE * self.size().1)
    }

    /// Its dominant colours as Algorithm 1 compares them, the most frequent first.
    pub(crate) fn colours(&self, settings: &Settings) -> Vec<Rgb> {
        dominant_colours(self.histogram(settings), settings)
    }

    /// Its colours as Algorithm 1 compares them.
    pub(crate) fn histogram(&self, settings: &Settings) -> &Histogram {
        match (&self.appearance, settings.colour_memory) {
            (Some(clear), ColourMemory::Clear) => &clear.histogram,
            _ => &self.last_detection.histogram,
        }
    }

    /// Its colours, to be compared with those of detections.
    pub(crate) fn comparable_colours(&self, settings: &Settings) -> ComparableColours {
        ComparableColours::new(self.histogram(settings), settings)
    }

    /// Colour similarity to a detection, 0..=1.2, and the least ΔE between two of their dominant colours.
    pub(crate) fn colour_similarity(&self, seen: &Histogram, settings: &Settings) -> (f32, f32) {
        self.comparable_colours(settings).similarity(&ComparableColours::new(seen, settings), settings)
    }
}

/// `value` clamped to at most `slack` from `middle`; `middle` where `slack` is negative.
pub(crate) fn clamp_around(middle: f32, slack: f32, value: f32) -> f32 {
    let slack = slack.max(0.0);
    middle + (value - middle).clamp(-slack, slack)
}

/// The template of a first detection, where the settings use templates.
pub(crate) fn template_of(detection: &Detection, settings: &Settings) -> Option<Template> {
    (settings.placing == Placing::Looks).then(|| Template::new(&detection.mosaic, &detection.bbox))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing)]
    use super::*;
    use crate::regions::colour::delta_e;
    use crate::tracking::kalman::Noise;

    #[test]
    fn an_object_constrained_in_every_frame_does_not_accelerate() {
        let bbox = Rect::around([100.0, 100.0], 40.0, 100.0);
        let (histogram, mosaic) = (Histogram::default(), Arc::default());
        let detection = Detection { bbox, area: 2500.0, histogram, labels: vec![1], mosaic };
        let noise = Noise { process: 0.5, measurement: 2.0 };
        let model = KalmanModel::new(Vector3::new(100.0, 100.0, 50.0), Vector3::zeros(), 1.0, noise);
        let mut object = Object::new(1, (FrameRef { number: 1, index: 1, t: 1 }, bbox), model, detection);
        // Its region is smaller than its box, and each frame it is localised a little beside the region's middle.
        for _ in 0..100 {
            object.predict(1.0);
            object.constrain_centre([100.0, 100.0]);
            object.update_position([106.0, 112.0], 0.5);
        }
        let ([x, y], velocity) = (object.model.centre(), object.model.velocity());
        assert!(velocity.norm() < 0.1, "it stands still: {velocity}");
        assert!((x - 106.0).abs() < 0.5 && (y - 112.0).abs() < 0.5, "where it is seen: {x} {y}");
    }

    #[test]
    fn its_scale_follows_from_its_place_and_does_not_accumulate() {
        let mut perspective = Perspective::default();
        for n in 0..500 {
            let y = (100 + n % 50) as f32;
            perspective.update(y, 100.0 * (0.01 * (y - 100.0)).exp(), 100.0, 100.0);
        }
        let bbox = Rect::around([100.0, 100.0], 40.0, 100.0);
        let detection = Detection {
            bbox,
            area: 2500.0,
            histogram: Histogram::default(),
            labels: vec![1],
            mosaic: Arc::default(),
        };
        let noise = Noise { process: 0.5, measurement: 2.0 };
        let model = KalmanModel::new(Vector3::new(100.0, 100.0, 50.0), Vector3::zeros(), 1.0, noise);
        let mut object =
            Object::new(1, (FrameRef { number: 1, index: 1, t: 1 }, bbox), model, detection.clone());
        object.update_appearance(&detection, false, &Settings::default());
        object.set_centre([100.0, 110.0]);
        for _ in 0..20 {
            object.update_scale(&perspective);
        }
        assert!((object.scale.ln() - 0.1).abs() < 0.01, "{}", object.scale);
    }

    fn detection(bbox: Rect, area: f32, colours: &[(Rgb, u32)]) -> Detection {
        let mut histogram = Histogram::default();
        for &(colour, pixels) in colours {
            histogram.add_scaled(&crate::regions::colour::tests::histogram(&[(colour, 1)]), pixels as f32);
        }
        Detection { bbox, area, histogram, labels: vec![1], mosaic: Arc::default() }
    }

    const RED: Rgb = [200, 0, 0];
    const BLUE: Rgb = [0, 0, 200];

    /// A red object of 40 by 100 pixels, half of them filled, with its centre at (100, 100), that was seen clearly once.
    fn object(velocity: [f32; 2]) -> Object {
        let seen = detection(Rect::around([100.0, 100.0], 40.0, 100.0), 2000.0, &[(RED, 2000)]);
        let noise = Noise { process: 0.5, measurement: 2.0 };
        let speed = Vector3::new(velocity[0], velocity[1], 0.0);
        let model = KalmanModel::new(seen.observation().measurement(), speed, 1.0, noise);
        let first = (FrameRef { number: 1, index: 1, t: 1 }, seen.bbox);
        let appearance = Some(Appearance::new(&seen, velocity));
        Object { appearance, ..Object::new(1, first, model, seen) }
    }

    fn close(found: f32, expected: f32) -> bool {
        (found - expected).abs() < 1e-4 * expected.abs().max(1.0)
    }

    #[test]
    fn the_appearance_is_the_mean_of_the_first_clear_frames_and_follows_later_ones_slowly() {
        let first = detection(Rect::new(10.0, 20.0, 40.0, 100.0), 2000.0, &[(RED, 1500), (BLUE, 500)]);
        let second = detection(Rect::new(10.0, 50.0, 60.0, 80.0), 4000.0, &[(BLUE, 4000)]);
        let mut clear = Appearance::new(&first, [2.0, 0.0]);
        let of = |clear: &Appearance| {
            let shares: Vec<f32> = clear.histogram.bins().map(|(_, bin)| bin.count).collect();
            [
                clear.w,
                clear.h,
                clear.area,
                clear.y,
                clear.velocity[0],
                clear.velocity[1],
                shares[0],
                shares[1],
            ]
        };
        let agree = |clear: &Appearance, expected: [f32; 8]| {
            let found = of(clear);
            assert!(found.iter().zip(expected).all(|(a, b)| close(*a, b)), "{found:?} {expected:?}");
        };
        agree(&clear, [40.0, 100.0, 2000.0, 70.0, 2.0, 0.0, 0.25, 0.75]);
        clear.update(&second, [4.0, -2.0]);
        agree(&clear, [50.0, 90.0, 3000.0, 80.0, 3.0, -1.0, 0.625, 0.375]);
        clear.update(&first, [0.0, 5.0]);
        agree(&clear, [140.0 / 3.0, 280.0 / 3.0, 8000.0 / 3.0, 230.0 / 3.0, 2.0, 1.0, 0.5, 0.5]);
        assert_eq!(clear.frames, 3);
        (0..17).for_each(|_| clear.update(&first, [2.0, 0.0]));
        let [w, h, area, ..] = of(&clear);
        clear.update(&second, [2.0, 0.0]);
        let slowly = |before: f32, now: f32| 0.9 * before + 0.1 * now;
        assert!(close(clear.w, slowly(w, 60.0)) && close(clear.h, slowly(h, 80.0)));
        assert!(close(clear.area, slowly(area, 4000.0)));
    }

    #[test]
    fn the_expected_size_follows_the_scale() {
        let mut object = object([0.0; 2]);
        object.scale = 1.5;
        assert_eq!((object.size(), object.area()), ((60.0, 150.0), 4500.0));
        assert_eq!((object.visible_share(900.0), object.visible_share(9000.0)), (0.2, 1.0));
        let whole =
            |h: f32, area: f32| object.is_nearly_whole(&detection(Rect::new(0.0, 0.0, 40.0, h), area, &[]));
        assert!(whole(120.0, 3151.0));
        assert!(!whole(119.0, 3151.0), "less than .8 of the height");
        assert!(!whole(120.0, 3149.0), "less than .7 of the area");
    }

    #[test]
    fn a_part_is_where_the_whole_can_be_around_it() {
        let mut object = object([3.0, 1.0]);
        object.model.set_velocity(Vector3::zeros());
        // The right half, and of that the lower six tenths.
        let part = detection(Rect::around([120.0, 130.0], 20.0, 60.0), 600.0, &[(RED, 600)]);
        object.update_partial(&part);
        assert_eq!(object.model.centre(), [110.0, 110.0]);
        assert_eq!(
            (object.partial_start, object.unconstrained_centre),
            ([100.0, 100.0], Some([100.0, 100.0]))
        );
        assert_eq!((object.partial_frames, object.seen_frames, object.last_detection.area), (1, 2, 600.0));
        let velocity = object.model.velocity();
        assert_eq!((velocity.x, velocity.y), (3.0, 1.0), "that of its clear frames");
        object.update_partial(&part);
        assert_eq!((object.partial_frames, object.seen_frames), (2, 3));
        assert_eq!((object.model.centre(), object.partial_start), ([110.0, 110.0], [100.0, 100.0]));
        // Where it is wider than expected, its middle is that of the part.
        object.update_partial(&detection(Rect::around([150.0, 90.0], 60.0, 120.0), 4000.0, &[]));
        assert_eq!(object.model.centre(), [150.0, 90.0]);
    }

    #[test]
    fn an_object_that_proved_to_be_another_continues_as_it() {
        let mut known = object([0.0; 2]);
        (known.seen_frames, known.partial_frames) = (7, 4);
        let mut whole = object([0.0; 2]);
        (whole.key, whole.seen_frames) = (9, 5);
        whole.set_centre([150.0, 100.0]);
        let mut part = whole.clone();
        let seen = Rect::around([160.0, 100.0], 20.0, 100.0);
        (part.last_detection.area, part.last_detection.bbox) = (900.0, seen);
        let mut continued = known.clone();
        continued.continue_as(whole);
        assert_eq!((continued.key, continued.seen_frames, continued.partial_frames), (9, 12, 0));
        assert_eq!(continued.model.centre(), [150.0, 100.0]);
        known.continue_as(part);
        assert_eq!((known.key, known.seen_frames, known.partial_frames), (9, 13, 5));
        assert_eq!(known.model.centre(), [150.0, 100.0], "as near to its prediction as the part allows");
        assert_eq!(known.last_detection.bbox, seen);
    }

    #[test]
    fn the_place_is_uncertain_by_size_speed_and_time() {
        let mut object = object([3.0, 4.0]);
        object.unseen_frames = 4;
        assert!(close(object.position_sigma(None), 15.0));
        assert!(close(object.position_sigma(Some(6)), 15.0 + 0.25 * 5.0 * 6.0));
        object.template = Some(Template::new(&Mosaic::default(), &Rect::default()));
        assert!(close(object.position_sigma(Some(6)), 15.0 + 0.25 * 5.0 * 4.0));
        assert!(close(object.stationary_radius(16), 60.0 + 4.0));
        assert!(close(object.reappearance_radius(16), 64.0 + 0.5 * 5.0 * 16.0));
    }

    #[test]
    fn a_localised_place_counts_by_the_visible_share() {
        let mut object = object([3.0, 0.0]);
        object.unseen_frames = 5;
        let mut model = object.model.clone();
        model.update(&Vector3::new(108.0, 97.0, model.scale()), 4.0);
        object.constrain_centre([90.0, 90.0]);
        object.update_position([108.0, 97.0], 0.25);
        assert_eq!((&object.model, object.unseen_frames), (&model, 0));
    }

    #[test]
    fn an_appearance_of_two_side_by_side_is_dropped() {
        let mut object = object([0.0; 2]);
        let kept = [true, true, false, true, true].map(|beside| {
            object.record_side_by_side(beside);
            object.appearance.is_some()
        });
        assert_eq!(kept, [true, true, true, true, false]);
    }

    #[test]
    fn an_appearance_is_learnt_from_the_whole_or_from_more_of_it() {
        use crate::regions::mosaic::Cell;
        let settings = Settings { placing: Placing::Looks, ..Settings::default() };
        let seen = |w: f32, grey: u8| {
            let cells = vec![Cell { pixels: 4, colour: [grey; 3] }; 20 * 50];
            let mosaic = Arc::new(Mosaic { side: 2, left: 0, top: 0, columns: 20, cells });
            Detection { mosaic, ..detection(Rect::new(0.0, 0.0, w, 100.0), 50.0 * w, &[(RED, 10)]) }
        };
        let mut object = Object { appearance: None, ..object([0.0; 2]) };
        let mut after = |w: f32, grey: u8, cut_off: bool| {
            object.update_appearance(&seen(w, grey), cut_off, &settings);
            let template = object.template.as_ref().map_or(-1.0, |it| it.at(0.5, 0.5).colour[0]);
            (object.appearance.as_ref().map(|clear| (clear.w, clear.frames)), template)
        };
        assert_eq!(after(20.0, 100, true), (None, 100.0), "a part, until more is seen");
        assert_eq!(after(40.0, 100, false), (Some((40.0, 1)), 100.0));
        assert_eq!(after(30.0, 200, true), (Some((40.0, 1)), 100.0), "a smaller part tells nothing");
        assert_eq!(after(50.0, 200, true), (Some((45.0, 2)), 100.0), "a larger one tells its size");
        assert_eq!(after(30.0, 220, false), (Some((40.0, 3)), 140.0));
        assert_eq!(object.seen_frames, 6);
    }

    #[test]
    fn an_object_has_moved_once_it_is_half_its_length_away() {
        let moved_by = |x: f32, y: f32| {
            let mut object = object([0.0; 2]);
            let seen = Rect::around([100.0 + x, 100.0 + y], 40.0, 100.0);
            object.last_detection = detection(seen, 1600.0, &[(RED, 1600)]);
            object
        };
        assert!(moved_by(12.0, -16.0).has_moved() && moved_by(0.0, 20.0).has_moved());
        assert!(!moved_by(12.0, 15.0).has_moved() && !moved_by(19.0, 0.0).has_moved());
        let known = object([0.0; 2]);
        assert!(moved_by(0.0, 0.0).may_match(&known), "as large as the one that is sought");
        let mut part = moved_by(0.0, 0.0);
        part.last_detection.area = 1300.0;
        assert!(!part.may_match(&known));
        part.last_detection.bbox = Rect::around([130.0, 100.0], 40.0, 100.0);
        assert!(part.may_match(&known));
    }

    #[test]
    fn colours_are_compared_by_the_clear_appearance_or_by_the_last_frame() {
        let mut object = object([0.0; 2]);
        let now = detection(object.first_bbox, 1000.0, &[(BLUE, 600), (RED, 400)]);
        object.last_detection = now.clone();
        let settings =
            |colour_memory, same_colour| Settings { same_colour, colour_memory, ..Settings::default() };
        let (clear, frame) = (settings(ColourMemory::Clear, 10.0), settings(ColourMemory::Frame, 10.0));
        assert_eq!((object.colours(&clear), object.colours(&frame)), (vec![RED], vec![BLUE]));
        let near = |(similarity, least): (f32, f32), expected: f32, delta: f32| {
            assert!(close(similarity, expected) && close(least, delta), "{similarity} {least}");
        };
        near(object.colour_similarity(&now.histogram, &clear), 0.4 + 0.2, 0.0);
        near(object.colour_similarity(&now.histogram, &frame), 1.0, 0.0);
        let red = detection(object.first_bbox, 1000.0, &[(RED, 1000)]).histogram;
        let apart = delta_e(RED, BLUE);
        near(object.colour_similarity(&red, &frame), 0.0, apart);
        near(object.colour_similarity(&red, &settings(ColourMemory::Frame, apart)), 1.0, apart);
        let blue = detection(object.first_bbox, 1000.0, &[(BLUE, 1000)]).histogram;
        near(object.colour_similarity(&blue, &clear), 0.0, apart);
    }

    #[test]
    fn a_part_that_moved_farther_than_what_it_could_be_hidden_by_is_the_whole() {
        let mut object = object([0.0; 2]);
        let moved = |object: &Object, w: f32| {
            object.has_moved_while_partial(&detection(Rect::new(0.0, 0.0, w, 50.0), 500.0, &[]))
        };
        // From (100, 100) by 25, where the whole is 40 wide and half of it 20.
        object.set_centre([115.0, 120.0]);
        assert!(moved(&object, 24.0) && moved(&object, 10.0));
        assert!(!moved(&object, 25.0) && !moved(&object, 60.0));
        object.set_centre([120.0, 100.0]);
        assert!(!moved(&object, 10.0));
        object.set_centre([100.0, 141.0]);
        assert!(moved(&object, 60.0));
    }

    #[test]
    fn an_appearance_learnt_anew_is_that_of_the_detection() {
        let mut object = object([3.0, 1.0]);
        object.scale = 2.0;
        let seen = detection(Rect::new(90.0, 80.0, 30.0, 50.0), 900.0, &[(BLUE, 900)]);
        object.relearn_appearance(&seen, &Settings::default());
        let clear = object
            .appearance
            .as_ref()
            .map(|clear| (clear.w, clear.h, clear.area, clear.velocity, clear.frames));
        assert_eq!((clear, object.scale), (Some((30.0, 50.0, 900.0, [3.0, 1.0], 1)), 1.0));
    }
}
