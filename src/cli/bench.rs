//! `occluscope bench`: measures the speed of decoding, the mixture, OpenCV's models and the whole analysis.
//!
//! All models process the same decoded frames in turn, batch by batch, and the median over the batches counts, so
//! that other load on the machine affects all of them alike.

use std::hint::black_box;
use std::io::{self, Write};
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use image::RgbImage;
use image::imageops::{self, FilterType};
use serde::Serialize;

use super::console::{Console, Progress};
use super::flags::{self, FrameRange};
use super::frames::{Batch, Frames, Item};
use super::{interrupt, source_flags, standard_output};
use crate::frame::{Frame, Mask, Size};
use crate::mixture::opencv::OpencvModel;
use crate::mixture::{BATCH, Mixture, Parameters};
use crate::pipeline::Pipeline;
use crate::registration::{CorrectionChoice, measure_all};
use crate::replay::memory;
use crate::settings::{BackgroundModel, Settings};
use crate::source::{self, Options, SourceInfo};

/// Number of frames that are kept decoded by default, if they are no larger than this.
const FRAMES: u32 = 320;
const FRAMES_BYTES: usize = 1 << 30;

/// Least number of frames for a meaningful median.
const LEAST_FRAMES: u32 = 2 * BATCH as u32;

/// Number of passes of the whole analysis.
const PASSES: usize = 3;

/// Defines the subcommand.
pub fn command() -> Command {
    let command = Command::new("bench")
        .about("Measure the speed of decoding, the mixture, OpenCV's MOG2 and KNN, and the whole analysis")
        .after_help(
            "All models process the same decoded frames in turn, one batch each; the table lists medians \
             in megapixels per second. `stream` processes one frame at a time, `replay` a batch at a time, \
             with equal results. MOG2 and KNN run without shadow detection, with the same α, threads and, \
             if supported, K. Frames of `bootstrap` are learnt by all models beforehand and not \
             timed.\n\nExamples:\n  occluscope bench street.mp4\n  occluscope bench street.mp4 --k 5 \
             --threads 2 --frames 200 --json",
        )
        .arg(flags::video().required(true))
        .arg(
            Arg::new("frames")
                .long("frames")
                .value_name("N")
                .value_parser(value_parser!(u32).range(i64::from(LEAST_FRAMES)..=100_000))
                .help("Number of frames to process [default: 320, or as many as fit into 1 GiB]"),
        )
        .arg(
            Arg::new("json")
                .long("json")
                .action(ArgAction::SetTrue)
                .help("Print one JSON object instead of a table"),
        );
    let command = source_flags::with_options(command).mut_arg("scale", |scale| {
        scale.value_name("S|WxH").help(
            "Reduce the images by this factor, or resize the frames to this size first, as in 1920x1080",
        )
    });
    flags::with_settings(flags::with_common(command))
}

/// Runs the measurement and prints it.
pub fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    let settings = flags::settings(matches)?;
    let scale = size(matches)?;
    let options = match scale {
        Some(_) => source_flags::unscaled_options(matches)?,
        None => source_flags::options(matches)?,
    };
    flags::start_threads(matches)?;
    let console = Console::new(matches);
    let video = matches.get_one::<String>("video").map_or("", String::as_str);
    let asked = matches.get_one::<u32>("frames").copied();
    let sequence = Sequence::open(video, options, asked, scale, CorrectionChoice::new(&settings), console)?;
    let figures = Figures::measure(video, &sequence, scale.is_some(), &settings, console)?;
    standard_output::write(|out| {
        if !matches.get_flag("json") {
            return Ok(figures.print(out)?);
        }
        serde_json::to_writer(&mut *out, &figures).map_err(io::Error::from)?;
        Ok(writeln!(out)?)
    })
}

