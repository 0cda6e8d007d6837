//! Messages on stderr: notes, warnings, progress.

use std::io::{self, Write};

use clap::ArgMatches;
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};

use crate::source::shown;

/// The verbosity of messages.
#[derive(Clone, Copy, Debug)]
pub(super) struct Console {
    quiet: bool,
    verbose: bool,
}

impl Console {
    /// As set by `--quiet` and `-v`.
    pub(super) fn new(matches: &ArgMatches) -> Self {
        Self { quiet: matches.get_flag("quiet"), verbose: matches.get_flag("verbose") }
    }

    /// Prints a note.
    pub(super) fn note(self, text: &str) {
        if !self.quiet {
            // Where stderr is closed, the message is dropped.
            let _ = writeln!(io::stderr(), "{}", one_line(text));
        }
    }

    /// Prints a detail, shown only with `-v`.
    pub(super) fn detail(self, text: &str) {
        if self.verbose {
            self.note(text);
        }
    }

    /// A progress bar over `total` frames, or a counter where the total is unknown. Shown on a terminal only.
    pub(super) fn progress(self, what: &'static str, total: Option<u32>) -> Progress {
        let bar = if self.quiet { ProgressBar::hidden() } else { ProgressBar::no_length() };
        if let Some(total) = total {
            bar.set_length(total.into());
        }
        let template = match total {
            Some(_) => "{msg:9} {wide_bar:.cyan/dim} {pos}/{len} frames  {per_sec:>9}  {eta:>4} left",
            None => "{msg:9} {spinner:.cyan} {pos} frames  {per_sec:>9}",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("━╸─"));
        }
        bar.set_message(what);
        Progress { bar, console: self }
    }

    /// The progress of a long work, whose total is in any unit.
    pub(super) fn long_progress(self, total: u64) -> LongProgress {
        let bar = if self.quiet { ProgressBar::hidden() } else { ProgressBar::new(total) };
        let template = "{msg} {wide_bar:.cyan/dim} {percent:>3} %  {eta:>4} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("━╸─"));
        }
        bar.set_position(0);
        LongProgress { bar, console: self }
    }
}

/// A message in one line: names and messages of libraries can have several.
pub(super) fn one_line(text: &str) -> String {
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    shown(&lines.join(" ")).replace(char::is_control, " ")
}

/// The progress of a long work of several parts: a bar with the time left, shown on a terminal only, and a line for each
/// complete part with `-v`.
pub(super) struct LongProgress {
    bar: ProgressBar,
    console: Console,
}

impl LongProgress {
    /// Names the part that is in work.
    pub(super) fn begin(&self, part: String) {
        self.bar.set_message(part);
    }

    /// Advances by this much of the total.
    pub(super) fn advance(&self, work: u64) {
        self.bar.inc(work);
    }

    /// Prints with `-v` that a part is done, with the share of the whole and the time left.
    pub(super) fn part_done(&self, part: &str) {
        let total = self.bar.length().unwrap_or(0).max(1);
        let left = if self.bar.position() < total {
            format!(", {} left", HumanDuration(self.bar.eta()))
        } else {
            String::new()
        };
        let percent = 100 * self.bar.position().min(total) / total;
        self.bar.suspend(|| self.console.detail(&format!("{part} ({percent} % of all{left})")));
    }

    /// Prints a note.
    pub(super) fn note(&self, text: &str) {
        self.bar.suspend(|| self.console.note(text));
    }
}

impl Drop for LongProgress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// A progress bar, removed when dropped.
pub(super) struct Progress {
    bar: ProgressBar,
    console: Console,
}

impl Progress {
    /// Advances by this many frames.
    pub(super) fn advance(&self, frames: usize) {
        self.bar.inc(frames as u64);
    }

    /// Prints a warning of a problem that did not end the work.
    pub(super) fn warn(&self, text: &str) {
        self.bar.suspend(|| self.console.note(&format!("warning: {text}")));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
