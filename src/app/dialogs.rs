//! File dialogs on threads of their own, so that the window never waits for one.

use std::path::PathBuf;

use crossbeam_channel::{Receiver, Sender};
use eframe::egui::Context;

/// What a dialog brought back.
pub(crate) enum Answer {
    /// A video or folder to open.
    Open(PathBuf),
    /// Where to write the frame.
    Save(PathBuf),
}

/// The dialogs that are open.
pub(crate) struct Dialogs {
    sender: Sender<Option<Answer>>,
    receiver: Receiver<Option<Answer>>,
    open: bool,
}

impl Default for Dialogs {
    fn default() -> Self {
        let (sender, receiver) = crossbeam_channel::unbounded();
        Self { sender, receiver, open: false }
    }
}

impl Dialogs {
    /// Asks for a video file.
    pub(crate) fn video(&mut self, ctx: &Context) {
        self.ask(ctx, || {
            let dialog = rfd::FileDialog::new().set_title("Open video");
            let endings = ["mp4", "avi", "mkv", "mov", "webm", "m4v", "mpg", "mpeg", "ogv"];
            dialog.add_filter("Video", &endings).add_filter("All files", &["*"]).pick_file().map(Answer::Open)
        });
    }

    /// Asks for a folder of images.
    pub(crate) fn folder(&mut self, ctx: &Context) {
        self.ask(ctx, || {
            rfd::FileDialog::new().set_title("Open folder of images").pick_folder().map(Answer::Open)
        });
    }

    /// Asks where to write a picture.
    pub(crate) fn save(&mut self, ctx: &Context, name: String) {
        self.ask(ctx, move || {
            let dialog = rfd::FileDialog::new().set_title("Export frame").set_file_name(name);
            dialog.add_filter("PNG picture", &["png"]).save_file().map(Answer::Save)
        });
    }

    /// What came back since this was last asked.
    pub(crate) fn answer(&mut self) -> Option<Answer> {
        let answer = self.receiver.try_recv().ok()?;
        self.open = false;
        answer
    }

    fn ask(&mut self, ctx: &Context, dialog: impl FnOnce() -> Option<Answer> + Send + 'static) {
        // One at a time: a second would only lie over the first.
        if self.open {
            return;
        }
        self.open = true;
        let (sender, ctx) = (self.sender.clone(), ctx.clone());
        std::thread::spawn(move || {
            // The window may be gone by then; then nobody waits for the answer.
            let _ = sender.send(dialog());
            ctx.request_repaint();
        });
    }
}
