//! `occluscope model`: the mixtures of all pixels after a frame, as arrays of NumPy.

use std::path::PathBuf;

use anyhow::{Context as _, bail};
use clap::{Arg, ArgMatches, Command, value_parser};

use super::console::Console;
use super::flags::{self, FrameRange, UsageError};
use super::frames::{Batch, Frames, Item};
use super::out_file::OutFile;
use super::{inputs, interrupt, source_flags};
use crate::export::model_npz;
use crate::export::staging::IsFolder;
use crate::mixture::BATCH;
use crate::pipeline::Pipeline;
use crate::registration::CorrectionChoice;
use crate::settings::Settings;
use crate::source::Options;

/// Defines the subcommand.
pub fn command() -> Command {
    let command = Command::new("model")
        .about("Write the mixtures of all pixels after one frame as NumPy arrays")
        .after_help(
            "Arrays of 32-bit floats, in rank order: mean (K, height, width, 3; with --space gray: 1), variance \
             and weight (K, height, width). Unused components are 0. With --scale or --crop they have the size of \
             the analysed frames.\n\nExample:\n  occluscope model street.mp4 --frame 250 --out model.npz\n  \
             python3 -c \"import numpy; print(numpy.load('model.npz')['mean'].shape)\"",
        )
        .arg(flags::video().required(true))
        .arg(
            Arg::new("frame")
                .long("frame")
                .value_name("N")
                .required(true)
                .value_parser(value_parser!(u32))
                .help("The frame, in source numbering"),
        )
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("FILE.npz")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("Output file"),
        );
    flags::with_settings(flags::with_common(flags::with_range(source_flags::with_options(command))))
}

/// Writes the file.
pub fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    let settings = flags::settings(matches)?;
    flags::require_mixture(&settings)?;
    let job = ModelJob {
        video: matches.get_one::<String>("video").cloned().unwrap_or_default(),
        number: matches.get_one::<u32>("frame").copied().unwrap_or_default(),
        settings,
        range: flags::range(matches)?,
        options: source_flags::options(matches)?,
        console: Console::new(matches),
    };
    if let Some(range) = job.range.filter(|range| !(range.first..=range.last).contains(&job.number)) {
        return Err(UsageError(format!("frame {} is not in --range {range}", job.number)).into());
    }
    flags::start_threads(matches)?;
    let out = matches.get_one::<PathBuf>("out").cloned().unwrap_or_default();
    inputs::protect(&inputs::of_command(matches), [(out.as_path(), IsFolder::No)])?;
    let out = OutFile::begin(&out)?;
    let pipeline = job.learn()?;
    let mixture = pipeline.mixture().context("this background model has no mixture")?;
    out.write(|file| Ok(model_npz::write(file, mixture)?))
}

struct ModelJob {
    video: String,
    /// The number of the last frame.
    number: u32,
    settings: Settings,
    range: Option<FrameRange>,
    options: Options,
    console: Console,
}

impl ModelJob {
    /// The model after the frame; later stages have not been run.
    fn learn(&self) -> anyhow::Result<Pipeline> {
        let Self { video, number, settings, console, .. } = self;
        let choice = CorrectionChoice::new(settings);
        let mut frames = Frames::open(video, self.options, self.range, Some(choice))?;
        let mut pipeline = Pipeline::new(settings, frames.info.size, frames.info.fps)?;
        frames.learn(settings, *console, |frames| pipeline.learn(frames).with_context(|| video.clone()))?;
        let progress = console.progress("analysing", frames.total.map(|total| total.min(*number)));
        let mut last = None;
        loop {
            if interrupt::is_stop_requested() {
                bail!("stopped before frame {number} of {video}; nothing was written");
            }
            let Batch { frames: batch, after } = frames.batch(BATCH);
            let until: Vec<_> = batch.iter().take_while(|frame| frame.number <= *number).collect();
            pipeline.masks(&until).with_context(|| video.clone())?;
            progress.advance(until.len());
            last = until.last().map(|frame| frame.number).or(last);
            if last == Some(*number) {
                return Ok(pipeline);
            }
            let is_beyond = until.len() < batch.len() || matches!(after, Some(Item::End));
            match after {
                Some(Item::Failed(error)) => return Err(error),
                Some(Item::Warning(text)) => progress.warn(&text),
                _ => {}
            }
            if is_beyond {
                let place =
                    last.map_or_else(String::new, |last| format!("; the last one before it is {last}"));
                bail!("{video} has no frame {number}{place}");
            }
        }
    }
}
