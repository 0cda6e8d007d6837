//! Arguments shared by the subcommands: settings, threads, verbosity, a range of frames.

use std::fmt;
use std::num::NonZero;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;

use anyhow::{Context as _, anyhow};
use clap::builder::{OsStringValueParser, TypedValueParser};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};

use crate::regions::Roi;
use crate::settings::file::read_text;
use crate::settings::{BackgroundModel, Kind, Preset, SETTINGS, Settings};
use crate::source::name_of;

/// An error of usage, independent of the contents of files: exit status 2.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);

/// The first argument, VIDEO.
pub(super) fn video() -> Arg {
    Arg::new("video").value_name("VIDEO").value_parser(source_name()).help(
        "A video file, a TIFF file of several pages, a folder of images, the folder of a CDnet or MOTChallenge \
         sequence, a pattern such as in%06d.png, camera:0, or an address such as rtsp://host/stream",
    )
}

/// A name of a source, also of a path that is no text.
pub(super) fn source_name() -> impl TypedValueParser<Value = String> {
    OsStringValueParser::new().map(name_of)
}

/// What ground truth can be: the readers that all commands and the window share.
pub(super) const TRUTH: &str = "tracks (MOTChallenge text or its sequence folder, CVAT XML, CAVIAR's CVML, COCO JSON, a \
     folder of label images), masks (a CDnet folder, or a folder of masks of 0 and 255), or a scene written by `synth`";

/// `--offset`.
pub(super) fn offset() -> Arg {
    Arg::new("offset")
        .long("offset")
        .value_name("N")
        .allow_negative_numbers(true)
        .value_parser(value_parser!(i64).range(-(1 << 32)..=1 << 32))
        .default_value("0")
        .help("Add N to the frame numbers of the ground truth")
}

/// Adds `--preset`, `--settings` and a flag for every setting.
pub(super) fn with_settings(command: Command) -> Command {
    let presets: Vec<_> =
        Preset::ALL.iter().map(|preset| format!("`{}`: {}", preset.word(), preset.meaning())).collect();
    let command = command
        .arg(
            Arg::new("preset")
                .long("preset")
                .value_name("NAME")
                .help(format!("Settings to start from. {} [default: default]", presets.join("; "))),
        )
        .arg(
            Arg::new("settings")
                .long("settings")
                .value_name("FILE.toml")
                .value_parser(value_parser!(PathBuf))
                .help(
                    "Settings file; overrides the preset, flags override both. `occluscope settings` \
                 writes one",
                ),
        );
    let defaults = Settings::default();
    SETTINGS.iter().fold(command, |command, setting| {
        let symbol = if setting.symbol.is_empty() { String::new() } else { format!("{}: ", setting.symbol) };
        let unit = if setting.unit.is_empty() { String::new() } else { format!(" {}", setting.unit) };
        let range = setting.kind.range(setting.symbol);
        command.arg(
            Arg::new(setting.name)
                .long(setting.flag())
                .value_name(match setting.kind {
                    Kind::Integer { .. } | Kind::OddSize { .. } => "N",
                    Kind::Real { .. } => "NUMBER",
                    Kind::Choice(_) => "WORD",
                    Kind::Span { .. } => "TIME",
                })
                .help(format!(
                    "{symbol}{} [{range}{unit}] [default: {}]",
                    setting.meaning.trim(),
                    setting.get(&defaults)
                ))
                .help_heading(setting.stage.name())
                .hide_short_help(true)
                .allow_negative_numbers(true),
        )
    })
}

/// The requested settings: the preset, overridden by the file, overridden by the flags.
pub(super) fn settings(matches: &ArgMatches) -> anyhow::Result<Settings> {
    let preset = match matches.get_one::<String>("preset") {
        Some(word) => Preset::from_word(word)
            .ok_or_else(|| crate::settings::SettingError::UnknownPreset(word.clone()))?,
        None => Preset::Default,
    };
    let mut settings = Settings::preset(preset);
    if let Some(path) = matches.get_one::<PathBuf>("settings") {
        let text = read_text(path).map_err(|error| {
            anyhow!(
                "the settings file {} cannot be read: {error}; check its path and permissions, or choose another file",
                path.display()
            )
        })?;
        settings.apply_toml(&text, path)?;
    }
    for setting in SETTINGS {
        if let Some(text) = matches.get_one::<String>(setting.name) {
            setting.set_text(&mut settings, text)?;
        }
    }
    Ok(settings)
}

/// Refuses a background model that has no mixture.
pub(super) fn require_mixture(settings: &Settings) -> Result<(), UsageError> {
    let model = settings.background_model;
    if model == BackgroundModel::Mixture {
        return Ok(());
    }
    let word = model.word();
    Err(UsageError(format!("the background model `{word}` has no mixture; omit --background-model {word}")))
}

/// Adds `--threads`, `--quiet` and `-v`.
pub(super) fn with_common(command: Command) -> Command {
    command
        .arg(
            Arg::new("threads")
                .long("threads")
                .value_name("N")
                .value_parser(value_parser!(u16).range(1..=1024))
                .help(
                    "Number of threads, at least 1; results do not depend on it [default: one per processor]",
                ),
        )
        .arg(
            Arg::new("quiet")
                .long("quiet")
                .short('q')
                .action(ArgAction::SetTrue)
                .help("No progress and no notes on stderr; errors are always printed"),
        )
        .arg(
            Arg::new("verbose")
                .long("verbose")
                .short('v')
                .action(ArgAction::SetTrue)
                .conflicts_with("quiet")
                .help("Print more details on stderr"),
        )
}

