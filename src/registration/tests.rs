#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use super::*;
use crate::explain::pixel::PixelHistory;
use crate::frame::{Frame, Mask, Size};
use crate::mixture::{Mixture, Parameters};
use crate::pipeline::Pipeline;
use crate::settings::{LightCorrection, Preset, Settings, Stabilise};
use crate::source::cache::FrameCache;
use crate::source::{FpsFrom, Source, SourceError, SourceInfo};

const SIZE: Size = Size::new(160, 120);

/// An aperiodic texture, unbounded: random levels every few pixels, interpolated smoothly.
fn level(x: f32, y: f32) -> f32 {
    let at = |column: i32, row: i32| {
        let mut bits = (column as u32).wrapping_mul(0x9e37_79b9) ^ (row as u32).wrapping_mul(0x85eb_ca6b);
        bits ^= bits >> 15;
        bits = bits.wrapping_mul(0xc2b2_ae35);
        bits ^= bits >> 13;
        (bits % 200) as f32 + 20.0
    };
    let octave = |cell: f32| {
        let (x, y) = (x / cell, y / cell);
        let (column, row) = (x.floor(), y.floor());
        let smooth = |share: f32| share * share * (3.0 - 2.0 * share);
        let (right, down) = (smooth(x - column), smooth(y - row));
        let (column, row) = (column as i32, row as i32);
        let mix = |row| at(column, row) + right * (at(column + 1, row) - at(column, row));
        mix(row) + down * (mix(row + 1) - mix(row))
    };
    0.6 * octave(17.0) + 0.4 * octave(6.0)
}

fn noise(number: u32, at: usize) -> f32 {
    let mut bits = (at as u32).wrapping_mul(2_654_435_761) ^ number.wrapping_mul(0x9e37_79b9);
    bits ^= bits >> 15;
    bits = bits.wrapping_mul(0x85eb_ca6b);
    bits ^= bits >> 13;
    (bits % 7) as f32 - 3.0
}

/// The texture seen by a camera with this motion, in this light; `object` covers part of it.
fn frame(number: u32, motion: &Motion, (gain, offset): (f32, f32), object: Option<(u32, u32)>) -> Frame {
    let back = motion.inverse();
    let mut rgb = Vec::new();
    for y in 0..SIZE.height {
        for x in 0..SIZE.width {
            let (from_x, from_y) = back.apply(x as f32 - 79.5, y as f32 - 59.5);
            let inside = object.is_some_and(|(left, width)| (left..left + width).contains(&x) && y > 20);
            let value = if inside { 60.0 + 0.3 * level(from_x * 3.0, from_y) } else { level(from_x, from_y) };
            let value = gain * value + offset + noise(number, rgb.len());
            rgb.extend([value, 0.9 * value, 0.8 * value].map(|value| value.round().clamp(0.0, 255.0) as u8));
        }
    }
    Frame::new(number, SIZE, rgb)
}

const EVERYTHING: CorrectionChoice =
    CorrectionChoice { stabilise: Stabilise::Similarity, light: LightCorrection::Gain };

fn still(number: u32) -> Frame {
    frame(number, &Motion::NONE, (1.0, 0.0), None)
}

fn shaken(number: u32) -> Motion {
    let t = number as f32;
    Motion { dx: 4.0 * (0.9 * t).sin(), dy: 3.0 * (1.7 * t).sin(), turn: 0.006 * (1.3 * t).sin(), zoom: 0.0 }
}

fn registered(frames: impl Iterator<Item = Frame>) -> Vec<Frame> {
    let mut estimator = Estimator::new(SIZE);
    frames
        .map(|mut frame| {
            frame.alignment = estimator.step(&frame);
            frame
        })
        .collect()
}

