//! Occlusion reasoning on drawn frames: flat figures on a flat background, without a background model.

#![allow(clippy::expect_used, clippy::panic, missing_docs)]

use occluscope::frame::{Frame, Mask, Size};
use occluscope::occlusion::{Event, EventKind, FrameResult, Relation, Tracker};
use occluscope::regions::find_regions;
use occluscope::settings::{Settings, Span};
use occluscope::tracking::TrackState;

const SIZE: Size = Size { width: 320, height: 240 };
const RED: [u8; 3] = [220, 30, 30];
const GREEN: [u8; 3] = [30, 220, 30];
const BLUE: [u8; 3] = [30, 30, 220];
const YELLOW: [u8; 3] = [230, 230, 30];

/// A figure of 20×60 pixels with a narrow head: the column of its centre, its top row, its colour.
type Figure = (i32, i32, [u8; 3]);

/// A frame with these figures and its mask; later figures occlude earlier ones.
fn draw(number: u32, figures: &[Figure]) -> (Frame, Mask) {
    let mut rgb = vec![90; 3 * SIZE.pixels()];
    let mut mask = Mask::empty(SIZE);
    for &(middle, top, colour) in figures {
        for row in 0..60 {
            let half = if row < 12 { 4 } else { 10 };
            for column in -half..half {
                let (x, y) = (middle + column, top + row);
                if let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y))
                    && let Some(index) = SIZE.index(x, y)
                {
                    mask.data[index] = Mask::FOREGROUND;
                    rgb[3 * index..3 * index + 3].copy_from_slice(&colour);
                }
            }
        }
    }
    (Frame::new(number, SIZE, rgb), mask)
}

fn step(tracker: &mut Tracker, number: u32, figures: &[Figure]) -> FrameResult {
    let (frame, mask) = draw(number, figures);
    let (_, regions) = find_regions(&frame, &mask, 4);
    // Without times, frames are one period apart.
    tracker.step(number, 0.0, &regions)
}

/// Two figures that cross: separate at first, in one region from about frame 40, separate again from about 56.
fn crossing(number: u32) -> [Figure; 2] {
    let x = 2 * number as i32;
    [(40 + x, 100, RED), (220 - x, 104, BLUE)]
}

fn kinds(events: &[Event]) -> Vec<EventKind> {
    events.iter().map(|event| event.kind).collect()
}

#[test]
fn a_group_that_splits_while_another_object_joins_is_analysed() {
    for fps in [2.0, 10.0, 25.0] {
        let mut tracker = Tracker::new(&Settings::default(), SIZE, fps);
        let heads = ((0.5 * fps).round() as u32).max(3) + 1;
        let mut number = 0;
        let mut show = |frames: u32, figures: &mut dyn FnMut(u32) -> Vec<Figure>| {
            for frame in 0..frames {
                number += 1;
                step(&mut tracker, number, &figures(frame));
            }
        };
        show(30, &mut |_| vec![(60, 100, RED), (130, 100, GREEN), (34, 100, BLUE)]);
        show(10, &mut |frame| vec![(65 + 5 * frame as i32, 100, RED), (130, 100, GREEN), (34, 100, BLUE)]);
        show(6, &mut |_| vec![(110, 100, RED), (130, 100, GREEN), (60, 100, BLUE)]);
        show(heads, &mut |_| vec![(90, 100, YELLOW), (110, 100, RED), (130, 100, GREEN), (64, 100, BLUE)]);
        show(21, &mut |_| vec![(90, 100, YELLOW), (110, 100, RED), (136, 100, GREEN), (70, 100, BLUE)]);
    }
}

#[test]
fn a_demerge_shortly_before_the_end_is_decided_at_the_end() {
    for last in [58, 60, 62] {
        let mut tracker = Tracker::new(&Settings::default(), SIZE, 25.0);
        let mut events = Vec::new();
        for number in 1..=last {
            events.extend(step(&mut tracker, number, &crossing(number)).events);
        }
        assert!(!kinds(&events).contains(&EventKind::Demerge), "not decided before frame {last}");
        events.extend(tracker.finish().events);
        let demerges: Vec<&Event> = events.iter().filter(|event| event.kind == EventKind::Demerge).collect();
        assert_eq!(demerges.len(), 1, "{last}: {:?}", kinds(&events));
        assert!((50..=58).contains(&demerges[0].frame), "{}", demerges[0].frame);
        assert!(tracker.finish().events.is_empty(), "no decision is pending");
    }
}

