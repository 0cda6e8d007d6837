//! `occluscope [VIDEO]`: the window.

use std::sync::Arc;

use clap::{Arg, ArgMatches, Command, value_parser};

use super::flags;
use crate::regions::Roi;
use crate::settings::Settings;

/// Adds what the window takes.
pub(super) fn with_arguments(command: Command) -> Command {
    let video = flags::video().help(
        "Open the window on a video file, a folder of images, a pattern such as in%06d.png, or camera:0; \
         without it, on a bundled sample",
    );
    let memory = Arg::new("memory")
        .long("memory")
        .value_name("MIB")
        .value_parser(value_parser!(u64).range(16..=1 << 30))
        .help("Memory for decoded frames and for going back in time, in MiB [default: a quarter of the machine's]");
    flags::with_common(flags::with_settings(flags::with_roi(command.arg(video).arg(memory))))
}

/// Opens the window and returns when it is closed.
pub(super) fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    let settings = flags::settings(matches)?;
    let roi = flags::roi(matches)?;
    flags::start_threads(matches)?;
    let memory = matches.get_one::<u64>("memory").map(|&mib| mib as usize * (1 << 20));
    open(matches.get_one::<String>("video").cloned(), settings, roi, memory)
}

#[cfg(feature = "gui")]
fn open(
    video: Option<String>,
    settings: Settings,
    roi: Option<Arc<Roi>>,
    memory: Option<usize>,
) -> anyhow::Result<()> {
    crate::app::run(video, settings, roi, memory)
}

#[cfg(not(feature = "gui"))]
fn open(video: Option<String>, _: Settings, _: Option<Arc<Roi>>, _: Option<usize>) -> anyhow::Result<()> {
    let video = video.unwrap_or_else(|| "VIDEO".to_owned());
    anyhow::bail!(
        "this build has no window; analyse with `occluscope run {video} --out DIR`, or build it without `--no-default-features`"
    )
}
