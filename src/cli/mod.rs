//! The command line: one file or folder per subcommand, and shared code.
//!
//! Exit status 0 is success, 1 a failure of the work, 2 wrong usage. A failure prints one line to stderr.

pub mod bench;
mod console;
pub mod export;
mod file_limit;
mod flags;
mod frames;
mod inputs;
mod interrupt;
pub mod model;
mod out_file;
pub mod pixel;
pub mod run;
pub mod score;
mod scored_results;
pub mod settings;
mod source_flags;
mod staged_file;
mod standard_output;
pub mod sweep;
pub mod synth;
mod window;

use std::env;
use std::ffi::OsString;
use std::io::{self, Write};
use std::panic::{self, AssertUnwindSafe};
use std::process::ExitCode;

use clap::{ArgMatches, Command};

pub use flags::UsageError;

use crate::settings::SettingError;

const ABOUT: &str =
    "A desktop microscope for background models, moving regions, tracks and occlusions in video";

const AFTER_HELP: &str = "\
Examples:
  occluscope                                  open the window on a bundled sample
  occluscope street.mp4 --preset paper        open a video with the paper's own settings
  occluscope run street.mp4 --out results     analyse without a display
  occluscope score results --truth gt.txt     compare the results with ground truth
  occluscope export results --format coco     convert the tracks for other tools
  occluscope sweep street.mp4 --truth gt.txt --grid k=3,4,5 --out swept
                                              compare settings by their scores
  occluscope pixel street.mp4 --at 320,240    one pixel's mixture at every frame, as CSV
  occluscope settings > my.toml               every setting with its range and meaning

VIDEO is a video file, a TIFF file of several pages, a folder of images, the folder of a CDnet or
MOTChallenge sequence, a pattern such as in%06d.png, camera:0, or an address such as rtsp://host/stream.
`occluscope COMMAND --help` shows details; `--help` lists every setting, `-h` omits them.";

/// Defines the whole command line.
pub fn command() -> Command {
    let program = Command::new("occluscope")
        .version(env!("OCCLUSCOPE_VERSION"))
        .about(ABOUT)
        .after_help(AFTER_HELP)
        .subcommand_value_name("COMMAND")
        .args_conflicts_with_subcommands(true)
        .subcommand_precedence_over_arg(false)
        .subcommand(run::command())
        .subcommand(pixel::command())
        .subcommand(model::command())
        .subcommand(score::command())
        .subcommand(export::command())
        .subcommand(sweep::command())
        .subcommand(bench::command())
        .subcommand(settings::command())
        .subcommand(flags::with_common(synth::command()));
    window::with_arguments(program)
}

/// Runs the program with these arguments, the first being the program's name.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    crate::source::silence_libraries();
    file_limit::make_an_error();
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let matches = match command().try_get_matches_from(&arguments) {
        Ok(matches) => matches,
        Err(error) if error.use_stderr() => {
            // Where stderr is closed, the message is dropped.
            let _ = writeln!(io::stderr(), "{}", usage_line(&error.to_string(), &arguments));
            return ExitCode::from(error.exit_code() as u8);
        }
        Err(help) => {
            return match help.print().and_then(|()| io::stdout().flush()) {
                Ok(()) => ExitCode::SUCCESS,
                Err(error) => report(&standard_output::failure(error)),
            };
        }
    };
    install_panic_hook();
    // Unwinding removes incomplete output.
    match panic::catch_unwind(AssertUnwindSafe(|| dispatch(&matches))) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(error)) => report(&error),
        Err(_) => ExitCode::FAILURE,
    }
}

/// A message of clap about wrong usage in one line, with the command whose help says what is right.
fn usage_line(message: &str, arguments: &[OsString]) -> String {
    let mut line = String::new();
    for part in message.lines().map(str::trim).filter(|part| !part.is_empty()) {
        if part.starts_with("Usage:") || part.starts_with("For more information") {
            break;
        }
        // Arguments that look like flags are no values here.
        if part.starts_with("tip: to pass") {
            continue;
        }
        line += match () {
            () if line.is_empty() => "",
            () if line.ends_with(':') => " ",
            () if part.starts_with("tip: ") => "; ",
            () => ", ",
        };
        line += part.strip_prefix("tip: ").unwrap_or(part);
    }
    let name = arguments.get(1).map(|name| name.to_string_lossy());
    let subcommand = name.filter(|name| command().find_subcommand(&**name).is_some());
    let help = subcommand.map_or_else(|| "--help".to_owned(), |name| format!("{name} --help"));
    format!("{line}; see occluscope {help}")
}

fn dispatch(matches: &ArgMatches) -> anyhow::Result<()> {
    match matches.subcommand() {
        Some(("run", matches)) => run::run(matches),
        Some(("pixel", matches)) => pixel::run(matches),
        Some(("model", matches)) => model::run(matches),
        Some(("score", matches)) => score::run(matches),
        Some(("export", matches)) => export::run(matches),
        Some(("sweep", matches)) => sweep::run(matches),
        Some(("bench", matches)) => bench::run(matches),
        Some(("settings", matches)) => settings::run(matches),
        Some(("synth", matches)) => flags::start_threads(matches).and_then(|()| synth::run(matches)),
        _ => window::run(matches),
    }
}

/// Reports a panic in one line, or with a backtrace if one is requested.
fn install_panic_hook() {
    if env::var_os("RUST_BACKTRACE").is_none() {
        panic::set_hook(Box::new(|bug| {
            let line = bug.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
            let _ = writeln!(
                io::stderr(),
                "error: bug in occluscope: {line}; please report it with the output of RUST_BACKTRACE=1"
            );
        }));
    }
}

/// Prints the error in one line and returns the exit status.
fn report(error: &anyhow::Error) -> ExitCode {
    let closed_pipe = error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<io::Error>())
        .any(|cause| cause.kind() == io::ErrorKind::BrokenPipe);
    if closed_pipe {
        return ExitCode::SUCCESS;
    }
    // Where stderr is closed, the message is dropped.
    let _ = writeln!(io::stderr(), "error: {}", console::one_line(&format!("{error:#}")));
    let wrong_usage = error.chain().any(|cause| {
        cause.downcast_ref::<UsageError>().is_some() || cause.downcast_ref::<SettingError>().is_some()
    });
    ExitCode::from(if wrong_usage { 2 } else { 1 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_valid() {
        command().debug_assert();
    }

    #[test]
    fn ground_truth_is_the_same_in_every_command() {
        let root = command();
        let mut count = 0;
        for command in std::iter::once(&root).chain(root.get_subcommands()) {
            for argument in command.get_arguments().filter(|argument| argument.get_id() == "truth") {
                let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
                assert!(help.contains(flags::TRUTH), "{}: {help}", command.get_name());
                count += 1;
            }
        }
        assert_eq!(count, 3);
    }
}
