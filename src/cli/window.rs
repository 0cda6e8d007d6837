//! `occluscope [VIDEO]`: opens the window.

use std::path::PathBuf;
use std::sync::Arc;

use clap::{Arg, ArgMatches, Command, value_parser};

use super::{flags, source_flags};
use crate::regions::Roi;
use crate::settings::Settings;
use crate::source::Options;
use crate::truth::TruthSource;

/// Adds the arguments of the window.
pub(super) fn with_arguments(command: Command) -> Command {
    let video = flags::video().help(
        "Video file, TIFF file of several pages, folder of images, folder of a CDnet or MOTChallenge sequence, \
         pattern such as in%06d.png, camera:0, or address such as rtsp://host/stream to open in the window \
         [default: a bundled sample]",
    );
    let memory = Arg::new("memory")
        .long("memory")
        .value_name("MIB")
        .value_parser(value_parser!(u64).range(16..=1 << 30))
        .help(
            "Memory budget for decoded frames and checkpoints, in MiB [default: a quarter of the \
         machine's memory]",
        );
    let truth = Arg::new("truth")
        .long("truth")
        .value_name("PATH")
        .value_parser(value_parser!(PathBuf))
        .help(format!("Ground truth for scoring: {}", flags::TRUTH));
    let command = command.arg(video).arg(truth).arg(memory);
    flags::with_common(flags::with_settings(flags::with_roi(source_flags::with_options(command))))
}

/// Opens the window and returns when it is closed.
pub(super) fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    let settings = flags::settings(matches)?;
    let roi = flags::roi(matches)?;
    let truth = matches.get_one::<PathBuf>("truth").cloned();
    if let Some(truth) = &truth {
        // Only its kind is detected here; the session reads it.
        TruthSource::of(truth)?;
    }
    flags::start_threads(matches)?;
    let memory = matches.get_one::<u64>("memory").map(|&mib| mib as usize * (1 << 20));
    let options = source_flags::options(matches)?;
    open(matches.get_one::<String>("video").cloned(), options, settings, roi, truth, memory)
}

#[cfg(feature = "gui")]
fn open(
    video: Option<String>,
    options: Options,
    settings: Settings,
    roi: Option<Arc<Roi>>,
    truth: Option<PathBuf>,
    memory: Option<usize>,
) -> anyhow::Result<()> {
    crate::app::run(crate::app::Opening { video, options, settings, roi, truth, memory })
}

#[cfg(not(feature = "gui"))]
fn open(
    video: Option<String>,
    _: Options,
    _: Settings,
    _: Option<Arc<Roi>>,
    _: Option<PathBuf>,
    _: Option<usize>,
) -> anyhow::Result<()> {
    let video = video.unwrap_or_else(|| "VIDEO".to_owned());
    anyhow::bail!(
        "this build has no window; analyse with `occluscope run {video} --out DIR`, or build without \
         `--no-default-features`"
    )
}
