//! The flags of the source's options.

use std::num::NonZeroU32;
use std::path::Path;

use clap::{Arg, ArgAction, ArgMatches, Command};

use super::console::Console;
use super::flags::UsageError;
use crate::placement::Crop;
use crate::source::{
    FPS_RANGE, FpsFrom, Levels, Options, SCALE_RANGE, SceneFolder, SourceInfo, parse_crop, parse_fps,
    parse_scale, path_of,
};
use crate::truth::TruthSource;

/// Adds a flag for each option of the source.
pub(super) fn with_options(command: Command) -> Command {
    let option = |name: &'static str, value: &'static str, help: &'static str| {
        Arg::new(name).long(name).value_name(value).allow_hyphen_values(true).help(help)
    };
    command
        .arg(option(
            "fps",
            "N",
            "Frames per second of the source, if it has none or a wrong value [default: from the video, or \
             `frameRate` in seqinfo.ini in the image folder or its parent, else 25]",
        ))
        .arg(option(
            "levels",
            "LOW..HIGH|auto",
            "The stored values of images that become 0 and 255, as in 0..4095 for a camera of 12 bits in 16-bit \
             files; those between are scaled linearly, those beyond are clamped. `auto`: the least and the greatest \
             value of up to 16 images at equal steps through the sequence. Not for videos, which are decoded to 8 \
             bits [default: the range of 8 or 16 bits, 0..1 of real numbers]",
        ))
        .arg(Arg::new("deinterlace").long("deinterlace").action(ArgAction::SetTrue).help(
            "Make one picture of the two fields of each frame of an interlaced video file, so that moving edges do not \
             look like combs",
        ))
        .arg(option(
            "stream",
            "N",
            "Index of the stream of a video file with several, as `ffprobe` prints it [default: the one that `ffmpeg` \
             selects]",
        ))
        .arg(option(
            "scale",
            "S",
            "Reduce the images by this factor before the analysis, 0.01–1; files have the source's pixels",
        ))
        .arg(option(
            "every",
            "N",
            "Analyse the source's first frame and each N-th after it; frames keep their numbers",
        ))
        .arg(option(
            "crop",
            "X,Y,W,H",
            "Analyse only this part of the images, in the source's pixels; it is cut out before scaling",
        ))
}

/// The options of the source.
pub(super) fn options(matches: &ArgMatches) -> Result<Options, UsageError> {
    Ok(Options { scale: scale(matches)?, ..unscaled_options(matches)? })
}

/// The options of the source, except the scale.
pub(super) fn unscaled_options(matches: &ArgMatches) -> Result<Options, UsageError> {
    Ok(Options {
        fps: fps(matches)?,
        levels: levels(matches)?,
        deinterlace: matches.get_flag("deinterlace"),
        stream: stream(matches)?,
        scale: None,
        every: every(matches)?,
        crop: crop(matches)?,
    })
}

fn fps(matches: &ArgMatches) -> Result<Option<f32>, UsageError> {
    let (least, greatest) = FPS_RANGE;
    parsed(matches, "fps", parse_fps, &format!("the range is {least}–{greatest} frames per second"))
}

fn stream(matches: &ArgMatches) -> Result<Option<u32>, UsageError> {
    parsed(matches, "stream", |text| text.trim().parse().ok(), "give the index of a stream, as in 1")
}

/// 1 leaves the images as they are.
fn scale(matches: &ArgMatches) -> Result<Option<f32>, UsageError> {
    let (least, greatest) = SCALE_RANGE;
    let scale = parsed(matches, "scale", parse_scale, &format!("the range is {least}–{greatest}"))?;
    Ok(scale.filter(|&scale| scale < greatest))
}

/// 1 leaves no frame out.
fn every(matches: &ArgMatches) -> Result<Option<NonZeroU32>, UsageError> {
    let parse = |text: &str| text.trim().parse().ok();
    let every = parsed(matches, "every", parse, "give a whole number from 1, as in 5")?;
    Ok(every.filter(|&every| every > NonZeroU32::MIN))
}

fn crop(matches: &ArgMatches) -> Result<Option<Crop>, UsageError> {
    let expected = "give column, row, width and height of a part of the images, as in 100,50,640,480";
    parsed(matches, "crop", parse_crop, expected)
}

/// The value of an option, or an error that says what is expected.
fn parsed<T>(
    matches: &ArgMatches,
    name: &str,
    parse: impl Fn(&str) -> Option<T>,
    expected: &str,
) -> Result<Option<T>, UsageError> {
    let Some(text) = matches.get_one::<String>(name) else { return Ok(None) };
    parse(text).map(Some).ok_or_else(|| UsageError(format!("--{name} cannot be `{text}`: {expected}")))
}

fn levels(matches: &ArgMatches) -> Result<Option<Levels>, UsageError> {
    let parse = |text: &str| text.parse().ok().filter(|levels: &Levels| levels.is_valid());
    parsed(matches, "levels", parse, "give two values in ascending order, as in 0..4095, or auto")
}

/// Prints a note if the folder of the sequence has ground truth for the results in `out`.
pub(super) fn note_truth(video: &str, out: &Path, has_masks: bool, console: Console) {
    let Some(truth) = SceneFolder::at(&path_of(video)).and_then(|scene| scene.truth) else { return };
    let needs_masks = matches!(TruthSource::of(&truth), Ok(TruthSource::Cdnet(_))) && !has_masks;
    console.note(&format!(
        "note: {video} has ground truth{}; score the results with occluscope score {} --truth {}",
        if needs_masks { " of masks, which need --masks" } else { "" },
        out.display(),
        truth.display()
    ));
}

/// Prints a note if the frame rate is assumed.
pub(super) fn note_assumed_fps(info: &SourceInfo, console: Console) {
    if info.fps_from == FpsFrom::Assumed {
        console.note(&format!(
            "note: {} has no frame rate, {} frames per second are assumed; set it with --fps N",
            info.name,
            info.source_fps()
        ));
    }
}
