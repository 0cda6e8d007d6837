//! Takes one frame's regions through tracking and occlusion reasoning (§VIII, Algorithms 1–3).
//!
//! The pool of Kalman models follows *blobs*: moving things with one region each. An *object* is what gets an
//! identity; a blob has one object as its member, or several while they share its region (an occlusion group). Events
//! are the changes of this partition from frame to frame.

use super::association::births::start_objects;
use super::association::cluster_update::update_cluster;
use super::association::detections::detections;
use super::association::matching::{clusters, match_blobs, match_manoeuvred_blobs};
use super::association::prediction::predict;
use super::event::{Counters, Event};
use super::events::demerges::{settle_demerges_of, update_pending_demerges};
use super::events::emission::emit_reappearance;
use super::events::episodes::update_group_episodes;
use super::events::group_changes::emit_group_changes;
use super::events::region_counts::RegionCounts;
use super::frame_result::{FinalResult, FrameResult, SettledResults, object_tracks};
use super::heads::head_split::count_heads;
use super::identities::confirmation::confirm_objects;
use super::identities::lost::{resolve_lost_blobs, resolve_lost_blobs_at_end};
use super::identities::occluded::update_occluded;
use super::members::existence::{correct_member_sizes, update_member_existence};
use super::members::member_search::reidentify_unseen_members;
use super::members::object_update::update_objects;
use super::state::context::Context;
use super::state::decisions::Decisions;
use super::state::object_table::ObjectTable;
use super::state::perspective::Perspective;
use crate::frame::Size;
use crate::regions::Region;
use crate::settings::{Settings, Switch};
use crate::tracking::seed_finder::SeedFinder;
use crate::tracking::{ObjectId, Track};

/// Follows objects through a sequence: regions of each frame, in order → tracks and events.
///
/// # Examples
/// A person of 20 × 60 pixels walks to the right, and is behind a wall in frames 50 to 69:
///
/// ```
/// use occluscope::frame::{Frame, Mask, Size};
/// use occluscope::occlusion::{EventKind, Tracker};
/// use occluscope::regions::find_regions;
/// use occluscope::settings::Settings;
///
/// let size = Size::new(320, 240);
/// let red = [200, 40, 40].repeat(size.pixels());
/// let mut tracker = Tracker::new(&Settings::default(), size, 25.0);
/// let mut events = Vec::new();
/// for number in 1..=100 {
///     let mut mask = Mask::empty(size);
///     if !(50..70).contains(&number) {
///         for y in 80..140 {
///             let start = 320 * y + 40 + 2 * number as usize;
///             mask.data[start..start + 20].fill(Mask::FOREGROUND);
///         }
///     }
///     let (_, regions) = find_regions(&Frame::new(number, size, red.clone()), &mask, 1);
///     events.extend(tracker.step(number, f64::from(number) / 25.0, &regions).events);
/// }
/// events.extend(tracker.finish().events);
///
/// let found: Vec<_> = events.iter().map(|event| (event.frame, event.kind, event.objects[0])).collect();
/// let expected = [(1, EventKind::Appear, 1), (50, EventKind::Disappear, 1), (70, EventKind::Reappear, 1)];
/// assert_eq!(found, expected);
/// ```
#[derive(Clone)]
pub struct Tracker {
    context: Context,
    table: ObjectTable,
    decisions: Decisions,
    perspective: Perspective,
    seeds: SeedFinder,
    region_counts: RegionCounts,
    counters: Counters,
}

impl Tracker {
    /// A tracker before the first frame, for frames of `size` at `fps` frames a second.
    pub fn new(settings: &Settings, size: Size, fps: f32) -> Self {
        Self {
            context: Context::new(settings, size, fps),
            table: ObjectTable::default(),
            decisions: Decisions::default(),
            perspective: Perspective::default(),
            seeds: SeedFinder::default(),
            region_counts: RegionCounts::default(),
            counters: Counters::default(),
        }
    }

