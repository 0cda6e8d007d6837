//! `occluscope run`: the whole analysis without a display.
//!
//! Decoding runs ahead on its own thread, images are encoded on others. The data for tables is kept until the end,
//! because the offline result needs all frames; annotated frames are drawn in a second pass over the video for the
//! same reason. A camera has no second pass: its annotated frames show the online result.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::Instant;

use anyhow::{Context as _, anyhow, bail};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use rayon::prelude::*;
use sha2::{Digest, Sha256};

use super::console::Console;
use super::flags::{self, Range};
use super::frames::{Frames, Item};
use super::interrupt;
use crate::export::annotate::{FrameAnnotations, annotate};
use crate::export::picture_queue::{Picture, PictureQueue};
use crate::export::summary::{self, Input, Summary, Timing};
use crate::export::video::VideoFile;
use crate::export::{Staging, episodes_csv, events_jsonl, picture, regions_csv, tracks_csv, tracks_json};
use crate::frame::{Frame, Mask, Size};
use crate::mixture::BATCH;
use crate::occlusion::{Event, EventKind};
use crate::pipeline::{Analysis, OfflineResult, Pipeline, offline_result};
use crate::regions::{Labels, Roi};
use crate::registration::CorrectionChoice;
use crate::settings::Settings;
use crate::source::{Options, SourceInfo};
use crate::tracking::Track;

const SUMMARY: &str = "summary.json";
/// The region of interest, if it is not the whole image.
const ROI: &str = "roi.png";

/// A file or folder that is written only on request.
struct BulkyOutput {
    flag: &'static str,
    file: &'static str,
    help: &'static str,
}

const MASKS: BulkyOutput =
    BulkyOutput { flag: "masks", file: "masks", help: "masks/bin000001.png …: foreground masks, 0 or 255" };
const FRAMES: BulkyOutput = BulkyOutput {
    flag: "frames",
    file: "frames",
    help: "frames/000001.png …: input frames with the results drawn on",
};
const ANNOTATED: BulkyOutput =
    BulkyOutput { flag: "annotated", file: "annotated.mp4", help: "annotated.mp4: the same as a video" };
const BACKGROUND: BulkyOutput = BulkyOutput {
    flag: "background",
    file: "background",
    help: "background/000001.png …: background model after each frame",
};
const PLAIN_FRAMES: BulkyOutput = BulkyOutput {
    flag: "plain-frames",
    file: "plain-frames",
    help: "plain-frames/000001.png …: input frames as decoded",
};
const ALL_BULKY: [BulkyOutput; 5] = [MASKS, FRAMES, ANNOTATED, BACKGROUND, PLAIN_FRAMES];

/// Defines the subcommand.
pub fn command() -> Command {
    let command = Command::new("run")
        .about("Analyse a video without a display and write tracks, regions, events and episodes")
        .after_help(
            "Writes into DIR: summary.json, settings.toml, tracks.csv (MOTChallenge), tracks.json, \
             regions.csv, events.jsonl, episodes.csv; with --roi also roi.png. Files of an earlier run are \
             replaced, other files are kept; files appear only when all are complete.\n\nExamples:\n  \
             occluscope run street.mp4 --out results\n  occluscope run street.mp4 --out results \
             --annotated --masks --range 100..250\n  occluscope run images/in%06d.jpg --out results \
             --preset plain --k 3 --alpha 0.005",
        )
        .arg(flags::video().required(true))
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("Output folder; created if it does not exist"),
        );
    let command = ALL_BULKY.into_iter().fold(command, |command, BulkyOutput { flag, help, .. }| {
        command
            .arg(Arg::new(flag).long(flag).action(ArgAction::SetTrue).help(help).help_heading("Large files"))
    });
    flags::with_settings(flags::with_common(flags::with_roi(flags::with_range(flags::with_source(command)))))
}

