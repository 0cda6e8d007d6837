//! All stages on arbitrary small frames under arbitrary settings.

use std::collections::BTreeSet;
use std::sync::{Arc, LazyLock};

use occluscope::export::tracks_json::TracksJson;
use occluscope::export::{episodes_csv, events_jsonl, tracks_csv};
use occluscope::frame::{Frame, Mask, Size};
use occluscope::occlusion::EventKind;
use occluscope::pipeline::{Analysis, Pipeline, offline_result};
use occluscope::regions::Roi;
use occluscope::registration::{CorrectionChoice, measure_all};
use occluscope::settings::{BackgroundModel, Kind, Preset, SETTINGS, Settings, Span, Value};
use rayon::ThreadPool;

use super::bytes::Bytes;

/// Number of frames.
const MOST_FRAMES: u32 = 14;
/// Width and height.
const MOST_SIDE: u32 = 24;

pub fn run(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let input = Input::new(&mut bytes);
    let together = pool(1).install(|| input.analyse(&input.batches));
    check(&input, &together.0);
    check_offline(&input, &together);
    let told = text(&together.0);
    if input.settings.background_model == BackgroundModel::Mixture {
        // Frame by frame, on several threads, is the same.
        let single = pool(3).install(|| input.analyse(&[]));
        assert_eq!(told, text(&single.0));
        check_copy(&input, &told);
    }
    check_again(&input, together, &told);
}

/// A sequence and how it is analysed.
struct Input {
    settings: Settings,
    size: Size,
    fps: f32,
    frames: Vec<Frame>,
    /// Number of first frames to learn from.
    learn: usize,
    roi: Option<Arc<Roi>>,
    /// The lengths of batches; single frames after the last.
    batches: Vec<usize>,
}

impl Input {
    fn new(bytes: &mut Bytes<'_>) -> Self {
        let settings = settings(bytes);
        let size = Size::new(bytes.within(1, MOST_SIDE), bytes.within(1, MOST_SIDE));
        let fps = bytes.of(&[25.0, 1.0, 0.05, 1000.0, 29.97]);
        let learn = bytes.within(0, 4) as usize;
        let batches = (0..bytes.within(0, 5)).map(|_| bytes.within(1, 6) as usize).collect();
        let roi = match bytes.within(0, 3) {
            0 => {
                let data =
                    (0..size.pixels()).map(|at| if at % 7 < 5 { Mask::FOREGROUND } else { 0 }).collect();
                Roi::new(Mask { size, data }).map(Arc::new)
            }
            _ => None,
        };
        let mut frames = frames(bytes, size);
        measure_all(&mut frames, CorrectionChoice::new(&settings));
        Self { settings, size, fps, frames, learn, roi, batches }
    }

    fn pipeline(&self) -> Pipeline {
        let mut pipeline = Pipeline::new(&self.settings, self.size, self.fps).unwrap();
        pipeline.set_roi(self.roi.clone()).unwrap();
        let first: Vec<&Frame> = self.frames.iter().take(self.learn).collect();
        pipeline.learn(&first).unwrap();
        pipeline
    }

    /// The analyses of all frames in batches of these lengths, and the pipeline after them.
    fn analyse(&self, batches: &[usize]) -> (Vec<Analysis>, Pipeline) {
        let mut pipeline = self.pipeline();
        let mut analyses = Vec::new();
        let mut batches = batches.iter();
        let mut rest = &self.frames[..];
        while !rest.is_empty() {
            let length = batches.next().map_or(1, |&length| length.min(rest.len()));
            let batch: Vec<&Frame> = rest[..length].iter().collect();
            analyses.extend(pipeline.step_many(&batch).unwrap());
            rest = &rest[length..];
        }
        (analyses, pipeline)
    }
}