/// The size in place of a factor for `--scale`.
fn size(matches: &ArgMatches) -> Result<Option<Size>, flags::UsageError> {
    let Some(text) = matches.get_one::<String>("scale") else { return Ok(None) };
    let Some((width, height)) = text.split_once(['x', '×']) else { return Ok(None) };
    let side = |text: &str| text.trim().parse().ok();
    match side(width).zip(side(height)).map(|(width, height)| Size::new(width, height)) {
        Some(size) if (1..=16_384).contains(&size.width) && (1..=16_384).contains(&size.height) => {
            Ok(Some(size))
        }
        _ => Err(flags::UsageError(format!(
            "--scale cannot be `{text}`: give width and height, as in 1920x1080"
        ))),
    }
}

/// Decoded frames, and the time of decoding each batch of them.
struct Sequence {
    info: SourceInfo,
    options: Options,
    frames: Vec<Frame>,
    decoding: Meter,
}

impl Sequence {
    fn open(
        video: &str,
        options: Options,
        asked: Option<u32>,
        scale: Option<Size>,
        choice: CorrectionChoice,
        console: Console,
    ) -> anyhow::Result<Self> {
        interrupt::watch();
        let mut source = source::open(video, options)?;
        let size = scale.unwrap_or(source.info().size);
        let fitting = (FRAMES_BYTES / (size.pixels() * 3).max(1)) as u32;
        let wanted = asked.unwrap_or_else(|| FRAMES.min(fitting).max(LEAST_FRAMES));
        let bytes = size.pixels() as u64 * 3 * u64::from(wanted);
        if bytes > memory() / 2 {
            bail!(
                "{wanted} frames of {size} need {} MiB, more than half of this machine's memory; reduce \
                 --frames or --scale",
                bytes >> 20
            );
        }
        let info = source.info().clone();
        let mut sequence = Self { info, options, frames: Vec::new(), decoding: Meter::default() };
        let progress = console.progress("decoding", Some(wanted));
        let mut ended = false;
        while !ended && sequence.frames.len() < wanted as usize {
            let missing = wanted as usize - sequence.frames.len();
            let started = Instant::now();
            let mut batch = Vec::new();
            while batch.len() < missing.min(BATCH) {
                let Some(frame) = source.next_frame()? else {
                    ended = true;
                    break;
                };
                batch.push(frame);
            }
            let took = started.elapsed();
            stop_if_asked(video)?;
            source.take_warnings().iter().for_each(|warning| progress.warn(warning));
            if !batch.is_empty() {
                let pixels = batch.iter().map(|frame: &Frame| frame.size.pixels()).sum();
                sequence.decoding.0.push(TimedWork { pixels, took });
            }
            progress.advance(batch.len());
            for frame in batch {
                sequence.frames.push(match scale {
                    Some(size) => scaled(frame, size)?,
                    None => frame,
                });
            }
        }
        measure_all(&mut sequence.frames, choice);
        let found = sequence.frames.len();
        if found < LEAST_FRAMES as usize {
            bail!(
                "{video} has {found} frames, the measurement needs at least {LEAST_FRAMES}; choose a \
                 longer video"
            );
        }
        Ok(sequence)
    }
}

fn scaled(frame: Frame, size: Size) -> anyhow::Result<Frame> {
    let number = frame.number;
    let image = RgbImage::from_raw(frame.size.width, frame.size.height, frame.rgb);
    let image = image.context("a frame has three bytes a pixel")?;
    let image = imageops::resize(&image, size.width, size.height, FilterType::Triangle);
    Ok(Frame::new(number, size, image.into_raw()))
}

fn stop_if_asked(video: &str) -> anyhow::Result<()> {
    if interrupt::is_stop_requested() {
        bail!("stopped before the measurement of {video} was complete");
    }
    Ok(())
}

/// The JSON output; `_mpx_s` is megapixels per second.
#[derive(Serialize)]
struct Figures {
    frames: usize,
    width: u32,
    height: u32,
    k: u32,
    threads: usize,
    decode_mpx_s: f64,
    stream_mpx_s: f64,
    replay_mpx_s: f64,
    mog2_mpx_s: f64,
    knn_mpx_s: f64,
    pipeline_fps: f64,
    /// Frames per second of decoding followed by the mixture only.
    #[serde(skip)]
    decode_and_mixture_fps: f64,
}