/// Analyses the video and writes the output.
pub fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    let job = RunJob::new(matches)?;
    flags::start_threads(matches)?;
    let started = Instant::now();
    let mut frames =
        Frames::open(&job.video, job.options, job.range, Some(CorrectionChoice::new(&job.settings)))?;
    if let Some(roi) = &job.roi {
        roi.check(frames.info.size)?;
    }
    let hash = hash_of_file(&job.video);
    job.console.detail(&format!(
        "{}: {}, {} frames/s{}; {} threads",
        job.video,
        frames.info.size,
        frames.info.fps,
        frames.total.map_or_else(String::new, |total| format!(", about {total} frames")),
        rayon::current_num_threads()
    ));

    let staging = Staging::new(&job.out).with_context(|| job.out_failure())?;
    let record = analyse(&job, &mut frames, &staging)?;
    if job.draws() && !frames.info.live {
        draw(&job, &record, &staging)?;
    }
    let sha256 = match hash {
        Some(hash) => Some(hash.join().map_err(|_| anyhow!("{} could not be hashed", job.video))??),
        None => record.frames_hash.clone(),
    };
    write_tables(&record, &job, &staging)?;
    let seconds = started.elapsed().as_secs_f64();
    let summary = summarise(&job, &frames.info, &record, sha256, seconds);
    write_file(&staging, SUMMARY, |out| summary::write(out, &summary))?;
    staging.publish(SUMMARY).with_context(|| job.out_failure())?;

    print_summary(&job, &summary);
    flags::note_assumed_fps(&frames.info, job.console);
    Ok(())
}

/// The inputs of a run.
struct RunJob {
    video: String,
    out: PathBuf,
    settings: Settings,
    roi: Option<Arc<Roi>>,
    range: Option<Range>,
    options: Options,
    console: Console,
    /// The flags of the requested bulky files.
    bulky: Vec<&'static str>,
}

impl RunJob {
    fn new(matches: &ArgMatches) -> anyhow::Result<Self> {
        Ok(Self {
            video: matches.get_one::<String>("video").cloned().unwrap_or_default(),
            out: matches.get_one::<PathBuf>("out").cloned().unwrap_or_default(),
            settings: flags::settings(matches)?,
            roi: flags::roi(matches)?,
            range: flags::range(matches)?,
            options: flags::source_options(matches)?,
            console: Console::new(matches),
            bulky: ALL_BULKY.iter().map(|bulky| bulky.flag).filter(|flag| matches.get_flag(flag)).collect(),
        })
    }

    fn out_failure(&self) -> String {
        format!("{} cannot be written to", self.out.display())
    }

    /// Whether annotated frames are requested.
    fn draws(&self) -> bool {
        self.wants(&FRAMES) || self.wants(&ANNOTATED)
    }

    fn wants(&self, bulky: &BulkyOutput) -> bool {
        self.bulky.contains(&bulky.flag)
    }
}

/// The recorded results of the whole sequence.
struct RunRecord {
    reading: OfflineResult,
    regions: Vec<(u32, Vec<regions_csv::Row>)>,
    foreground_share: f64,
    warnings: Vec<String>,
    /// The hash of all decoded frames; `None` for a camera or a video file, which has its own hash.
    frames_hash: Option<String>,
}

