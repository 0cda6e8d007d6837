//! The program: the window, or a subcommand.

use std::process::ExitCode;

fn main() -> ExitCode {
    occluscope::cli::main(std::env::args_os())
}
