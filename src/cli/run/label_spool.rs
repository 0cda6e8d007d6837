//! The labels of all frames, run-length encoded in a temporary file until the identities of their objects are known.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek as _, Write as _};
use std::path::PathBuf;

use anyhow::{Context as _, bail};

use super::arguments::RunJob;
use super::bulky_output::LABELS;
use super::pictures::numbered;
use super::result_spool::ResultSpool;
use crate::cli::interrupt;
use crate::export::Staging;
use crate::export::label_image::LabelImage;
use crate::export::picture_queue::{Picture, PictureQueue};
use crate::export::write_failure::told;
use crate::frame::Size;
use crate::regions::{Labels, rle};
use crate::source::SourceInfo;

/// The file, which has no name, so that nothing of it is left after a failure. Each frame is the number of its bytes
/// and these, some kilobytes; memory holds one frame.
pub(super) struct LabelSpool {
    size: Size,
    file: BufWriter<File>,
    /// The folder of the label images, for messages.
    folder: PathBuf,
}

impl LabelSpool {
    /// `None` if label images are not requested.
    pub(super) fn new(job: &RunJob, info: &SourceInfo, staging: &Staging) -> io::Result<Option<Self>> {
        if !job.wants(&LABELS) {
            return Ok(None);
        }
        let folder = staging.folder(LABELS.file)?;
        let file = tempfile::tempfile_in(&folder).map_err(|error| told(&folder, error))?;
        Ok(Some(Self { size: info.size, file: BufWriter::new(file), folder }))
    }

    /// Adds the labels of the next frame.
    pub(super) fn add(&mut self, labels: &Labels) -> io::Result<()> {
        let bytes = rle::encode_labels(labels);
        let length = self.file.write_all(&(bytes.len() as u64).to_le_bytes());
        length.and_then(|()| self.file.write_all(&bytes)).map_err(|error| told(&self.folder, error))
    }

    /// Writes the label image of each frame of `results`, which are in the pixels of the frames.
    pub(super) fn write_images(
        self,
        job: &RunJob,
        info: &SourceInfo,
        results: &ResultSpool,
    ) -> anyhow::Result<()> {
        let folder = self.folder;
        let failed = |error| told(&folder, error);
        let mut queue = PictureQueue::start(rayon::current_num_threads().min(8))?;
        let mut file = self.file.into_inner().map_err(io::IntoInnerError::into_error).map_err(failed)?;
        file.rewind().map_err(failed)?;
        let mut file = BufReader::new(file);
        let placement = info.placement();
        let progress = job.console.progress("labelling", Some(results.len() as u32));
        for frame in results.frames()? {
            let tracks = frame?.tracks;
            if interrupt::is_stop_requested() && !info.live {
                bail!("stopped before all label images of {} were written; nothing was written", job.video);
            }
            let labels = read(&mut file, self.size).map_err(failed)?;
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

/// The labels of the next frame.
fn read(file: &mut impl Read, size: Size) -> io::Result<Labels> {
    let mut length = [0; 8];
    file.read_exact(&mut length)?;
    let mut bytes = vec![0; u64::from_le_bytes(length) as usize];
    file.read_exact(&mut bytes)?;
    Ok(rle::decode_labels(&bytes, size).1)
}