/// The first pass: every frame through all stages. Images that do not need the offline result are written during it.
fn analyse(job: &RunJob, frames: &mut Frames, staging: &Staging) -> anyhow::Result<RunRecord> {
    let info = &frames.info.clone();
    let mut pipeline = Pipeline::new(&job.settings, info.size, info.fps)?;
    pipeline.set_roi(job.roi.clone())?;
    frames.learn(&job.settings, job.console, |frames| {
        pipeline.learn(frames).with_context(|| job.video.clone())
    })?;
    let mut pictures = Pictures::new(job, staging).with_context(|| job.out_failure())?;
    let mut live = None;
    if info.live && job.draws() {
        live = Some(LiveDrawing::new(Drawing::new(job, info, staging)?, info.fps));
    }
    let mut hasher = is_images(info).then(Sha256::new);
    let mut kept = Vec::new();
    let mut regions = Vec::new();
    let mut foreground = 0;
    let mut warnings = Vec::new();
    let no_mask = Arc::new(Mask::empty(Size::new(0, 0)));
    let no_labels = Arc::new(Labels::none(Size::new(0, 0)));
    let no_regions = Arc::new(Vec::new());

    let progress = job.console.progress("analysing", frames.total);
    // Images of the model are of the state after each frame.
    let most = if pictures.background.is_some() { 1 } else { BATCH };
    loop {
        // Stopping ends a recording; any other work is then incomplete.
        if interrupt::is_stop_requested() && !info.live {
            bail!("stopped before the end of {}; nothing was written", job.video);
        }
        let (batch, after) = frames.batch(most);
        let batch: Vec<_> = batch.into_iter().map(Arc::new).collect();
        if let Some(hasher) = &mut hasher {
            for frame in &batch {
                hasher.update(&frame.rgb);
            }
        }
        let borrowed: Vec<_> = batch.iter().map(Arc::as_ref).collect();
        let analyses = pipeline.step_many(&borrowed).with_context(|| job.video.clone())?;
        for (frame, analysis) in batch.iter().zip(analyses) {
            pictures.write(frame, &analysis, &pipeline).with_context(|| job.out_failure())?;
            if let Some(live) = &mut live {
                live.draw(Frame::clone(frame), &analysis).with_context(|| job.out_failure())?;
            }
            foreground += analysis.mask.foreground_pixels();
            regions.push((frame.number, analysis.regions.iter().map(regions_csv::Row::from).collect()));
            // Masks, labels and histograms would exceed the memory, and the offline result does not need them.
            kept.push(Analysis {
                mask: no_mask.clone(),
                labels: no_labels.clone(),
                regions: no_regions.clone(),
                ..analysis
            });
        }
        progress.advance(batch.len());
        match after {
            None | Some(Item::Frame(_)) => {}
            Some(Item::Warning(text)) => {
                progress.warn(&text);
                warnings.push(text);
            }
            Some(Item::Failed(error)) => return Err(error),
            Some(Item::End) => break,
        }
    }
    drop(progress);
    pictures.queue.finish().with_context(|| job.out_failure())?;
    if let Some(live) = live {
        live.finish()?;
    }
    if kept.is_empty() {
        bail!("{} has no frames; nothing was written", job.video);
    }
    Ok(RunRecord {
        reading: offline_result(&kept, &pipeline),
        foreground_share: foreground as f64 / (kept.len() * info.size.pixels()) as f64,
        regions,
        warnings,
        frames_hash: hasher.map(|hasher| hexadecimal(&hasher.finalize())),
    })
}

/// The bulky images that are written during the first pass.
struct Pictures {
    masks: Option<PathBuf>,
    background: Option<PathBuf>,
    plain_frames: Option<PathBuf>,
    queue: PictureQueue,
}

impl Pictures {
    fn new(job: &RunJob, staging: &Staging) -> io::Result<Self> {
        let folder = |bulky: &BulkyOutput| job.wants(bulky).then(|| staging.folder(bulky.file)).transpose();
        Ok(Self {
            masks: folder(&MASKS)?,
            background: folder(&BACKGROUND)?,
            plain_frames: folder(&PLAIN_FRAMES)?,
            queue: PictureQueue::start(rayon::current_num_threads().min(8))?,
        })
    }

    fn write(&mut self, frame: &Arc<Frame>, analysis: &Analysis, pipeline: &Pipeline) -> anyhow::Result<()> {
        let number = frame.number;
        if let Some(folder) = &self.masks {
            let path = folder.join(format!("bin{number:06}.png"));
            self.queue.write(path, Picture::Mask(analysis.mask.clone()))?;
        }
        if let Some(folder) = &self.background {
            let image = Frame::new(number, frame.size, pipeline.background_image()?);
            self.queue.write(numbered(folder, number), Picture::Frame(Arc::new(image)))?;
        }
        if let Some(folder) = &self.plain_frames {
            self.queue.write(numbered(folder, number), Picture::Frame(frame.clone()))?;
        }
        Ok(())
    }
}

fn numbered(folder: &Path, number: u32) -> PathBuf {
    folder.join(format!("{number:06}.png"))
}

/// The destination of annotated frames.
struct Drawing {
    frames: Option<PathBuf>,
    video: Option<VideoFile>,
}

