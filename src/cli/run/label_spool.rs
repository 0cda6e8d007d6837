//! The labels of all frames, run-length encoded in a temporary file until the identities of their objects are known.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek as _, Write as _};

use anyhow::{Context as _, bail};

use super::arguments::RunJob;
use super::bulky_output::LABELS;
use super::pictures::numbered;
use super::result_spool::ResultSpool;
use crate::cli::interrupt;
use crate::export::Staging;
use crate::export::label_image::LabelImage;
use crate::export::picture_queue::{Picture, PictureQueue};
use crate::frame::Size;
use crate::regions::{Labels, rle};
use crate::source::SourceInfo;

/// The file, which has no name, so that nothing of it is left after a failure. Each frame is the number of its bytes
/// and these, some kilobytes; memory holds one frame.
pub(super) struct LabelSpool {
    size: Size,
    file: BufWriter<File>,
}

impl LabelSpool {
    /// `None` if label images are not requested.
    pub(super) fn new(job: &RunJob, info: &SourceInfo, staging: &Staging) -> io::Result<Option<Self>> {
        if !job.wants(&LABELS) {
            return Ok(None);
        }
        let file = BufWriter::new(tempfile::tempfile_in(staging.path(""))?);
        Ok(Some(Self { size: info.size, file }))
    }

    /// Adds the labels of the next frame.
    pub(super) fn add(&mut self, labels: &Labels) -> io::Result<()> {
        let bytes = rle::encode_labels(labels);
        self.file.write_all(&(bytes.len() as u64).to_le_bytes())?;
        self.file.write_all(&bytes)
    }

    /// Writes the label image of each frame of `results`, which are in the pixels of the frames.
    pub(super) fn write_images(
        self,
        job: &RunJob,
        info: &SourceInfo,
        results: &ResultSpool,
        staging: &Staging,
    ) -> anyhow::Result<()> {
        let failed = || job.out_failure();
        let folder = staging.folder(LABELS.file).with_context(failed)?;
        let mut queue = PictureQueue::start(rayon::current_num_threads().min(8)).with_context(failed)?;
        let mut file = self.file.into_inner().map_err(io::IntoInnerError::into_error).with_context(failed)?;
        file.rewind().with_context(failed)?;
        let mut file = BufReader::new(file);
        let placement = info.placement();
        let progress = job.console.progress("labelling", Some(results.len() as u32));
        for frame in results.frames().with_context(failed)? {
            let tracks = frame.with_context(failed)?.tracks;
            if interrupt::is_stop_requested() && !info.live {
                bail!("stopped before all label images of {} were written; nothing was written", job.video);
            }
            let labels = read(&mut file, self.size).with_context(failed)?;
            let image = LabelImage::new(&labels, &tracks, &results.decisions.episodes)
                .with_context(|| job.video.clone())?;
            let image = match &placement {
                Some(placement) => image.in_source(placement),
                None => image,
            };
            let path = numbered(&folder, tracks.number);
            queue.write(path, Picture::Labels(image)).with_context(failed)?;
            progress.advance(1);
        }
        queue.finish().with_context(failed)
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
