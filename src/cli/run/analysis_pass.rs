//! The first pass: every frame through all stages.

use std::sync::Arc;

use anyhow::{Context as _, bail};

use super::annotated_output::AnnotatedOutput;
use super::arguments::RunJob;
use super::label_spool::LabelSpool;
use super::live_annotation::LiveAnnotation;
use super::pictures::Pictures;
use super::record::{ResultRecorder, RunRecord};
use crate::cli::frames::{Batch, Frames, Item};
use crate::cli::interrupt;
use crate::export::Staging;
use crate::mixture::BATCH;
use crate::pipeline::Pipeline;
use crate::regions::Roi;

/// Analyses all frames within `roi`. Images that do not need the offline result are written during it, and a camera's
/// annotated frames; `labels` takes the labels of all frames.
pub(super) fn analyse(
    job: &RunJob,
    roi: Option<&Arc<Roi>>,
    frames: &mut Frames,
    staging: &Staging,
    annotated: &mut AnnotatedOutput,
    mut labels: Option<&mut LabelSpool>,
) -> anyhow::Result<RunRecord> {
    let info = &frames.info.clone();
    let mut pipeline = prepare(job, roi, frames)?;
    let mut pictures = Pictures::new(job, info, staging)?;
    let mut live = LiveAnnotation::new(info, annotated);
    let mut recorder = ResultRecorder::new(info, staging)?;

    let progress = job.console.progress("analysing", frames.total);
    // Images of the model are of the state after each frame.
    let most = if pictures.has_background() { 1 } else { BATCH };
    loop {
        // Stopping ends a recording; any other work is then incomplete.
        if interrupt::is_stop_requested() && !info.live {
            bail!("stopped before the end of {}; nothing was written", job.video);
        }
        let Batch { frames: batch, after } = frames.batch(most);
        let batch: Vec<_> = batch.into_iter().map(Arc::new).collect();
        let borrowed: Vec<_> = batch.iter().map(Arc::as_ref).collect();
        let analyses = pipeline.step_many(&borrowed).with_context(|| job.video.clone())?;
        for (frame, analysis) in batch.iter().zip(analyses) {
            pictures.write(frame, &analysis, &pipeline)?;
            if let Some(spool) = &mut labels {
                spool.add(&analysis.labels)?;
            }
            if let Some(live) = &mut live {
                live.write(frame, &analysis)?;
            }
            recorder.add(frame, &analysis)?;
        }
        progress.advance(batch.len());
        match after {
            None | Some(Item::Frame(_)) => {}
            Some(Item::Warning(text)) => {
                progress.warn(&text);
                recorder.add_warning(text);
            }
            Some(Item::Failed(error)) => return Err(error),
            Some(Item::End) => break,
        }
    }
    drop(progress);
    pictures.finish()?;
    if recorder.frames() == 0 {
        bail!("{} has no frames; nothing was written", job.video);
    }
    Ok(recorder.finish(&pipeline)?)
}

/// The stages, after the model has learned from the first frames.
fn prepare(job: &RunJob, roi: Option<&Arc<Roi>>, frames: &mut Frames) -> anyhow::Result<Pipeline> {
    let mut pipeline = Pipeline::new(&job.settings, frames.info.size, frames.info.fps)?;
    pipeline.set_roi(roi.cloned())?;
    frames.learn(&job.settings, job.console, |frames| {
        pipeline.learn(frames).with_context(|| job.video.clone())
    })?;
    Ok(pipeline)
}