impl Drawing {
    fn new(job: &RunJob, info: &SourceInfo, staging: &Staging) -> anyhow::Result<Self> {
        let frames = job
            .wants(&FRAMES)
            .then(|| staging.folder(FRAMES.file))
            .transpose()
            .with_context(|| job.out_failure())?;
        let video = job
            .wants(&ANNOTATED)
            .then(|| VideoFile::create(&staging.path(ANNOTATED.file), info.size, info.fps))
            .transpose()?;
        Ok(Self { frames, video })
    }

    fn write(&mut self, frames: &[Frame]) -> anyhow::Result<()> {
        if let Some(folder) = &self.frames {
            frames
                .par_iter()
                .try_for_each(|frame| picture::write_frame(&numbered(folder, frame.number), frame))?;
        }
        if let Some(video) = &mut self.video {
            for frame in frames {
                video.write(frame)?;
            }
        }
        Ok(())
    }

    fn finish(self) -> anyhow::Result<()> {
        Ok(self.video.map_or(Ok(()), VideoFile::finish)?)
    }
}

/// Draws the online result onto each frame during the first pass.
struct LiveDrawing {
    drawing: Drawing,
    fps: f32,
    tracks: Vec<(u32, Vec<Track>)>,
    events: Vec<Event>,
}

impl LiveDrawing {
    fn new(drawing: Drawing, fps: f32) -> Self {
        Self { drawing, fps, tracks: Vec::new(), events: Vec::new() }
    }

    fn draw(&mut self, mut frame: Frame, analysis: &Analysis) -> anyhow::Result<()> {
        self.tracks.push((analysis.number, analysis.tracks.to_vec()));
        self.events.extend(analysis.events.iter().cloned());
        // An event can be decided some frames after it happened.
        self.events.sort_by_key(|event| event.frame);
        annotate(
            &mut frame,
            &FrameAnnotations::at(self.tracks.len() - 1, &self.tracks, &self.events, self.fps),
        );
        self.drawing.write(&[frame])
    }

    fn finish(self) -> anyhow::Result<()> {
        self.drawing.finish()
    }
}

/// The second pass: decodes the frames again and draws the offline result.
fn draw(job: &RunJob, record: &RunRecord, staging: &Staging) -> anyhow::Result<()> {
    let mut frames = Frames::open(&job.video, job.options, job.range, None)?;
    let fps = frames.info.fps;
    let OfflineResult { tracks, events, .. } = &record.reading;
    let mut drawing = Drawing::new(job, &frames.info, staging)?;
    let progress = job.console.progress("drawing", Some(tracks.len() as u32));
    let changed = || anyhow!("{} changed during the analysis; run again", job.video);

    let mut pictures = frames.items().filter_map(|item| match item {
        Item::Frame(frame) => Some(Ok(frame)),
        // Already reported by the first pass.
        Item::Warning(_) | Item::End => None,
        Item::Failed(error) => Some(Err(error)),
    });
    let mut done = 0;
    while done < tracks.len() {
        if interrupt::is_stop_requested() {
            bail!("stopped before all frames of {} were drawn; nothing was written", job.video);
        }
        let some = 2 * rayon::current_num_threads();
        let mut batch: Vec<Frame> =
            pictures.by_ref().take(some.min(tracks.len() - done)).collect::<Result<_, _>>()?;
        if batch.is_empty()
            || batch.iter().zip(&tracks[done..]).any(|(frame, (number, _))| frame.number != *number)
        {
            return Err(changed());
        }
        batch.par_iter_mut().enumerate().for_each(|(offset, frame)| {
            annotate(frame, &FrameAnnotations::at(done + offset, tracks, events, fps));
        });
        drawing.write(&batch).with_context(|| job.out_failure())?;
        done += batch.len();
        progress.advance(batch.len());
    }
    drawing.finish()
}

/// Whether frames come from a folder or a pattern of images.
fn is_images(info: &SourceInfo) -> bool {
    !info.live && !Path::new(&info.name).is_file()
}

