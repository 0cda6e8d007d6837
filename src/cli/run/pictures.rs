//! The images that do not need the offline result: masks, background and plain frames.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::arguments::RunJob;
use super::bulky_output::{BACKGROUND, BulkyOutput, MASKS, PLAIN_FRAMES};
use crate::export::Staging;
use crate::export::picture_queue::{Picture, PictureQueue};
use crate::frame::Frame;
use crate::pipeline::{Analysis, Pipeline};
use crate::placement::Placement;
use crate::source::SourceInfo;

/// The folders of the requested images, and the queue that encodes them.
pub(super) struct Pictures {
    masks: Option<PathBuf>,
    background: Option<PathBuf>,
    plain_frames: Option<PathBuf>,
    /// Where the frames lie in the source's images, if they are not these images.
    placement: Option<Placement>,
    queue: PictureQueue,
}

impl Pictures {
    /// Creates the folders of the requested images.
    pub(super) fn new(job: &RunJob, info: &SourceInfo, staging: &Staging) -> io::Result<Self> {
        let folder = |bulky: &BulkyOutput| job.wants(bulky).then(|| staging.folder(bulky.file)).transpose();
        Ok(Self {
            masks: folder(&MASKS)?,
            background: folder(&BACKGROUND)?,
            plain_frames: folder(&PLAIN_FRAMES)?,
            placement: info.placement(),
            queue: PictureQueue::start(rayon::current_num_threads().min(8))?,
        })
    }

    /// Whether images of the model are requested.
    pub(super) const fn has_background(&self) -> bool {
        self.background.is_some()
    }

    /// Writes the images of a frame; `pipeline` is in its state after that frame.
    pub(super) fn write(
        &mut self,
        frame: &Arc<Frame>,
        analysis: &Analysis,
        pipeline: &Pipeline,
    ) -> anyhow::Result<()> {
        let number = frame.number;
        if let Some(folder) = &self.masks {
            let path = folder.join(format!("bin{number:06}.png"));
            let mask = match &self.placement {
                Some(placement) => Arc::new(placement.source_mask(&analysis.mask)),
                None => analysis.mask.clone(),
            };
            self.queue.write(path, Picture::Mask(mask))?;
        }
        if let Some(folder) = &self.background {
            let image = Frame::new(number, frame.size, pipeline.background_image()?);
            self.queue.write(numbered(folder, number), Picture::Frame(Arc::new(image)))?;
        }
        if let Some(folder) = &self.plain_frames {
            self.queue.write(numbered(folder, number), Picture::Frame(frame.clone()))?;
        }
        Ok(())
    }

    /// Waits until all images are written.
    pub(super) fn finish(self) -> io::Result<()> {
        self.queue.finish()
    }
}

/// The path of the image of a frame in `folder`.
pub(super) fn numbered(folder: &Path, number: u32) -> PathBuf {
    folder.join(format!("{number:06}.png"))
}