    /// Processes the regions of the next frame, whose number is `number`, at `time` in seconds since any common start. A
    /// frame whose time is not later than that before it counts as one frame period later.
    pub fn step(&mut self, number: u32, time: f64, regions: &[Region]) -> FrameResult {
        self.context.advance(number, time);
        let Self { context, table, decisions, .. } = self;

        // Prediction and association.
        predict(context, table, &self.perspective);
        let detections = detections(context, table, regions);
        match_blobs(context, table, &detections);
        let mut unexplained = Vec::new();
        for cluster in clusters(context, table, &detections) {
            unexplained.extend(update_cluster(context, table, decisions, &cluster, &detections));
        }
        table.drop_empty_blobs();
        let unexplained = match_manoeuvred_blobs(context, table, &detections, unexplained);
        let earlier = start_objects(context, table, &mut self.seeds, &detections, &unexplained);
        self.region_counts.record(context, table);

        // Motion, appearance and members of each region.
        update_objects(context, table, decisions, &mut self.perspective);
        if context.settings.count_heads == Switch::On {
            count_heads(context, table, decisions);
        }
        if context.settings.find_again == Switch::On {
            reidentify_unseen_members(context, table, decisions);
        }
        correct_member_sizes(context, table);

        // Existence, identities and events.
        update_member_existence(context, table, decisions);
        resolve_lost_blobs(context, table, decisions);
        confirm_objects(context, table, decisions);
        update_occluded(context, table, decisions);
        update_pending_demerges(context, table, decisions);
        emit_group_changes(context, table, decisions);
        update_group_episodes(context, table, &mut decisions.group_episodes);

        debug_assert_eq!(table.check(), None, "in frame {number}");
        let result = self.take_frame_result(earlier);
        let Self { table, decisions, .. } = self;
        table.prune_identities(|id| decisions.has_reference_to(id));
        result
    }

    /// Decides what is pending after the last frame: demerges, reappearances, and objects lost shortly before the
    /// end.
    pub fn finish(&mut self) -> FinalResult {
        let Self { context, table, decisions, .. } = self;
        while let Some(members) = decisions.demerges.first().map(|demerge| demerge.members.clone()) {
            for id in members {
                settle_demerges_of(context, table, decisions, id);
            }
        }
        let pending: Vec<ObjectId> = decisions.reappearances.iter().map(|pending| pending.id).collect();
        for id in pending {
            emit_reappearance(context, table, decisions, id);
        }
        resolve_lost_blobs_at_end(context, table, decisions);
        emit_group_changes(context, table, decisions);
        decisions.group_episodes.close_all();
        FinalResult { events: self.take_counted_events(), settled: self.take_settled(Vec::new()) }
    }

    /// Events so far, by kind.
    pub const fn counters(&self) -> Counters {
        self.counters
    }

    /// Number of retained items of all kinds: must not grow with time.
    pub fn retained_items(&self) -> usize {
        self.table.len() + self.decisions.len() + self.region_counts.len() + self.seeds.len()
    }

    /// Takes the results after a frame; `earlier` are the tracks of its new objects in earlier frames.
    fn take_frame_result(&mut self, earlier: Vec<(u32, Track)>) -> FrameResult {
        let objects = object_tracks(&self.context, &self.table, &self.decisions);
        let identities = self.table.identity_map();
        let (confirmed, tentative): (Vec<_>, Vec<_>) =
            objects.iter().partition(|track| identities.of(track.key).is_some());
        FrameResult {
            tracks: identities.apply(confirmed),
            tentative: tentative.into_iter().cloned().collect(),
            objects,
            events: self.take_counted_events(),
            settled: self.take_settled(earlier),
        }
    }

    /// Takes the results settled since the previous call, with tracks in `earlier` frames.
    fn take_settled(&mut self, earlier: Vec<(u32, Track)>) -> SettledResults {
        let Self { table, decisions, .. } = self;
        let mut episodes = decisions.group_episodes.take_closed(|id| table.identity(id));
        episodes.append(&mut decisions.scene_episodes);
        SettledResults { identities: table.take_assigned_identities(), episodes, earlier }
    }