/// Sets the size of the thread pool.
pub(super) fn start_threads(matches: &ArgMatches) -> anyhow::Result<()> {
    let threads = matches.get_one::<u16>("threads").copied();
    if let Some(threads) = threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.into())
            .build_global()
            .with_context(|| format!("{threads} threads cannot be started; use fewer"))?;
    }
    // OpenCV's pool warns of more threads than processors, also where an environment variable asks for them.
    let processors = thread::available_parallelism().map_or(1, NonZero::get);
    let threads = threads.map_or(processors, |threads| processors.min(threads.into()));
    opencv::core::set_num_threads(threads as i32).map_err(|error| anyhow!("OpenCV: {error}"))
}

/// Adds `--range`.
pub(super) fn with_range(command: Command) -> Command {
    command.arg(
        Arg::new("range")
            .long("range")
            .value_name("A..B")
            .allow_hyphen_values(true)
            .help("Only frames A to B, inclusive, in source numbering; the model starts at A"),
    )
}

/// The requested frames, `None` for all.
pub(super) fn range(matches: &ArgMatches) -> Result<Option<FrameRange>, UsageError> {
    let Some(text) = matches.get_one::<String>("range") else { return Ok(None) };
    let parsed = text.split_once("..").and_then(|(first, last)| {
        Some(FrameRange { first: frame_number(first)?, last: frame_number(last)? })
    });
    match parsed {
        Some(range) if range.first <= range.last => Ok(Some(range)),
        _ => Err(UsageError(format!(
            "--range cannot be `{text}`: give two frame numbers in ascending order, as in 100..250"
        ))),
    }
}

/// A frame number; one beyond the greatest possible is that.
fn frame_number(text: &str) -> Option<u32> {
    use std::num::IntErrorKind::PosOverflow;
    match text.trim().parse() {
        Ok(number) => Some(number),
        Err(error) => (*error.kind() == PosOverflow).then_some(u32::MAX),
    }
}

/// Adds `--roi`.
pub(super) fn with_roi(command: Command) -> Command {
    command.arg(Arg::new("roi").long("roi").value_name("MASK.png").value_parser(value_parser!(PathBuf)).help(
        "Analyse only the bright pixels (128 or more) of this image of the source's size; foreground \
             elsewhere is removed before post-processing",
    ))
}

/// The region of interest, `None` for the whole image.
pub(super) fn roi(matches: &ArgMatches) -> anyhow::Result<Option<Arc<Roi>>> {
    let path = matches.get_one::<PathBuf>("roi");
    Ok(path.map(|path| Roi::read(path)).transpose()?.map(Arc::new))
}

/// An inclusive range of frame numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FrameRange {
    /// The first number.
    pub first: u32,
    /// The last number.
    pub last: u32,
}

impl FrameRange {
    /// The number of frames, at most `u32::MAX`.
    pub(super) const fn count(self) -> u32 {
        (self.last - self.first).saturating_add(1)
    }
}

impl fmt::Display for FrameRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.first, self.last)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn parsed(arguments: &[&str]) -> ArgMatches {
        let command = with_range(with_common(with_settings(Command::new("test"))));
        command.try_get_matches_from([&["test"], arguments].concat()).unwrap()
    }

    #[test]
    fn flags_override_the_file_and_the_file_overrides_the_preset() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("my.toml");
        std::fs::write(&path, "k = 6\nalpha = 0.25\n").unwrap();
        let path = path.to_str().unwrap();
        let settings = settings(&parsed(&["--preset", "paper", "--settings", path, "--k", "2"])).unwrap();
        let expected = Settings { k: 2, alpha: 0.25, ..Settings::preset(Preset::Paper) };
        assert_eq!(settings, expected);
    }

    #[test]
    fn every_setting_has_a_flag() {
        for setting in SETTINGS {
            let value = setting.get(&Settings::preset(Preset::OpencvMog)).to_string();
            let flag = format!("--{}={value}", setting.flag());
            let read = settings(&parsed(&[&flag])).unwrap();
            assert_eq!(setting.get(&read).to_string(), value, "{flag}");
        }
    }

    #[test]
    fn a_negative_number_is_refused_as_a_value_and_not_parsed_as_a_flag() {
        let error = settings(&parsed(&["--alpha", "-1"])).unwrap_err().to_string();
        assert!(error.contains("0 < α < 1"), "{error}");
    }

    #[test]
    fn ranges_are_two_numbers_in_order() {
        assert_eq!(range(&parsed(&[])).unwrap(), None);
        assert_eq!(range(&parsed(&["--range", "3..3"])).unwrap(), Some(FrameRange { first: 3, last: 3 }));
        let all = range(&parsed(&["--range", "0..4294967295"])).unwrap().unwrap();
        assert_eq!(all.count(), u32::MAX);
        let beyond = range(&parsed(&["--range", "1..99999999999"])).unwrap();
        assert_eq!(beyond, Some(FrameRange { first: 1, last: u32::MAX }));
        for text in ["", "5", "5..", "..5", "5..4", "a..b", "1...4", "-1..4", "1..-99999999999"] {
            assert!(range(&parsed(&["--range", text])).is_err(), "{text}");
        }
    }
}
