//! The command line, one argument a line, and the texts that stand for several values: grids, crops, rates, levels.

use std::cell::RefCell;
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;

use clap::Command;
use occluscope::cli;
use occluscope::settings::{SETTINGS, Settings};
use occluscope::source::{self, Levels};
use occluscope::sweep::grid::{Axis, Grid};

use super::check_message;

thread_local! {
    /// The command line, which takes longer to define than to use.
    static COMMAND: RefCell<Command> = RefCell::new(cli::command());
}

pub fn run(data: &[u8]) {
    let lines: Vec<&[u8]> = data.split(|&byte| byte == b'\n').collect();
    let arguments = lines.iter().map(|line| OsStr::from_bytes(line));
    // What it says in several lines is made one by the program.
    let arguments = [OsStr::new("occluscope")].into_iter().chain(arguments);
    let _ = COMMAND.with_borrow_mut(|command| command.try_get_matches_from_mut(arguments));
    let mut axes = Vec::new();
    for text in lines.iter().filter_map(|line| std::str::from_utf8(line).ok()) {
        match Axis::of_text(text) {
            Ok(axis) => axes.push(axis),
            Err(error) => check_message(&error.to_string()),
        }
        assert!(source::parse_scale(text).is_none_or(|scale| scale > 0.0 && scale <= 1.0));
        assert!(source::parse_fps(text).is_none_or(|fps| fps.is_finite() && fps > 0.0));
        assert!(source::parse_crop(text).is_none_or(|crop| crop.width > 0 && crop.height > 0));
        let _ = text.parse::<Levels>().map(Levels::is_valid);
        if let Some((name, value)) = text.split_once('=') {
            let mut settings = Settings::default();
            if settings.set(name, value).is_ok() {
                let setting = SETTINGS.iter().find(|it| it.name == name || it.flag() == name).unwrap();
                assert!(setting.kind.contains(setting.get(&settings)));
            }
        }
    }
    if let Ok(grid) = Grid::new(axes) {
        let base = Settings::default();
        for combination in [0, grid.combinations() / 2, grid.combinations() - 1] {
            let settings = grid.settings(&base, combination).unwrap();
            assert_eq!(grid.combination_of(&settings), Some(combination), "{}", grid.name(combination));
        }
    }
}
