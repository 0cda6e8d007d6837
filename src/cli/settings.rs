//! `occluscope settings`: every setting, its default, range and meaning, as commented TOML.

use std::io::Write as _;

use clap::{ArgMatches, Command};

use super::{flags, standard_output};

/// Defines the subcommand.
pub fn command() -> Command {
    let command = Command::new("settings")
        .about("Print every setting with its range, default and meaning, as a settings file")
        .after_help(
            "Examples:\n  occluscope settings > my.toml\n  occluscope settings --preset paper --k 3 > paper3.toml\n  occluscope run street.mp4 --settings paper3.toml --out results",
        );
    flags::with_settings(command)
}

/// Prints the requested settings.
pub fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    let settings = flags::settings(matches)?;
    standard_output::write(|out| Ok(out.write_all(settings.to_toml().as_bytes())?))
}