#[test]
fn an_invisible_member_leaves_its_group() {
    let mut tracker = Tracker::new(&Settings::default(), SIZE, 25.0);
    let mut number = 0;
    while number < 48 {
        number += 1;
        step(&mut tracker, number, &crossing(number));
    }
    // The red figure has left; the blue one walks on alone.
    let mut last = FrameResult::default();
    while number < 110 {
        number += 1;
        let [_, blue] = crossing(number);
        last = step(&mut tracker, number, &[blue]);
    }
    assert_eq!(last.tracks.len(), 1, "one figure is visible: {:?}", last.tracks);
    assert!(last.tracks[0].group.is_empty(), "the figure is not in a group: {:?}", last.tracks[0].group);
}

#[test]
fn a_detection_is_no_larger_than_its_object() {
    // Two people close together are one region at first; then they separate, and others stand between them.
    let mut tracker = Tracker::new(&Settings::default(), SIZE, 25.0);
    let mut widest: f32 = 0.0;
    for number in 1..=120_u32 {
        let apart = (number as i32 - 40).max(0);
        let mut figures = vec![(151 - apart, 100, RED), (169 + apart, 100, BLUE)];
        if number > 90 {
            figures.push((160, 100, GREEN));
        }
        let seen = step(&mut tracker, number, &figures);
        if number > 100 {
            widest = seen.tracks.iter().map(|track| track.bbox.w).fold(widest, f32::max);
        }
    }
    assert!(widest < 60.0, "a box spans figures that are far apart: {widest} pixels");
}

/// All events of two crossing figures, including those at the end.
fn events_of_crossing(last: u32) -> Vec<Event> {
    let mut tracker = Tracker::new(&Settings::default(), SIZE, 25.0);
    let mut events: Vec<Event> =
        (1..=last).flat_map(|number| step(&mut tracker, number, &crossing(number)).events).collect();
    events.extend(tracker.finish().events);
    events
}

#[test]
fn counters_decrease_at_a_merge_and_increase_at_a_demerge() {
    let events = events_of_crossing(100);
    let counted = |kind: EventKind| {
        let event = events.iter().find(|event| event.kind == kind).expect("they cross");
        (event.evidence.objects_before, event.evidence.objects_now)
    };
    assert_eq!(counted(EventKind::Merge), (2, 1));
    assert_eq!(counted(EventKind::Demerge), (1, 2));
}

#[test]
fn evidence_is_consistent_with_its_numbers() {
    let events = events_of_crossing(100);
    let numbers = || events.iter().flat_map(|event| &event.evidence.comparisons);
    for number in numbers() {
        let holds = match (number.relation, number.threshold) {
            (Some(Relation::AtMost), Some(threshold)) => number.value <= threshold,
            (Some(Relation::AtLeast), Some(threshold)) => number.value >= threshold,
            (None, None) => true,
            _ => panic!("a threshold without a relation: {number:?}"),
        };
        assert_eq!(number.holds, holds, "{number:?}");
    }
    // Each member has one of the regions after the demerge, the one of the most similar colours.
    let demerge = events.iter().find(|event| event.kind == EventKind::Demerge).expect("they cross");
    for id in &demerge.objects {
        let mine = |what: &str| {
            what.starts_with("colour similarity") && what.contains(&format!(" of {id} and fragment"))
        };
        let colours: Vec<_> =
            demerge.evidence.comparisons.iter().filter(|number| mine(&number.what)).collect();
        let best = colours.iter().max_by(|a, b| a.value.total_cmp(&b.value)).expect("two pieces");
        assert_eq!(colours.iter().filter(|number| number.chosen == Some(true)).count(), 1);
        assert_eq!(best.chosen, Some(true), "{colours:?}");
    }
}

#[test]
fn a_new_object_names_the_rejected_occluded_object() {
    let mut tracker = Tracker::new(&Settings::default(), SIZE, 25.0);
    let mut events = Vec::new();
    for number in 1..=90 {
        let figures: &[Figure] = match number {
            1..=30 => &[(110 - number as i32, 100, RED)],
            31..=50 => &[],
            _ => &[(189 + number as i32, 100, GREEN)],
        };
        events.extend(step(&mut tracker, number, figures).events);
    }
    let new = events.iter().rfind(|event| event.kind == EventKind::Appear).expect("the second figure");
    let refused =
        new.evidence.comparisons.iter().find(|number| number.chosen == Some(false)).expect("the first");
    assert!(refused.what.contains("occluded 1") && refused.holds, "{refused:?}");
}

#[test]
fn a_region_of_one_figure_causes_no_reappearance() {
    // The second figure has left; the first one turns, so that its appearance model does not explain its region.
    let mut tracker = Tracker::new(&Settings::default(), SIZE, 25.0);
    let mut seen = FrameResult::default();
    for number in 1..=80 {
        let x = number as i32;
        let figures: &[Figure] =
            if number <= 30 { &[(90 + x, 100, RED), (120 + x, 100, RED)] } else { &[(126, 100, RED)] };
        seen = step(&mut tracker, number, figures);
        if number == 30 {
            assert_eq!(seen.tracks.len(), 2, "{:?}", seen.tracks);
        }
    }
    assert_eq!(seen.tracks.iter().filter(|track| !track.group.is_empty()).count(), 0, "{:?}", seen.tracks);
}