impl Figures {
    fn measure(
        video: &str,
        sequence: &Sequence,
        scaled: bool,
        settings: &Settings,
        console: Console,
    ) -> anyhow::Result<Self> {
        let frames = &sequence.frames;
        let size = frames.first().map_or(Size::new(0, 0), |frame| frame.size);
        let parameters = Parameters::new(settings);
        let (mut streamed, mut replayed) = (Mixture::new(size, parameters), Mixture::new(size, parameters));
        let mut mog2 = opencv_model(settings, size, BackgroundModel::Mog2)?;
        let mut knn = opencv_model(settings, size, BackgroundModel::Knn)?;
        // All models start after learning, as in an analysis; learning itself is not timed.
        let first: Vec<&Frame> = frames.iter().take(sequence.info.bootstrap(settings) as usize).collect();
        streamed.learn(&first);
        replayed.learn(&first);
        first.iter().try_for_each(|frame| mog2.learn(frame).and_then(|()| knn.learn(frame)))?;
        let mut masks = vec![Mask::empty(size); BATCH];
        let mut meters: [Meter; 4] = Default::default();
        let [stream, replay, mog2_meter, knn_meter] = &mut meters;
        let progress = console.progress("measuring", Some(frames.len() as u32));
        for batch in frames.chunks(BATCH) {
            stop_if_asked(video)?;
            let batch: Vec<&Frame> = batch.iter().collect();
            let pixels = batch.len() * size.pixels();
            stream.time(pixels, || batch.iter().for_each(|frame| drop(black_box(streamed.step(frame)))));
            replay.time(pixels, || replayed.step_many(black_box(&batch), &mut masks[..batch.len()]));
            black_box(&masks);
            mog2_meter.time(pixels, || batch.iter().try_for_each(|frame| mog2.step(frame).map(drop)))?;
            knn_meter.time(pixels, || batch.iter().try_for_each(|frame| knn.step(frame).map(drop)))?;
            progress.advance(batch.len());
        }
        drop(progress);
        let (mut pipeline, mut mixture) = (Meter::default(), Meter::default());
        let progress = console.progress("analysing", Some((2 * PASSES * frames.len()) as u32));
        for _ in 0..PASSES {
            let mut alone = Mixture::new(size, parameters);
            alone.learn(&first);
            mixture.pass(video, sequence, scaled, None, &progress, |batch| {
                alone.step_many(batch, &mut masks[..batch.len()]);
                Ok(())
            })?;
            let mut whole = Pipeline::new(settings, size, sequence.info.fps)?;
            whole.learn(&first)?;
            pipeline.pass(
                video,
                sequence,
                scaled,
                Some(CorrectionChoice::new(settings)),
                &progress,
                |batch| {
                    black_box(whole.step_many(batch)?);
                    Ok(())
                },
            )?;
        }
        let frame_mpx = size.pixels() as f64 / 1e6;
        Ok(Self {
            frames: frames.len(),
            width: size.width,
            height: size.height,
            k: settings.k,
            threads: rayon::current_num_threads(),
            decode_mpx_s: sequence.decoding.median(),
            stream_mpx_s: stream.median(),
            replay_mpx_s: replay.median(),
            mog2_mpx_s: mog2_meter.median(),
            knn_mpx_s: knn_meter.median(),
            pipeline_fps: pipeline.median() / frame_mpx,
            decode_and_mixture_fps: mixture.median() / frame_mpx,
        })
    }

