//! File dialogs and the file access that follows them. Both run on their own threads, so that the window never waits.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender};
use eframe::egui::{ColorImage, Context};
use rfd::FileDialog;

use crate::app::files::atomic_write;
use crate::app::files::export_frame::FrameExport;
use crate::app::files::settings_file;
use crate::app::files::sweep_file;
use crate::app::model::opened_sweep::OpenedSweep;
use crate::export::picture;
use crate::frame::Mask;
use crate::panic_message::message;
use crate::regions::Roi;
use crate::settings::Settings;
use crate::source::{SceneFolder, VIDEO_ENDINGS, path_of};
use crate::truth::Truth;
use crate::truth::external::ExternalResults;

/// Minimum time in which a user can cancel a dialog. A dialog that ends sooner was never shown.
const MIN_DIALOG_DURATION: Duration = Duration::from_millis(250);

/// The endings of the names of other files than videos that are a source.
const FURTHER_ENDINGS: [&str; 3] = ["gif", "tif", "tiff"];

/// The endings of the names of files of tracks that the dialogs list.
const TRACK_ENDINGS: [&str; 5] = ["txt", "csv", "xml", "json", "zip"];

/// The result of a dialog.
pub(crate) enum DialogResult {
    /// A video or folder to open.
    Open(PathBuf),
    /// A file was written, or an error in a sentence.
    Written(Result<PathBuf, String>),
    /// A plot was drawn for the clipboard, or an error in a sentence.
    Plot(Result<ColorImage, String>),
    /// A table was written for the clipboard, with its number of rows, or an error in a sentence.
    Table(Result<(String, usize), String>),
    /// Settings were read from a file, or an error in a sentence.
    Settings(Result<(PathBuf, Box<Settings>), String>),
    /// A sweep was read, or an error in a sentence.
    Sweep(Result<Arc<OpenedSweep>, String>),
    /// A mask was read from a file, or an error in a sentence.
    Mask(Result<Arc<Roi>, String>),
    /// Ground truth was read, or an error in a sentence.
    Truth(Result<Arc<Truth>, String>),
    /// External results were read, or an error in a sentence.
    External(Result<Arc<ExternalResults>, String>),
    /// The ground truth beside the video of this name, if any.
    TruthOffered(String, Option<PathBuf>),
    /// This system has no file dialogs.
    NoDialog,
    /// The work could not be done, in a sentence.
    Failed(String),
}

/// The result, if any, and whether it closed a dialog.
struct DialogOutcome {
    answer: Option<DialogResult>,
    from_dialog: bool,
}

/// The open dialog and pending results.
pub(crate) struct Dialogs {
    sender: Sender<DialogOutcome>,
    receiver: Receiver<DialogOutcome>,
    open: bool,
}

impl Default for Dialogs {
    fn default() -> Self {
        let (sender, receiver) = crossbeam_channel::unbounded();
        Self { sender, receiver, open: false }
    }
}

impl Dialogs {
    /// Opens no dialog from now on, as while one is open.
    #[cfg(test)]
    pub(crate) const fn refuse(&mut self) {
        self.open = true;
    }

    /// Asks for a video file.
    pub(crate) fn video(&mut self, ctx: &Context) {
        self.ask(ctx, || {
            let dialog = FileDialog::new().set_title("Open video");
            let endings = [&VIDEO_ENDINGS[..], &FURTHER_ENDINGS].concat();
            with_filter(dialog, "Video", &endings).pick_file().map(DialogResult::Open)
        });
    }

    /// Asks for a folder of images.
    pub(crate) fn folder(&mut self, ctx: &Context) {
        self.ask(ctx, || {
            FileDialog::new().set_title("Open folder of images").pick_folder().map(DialogResult::Open)
        });
    }

    /// Asks for a path and writes a frame there.
    pub(crate) fn export_frame(&mut self, ctx: &Context, picture: FrameExport) {
        let (name, kind) = (picture.name(), ("PNG image", "png"));
        self.save(ctx, "Export frame", name, kind, move |path| picture.write(path));
    }

    /// Asks for a path and writes settings there.
    pub(crate) fn save_settings(&mut self, ctx: &Context, settings: Settings) {
        let (name, kind) = (settings_file::FILE_NAME.to_owned(), ("Settings", settings_file::EXTENSION));
        self.save(ctx, "Save settings", name, kind, move |path| settings_file::write(path, &settings));
    }

    /// Asks for a settings file and reads it.
    pub(crate) fn load_settings(&mut self, ctx: &Context) {
        self.ask(ctx, || {
            let dialog = FileDialog::new().set_title("Load settings");
            let path = with_filter(dialog, "Settings", &[settings_file::EXTENSION]).pick_file()?;
            let read = settings_file::read(&path);
            Some(DialogResult::Settings(read.map(|settings| (path, Box::new(settings)))))
        });
    }