/// A preset with some settings changed, often to the ends of their ranges.
fn settings(bytes: &mut Bytes<'_>) -> Settings {
    let preset = bytes.of(&[Preset::Plain, Preset::Default, Preset::Paper]);
    let mut settings = Settings::preset(preset);
    for _ in 0..bytes.within(0, 12) {
        let setting = &SETTINGS[bytes.within(0, SETTINGS.len() as u32 - 1) as usize];
        let value = match setting.kind {
            Kind::Integer { min, max } => Value::Integer(bytes.within(min, max)),
            Kind::OddSize { max } => Value::Integer(bytes.within(0, max) | 1),
            Kind::Real { min, max, .. } => {
                let share = bytes.byte();
                // The middle of the range is reached; excluded ends are refused below.
                Value::Real(if share == 255 { max } else { min + (max - min) * f32::from(share) / 254.0 })
            }
            Kind::Choice(words) => Value::Choice(bytes.of(words)),
            Kind::Span { max_frames, max_seconds } => Value::Span(match bytes.within(0, 2) {
                0 => Span::Frames(bytes.within(0, 8)),
                1 => Span::Frames(bytes.within(0, max_frames)),
                _ => Span::Seconds(max_seconds * f32::from(bytes.byte()) / 255.0),
            }),
        };
        let _ = setting.set(&mut settings, value);
    }
    settings
}

/// Frames of a colour with rectangles and noise, at rising numbers and times.
fn frames(bytes: &mut Bytes<'_>, size: Size) -> Vec<Frame> {
    let colour = [bytes.byte(), bytes.byte(), bytes.byte()];
    let mut noise = bytes.number() | 1;
    let (mut number, mut time) = (bytes.within(0, 3), 0.0);
    let mut frames = Vec::new();
    for _ in 0..bytes.within(1, MOST_FRAMES) {
        let mut rgb: Vec<u8> = colour.iter().copied().cycle().take(3 * size.pixels()).collect();
        let amplitude = bytes.of(&[0, 1, 8, 255]);
        if amplitude > 0 {
            for value in &mut rgb {
                noise ^= noise << 13;
                noise ^= noise >> 17;
                noise ^= noise << 5;
                *value = value.wrapping_add((noise as u8) % amplitude);
            }
        }
        for _ in 0..bytes.within(0, 4) {
            let (left, top) = (bytes.within(0, size.width - 1), bytes.within(0, size.height - 1));
            let (right, bottom) = (bytes.within(left, size.width - 1), bytes.within(top, size.height - 1));
            let colour = [bytes.byte(), bytes.byte(), bytes.byte()];
            for (x, y) in (top..=bottom).flat_map(|y| (left..=right).map(move |x| (x, y))) {
                let at = 3 * size.index(x, y).unwrap();
                rgb[at..at + 3].copy_from_slice(&colour);
            }
        }
        frames.push(Frame::new(number, size, rgb).at_time(time));
        number += bytes.of(&[1, 1, 1, 2, 1000]);
        time += bytes.of(&[0.04, 0.04, 1.0, 1e-4, 1e6]);
    }
    frames
}

fn pool(threads: usize) -> &'static ThreadPool {
    static ONE: LazyLock<ThreadPool> = LazyLock::new(|| new_pool(1));
    static THREE: LazyLock<ThreadPool> = LazyLock::new(|| new_pool(3));
    if threads == 1 { &ONE } else { &THREE }
}

fn new_pool(threads: usize) -> ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

/// Everything that is known of frames: a text and the mask of each.
fn text(analyses: &[Analysis]) -> Vec<(String, Vec<u8>)> {
    analyses.iter().map(|analysis| (format!("{analysis:?}"), analysis.mask.data.clone())).collect()
}