#[test]
fn a_motion_and_its_inverse_undo_each_other() {
    let motion = Motion { dx: 3.0, dy: -7.0, turn: 0.02, zoom: 0.03 };
    for (x, y) in [(0.0, 0.0), (50.0, -20.0), (-70.0, 60.0)] {
        let (there_x, there_y) = motion.apply(x, y);
        let (back_x, back_y) = motion.inverse().apply(there_x, there_y);
        assert!((back_x - x).abs() + (back_y - y).abs() < 1e-3, "{back_x} {back_y}");
        let both = motion.after(&motion.inverse());
        let (same_x, same_y) = both.apply(x, y);
        assert!((same_x - x).abs() + (same_y - y).abs() < 1e-3);
    }
}

#[test]
fn a_known_motion_is_found_to_a_quarter_of_a_pixel() {
    let light = |number: u32| if number > 60 { (0.7, 4.0) } else { (1.0, 0.0) };
    // A third of the image is covered by a moving object.
    let frames = (1..=90).map(|number| {
        let object = (number % 3 > 0).then_some((number, 50));
        frame(number, &if number == 1 { Motion::NONE } else { shaken(number) }, light(number), object)
    });
    for frame in registered(frames).iter().skip(1) {
        let (found, truth) = (frame.alignment.motion, shaken(frame.number));
        for (x, y) in [(-60.0, -40.0), (60.0, 40.0), (0.0, 0.0)] {
            let (a, b) = (found.apply(x, y), truth.apply(x, y));
            let off = ((a.0 - b.0).powi(2) + (a.1 - b.1).powi(2)).sqrt();
            assert!(off < 0.25, "frame {}: {off} at {x} {y}: {found:?} {truth:?}", frame.number);
        }
    }
}

#[test]
fn a_still_camera_in_steady_light_has_no_alignment() {
    let frames = registered((1..=150).map(|number| {
        let object = (40..120).contains(&number).then(|| (number - 40, 60));
        frame(number, &Motion::NONE, (1.0, 0.0), object)
    }));
    for frame in &frames {
        assert_eq!(frame.alignment, Alignment::default(), "frame {}", frame.number);
    }
    let corrected_by = |stabilise, light| {
        let settings = Settings { stabilise, light, ..Settings::default() };
        let mut pipeline = Pipeline::new(&settings, SIZE, 25.0).unwrap();
        frames.iter().map(|frame| pipeline.step(frame).unwrap().mask).collect::<Vec<_>>()
    };
    let off = corrected_by(Stabilise::Off, LightCorrection::Off);
    assert!(off.iter().any(|mask| mask.foreground_pixels() > 500));
    for stabilise in [Stabilise::Auto, Stabilise::Shift, Stabilise::Similarity] {
        assert!(corrected_by(stabilise, LightCorrection::Gain) == off);
    }
}

#[test]
fn a_change_of_light_is_distinguished_from_an_object_near_the_camera() {
    let cloud = |number: u32| 1.0 - 0.33 * ((number as f32 - 60.0) / 40.0).clamp(0.0, 1.0);
    let frames = registered((1..=140).map(|number| {
        let object = (number % 2 == 0).then_some((number / 2, 30));
        frame(number, &Motion::NONE, (cloud(number), 0.0), object)
    }));
    for frame in &frames {
        let (gain, truth) = (frame.alignment.light.luma_gain(), cloud(frame.number));
        // The reference follows within a thousand frames.
        let followed = 0.33 * (frame.number as f32 / 500.0).min(0.4);
        let bounds = truth - 0.04..truth + 0.04 + followed;
        let slight = truth > 0.85 && gain == 1.0;
        assert!(slight || bounds.contains(&gain), "frame {}: {gain} {truth}", frame.number);
    }
    // Half the image darkens, as when a dark object comes close to the camera.
    let close = registered((1..=120).map(|number| {
        let mut frame = still(number);
        if number > 60 {
            for row in frame.rgb.chunks_exact_mut(SIZE.width as usize * 3) {
                for level in &mut row[..SIZE.width as usize * 3 / 2] {
                    *level /= 2;
                }
            }
        }
        frame
    }));
    assert!(close.iter().all(|frame| frame.alignment.light == Light::SAME));
}