    /// Asks for the table of a sweep and reads it.
    pub(crate) fn open_sweep(&mut self, ctx: &Context) {
        self.ask(ctx, || {
            let dialog = FileDialog::new().set_title("Open sweep");
            Some(sweep(&with_filter(dialog, "Table of a sweep", &["csv"]).pick_file()?))
        });
    }

    /// Reads a sweep from its table or folder.
    pub(crate) fn read_sweep(&mut self, ctx: &Context, path: PathBuf) {
        self.run(ctx, move || sweep(&path));
    }

    /// Asks for an image of the region of interest and reads it.
    pub(crate) fn load_mask(&mut self, ctx: &Context) {
        self.ask(ctx, || {
            let dialog = FileDialog::new().set_title("Load area mask");
            let endings = ["png", "bmp", "jpg", "jpeg", "tif", "tiff", "pgm"];
            let path = with_filter(dialog, "Image", &endings).pick_file()?;
            Some(DialogResult::Mask(Roi::read(&path).map(Arc::new).map_err(|error| error.to_string())))
        });
    }

    /// Asks for a ground-truth file and reads it.
    pub(crate) fn load_truth(&mut self, ctx: &Context) {
        self.ask(ctx, || {
            let dialog = FileDialog::new().set_title("Load ground truth");
            Some(truth(&with_filter(dialog, "Tracks", &TRACK_ENDINGS).pick_file()?))
        });
    }

    /// Asks for a ground-truth folder and reads it.
    pub(crate) fn load_truth_folder(&mut self, ctx: &Context) {
        self.ask(ctx, || {
            Some(truth(&FileDialog::new().set_title("Load ground truth folder").pick_folder()?))
        });
    }

    /// Asks for a file of external tracks and reads it.
    pub(crate) fn load_external(&mut self, ctx: &Context) {
        self.ask(ctx, || {
            let dialog = FileDialog::new().set_title("Load external results");
            Some(external(&with_filter(dialog, "Tracks", &TRACK_ENDINGS).pick_file()?))
        });
    }

    /// Asks for a folder of external results and reads it.
    pub(crate) fn load_external_folder(&mut self, ctx: &Context) {
        self.ask(ctx, || {
            Some(external(&FileDialog::new().set_title("Load external results folder").pick_folder()?))
        });
    }

    /// Reads ground truth from a file or folder.
    pub(crate) fn read_truth(&mut self, ctx: &Context, path: PathBuf) {
        self.run(ctx, move || truth(&path));
    }

    /// Finds the ground truth beside the images of a data set's sequence.
    pub(crate) fn find_truth(&mut self, ctx: &Context, name: &str) {
        let name = name.to_owned();
        self.run(ctx, move || {
            let truth = SceneFolder::at(&path_of(&name)).and_then(|scene| scene.truth);
            DialogResult::TruthOffered(name, truth)
        });
    }

    /// Asks for a path and writes the region of interest there as an image.
    pub(crate) fn save_mask(&mut self, ctx: &Context, mask: Mask) {
        self.save(ctx, "Save area mask", "roi.png".to_owned(), ("PNG image", "png"), move |path| {
            atomic_write::write(path, "png", |at| picture::write_mask(at, &mask))
        });
    }

    /// Asks for a path with this proposed file name, of a kind of file given by its name and extension, and writes
    /// the file there.
    pub(crate) fn save(
        &mut self,
        ctx: &Context,
        title: &'static str,
        file_name: String,
        (kind, extension): (&'static str, &'static str),
        write: impl FnOnce(PathBuf) -> Result<PathBuf, String> + Send + 'static,
    ) {
        self.ask(ctx, move || {
            let dialog = FileDialog::new().set_title(title).set_file_name(file_name);
            Some(DialogResult::Written(write(dialog.add_filter(kind, &[extension]).save_file()?)))
        });
    }

    /// Runs work without a dialog on a thread of its own.
    pub(crate) fn run(&mut self, ctx: &Context, work: impl FnOnce() -> DialogResult + Send + 'static) {
        self.start(ctx, false, || Some(work()));
    }

