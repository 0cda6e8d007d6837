//! The definition of the subcommand, and its arguments.

use std::path::PathBuf;
use std::sync::Arc;

use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};

use super::bulky_output::{self, BulkyOutput};
use crate::cli::console::Console;
use crate::cli::flags::{self, FrameRange};
use crate::cli::source_flags;
use crate::regions::Roi;
use crate::settings::Settings;
use crate::source::Options;

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
    let command = bulky_output::ALL.into_iter().fold(command, |command, BulkyOutput { flag, help, .. }| {
        command
            .arg(Arg::new(flag).long(flag).action(ArgAction::SetTrue).help(help).help_heading("Large files"))
    });
    flags::with_settings(flags::with_common(flags::with_roi(flags::with_range(source_flags::with_options(
        command,
    )))))
}

/// The arguments of a run.
pub(super) struct RunJob {
    /// The name of the source.
    pub video: String,
    /// The output folder.
    pub out: PathBuf,
    pub settings: Settings,
    /// The region of interest; `None` for the whole image.
    pub roi: Option<Arc<Roi>>,
    /// The analysed frames; `None` for all.
    pub range: Option<FrameRange>,
    pub options: Options,
    pub console: Console,
    /// The flags of the requested bulky files.
    bulky: Vec<&'static str>,
}

impl RunJob {
    pub(super) fn new(matches: &ArgMatches) -> anyhow::Result<Self> {
        Ok(Self {
            video: matches.get_one::<String>("video").cloned().unwrap_or_default(),
            out: matches.get_one::<PathBuf>("out").cloned().unwrap_or_default(),
            settings: flags::settings(matches)?,
            roi: flags::roi(matches)?,
            range: flags::range(matches)?,
            options: source_flags::options(matches)?,
            console: Console::new(matches),
            bulky: bulky_output::ALL
                .iter()
                .map(|bulky| bulky.flag)
                .filter(|flag| matches.get_flag(flag))
                .collect(),
        })
    }

    pub(super) fn wants(&self, bulky: &BulkyOutput) -> bool {
        self.bulky.contains(&bulky.flag)
    }
}