#[test]
fn a_partly_visible_object_has_a_box_of_its_visible_part() {
    let mut tracker = Tracker::new(&Settings::default(), SIZE, 25.0);
    for number in 1..=40 {
        let (frame, mut mask) = draw(number, &[(40 + 2 * number as i32, 100, RED)]);
        // From frame 31 on its lower half has the background's colour. No occluder is known here.
        if number > 30 {
            mask.data[130 * SIZE.width as usize..].fill(Mask::BACKGROUND);
        }
        let (_, regions) = find_regions(&frame, &mask, 4);
        let seen = tracker.step(number, f64::from(number) / 25.0, &regions);
        if number > 30 {
            let [track] = &seen.tracks[..] else { panic!("frame {number}: {:?}", seen.tracks) };
            assert_eq!(track.bbox, regions[0].shape.bbox, "frame {number}");
        }
    }
}

/// The tracks of a figure that walks `speed` pixels a period, in frames at these periods, and the events.
fn walk(
    frames: impl IntoIterator<Item = u32>,
    speed: i32,
    times: impl Fn(u32) -> f64,
) -> (Vec<usize>, Vec<Event>) {
    let mut tracker = Tracker::new(&Settings::default(), SIZE, 25.0);
    let (mut counts, mut events) = (Vec::new(), Vec::new());
    for (number, period) in (1..).zip(frames) {
        let (frame, mask) = draw(number, &[(20 + speed * period as i32, 100, RED)]);
        let (_, regions) = find_regions(&frame, &mask, 4);
        let seen = tracker.step(number, times(period), &regions);
        counts.push(seen.tracks.len());
        events.extend(seen.events);
    }
    events.extend(tracker.finish().events);
    (counts, events)
}

#[test]
fn an_object_is_followed_over_missing_frames_by_their_times() {
    // Eight frames are missing.
    let frames = || (0..20).chain(28..41);
    let (counts, events) = walk(frames(), 7, |period| f64::from(period) / 25.0);
    assert_eq!(kinds(&events), [EventKind::Appear], "one object, never lost");
    assert_eq!(counts[20..], [1; 13], "not for a frame");
    let (_, events) = walk(frames(), 7, |_| 0.0);
    assert_ne!(
        kinds(&events),
        [EventKind::Appear],
        "a leap of 63 pixels from one frame to the next is another object"
    );
}

#[test]
fn who_is_seen_elsewhere_after_a_long_gap_is_another_object() {
    let mut tracker = Tracker::new(&Settings::default(), SIZE, 25.0);
    let mut tracks = Vec::new();
    for number in 1..=60_u32 {
        let x = 2 * number as i32;
        let (figure, time) =
            if number <= 30 { ((40 + x, 100, RED), 0.0) } else { ((300 - x, 40, BLUE), 10.0) };
        let (frame, mask) = draw(number, &[figure]);
        let (_, regions) = find_regions(&frame, &mask, 4);
        tracks = tracker.step(number, time + f64::from(number) / 25.0, &regions).tracks;
    }
    let seen: Vec<_> = tracks.iter().filter(|track| track.state == TrackState::Visible).collect();
    assert_eq!(seen.iter().map(|track| track.id).collect::<Vec<_>>(), [2], "{tracks:?}");
}

#[test]
fn settings_in_seconds_are_times_and_not_frames() {
    let hidden_for = |seconds: f64| {
        let settings = Settings { max_hidden: Span::Seconds(2.0), ..Settings::default() };
        let mut tracker = Tracker::new(&settings, SIZE, 25.0);
        let mut events = Vec::new();
        for number in 1..=90 {
            let x = 40 + 2 * number as i32;
            let figures: &[Figure] = if (30..40).contains(&number) { &[] } else { &[(x, 100, RED)] };
            let (frame, mask) = draw(number, figures);
            let (_, regions) = find_regions(&frame, &mask, 4);
            // The ten frames in which it is hidden are far apart.
            let slow = f64::from(number.clamp(29, 39) - 29) * (seconds / 10.0 - 0.04);
            events.extend(tracker.step(number, f64::from(number) / 25.0 + slow, &regions).events);
        }
        events.extend(tracker.finish().events);
        kinds(&events)
    };
    let [enter, hidden, again] = hidden_for(1.0)[..] else { panic!("{:?}", hidden_for(1.0)) };
    assert_eq!([enter, hidden, again], [EventKind::Appear, EventKind::Disappear, EventKind::Reappear]);
    assert!(
        !hidden_for(8.0).contains(&EventKind::Reappear),
        "after eight seconds it is another: {:?}",
        hidden_for(8.0)
    );
}
