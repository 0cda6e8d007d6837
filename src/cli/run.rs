//! `occluscope run`: the whole analysis without a display.
//!
//! Decoding runs ahead on its own thread, pictures are encoded on others. What tables need of each
//! frame is kept until the end, because only then is it known who was who; the annotated pictures
//! are drawn in a second pass over the video for the same reason. A camera has no second pass:
//! its pictures show what was known at the time.

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
use crate::export::annotate::{Moment, annotate};
use crate::export::picture_queue::{Picture, PictureQueue};
use crate::export::summary::{self, Input, Summary, Timing};
use crate::export::video::VideoFile;
use crate::export::{Staging, episodes_csv, events_jsonl, picture, regions_csv, tracks_csv, tracks_json};
use crate::frame::{Frame, Mask, Size};
use crate::occlusion::Event;
use crate::pipeline::{Analysis, Pipeline, Reading, final_reading};
use crate::regions::Labels;
use crate::settings::Settings;
use crate::tracking::Track;

const MASKS: &str = "masks";
const FRAMES: &str = "frames";
const ANNOTATED: &str = "annotated.mp4";
const BACKGROUND: &str = "background";
const PLAIN_FRAMES: &str = "plain-frames";
const SUMMARY: &str = "summary.json";

/// The subcommand.
pub fn command() -> Command {
    let switch = |name: &'static str, help: &'static str| {
        Arg::new(name).long(name).action(ArgAction::SetTrue).help(help).help_heading("Bulky files")
    };
    let command = Command::new("run")
        .about("Analyse a video without a display and write tracks, regions, events and episodes")
        .after_help(
            "Writes into DIR: summary.json, settings.toml, tracks.csv (MOTChallenge), tracks.json, regions.csv, \
             events.jsonl, episodes.csv. Files of an earlier run are replaced, others are left alone; nothing appears \
             before all of it is whole.\n\n\
             Examples:\n  occluscope run street.mp4 --out results\n  occluscope run street.mp4 --out results --annotated --masks --range 100..250\n  occluscope run images/in%06d.jpg --out results --preset plain --k 3 --alpha 0.005",
        )
        .arg(flags::video().required(true))
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("The folder for the results; made if it is not there"),
        )
        .arg(switch(MASKS, "masks/bin000001.png …: the foreground, 0 or 255"))
        .arg(switch(FRAMES, "frames/000001.png …: the input with all that was found drawn on"))
        .arg(switch("annotated", "annotated.mp4: the same as a video"))
        .arg(switch(BACKGROUND, "background/000001.png …: the model's background after each frame"))
        .arg(switch(PLAIN_FRAMES, "plain-frames/000001.png …: the input as it was decoded"));
    flags::with_settings(flags::with_common(flags::with_range(command)))
}

/// Analyses and writes.
pub fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    let job = Job::new(matches)?;
    flags::start_threads(matches)?;
    let started = Instant::now();
    let frames = Frames::open(&job.video, job.range)?;
    let hash = hash_of_file(&job.video);
    job.console.detail(&format!(
        "{}: {}, {} frames/s{}; {} threads",
        job.video,
        frames.info.size,
        frames.info.fps,
        frames.total.map_or_else(String::new, |total| format!(", about {total} frames")),
        rayon::current_num_threads()
    ));

    let staging = Staging::new(&job.out).with_context(|| format!("{} cannot be written to", job.out.display()))?;
    let record = analyse(&job, &frames, &staging)?;
    if job.draws() && !frames.info.live {
        draw(&job, &record, &staging)?;
    }
    let sha256 = match hash {
        Some(hash) => hash.join().map_err(|_| anyhow!("{} could not be hashed", job.video))??,
        None => record.frames_hash.clone(),
    };
    write_tables(&record, &job.settings, &staging)?;
    let seconds = started.elapsed().as_secs_f64();
    let summary = summarise(&job, &frames, &record, sha256, seconds);
    write_file(&staging, SUMMARY, |out| summary::write(out, &summary))?;
    staging.publish(SUMMARY).with_context(|| format!("{} cannot be written to", job.out.display()))?;

    tell(&job, &summary);
    Ok(())
}

