//! Writing the frame in view as a picture, on a thread of its own.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crossbeam_channel::{Receiver, Sender};
use eframe::egui::Context;

use super::state::Model;
use crate::export::annotate::{Moment, annotate};
use crate::export::picture;
use crate::frame::Frame;
use crate::occlusion::Event;
use crate::replay::Shown;
use crate::tracking::Track;

/// A frame with all that is drawn on it, held while a place to write it is chosen.
pub(crate) struct Picture {
    shown: Arc<Shown>,
    recent: Vec<(u32, Vec<Track>)>,
    events: Vec<Event>,
}

impl Picture {
    /// The frame in view.
    pub(crate) fn of(model: &Model) -> Option<Self> {
        let shown = model.state.as_ref()?.shown.clone()?;
        let recent = model
            .trails
            .range(..=shown.position)
            .map(|(_, (number, tracks))| (*number, tracks.as_ref().clone()))
            .collect();
        let timeline = model.timeline()?;
        let here = timeline.events.iter().filter(|(position, _)| *position == shown.position);
        let events = here.map(|(_, event)| event.clone()).collect();
        Some(Self { shown, recent, events })
    }

    /// The name that is proposed for it.
    pub(crate) fn name(&self) -> String {
        format!("frame-{:06}.png", self.shown.frame.number)
    }

    fn write(&self, path: &Path) -> Result<(), String> {
        let mut frame = Frame::clone(&self.shown.frame);
        annotate(&mut frame, &Moment { recent: &self.recent, events: &self.events });
        write_whole(path, &frame)
            .map_err(|error| format!("{} was not written: {error}; choose another place", path.display()))
    }
}

/// Writes beside the place first, so that what stands there is never replaced by half a picture.
fn write_whole(path: &Path, frame: &Frame) -> std::io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let file = tempfile::Builder::new().suffix(".png").tempfile_in(folder)?;
    picture::write_frame(file.path(), frame)?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}

/// Pictures being written.
pub(crate) struct Exports {
    sender: Sender<Result<PathBuf, String>>,
    receiver: Receiver<Result<PathBuf, String>>,
}

impl Default for Exports {
    fn default() -> Self {
        let (sender, receiver) = crossbeam_channel::unbounded();
        Self { sender, receiver }
    }
}

impl Exports {
    /// Writes a picture; [`Exports::done`] tells when it is there.
    pub(crate) fn start(&self, ctx: &Context, picture: Picture, path: PathBuf) {
        let (sender, ctx) = (self.sender.clone(), ctx.clone());
        std::thread::spawn(move || {
            let path = if path.extension().is_none() { path.with_extension("png") } else { path };
            let result = picture.write(&path).map(|()| path);
            // The window may be gone by then; then nobody waits for the answer.
            let _ = sender.send(result);
            ctx.request_repaint();
        });
    }

    /// A picture that has been written since this was last asked, or why it was not.
    pub(crate) fn done(&self) -> Option<Result<PathBuf, String>> {
        self.receiver.try_recv().ok()
    }
}
