//! A video can end in any frame: events up to then are emitted.

#![allow(clippy::panic)]

#[path = "common/balance.rs"]
mod balance;
#[path = "common/blocks.rs"]
mod blocks;

use blocks::{Block, regions};
use occluscope::frame::Size;
use occluscope::occlusion::{Event, EventKind, Tracker};
use occluscope::settings::Settings;
use occluscope::tracking::{FrameTracks, IdentityMap, Track};

const SIZE: Size = Size::new(320, 240);
const FPS: f32 = 25.0;
const FRAMES: u32 = 150;

/// The upper left cell of a walker in a frame; `None` while it is not detected.
type Trajectory = fn(i32) -> Option<(i32, i32)>;

/// The events of the video ending at each frame.
fn told_of(ways: &[Trajectory]) -> Vec<Vec<Event>> {
    let colours = [[200, 30, 30], [30, 30, 200], [30, 180, 30]];
    let settings = Settings::default();
    let mut tracker = Tracker::new(&settings, SIZE, FPS);
    let (mut events, mut identities, mut frames, mut endings) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for number in 1..=FRAMES {
        let seen = ways.iter().zip(colours).filter_map(|(way, colour)| {
            way(number as i32).and_then(|at| Block::new(at, (8, 20), colour, SIZE))
        });
        let seen = tracker.step(
            number,
            f64::from(number) / f64::from(FPS),
            &regions(&seen.collect::<Vec<_>>(), SIZE),
        );
        events.extend(seen.events);
        identities.extend(seen.settled.identities);
        frames.push((number, seen.objects));
        let end = tracker.clone().finish();
        let mut told = events.clone();
        told.extend(end.events);
        told.sort_by(|a, b| (a.frame, a.kind, &a.objects).cmp(&(b.frame, b.kind, &b.objects)));
        let mut identity_map = IdentityMap::default();
        for &(key, identity) in identities.iter().chain(&end.settled.identities) {
            identity_map.set(key, identity);
        }
        let apply = |(number, objects): &(u32, Vec<Track>)| FrameTracks {
            number: *number,
            time: 0.0,
            tracks: identity_map.apply(objects),
        };
        let tracks: Vec<_> = frames.iter().map(apply).collect();
        let faults = balance::faults(&told, &tracks, &settings, FPS);
        assert!(faults.is_empty(), "a video of {number} frames: {faults:#?}");
        endings.push(told);
    }
    endings
}

/// For each ending the frame of the event of this kind; `None` if it is not emitted.
fn frames_of(endings: &[Vec<Event>], kind: EventKind) -> Vec<Option<u32>> {
    endings
        .iter()
        .map(|told| {
            let mut frames = told.iter().filter(|event| event.kind == kind).map(|event| event.frame);
            let frame = frames.next();
            assert_eq!(frames.next(), None, "{kind:?} twice");
            frame
        })
        .collect()
}

/// The event of the whole video is emitted in every video that ends at least `after` frames later.
fn is_told_at_once(endings: &[Vec<Event>], kind: EventKind, after: u32) {
    let frames = frames_of(endings, kind);
    let whole = frames.last().copied().flatten();
    let happens = whole.unwrap_or_else(|| panic!("{kind:?} is missing for the whole video"));
    for (frame, last) in frames.into_iter().zip(1..) {
        if last >= happens + after {
            assert_eq!(frame, Some(happens), "{kind:?} at {happens} in a video of {last} frames");
        }
        if last < happens {
            assert_eq!(frame, None, "{kind:?} at {happens} in a video of {last} frames");
        }
    }
}

#[test]
fn merge_and_demerge_are_emitted_at_the_end() {
    let endings = told_of(&[|t| Some((20 + t, 40)), |t| Some((128 - t, 44))]);
    is_told_at_once(&endings, EventKind::Merge, 0);
    is_told_at_once(&endings, EventKind::Demerge, 0);
}

#[test]
fn exits_are_emitted_at_the_end() {
    let endings = told_of(&[|t| Some((20 + t, 40)), |_| Some((20, 90))]);
    is_told_at_once(&endings, EventKind::Exit, 0);
}

#[test]
fn disappearance_and_reappearance_are_emitted_at_the_end() {
    let endings = told_of(&[|t| (!(50..80).contains(&t)).then_some((20 + t, 40)), |_| Some((20, 90))]);
    is_told_at_once(&endings, EventKind::Disappear, 2);
    // The identity of a reappearing object is known after it has been detected for some frames.
    is_told_at_once(&endings, EventKind::Reappear, 12);
}

#[test]
fn a_flicker_in_the_last_frames_causes_no_event() {
    let endings = told_of(&[|t| (t % 30 > 1).then_some((20 + t / 2, 40)), |_| Some((20, 90))]);
    assert!(frames_of(&endings, EventKind::Disappear).iter().all(Option::is_none));
}
