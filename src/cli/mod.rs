//! The command line: one file per subcommand, and what they share.
//!
//! Exit status 0: done, 1: the work failed, 2: wrong usage. A failure is one line on stderr.

pub mod bench;
mod console;
mod flags;
mod frames;
mod interrupt;
pub mod pixel;
pub mod run;
pub mod score;
pub mod settings;
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
  occluscope pixel street.mp4 --at 320,240    one pixel's mixture at every frame, as CSV
  occluscope settings > my.toml               every setting with its range and meaning

VIDEO is a video file, a folder of images, a pattern such as in%06d.png, or camera:0.
`occluscope COMMAND --help` shows details; `--help` lists every setting, `-h` omits them.";

/// The whole command line.
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
        .subcommand(score::command())
        .subcommand(bench::command())
        .subcommand(settings::command())
        .subcommand(flags::with_common(synth::command()));
    window::with_arguments(program)
}

/// Runs the program with these arguments, the first being its own name.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    crate::source::silence_libraries();
    let matches = match command().try_get_matches_from(arguments) {
        Ok(matches) => matches,
        Err(error) => {
            // A closed pipe after `--help | head` is nobody's failure.
            let _ = error.print();
            return ExitCode::from(error.exit_code() as u8);
        }
    };
    tell_bugs_in_one_line();
    // Unwinding takes away what was half written.
    match panic::catch_unwind(AssertUnwindSafe(|| dispatch(&matches))) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(error)) => report(&error),
        Err(_) => ExitCode::FAILURE,
    }
}

fn dispatch(matches: &ArgMatches) -> anyhow::Result<()> {
    match matches.subcommand() {
        Some(("run", matches)) => run::run(matches),
        Some(("pixel", matches)) => pixel::run(matches),
        Some(("score", matches)) => score::run(matches),
        Some(("bench", matches)) => bench::run(matches),
        Some(("settings", matches)) => settings::run(matches),
        Some(("synth", matches)) => flags::start_threads(matches).and_then(|()| synth::run(matches)),
        _ => window::run(matches),
    }
}

/// A bug is told in one line, too; who asks for a backtrace gets it.
fn tell_bugs_in_one_line() {
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

/// Tells what went wrong in one line and gives the exit status.
fn report(error: &anyhow::Error) -> ExitCode {
    let closed_pipe = error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<io::Error>())
        .any(|cause| cause.kind() == io::ErrorKind::BrokenPipe);
    if closed_pipe {
        return ExitCode::SUCCESS;
    }
    let line = format!("{error:#}").split_whitespace().collect::<Vec<_>>().join(" ");
    // Where stderr is closed, there is nobody to tell.
    let _ = writeln!(io::stderr(), "error: {line}");
    let wrong_usage = error.chain().any(|cause| {
        cause.downcast_ref::<UsageError>().is_some() || cause.downcast_ref::<SettingError>().is_some()
    });
    ExitCode::from(if wrong_usage { 2 } else { 1 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_sound() {
        command().debug_assert();
    }
}
