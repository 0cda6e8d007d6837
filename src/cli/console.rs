//! What is said on stderr: notes, warnings, progress.

use std::io::{self, Write};

use clap::ArgMatches;
use indicatif::{ProgressBar, ProgressStyle};

/// How much is said.
#[derive(Clone, Copy, Debug)]
pub(super) struct Console {
    quiet: bool,
    verbose: bool,
}

impl Console {
    /// As `--quiet` and `-v` ask for.
    pub(super) fn new(matches: &ArgMatches) -> Self {
        Self { quiet: matches.get_flag("quiet"), verbose: matches.get_flag("verbose") }
    }

    /// Something that is good to know.
    pub(super) fn note(self, text: &str) {
        if !self.quiet {
            // Where stderr is closed, there is nobody to tell.
            let _ = writeln!(io::stderr(), "{text}");
        }
    }

    /// Something that only those who ask want to know.
    pub(super) fn detail(self, text: &str) {
        if self.verbose {
            self.note(text);
        }
    }

    /// A bar over `total` frames, or a counter where the total is not known. Seen on a terminal only.
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
}

/// A progress bar, taken away when dropped.
pub(super) struct Progress {
    bar: ProgressBar,
    console: Console,
}

impl Progress {
    /// So many more frames are done.
    pub(super) fn advance(&self, frames: usize) {
        self.bar.inc(frames as u64);
    }

    /// Something went wrong without ending the work.
    pub(super) fn warn(&self, text: &str) {
        self.bar.suspend(|| self.console.note(&format!("warning: {text}")));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