    /// Takes the events since the previous call, by frame and kind.
    fn take_counted_events(&mut self) -> Vec<Event> {
        let mut events = std::mem::take(&mut self.decisions.events);
        events.sort_by(|a, b| (a.frame, a.kind, &a.objects).cmp(&(b.frame, b.kind, &b.objects)));
        for event in &mut events {
            self.counters.count(event.kind);
            (event.evidence.objects_before, event.evidence.objects_now) =
                self.region_counts.around(event.frame);
        }
        events
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::occlusion::EventKind;
    use crate::occlusion::fixtures::{BLUE, RED, person, region, shared_region};
    use crate::regions::{Rect, Rgb};

    const SIZE: Size = Size::new(320, 240);

    fn tracker() -> Tracker {
        Tracker::new(&Settings::default(), SIZE, 25.0)
    }

    /// The regions of boxes in a frame: boxes that overlap are one region.
    fn regions_of(boxes: &[(Rect, Rgb)]) -> Vec<Region> {
        let mut groups: Vec<Vec<(Rect, Rgb)>> = Vec::new();
        for each in boxes {
            let overlaps = |group: &Vec<(Rect, Rgb)>| {
                group.iter().any(|(other, _)| other.intersection(&each.0).area() > 0.0)
            };
            let (joined, apart): (Vec<_>, Vec<_>) = groups.into_iter().partition(overlaps);
            groups = apart;
            groups.push(joined.into_iter().flatten().chain([*each]).collect());
        }
        (1..).zip(&groups).map(|(label, group)| shared_region(label, group)).collect()
    }

    #[test]
    fn two_people_who_cross_merge_once_and_demerge_once() {
        let mut tracker = tracker();
        let mut events = Vec::new();
        for number in 1..=100 {
            let x = 2.0 * number as f32;
            let boxes = [(person(40.0 + x, 80.0), RED), (person(260.0 - x, 80.0), BLUE)];
            events.extend(tracker.step(number, f64::from(number) / 25.0, &regions_of(&boxes)).events);
        }
        events.extend(tracker.finish().events);
        let kinds: Vec<_> = events.iter().map(|event| event.kind).collect();
        assert_eq!(kinds, [EventKind::Appear, EventKind::Appear, EventKind::Merge, EventKind::Demerge]);
        assert_eq!(events.last().map(|event| &event.pieces[..]), Some(&[vec![1], vec![2]][..]));
    }

    #[test]
    fn a_person_behind_an_occluder_disappears_and_reappears_under_one_identity() {
        let mut tracker = tracker();
        let mut events = Vec::new();
        for number in 1..=100 {
            let bbox = person(40.0 + 2.0 * number as f32, 80.0);
            let regions = if (50..70).contains(&number) { vec![] } else { vec![region(1, bbox, RED)] };
            events.extend(tracker.step(number, f64::from(number) / 25.0, &regions).events);
        }
        events.extend(tracker.finish().events);
        let kinds: Vec<_> = events.iter().map(|event| (event.kind, event.objects.clone())).collect();
        let of = |kind: EventKind| (kind, vec![1]);
        assert_eq!(kinds, [of(EventKind::Appear), of(EventKind::Disappear), of(EventKind::Reappear)]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn every_frame_leaves_the_table_whole(
            // Start, height in the image, speed and colour of each person; when each is hidden.
            people in prop::collection::vec((0_i16..300, 20_u8..80, -3_i8..4, any::<bool>()), 1..7),
            hidden in prop::collection::vec((0_usize..7, 0_u32..90, 1_u32..30), 0..6),
        ) {
            let mut tracker = tracker();
            for number in 1..=90 {
                let mut boxes = Vec::new();
                for (index, &(start, y, speed, red)) in people.iter().enumerate() {
                    let x = i32::from(start) / 2 * 2 + 2 * i32::from(speed) * number;
                    let is_hidden = hidden.iter().any(|&(of, from, frames)| {
                        of == index && (from..from + frames).contains(&(number as u32))
                    });
                    if !is_hidden && (0..300).contains(&x) {
                        let bbox = person(x as f32, (2 * i32::from(y)) as f32);
                        boxes.push((bbox, if red { RED } else { BLUE }));
                    }
                }
                tracker.step(number as u32, f64::from(number) / 25.0, &regions_of(&boxes));
                prop_assert_eq!(tracker.table.check(), None, "in frame {}", number);
            }
            tracker.finish();
            prop_assert_eq!(tracker.table.check(), None, "at the end");
        }
    }
}