#[test]
fn a_shake_is_detected_and_a_permanent_move_is_reported_once() {
    let shaking = registered((1..=80).map(|number| frame(number, &shaken(number), (1.0, 0.0), None)));
    let since = shaking.iter().position(|frame| frame.alignment.rest.is_some());
    assert!(since.is_some_and(|since| since < 50), "{since:?}");
    assert!(shaking.iter().all(|frame| frame.alignment.moved_since.is_none()));

    let turned = Motion { dx: 9.0, dy: -4.0, ..Motion::NONE };
    let far = Motion { dx: 400.0, dy: 300.0, ..Motion::NONE };
    for after in [turned, far] {
        let moving = registered((1..=220).map(|number| {
            frame(number, if number < 100 { &Motion::NONE } else { &after }, (1.0, 0.0), None)
        }));
        let reported: Vec<_> = moving.iter().filter_map(|frame| frame.alignment.moved_since).collect();
        // Reported by the first sample that shows it.
        assert!(reported.len() == 1 && (100..106).contains(&reported[0]), "{after:?}: {reported:?}");
    }
}

/// Frames with camera shake and changing light, as a source gives them.
fn restless() -> Vec<Frame> {
    registered((1..=120).map(|number| {
        let gain = if (40..70).contains(&number) { 1.5 } else { 1.0 };
        let object = (number > 20).then_some((number, 20));
        frame(number, &shaken(number), (gain, 0.0), object)
    }))
}

fn choices() -> impl Iterator<Item = Settings> {
    let all = [Stabilise::Off, Stabilise::Auto, Stabilise::Shift, Stabilise::Similarity];
    all.into_iter().flat_map(|stabilise| {
        [LightCorrection::Off, LightCorrection::Gain].map(|light| Settings {
            stabilise,
            light,
            ..Settings::preset(Preset::Plain)
        })
    })
}

#[test]
fn in_batches_of_any_length_the_mixture_equals_single_pixels() {
    let frames = restless();
    let all: Vec<_> = frames.iter().collect();
    let mut unknown = 0;
    for settings in choices() {
        let parameters = Parameters::new(&settings);
        let mut one_by_one = Mixture::new(SIZE, parameters);
        let masks: Vec<_> = all.iter().map(|frame| one_by_one.step(frame)).collect();
        let mut together = Mixture::new(SIZE, parameters);
        let mut replayed = vec![Mask::empty(SIZE); all.len()];
        let mut start = 0;
        for length in [1, 7, 16, 40, 56] {
            together.step_many(&all[start..start + length], &mut replayed[start..start + length]);
            start += length;
        }
        assert_eq!(start, all.len());
        assert!(masks == replayed, "{settings:?}");
        for at in [(0, 0), (2, 60), (80, 119), (159, 3), (90, 50), (157, 117)] {
            let mut history = PixelHistory::new(at, parameters);
            for frame in &all {
                history.push(frame);
            }
            let last = history.states.last().unwrap();
            assert_eq!(together.pixel(at.0, at.1).unwrap(), last.pixel, "{at:?} {settings:?}");
            assert_eq!(one_by_one.pixel(at.0, at.1).unwrap(), last.pixel, "{at:?} {settings:?}");
            let far = (0..history.states.len()).find(|&index| history.place(index).0.abs_diff(at.0) > 8);
            assert_eq!(far.map(|index| frames[index].alignment), None, "{at:?} {settings:?}");
            for (state, mask) in history.states.iter().zip(&masks) {
                let shadow = parameters.shadow.is_on();
                assert!(shadow || mask.is_foreground(at.0, at.1) == state.outcome.foreground);
                unknown += usize::from(!state.known);
            }
        }
    }
    assert!(unknown > 100, "{unknown}");
}

