//! `occluscope pixel`: one pixel's mixture at every frame, as CSV.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context as _, bail};
use clap::{Arg, ArgMatches, Command, value_parser};

use super::console::Console;
use super::flags::{self, FrameRange, UsageError};
use super::frames::{Frames, Item};
use super::out_file::OutFile;
use super::{inputs, interrupt, source_flags, standard_output};
use crate::explain::pixel::PixelHistory;
use crate::export::pixel_csv;
use crate::export::staging::IsFolder;
use crate::mixture::Parameters;
use crate::placement::Crop;
use crate::regions::Roi;
use crate::registration::CorrectionChoice;
use crate::settings::Settings;
use crate::source::Options;

/// Defines the subcommand.
pub fn command() -> Command {
    let command = Command::new("pixel")
        .about("Write one pixel's mixture at every frame as CSV")
        .after_help(
            "Columns: frame, the value, matched (rank before the update, 0: none), rank (after it), \
             background_count (B), foreground (0 or 1), rho, p, and for each component in rank order w, \
             mu, var. The values are the mixture's only; a note is printed if --roi excludes the pixel. \
             There is one row per evaluated frame; with `bootstrap` the model is trained before the first \
             one.\n\nExamples:\n  occluscope pixel street.mp4 --at 320,240 --out pixel.csv\n  occluscope \
             pixel street.mp4 --at 320,240 --k 3 --range 100..200 | head",
        )
        .arg(flags::video().required(true))
        .arg(
            Arg::new("at")
                .long("at")
                .value_name("X,Y")
                .required(true)
                .allow_hyphen_values(true)
                .help("The pixel of the source as column and row; the upper left pixel is 0,0"),
        )
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("FILE.csv")
                .value_parser(value_parser!(PathBuf))
                .help("Output file [default: stdout]"),
        );
    flags::with_settings(flags::with_common(flags::with_roi(flags::with_range(source_flags::with_options(
        command,
    )))))
}

/// Follows the pixel through the video.
pub fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    let settings = flags::settings(matches)?;
    let range = flags::range(matches)?;
    let at = at(matches)?;
    flags::require_mixture(&settings)?;
    flags::start_threads(matches)?;
    let follow = Follow {
        video: text(matches, "video"),
        at,
        settings: &settings,
        roi: flags::roi(matches)?,
        range,
        options: source_flags::options(matches)?,
        console: Console::new(matches),
    };
    if let Some(path) = matches.get_one::<PathBuf>("out") {
        inputs::protect(&inputs::of_command(matches), [(path.as_path(), IsFolder::No)])?;
        let (mut frames, at) = follow.open()?;
        return OutFile::begin(path)?.write(|out| follow.write_frames(&mut frames, at, out));
    }
    let (mut frames, at) = follow.open()?;
    standard_output::write(|out| follow.write_frames(&mut frames, at, out))
}

fn text<'a>(matches: &'a ArgMatches, name: &str) -> &'a str {
    matches.get_one::<String>(name).map_or("", String::as_str)
}

fn at(matches: &ArgMatches) -> Result<(u32, u32), UsageError> {
    let text = text(matches, "at");
    text.split_once(',')
        .and_then(|(x, y)| Some((x.trim().parse().ok()?, y.trim().parse().ok()?)))
        .ok_or_else(|| UsageError(format!("--at cannot be `{text}`: give column and row, as in 320,240")))
}

struct Follow<'a> {
    video: &'a str,
    /// The pixel of the source's images.
    at: (u32, u32),
    settings: &'a Settings,
    roi: Option<Arc<Roi>>,
    range: Option<FrameRange>,
    options: Options,
    console: Console,
}

impl Follow<'_> {
    /// Opens the video. Returns the pixel of its frames, too.
    fn open(&self) -> anyhow::Result<(Frames, (u32, u32))> {
        let frames =
            Frames::open(self.video, self.options, self.range, Some(CorrectionChoice::new(self.settings)))?;
        let info = &frames.info;
        let (x, y) = self.at;
        let size = info.source_size();
        if size.index(x, y).is_none() {
            bail!(
                "pixel {x},{y} is outside {}, which is {size}; choose a column in 0–{} and a row in 0–{}",
                self.video,
                size.width - 1,
                size.height - 1
            );
        }
        let placement = info.placement();
        let at = match &placement {
            None => (x, y),
            Some(placement) => placement.frame_pixel(self.at).with_context(|| {
                let Crop { x: left, y: top, width, height } = placement.crop();
                format!(
                    "pixel {x},{y} is outside the crop of {}; choose a column in {left}–{} and a row in {top}–{}",
                    self.video,
                    left + width - 1,
                    top + height - 1
                )
            })?,
        };
        if let Some(roi) = &self.roi {
            let roi = Roi::of_frames(roi, info.size, placement.as_ref())?;
            if !roi.contains(at.0, at.1) {
                self.console.note(&format!(
                    "note: pixel {x},{y} lies outside the analysed area: foreground verdicts of the \
                     mixture are removed by a later stage"
                ));
            }
        }
        Ok((frames, at))
    }

    fn write_frames(&self, frames: &mut Frames, at: (u32, u32), out: &mut impl Write) -> anyhow::Result<()> {
        let parameters = Parameters::new(self.settings);
        let mut history = PixelHistory::new(at, parameters);
        frames.learn(self.settings, self.console, |frames| {
            for frame in frames {
                history.learn(frame);
            }
            Ok(())
        })?;
        let progress = self.console.progress("analysing pixel", frames.total);
        let live = frames.info.live;
        for item in frames.items() {
            if interrupt::is_stop_requested() && !live {
                bail!("stopped before the end of {}", self.video);
            }
            match item {
                Item::Frame(frame) => {
                    if history.states.is_empty() {
                        pixel_csv::write_header(out, &parameters)?;
                    }
                    history.push(&frame);
                    if let Some(state) = history.states.last() {
                        pixel_csv::write_row(out, &parameters, state)?;
                    }
                    progress.advance(1);
                }
                Item::Warning(text) => progress.warn(&text),
                Item::Failed(error) => return Err(error),
                Item::End => break,
            }
        }
        Ok(())
    }
}
