//! The labels of all frames, run-length encoded in a temporary file until the identities of their objects are known.

use std::io;
use std::path::PathBuf;

use anyhow::{Context as _, bail};

use super::arguments::RunJob;
use super::bulky_output::LABELS;
use super::pictures::numbered;
use super::result_spool::ResultSpool;
use super::spool::SpoolWriter;
use crate::cli::interrupt;
use crate::export::Staging;
use crate::export::label_image::LabelImage;
use crate::export::picture_queue::{Picture, PictureQueue};
use crate::frame::Size;
use crate::regions::{Labels, rle};
use crate::source::SourceInfo;

/// The labels, some kilobytes a frame.
pub(super) struct LabelSpool {
    size: Size,
    spool: SpoolWriter,
    /// The folder of the label images.
    folder: PathBuf,
}

impl LabelSpool {
    /// `None` if label images are not requested.
    pub(super) fn new(job: &RunJob, info: &SourceInfo, staging: &Staging) -> io::Result<Option<Self>> {
        if !job.wants(&LABELS) {
            return Ok(None);
        }
        let folder = staging.folder(LABELS.file)?;
        Ok(Some(Self { size: info.size, spool: SpoolWriter::new(&folder)?, folder }))
    }

    /// Adds the labels of the next frame.
    pub(super) fn add(&mut self, labels: &Labels) -> io::Result<()> {
        self.spool.add(&rle::encode_labels(labels))
    }

    /// Writes the label image of each frame of `results`, which are in the pixels of the frames.
    pub(super) fn write_images(
        self,
        job: &RunJob,
        info: &SourceInfo,
        results: &ResultSpool,
    ) -> anyhow::Result<()> {
        let Self { size, spool, folder } = self;
        let mut queue = PictureQueue::start(rayon::current_num_threads().min(8))?;
        let spool = spool.finish()?;
        let placement = info.placement();
        let progress = job.console.progress("labelling", Some(results.len() as u32));
        for (labels, frame) in spool.read()?.zip(results.frames()?) {
            let tracks = frame?.tracks;
            if interrupt::is_stop_requested() && !info.live {
                bail!("stopped before all label images of {} were written; nothing was written", job.video);
            }
            let labels = rle::decode_labels(&labels?, size).1;
            let image = LabelImage::new(&labels, &tracks, &results.decisions.episodes)
                .with_context(|| job.video.clone())?;
            let image = match &placement {
                Some(placement) => image.in_source(placement),
                None => image,
            };
            let path = numbered(&folder, tracks.number);
            queue.write(path, Picture::Labels(image))?;
            progress.advance(1);
        }
        Ok(queue.finish()?)
    }
}