    /// Does the work on a thread of its own, which answers in any case.
    fn start(
        &self,
        ctx: &Context,
        from_dialog: bool,
        work: impl FnOnce() -> Option<DialogResult> + Send + 'static,
    ) {
        let (sender, ctx) = (self.sender.clone(), ctx.clone());
        let work = move || {
            let answer = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
                let why = message(&*panic);
                Some(DialogResult::Failed(format!(
                    "internal error ({why}); save your settings and try again"
                )))
            });
            // Sending fails if the window is already closed; the result is then discarded.
            let _ = sender.send(DialogOutcome { answer, from_dialog });
            ctx.request_repaint();
        };
        if let Err(error) = thread::Builder::new().name("files".into()).spawn(work) {
            let why = format!("no thread can be started: {error}; close other programs and try again");
            let _ = self.sender.send(DialogOutcome { answer: Some(DialogResult::Failed(why)), from_dialog });
        }
    }

    /// The next pending result.
    pub(crate) fn answer(&mut self) -> Option<DialogResult> {
        let outcome = self.receiver.try_recv().ok()?;
        // Results for the clipboard come from no dialog; a dialog may still be open.
        self.open &= !outcome.from_dialog;
        outcome.answer
    }

    fn ask(&mut self, ctx: &Context, dialog: impl FnOnce() -> Option<DialogResult> + Send + 'static) {
        // Only one dialog at a time: a second one would cover the first.
        if self.open {
            return;
        }
        self.open = true;
        self.start(ctx, true, || {
            let asked = Instant::now();
            dialog().or_else(|| (asked.elapsed() < MIN_DIALOG_DURATION).then_some(DialogResult::NoDialog))
        });
    }
}

/// Adds a filter of endings in lower and upper case, because some systems compare case, and one of all files.
fn with_filter(dialog: FileDialog, kind: &str, endings: &[&str]) -> FileDialog {
    dialog.add_filter(kind, &in_both_cases(endings)).add_filter("All files", &["*"])
}

fn in_both_cases(endings: &[&str]) -> Vec<String> {
    endings.iter().flat_map(|ending| [(*ending).to_owned(), ending.to_uppercase()]).collect()
}

fn sweep(path: &Path) -> DialogResult {
    DialogResult::Sweep(sweep_file::read(path).map(Arc::new))
}

fn truth(path: &Path) -> DialogResult {
    let read = Truth::read(path);
    DialogResult::Truth(read.map(Arc::new).map_err(|error| format!("{error}; choose another file")))
}

fn external(path: &Path) -> DialogResult {
    let read = ExternalResults::read(path);
    DialogResult::External(read.map(Arc::new).map_err(|error| error.to_string()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]

    use super::*;

    /// The result of a dialog, once it has ended.
    fn outcome(dialog: impl FnOnce() -> Option<DialogResult> + Send + 'static) -> Option<DialogResult> {
        let (ctx, mut dialogs) = (Context::default(), Dialogs::default());
        dialogs.ask(&ctx, dialog);
        assert!(dialogs.open);
        let answer = dialogs.receiver.recv().unwrap();
        dialogs.sender.send(answer).unwrap();
        let answer = dialogs.answer();
        assert!(!dialogs.open);
        answer
    }

    #[test]
    fn endings_are_listed_in_both_cases() {
        assert_eq!(in_both_cases(&["mp4", "3gp"]), ["mp4", "MP4", "3gp", "3GP"]);
    }

    #[test]
    fn a_clipboard_result_closes_no_dialog() {
        let (ctx, mut dialogs) = (Context::default(), Dialogs::default());
        dialogs.open = true;
        dialogs.run(&ctx, || DialogResult::Table(Ok(("a,b\n".to_owned(), 0))));
        let answer = dialogs.receiver.recv().unwrap();
        dialogs.sender.send(answer).unwrap();
        assert!(matches!(dialogs.answer(), Some(DialogResult::Table(Ok(_)))) && dialogs.open);
    }

    #[test]
    fn a_panic_becomes_a_message_and_the_next_dialog_opens() {
        let answer = outcome(|| panic!("the writer\n broke"));
        let Some(DialogResult::Failed(why)) = answer else { panic!("no message") };
        assert_eq!(why, "internal error (the writer broke); save your settings and try again");
        let (ctx, mut dialogs) = (Context::default(), Dialogs::default());
        dialogs.run(&ctx, || panic!("number {}", 7));
        let answer = dialogs.receiver.recv().unwrap().answer;
        assert!(matches!(answer, Some(DialogResult::Failed(why)) if why.contains("number 7")));
    }

    #[test]
    fn a_dialog_that_was_never_shown_differs_from_a_cancelled_one() {
        assert!(matches!(outcome(|| None), Some(DialogResult::NoDialog)));
        let cancelled = || {
            std::thread::sleep(2 * MIN_DIALOG_DURATION);
            None
        };
        assert!(outcome(cancelled).is_none());
        assert!(matches!(outcome(|| Some(DialogResult::Open("a".into()))), Some(DialogResult::Open(_))));
    }
}