/// What is to be done.
struct Job {
    video: String,
    out: PathBuf,
    settings: Settings,
    range: Option<Range>,
    console: Console,
    masks: bool,
    frames: bool,
    annotated: bool,
    background: bool,
    plain_frames: bool,
}

impl Job {
    fn new(matches: &ArgMatches) -> anyhow::Result<Self> {
        Ok(Self {
            video: matches.get_one::<String>("video").cloned().unwrap_or_default(),
            out: matches.get_one::<PathBuf>("out").cloned().unwrap_or_default(),
            settings: flags::settings(matches)?,
            range: flags::range(matches)?,
            console: Console::new(matches),
            masks: matches.get_flag(MASKS),
            frames: matches.get_flag(FRAMES),
            annotated: matches.get_flag("annotated"),
            background: matches.get_flag(BACKGROUND),
            plain_frames: matches.get_flag(PLAIN_FRAMES),
        })
    }

    /// Whether anything is to be drawn onto frames.
    fn draws(&self) -> bool {
        self.frames || self.annotated
    }
}

/// What is kept of the whole sequence.
struct Record {
    reading: Reading,
    regions: Vec<(u32, Vec<regions_csv::Row>)>,
    foreground_share: f64,
    warnings: Vec<String>,
    /// Of all frames as they were decoded; none of a camera or a video file, which has a hash of its own.
    frames_hash: Option<String>,
}

/// The first pass: every frame through all stages. Pictures that need no later knowledge are written on the way.
fn analyse(job: &Job, frames: &Frames, staging: &Staging) -> anyhow::Result<Record> {
    let info = &frames.info;
    let mut pipeline = Pipeline::new(&job.settings, info.size, info.fps)?;
    let mut pictures = Pictures::new(job, staging)?;
    let mut live = if info.live && job.draws() { Some(Live::new(job, frames, staging)?) } else { None };
    let mut hasher = (!info.live && Path::new(&job.video).is_dir() || job.video.contains('%')).then(Sha256::new);
    let mut kept = Vec::new();
    let mut regions = Vec::new();
    let mut share = 0.0;
    let mut warnings = Vec::new();
    let nothing = Analysis {
        mask: Arc::new(Mask::empty(Size::new(0, 0))),
        labels: Arc::new(Labels { size: Size::new(0, 0), data: Vec::new() }),
        ..Analysis::default()
    };
    let progress = job.console.progress("analysing", frames.total);
    for item in frames.items() {
        // A recording ends when it is stopped; anything else is then not done.
        if interrupt::asked() && !info.live {
            bail!("stopped before the end of {}; nothing was written", job.video);
        }
        let frame = match item {
            Item::Frame(frame) => Arc::new(frame),
            Item::Warning(text) => {
                progress.warn(&text);
                warnings.push(text);
                continue;
            }
            Item::Failed(error) => return Err(error),
        };
        if let Some(hasher) = &mut hasher {
            hasher.update(&frame.rgb);
        }
        let analysis = pipeline.step(&frame).with_context(|| job.video.clone())?;
        pictures.write(&frame, &analysis, &pipeline).with_context(|| job.out.display().to_string())?;
        if let Some(live) = &mut live {
            live.draw(&frame, &analysis)?;
        }
        share += f64::from(analysis.mask.foreground_pixels() as u32) / info.size.pixels() as f64;
        regions.push((frame.number, analysis.regions.iter().map(regions_csv::Row::from).collect()));
        // Masks and labels would fill the memory, and the final reading needs none.
        kept.push(Analysis {
            mask: nothing.mask.clone(),
            labels: nothing.labels.clone(),
            regions: nothing.regions.clone(),
            ..analysis
        });
        progress.step();
    }
    drop(progress);
    pictures.queue.finish().with_context(|| job.out.display().to_string())?;
    if let Some(live) = live {
        live.finish()?;
    }
    if kept.is_empty() {
        bail!("{} gave no frames; nothing was written", job.video);
    }
    Ok(Record {
        reading: final_reading(&kept, &pipeline),
        foreground_share: share / kept.len() as f64,
        regions,
        warnings,
        frames_hash: hasher.map(|hasher| hexadecimal(&hasher.finalize())),
    })
}