/// Each analysis is consistent in itself.
fn check(input: &Input, analyses: &[Analysis]) {
    assert_eq!(analyses.len(), input.frames.len());
    let mut told = 0;
    for (analysis, frame) in analyses.iter().zip(&input.frames) {
        assert_eq!((analysis.number, analysis.mask.size), (frame.number, input.size));
        assert!(analysis.mask.data.iter().all(|level| [Mask::FOREGROUND, Mask::BACKGROUND].contains(level)));
        if let Some(roi) = &input.roi {
            let mut outside = (*analysis.mask).clone();
            roi.clear_outside(&mut outside);
            assert!(outside.data == analysis.mask.data, "foreground outside the region of interest");
        }
        let area: u32 = analysis.regions.iter().map(|region| region.shape.area).sum();
        assert!(area as usize <= analysis.mask.foreground_pixels());
        let labelled: u32 =
            analysis.labels.runs.iter().filter(|run| run.label > 0).map(|run| run.length).sum();
        assert_eq!(labelled, area);
        for region in analysis.regions.iter() {
            let bbox = region.shape.bbox;
            assert!(bbox.x >= 0.0 && bbox.right() <= input.size.width as f32, "{bbox:?}");
            assert!(bbox.y >= 0.0 && bbox.bottom() <= input.size.height as f32, "{bbox:?}");
        }
        assert_eq!(analysis.tracks.len() + analysis.tentative.len(), analysis.objects.len());
        let keys: BTreeSet<_> = analysis.objects.iter().map(|track| track.key).collect();
        let ids: BTreeSet<_> = analysis.tracks.iter().map(|track| track.id).collect();
        assert_eq!((keys.len(), ids.len()), (analysis.objects.len(), analysis.tracks.len()), "one twice");
        for track in analysis.objects.iter() {
            let numbers =
                [track.bbox.x, track.bbox.y, track.bbox.w, track.bbox.h, track.scale, track.fitness];
            assert!(
                numbers.iter().chain(&track.centre).chain(&track.velocity).all(|it| it.is_finite()),
                "{track:?}"
            );
            assert!((0.0..=1.0).contains(&track.visible_share), "{track:?}");
            assert!(track.regions.iter().all(|label| (1..=analysis.regions.len() as u32).contains(label)));
        }
        for event in analysis.events.iter() {
            assert!(
                event.frame <= analysis.number && event.x.is_finite() && event.y.is_finite(),
                "{event:?}"
            );
            let least = if matches!(event.kind, EventKind::Merge | EventKind::Demerge) { 2 } else { 1 };
            assert!(event.objects.len() >= least, "{event:?}");
        }
        told += analysis.events.len();
        let counted: u32 = EventKind::ALL.iter().map(|&kind| analysis.counters.of(kind)).sum();
        assert_eq!(counted as usize, told);
    }
}

/// The tables can be written and hold numbers only.
fn check_offline(input: &Input, (analyses, pipeline): &(Vec<Analysis>, Pipeline)) {
    let result = offline_result(analyses, pipeline);
    assert_eq!(result.tracks.len(), input.frames.len());
    for episode in &result.episodes {
        assert!(episode.start <= episode.end && episode.objects.iter().all(|&id| id > 0), "{episode:?}");
    }
    let mut tables = Vec::new();
    let times: Vec<_> = result.tracks.iter().map(|frame| (frame.number, frame.time)).collect();
    episodes_csv::write(&mut tables, &result.episodes).unwrap();
    events_jsonl::write(&mut tables, &result.events, &times).unwrap();
    for frame in &result.tracks {
        tracks_csv::write_frame(&mut tables, frame).unwrap();
    }
    let mut json = TracksJson::new(&mut tables).unwrap();
    for frame in &result.tracks {
        json.write_frame(frame).unwrap();
    }
    json.finish().unwrap();
    // Who is in front is not always known.
    let tables = String::from_utf8(tables).unwrap().replace("\"front\":null", "");
    assert!(!tables.contains("NaN") && !tables.contains(",inf") && !tables.contains(":null"), "{tables}");
}

/// A copy of the pipeline in the middle goes on as the original does.
fn check_copy(input: &Input, told: &[(String, Vec<u8>)]) {
    let mut pipeline = input.pipeline();
    let (before, after) = input.frames.split_at(input.frames.len() / 2);
    for frame in before {
        pipeline.step(frame).unwrap();
    }
    let mut copy = pipeline.try_clone().unwrap();
    let rest: Vec<Analysis> = after.iter().map(|frame| copy.step(frame).unwrap()).collect();
    assert_eq!(text(&rest), told[before.len()..]);
}

/// Tracking the same regions again gives the same.
fn check_again(
    input: &Input,
    (analyses, mut pipeline): (Vec<Analysis>, Pipeline),
    told: &[(String, Vec<u8>)],
) {
    pipeline.restart_tracking(&input.settings, input.fps);
    let again: Vec<Analysis> = analyses.iter().map(|analysis| pipeline.track_again(analysis)).collect();
    assert_eq!(text(&again), told);
}