#[test]
fn pixels_that_a_frame_does_not_show_are_background_and_not_learned() {
    let frames = restless();
    let settings = Settings { stabilise: Stabilise::Similarity, ..Settings::preset(Preset::Plain) };
    let mut history = PixelHistory::new((1, 60), Parameters::new(&settings));
    for frame in &frames {
        history.push(frame);
    }
    let mut unknown = 0;
    for (index, state) in history.states.iter().enumerate().filter(|(_, state)| !state.known) {
        assert_eq!(history.before(index), Some(&state.pixel));
        assert!(!state.outcome.foreground);
        unknown += 1;
    }
    assert!((10..110).contains(&unknown), "{unknown}");
    for model in [crate::settings::BackgroundModel::Mog2, crate::settings::BackgroundModel::Knn] {
        let settings = Settings { background_model: model, ..settings.clone() };
        let mut pipeline = Pipeline::new(&settings, SIZE, 25.0).unwrap();
        for frame in &frames {
            let choice = CorrectionChoice::new(&settings);
            let mask = pipeline.masks(&[frame]).unwrap().swap_remove(0);
            let Some(correction) = choice.correction(&frame.alignment, SIZE) else { continue };
            let back = correction.motion().inverse();
            for (at, _) in mask.data.iter().enumerate().filter(|(_, level)| **level > 0) {
                let (x, y) = ((at % 160) as f32 - 79.5, (at / 160) as f32 - 59.5);
                let (x, y) = back.apply(x, y);
                assert!(x.abs() < 80.1 && y.abs() < 60.1, "frame {}: {x} {y}", frame.number);
            }
        }
    }
}

#[test]
fn a_corrected_shake_causes_no_foreground() {
    let frames = restless();
    let share = |stabilise, light| {
        let settings = Settings { stabilise, light, ..Settings::default() };
        let mut pipeline = Pipeline::new(&settings, SIZE, 25.0).unwrap();
        let mut wrong = 0;
        for frame in &frames {
            let analysis = pipeline.step(frame).unwrap();
            let object = (frame.number..frame.number + 20).start.saturating_sub(8)..frame.number + 28;
            let column = |at: usize| (at % 160) as u32;
            let outside = |(at, level): &(usize, &u8)| **level > 0 && !object.contains(&column(*at));
            wrong += analysis.mask.data.iter().enumerate().skip(160 * 8).filter(outside).count();
        }
        wrong as f32 / (frames.len() * SIZE.pixels()) as f32
    };
    let shaking = share(Stabilise::Off, LightCorrection::Gain);
    let lit = share(Stabilise::Similarity, LightCorrection::Off);
    let both = share(Stabilise::Similarity, LightCorrection::Gain);
    assert!(shaking > 0.004 && lit > 0.05 && both < 0.0005, "{shaking} {lit} {both}");
}

/// A source without alignment that gives these frames, stored in reverse order.
struct Recorded(SourceInfo, Vec<Frame>);

fn recorded(mut frames: Vec<Frame>, live: bool) -> Recorded {
    for frame in &mut frames {
        frame.alignment = Alignment::default();
    }
    frames.reverse();
    let info = SourceInfo {
        name: "restless".into(),
        size: SIZE,
        pixel_aspect: None,
        fps: 25.0,
        fps_from: FpsFrom::Assumed,
        frames: None,
        live,
        reduction: None,
    };
    Recorded(info, frames)
}

impl Source for Recorded {
    fn info(&self) -> &SourceInfo {
        &self.0
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        Ok(self.1.pop())
    }

    fn take_warnings(&mut self) -> Vec<String> {
        Vec::new()
    }
}

