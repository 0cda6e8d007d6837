//! The occlusion reasoning on drawn frames: flat figures on a flat ground, without a background model.

#![allow(clippy::expect_used, missing_docs)]

use occluscope::frame::{Frame, Mask, Size};
use occluscope::occlusion::{Event, EventKind, Reasoner, Seen};
use occluscope::regions::find_regions;
use occluscope::settings::Settings;

const SIZE: Size = Size { width: 320, height: 240 };
const RED: [u8; 3] = [220, 30, 30];
const GREEN: [u8; 3] = [30, 220, 30];
const BLUE: [u8; 3] = [30, 30, 220];
const YELLOW: [u8; 3] = [230, 230, 30];

/// A figure of 20×60 pixels with a narrow head: the column of its middle, its top row, its colour.
type Figure = (i32, i32, [u8; 3]);

/// A frame with these figures and its mask; a later figure is drawn over an earlier one.
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

fn step(reasoner: &mut Reasoner, number: u32, figures: &[Figure]) -> Seen {
    let (frame, mask) = draw(number, figures);
    let (_, regions) = find_regions(&frame, &mask, 4);
    reasoner.step(number, &regions)
}

/// Two figures that cross: apart at first, in one region from about frame 40, apart again from about 56.
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
        let mut reasoner = Reasoner::new(&Settings::default(), SIZE, fps);
        let heads = ((0.5 * fps).round() as u32).max(3) + 1;
        let mut number = 0;
        let mut show = |frames: u32, figures: &mut dyn FnMut(u32) -> Vec<Figure>| {
            for frame in 0..frames {
                number += 1;
                step(&mut reasoner, number, &figures(frame));
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
fn a_split_a_moment_before_the_end_is_decided_by_the_end() {
    for last in [58, 60, 62] {
        let mut reasoner = Reasoner::new(&Settings::default(), SIZE, 25.0);
        let mut events = Vec::new();
        for number in 1..=last {
            events.extend(step(&mut reasoner, number, &crossing(number)).events);
        }
        assert!(!kinds(&events).contains(&EventKind::Demerge), "not decided before frame {last}");
        events.extend(reasoner.finish());
        let demerges: Vec<&Event> = events.iter().filter(|event| event.kind == EventKind::Demerge).collect();
        assert_eq!(demerges.len(), 1, "{last}: {:?}", kinds(&events));
        assert!((50..=58).contains(&demerges[0].frame), "{}", demerges[0].frame);
        assert!(reasoner.finish().is_empty(), "nothing is left open");
    }
}

#[test]
fn a_member_of_which_nothing_is_seen_leaves_its_group() {
    let mut reasoner = Reasoner::new(&Settings::default(), SIZE, 25.0);
    let mut number = 0;
    while number < 48 {
        number += 1;
        step(&mut reasoner, number, &crossing(number));
    }
    // The red one is gone for good; the blue one walks on alone.
    let mut last = Seen::default();
    while number < 110 {
        number += 1;
        let [_, blue] = crossing(number);
        last = step(&mut reasoner, number, &[blue]);
    }
    assert_eq!(last.tracks.len(), 1, "one figure is seen: {:?}", last.tracks);
    assert!(last.tracks[0].group.is_empty(), "it is alone: {:?}", last.tracks[0].group);
}

#[test]
fn a_detection_is_no_larger_than_its_object() {
    // Two who stand close together are one region at first; then they walk apart, and others stand between.
    let mut reasoner = Reasoner::new(&Settings::default(), SIZE, 25.0);
    let mut widest: f32 = 0.0;
    for number in 1..=120_u32 {
        let apart = (number as i32 - 40).max(0);
        let mut figures = vec![(151 - apart, 100, RED), (169 + apart, 100, BLUE)];
        if number > 90 {
            figures.push((160, 100, GREEN));
        }
        let seen = step(&mut reasoner, number, &figures);
        if number > 100 {
            widest = seen.tracks.iter().map(|track| track.bbox.w).fold(widest, f32::max);
        }
    }
    assert!(widest < 60.0, "a box spans figures that are far apart: {widest} pixels");
}
