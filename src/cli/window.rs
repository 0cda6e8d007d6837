//! `occluscope [VIDEO]`: the window.

use clap::{ArgMatches, Command};

use super::flags;
use crate::settings::Settings;

/// Adds what the window takes.
pub(super) fn with_arguments(command: Command) -> Command {
    let video = flags::video().help(
        "Open the window on a video file, a folder of images, a pattern such as in%06d.png, or camera:0; \
         without it, on a bundled sample",
    );
    flags::with_common(flags::with_settings(command.arg(video)))
}

/// Opens the window and returns when it is closed.
pub(super) fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    let settings = flags::settings(matches)?;
    flags::start_threads(matches)?;
    open(matches.get_one::<String>("video").cloned(), settings)
}

#[cfg(feature = "gui")]
fn open(video: Option<String>, settings: Settings) -> anyhow::Result<()> {
    crate::app::run(video, settings)
}

#[cfg(not(feature = "gui"))]
fn open(video: Option<String>, _: Settings) -> anyhow::Result<()> {
    let video = video.unwrap_or_else(|| "VIDEO".to_owned());
    anyhow::bail!(
        "this build has no window; analyse with `occluscope run {video} --out DIR`, or build it without `--no-default-features`"
    )
}