#[test]
fn a_frame_that_is_decoded_again_has_the_alignment_that_it_had() {
    let mut expected: Vec<_> = restless().into_iter().take(60).collect();
    measure_all(&mut expected, EVERYTHING);
    let raw = expected.clone();
    let open = move || -> Result<Box<dyn Source>, SourceError> { Ok(Box::new(recorded(raw.clone(), false))) };
    let mut cache = FrameCache::new(open, 4 * SIZE.pixels() * 3).unwrap();
    for position in [0, 59, 3, 4, 40, 39, 12, 58, 1] {
        let frame = cache.get(position).unwrap().unwrap();
        assert_eq!(frame.alignment, expected[position as usize].alignment, "position {position}");
    }
    let known: Vec<_> = expected.iter().map(|frame| frame.alignment).collect();
    assert_eq!(cache.alignments(), known);
    assert!(known.iter().any(|alignment| alignment.motion != Motion::NONE));
}

#[test]
fn a_shake_applies_from_the_first_frame_of_a_file_and_later_of_a_camera() {
    let frames = restless();
    let read = |live, first| {
        let source = Box::new(recorded(frames.clone(), live));
        let mut source = Registered::by(source, Estimator::of(SIZE, EVERYTHING), first);
        std::iter::from_fn(|| source.next_frame().unwrap()).collect::<Vec<_>>()
    };
    let rests = |frames: &[Frame]| frames.iter().map(|frame| frame.alignment.rest).collect::<Vec<_>>();
    let (file, camera) = (read(false, 0), read(true, 0));
    assert!(file == frames && camera == frames, "all frames, in order");
    let rest = frames.last().unwrap().alignment.rest;
    assert!(rest.is_some() && rests(&file).iter().all(|found| *found == rest));
    assert_eq!(rests(&camera), rests(&frames));
    assert!(rests(&camera)[..20].iter().all(Option::is_none));
    let later = read(false, 31);
    assert!(later[..30].iter().all(|frame| frame.alignment == Alignment::default()));
    assert!(later[30..].iter().all(|frame| frame.alignment.rest.is_some()));
}

#[test]
fn uncorrected_changes_are_not_measured_and_do_not_affect_others() {
    let calm: Vec<_> = (1..=120).map(still).collect();
    for frames in [restless(), calm] {
        let measured = |choice| {
            let mut frames = frames.clone();
            measure_all(&mut frames, choice);
            frames.iter().map(|frame| frame.alignment).collect::<Vec<_>>()
        };
        let all = measured(EVERYTHING);
        for settings in choices() {
            let choice = CorrectionChoice::new(&settings);
            for (number, (alignment, all)) in measured(choice).iter().zip(&all).enumerate() {
                assert_eq!((alignment.rest, alignment.moved_since), (all.rest, all.moved_since), "{number}");
                let lit = choice.light == LightCorrection::Gain;
                assert_eq!(alignment.light, if lit { all.light } else { Light::SAME }, "{number}");
                let correction = |alignment| choice.correction(alignment, SIZE).map(|it| *it.motion());
                assert_eq!(correction(alignment), correction(all), "{number}");
                let off = choice == CorrectionChoice::NOTHING && number >= 50 && (number + 1) % 6 != 0;
                assert!(!off || alignment.motion == Motion::NONE, "{number}");
            }
        }
    }
}

#[test]
fn slow_changes_of_light_are_not_corrected_and_sudden_ones_decay() {
    let gains = |light: fn(u32) -> f32, last| {
        let frames = (1..=last).map(|number| frame(number, &Motion::NONE, (light(number), 0.0), None));
        let frames = registered(frames);
        frames.iter().map(|frame| frame.alignment.light.luma_gain()).collect::<Vec<_>>()
    };
    let slow = gains(|number| 1.0 + 0.0002 * number as f32, 400);
    assert!(slow.iter().all(|gain| *gain == 1.0), "{slow:?}");
    let sudden = gains(|number| if number > 60 { 0.9 } else { 1.0 }, 420);
    assert!((sudden[60] - 0.9).abs() < 0.02, "{}", sudden[60]);
    assert!(sudden.windows(2).skip(60).all(|pair| (pair[1] - pair[0]).abs() < 0.015), "{sudden:?}");
    assert_eq!(sudden.last(), Some(&1.0));
}
