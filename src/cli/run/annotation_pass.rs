//! The second pass: the offline result, drawn onto the frames.

use anyhow::{Context as _, anyhow, bail};
use rayon::prelude::*;

use super::annotated_output::AnnotatedOutput;
use super::arguments::RunJob;
use crate::cli::frames::{Frames, Item};
use crate::cli::interrupt;
use crate::export::annotate::{FrameAnnotations, annotate};
use crate::frame::Frame;
use crate::pipeline::OfflineResult;

/// Decodes the frames again and draws `result` onto them.
pub(super) fn annotate_frames(
    job: &RunJob,
    result: &OfflineResult,
    output: &mut AnnotatedOutput,
) -> anyhow::Result<()> {
    let mut frames = Frames::open(&job.video, job.options, job.range, None)?;
    let OfflineResult { tracks, events, .. } = result;
    let progress = job.console.progress("drawing", Some(tracks.len() as u32));

    let mut decoded = frames.items().filter_map(|item| match item {
        Item::Frame(frame) => Some(Ok(frame)),
        // Already reported by the first pass.
        Item::Warning(_) | Item::End => None,
        Item::Failed(error) => Some(Err(error)),
    });
    let mut done = 0;
    while done < tracks.len() && output.is_open() {
        if interrupt::is_stop_requested() {
            bail!("stopped before all frames of {} were drawn; nothing was written", job.video);
        }
        let most = (2 * rayon::current_num_threads()).min(tracks.len() - done);
        let mut batch: Vec<Frame> = decoded.by_ref().take(most).collect::<Result<_, _>>()?;
        let mut pairs = batch.iter().zip(&tracks[done..]);
        if batch.is_empty() || pairs.any(|(frame, tracks)| frame.number != tracks.number) {
            return Err(anyhow!("{} changed during the analysis; run again", job.video));
        }
        batch.par_iter_mut().enumerate().for_each(|(offset, frame)| {
            annotate(frame, &FrameAnnotations::at(done + offset, tracks, events));
        });
        output.write(&batch).with_context(|| job.out_failure())?;
        done += batch.len();
        progress.advance(batch.len());
    }
    Ok(())
}