/// Starts hashing a video file; `None` for other sources.
fn hash_of_file(video: &str) -> Option<JoinHandle<io::Result<String>>> {
    let path = Path::new(video).is_file().then(|| PathBuf::from(video))?;
    let hash = move || {
        let mut file = File::open(path)?;
        let mut hasher = Sha256::new();
        let mut part = vec![0; 1 << 16];
        loop {
            match file.read(&mut part)? {
                0 => return Ok(hexadecimal(&hasher.finalize())),
                read => hasher.update(&part[..read]),
            }
        }
    };
    thread::Builder::new().name("hash".to_owned()).spawn(hash).ok()
}

fn hexadecimal(bytes: &[u8]) -> String {
    use std::fmt::Write as _;
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn write_tables(record: &RunRecord, job: &RunJob, staging: &Staging) -> anyhow::Result<()> {
    let RunRecord { reading, regions, .. } = record;
    write_file(staging, "settings.toml", |out| {
        out.write_all(job.settings.to_toml().as_bytes())?;
        if job.roi.is_some() {
            writeln!(
                out,
                "# Only the bright pixels of {ROI} are analysed; to repeat this run, add --roi {ROI}"
            )?;
        }
        Ok(())
    })?;
    if let Some(roi) = &job.roi {
        picture::write_mask(&staging.path(ROI), roi.mask())
            .with_context(|| format!("{ROI} cannot be written"))?;
    }
    write_file(staging, "tracks.csv", |out| tracks_csv::write(out, &reading.tracks))?;
    write_file(staging, "tracks.json", |out| tracks_json::write(out, &reading.tracks))?;
    write_file(staging, "regions.csv", |out| regions_csv::write(out, regions, &reading.tracks))?;
    write_file(staging, "events.jsonl", |out| events_jsonl::write(out, &reading.events))?;
    write_file(staging, "episodes.csv", |out| episodes_csv::write(out, &reading.episodes))
}

fn write_file(
    staging: &Staging,
    name: &str,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> anyhow::Result<()> {
    let write = || {
        let mut out = BufWriter::new(File::create(staging.path(name))?);
        content(&mut out)?;
        out.flush()
    };
    write().with_context(|| format!("{name} cannot be written"))
}

fn summarise(
    job: &RunJob,
    info: &SourceInfo,
    record: &RunRecord,
    sha256: Option<String>,
    seconds: f64,
) -> Summary {
    let reading = &record.reading;
    let frames = reading.tracks.len() as u32;
    let number = |entry: Option<&(u32, Vec<Track>)>| entry.map_or(0, |(number, _)| *number);
    let identities: BTreeSet<_> =
        reading.tracks.iter().flat_map(|(_, tracks)| tracks.iter().map(|track| track.id)).collect();
    Summary {
        version: env!("CARGO_PKG_VERSION"),
        input: Input {
            path: job.video.clone(),
            size: info.size,
            fps: info.fps,
            fps_from: info.fps_from.word(),
            frames,
            first_frame: number(reading.tracks.first()),
            last_frame: number(reading.tracks.last()),
            sha256,
        },
        settings: job.settings.clone(),
        analysed_share: job.roi.as_ref().map(|roi| roi.share()),
        objects: identities.len(),
        events: reading.counters,
        episodes: reading.episodes.len(),
        foreground_share: record.foreground_share,
        warnings: record.warnings.clone(),
        timing: Timing { seconds, frames_per_second: f64::from(frames) / seconds.max(f64::MIN_POSITIVE) },
    }
}

/// Prints a summary of the results.
fn print_summary(job: &RunJob, summary: &Summary) {
    job.console.note(&format!(
        "{} frames, {} objects, {} occlusion episodes, {:.0} frames/s; written to {}",
        summary.input.frames,
        summary.objects,
        summary.episodes,
        summary.timing.frames_per_second,
        job.out.display()
    ));
    for kind in EventKind::ALL {
        job.console.detail(&format!("{:>9}: {}", kind.name(), summary.events.of(kind)));
    }
    let bulky = ALL_BULKY.iter().map(|bulky| (bulky.file, job.wants(bulky)));
    for (file, ours) in bulky.chain([(ROI, job.roi.is_some())]) {
        let path = job.out.join(file);
        if !ours && path.exists() {
            job.console.note(&format!("note: {} is not from this run", path.display()));
        }
    }
}
