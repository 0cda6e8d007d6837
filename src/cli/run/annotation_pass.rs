//! The second pass: the offline result, drawn onto the frames.

use anyhow::{anyhow, bail};
use rayon::prelude::*;

use super::annotated_output::AnnotatedOutput;
use super::arguments::RunJob;
use super::recent_tracks::RecentTracks;
use super::result_spool::ResultSpool;
use crate::cli::frames::{Frames, Item};
use crate::cli::interrupt;
use crate::export::annotate::{FrameAnnotations, annotate};
use crate::frame::Frame;

/// Decodes the frames again and draws `results` onto them.
pub(super) fn annotate_frames(
    job: &RunJob,
    results: &ResultSpool,
    output: &mut AnnotatedOutput,
) -> anyhow::Result<()> {
    let mut frames = Frames::open(&job.video, job.options, job.range, None)?;
    let events = &results.decisions.events;
    let progress = job.console.progress("drawing", Some(results.len() as u32));
    let mut tracks = results.frames()?;
    let mut recent = RecentTracks::default();

    let mut decoded = frames.items().filter_map(|item| match item {
        Item::Frame(frame) => Some(Ok(frame)),
        // Already reported by the first pass.
        Item::Warning(_) | Item::End => None,
        Item::Failed(error) => Some(Err(error)),
    });
    let mut done = 0;
    while done < results.len() && output.is_open() {
        if interrupt::is_stop_requested() {
            bail!("stopped before all frames of {} were drawn; nothing was written", job.video);
        }
        let most = (2 * rayon::current_num_threads()).min(results.len() - done);
        let mut batch: Vec<Frame> = decoded.by_ref().take(most).collect::<Result<_, _>>()?;
        recent.forget();
        let before = recent.frames().len();
        for frame in tracks.by_ref().take(batch.len()) {
            recent.push(frame?.tracks);
        }
        let mut pairs = batch.iter().zip(&recent.frames()[before..]);
        if batch.is_empty() || pairs.any(|(frame, tracks)| frame.number != tracks.number) {
            return Err(anyhow!("{} changed during the analysis; run again", job.video));
        }
        batch.par_iter_mut().enumerate().for_each(|(offset, frame)| {
            annotate(frame, &FrameAnnotations::at(before + offset, recent.frames(), events));
        });
        output.write(&batch)?;
        done += batch.len();
        progress.advance(batch.len());
    }
    Ok(())
}