    fn print(&self, out: &mut impl Write) -> io::Result<()> {
        let Self { frames, width, height, k, threads, .. } = self;
        writeln!(out, "{frames} frames of {width}×{height}, K = {k}, {threads} threads; medians\n")?;
        let frame_mpx = f64::from(*width) * f64::from(*height) / 1e6;
        let mut row = |name: &str, mpx_s: f64| {
            let (frames, times) = (mpx_s / frame_mpx, mpx_s / self.mog2_mpx_s);
            writeln!(out, "{name:24} {mpx_s:9.1} Mpx/s {frames:9.1} frames/s {times:8.2} × MOG2")
        };
        row("decoding", self.decode_mpx_s)?;
        row("mixture, frame by frame", self.stream_mpx_s)?;
        row("mixture, replay", self.replay_mpx_s)?;
        row("OpenCV MOG2", self.mog2_mpx_s)?;
        row("OpenCV KNN", self.knn_mpx_s)?;
        writeln!(out)?;
        let share = 100.0 * self.pipeline_fps / self.decode_and_mixture_fps;
        writeln!(out, "{:24} {:9.1} frames/s", "decoding and mixture", self.decode_and_mixture_fps)?;
        writeln!(out, "{:24} {:9.1} frames/s, {share:.0} % of that", "the whole analysis", self.pipeline_fps)
    }
}

fn opencv_model(settings: &Settings, size: Size, model: BackgroundModel) -> anyhow::Result<OpencvModel> {
    let settings = Settings { background_model: model, ..settings.clone() };
    OpencvModel::new(&settings, size)?.context("OpenCV has this model")
}

/// The time that some work on this number of pixels took.
struct TimedWork {
    pixels: usize,
    took: Duration,
}

impl TimedWork {
    /// Megapixels per second.
    fn speed(&self) -> f64 {
        self.pixels as f64 / 1e6 / self.took.as_secs_f64().max(1e-9)
    }
}

/// The measurements of one kind of work.
#[derive(Default)]
struct Meter(Vec<TimedWork>);

impl Meter {
    fn time<T>(&mut self, pixels: usize, work: impl FnOnce() -> T) -> T {
        let started = Instant::now();
        let result = work();
        self.0.push(TimedWork { pixels, took: started.elapsed() });
        result
    }

    /// A pass over the video as in `run`, with decoding ahead on a separate thread; scaled frames are taken from
    /// memory.
    fn pass(
        &mut self,
        video: &str,
        sequence: &Sequence,
        scaled: bool,
        choice: Option<CorrectionChoice>,
        progress: &Progress,
        mut work: impl FnMut(&[&Frame]) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let pixels = sequence.frames.iter().map(|frame| frame.size.pixels()).sum();
        let started = Instant::now();
        if scaled {
            for batch in sequence.frames.chunks(BATCH) {
                stop_if_asked(video)?;
                work(&batch.iter().collect::<Vec<_>>())?;
                progress.advance(batch.len());
            }
        } else {
            let last = sequence.frames.last().map_or(0, |frame| frame.number);
            let first = sequence.frames.first().map_or(0, |frame| frame.number);
            let mut frames = Frames::open(video, sequence.options, Some(FrameRange { first, last }), choice)?;
            loop {
                stop_if_asked(video)?;
                let Batch { frames: batch, after } = frames.batch(BATCH);
                work(&batch.iter().collect::<Vec<_>>())?;
                progress.advance(batch.len());
                match after {
                    Some(Item::End) => break,
                    Some(Item::Failed(error)) => return Err(error),
                    // Already reported when the frames were decoded first.
                    Some(Item::Warning(_) | Item::Frame(_)) | None => {}
                }
            }
        }
        self.0.push(TimedWork { pixels, took: started.elapsed() });
        Ok(())
    }

    /// The median in megapixels per second.
    fn median(&self) -> f64 {
        let mut speeds: Vec<_> = self.0.iter().map(TimedWork::speed).collect();
        speeds.sort_by(f64::total_cmp);
        speeds.get(speeds.len() / 2).copied().unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_slow_batch_does_not_change_the_median() {
        let measured = [(2_000_000, 1), (3_000_000, 1), (2_000_000, 100)];
        let measured =
            measured.map(|(pixels, seconds)| TimedWork { pixels, took: Duration::from_secs(seconds) });
        let meter = Meter(measured.into());
        assert_eq!(meter.median(), 2.0);
        assert_eq!(Meter::default().median(), 0.0);
    }
}
