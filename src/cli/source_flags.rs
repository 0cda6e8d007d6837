//! The flags of the source's options.

use clap::{Arg, ArgMatches, Command};

use super::console::Console;
use super::flags::UsageError;
use crate::source::{FPS_RANGE, FpsFrom, Options, SourceInfo, parse_fps};

/// Adds a flag for each option of the source.
pub(super) fn with_options(command: Command) -> Command {
    command.arg(Arg::new("fps").long("fps").value_name("N").allow_hyphen_values(true).help(
        "Frames per second, if the source has none or a wrong value [default: from the video, or \
         `frameRate` in seqinfo.ini in the image folder or its parent, else 25]",
    ))
}

/// The options of the source.
pub(super) fn options(matches: &ArgMatches) -> Result<Options, UsageError> {
    Ok(Options { fps: fps(matches)? })
}

fn fps(matches: &ArgMatches) -> Result<Option<f32>, UsageError> {
    let Some(text) = matches.get_one::<String>("fps") else { return Ok(None) };
    let (least, greatest) = FPS_RANGE;
    parse_fps(text).map(Some).ok_or_else(|| {
        UsageError(format!("--fps cannot be `{text}`: the range is {least}–{greatest} frames per second"))
    })
}

/// Prints a note if the frame rate is assumed.
pub(super) fn note_assumed_fps(info: &SourceInfo, console: Console) {
    if info.fps_from == FpsFrom::Assumed {
        console.note(&format!(
            "note: {} has no frame rate, {} frames per second are assumed; set it with --fps N",
            info.name, info.fps
        ));
    }
}
