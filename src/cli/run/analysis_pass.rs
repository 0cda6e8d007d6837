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
use crate::frame::Frame;
use crate::mixture::BATCH;
use crate::pipeline::{Analysis, Pipeline};
use crate::regions::Roi;

/// Analyses all frames within `roi`. Images that do not need the offline result are written during it, and a camera's
/// annotated frames; `labels` takes the labels of all frames.
pub(super) fn analyse(
    job: &RunJob,
    roi: Option<&Arc<Roi>>,
    frames: &mut Frames,
    staging: &Staging,
    annotated: &mut AnnotatedOutput,
    labels: Option<&mut LabelSpool>,
) -> anyhow::Result<RunRecord> {
    let info = &frames.info.clone();
    let mut pipeline = prepare(job, roi, frames)?;
    let mut outputs = Outputs {
        pictures: Pictures::new(job, info, staging)?,
        labels,
        live: LiveAnnotation::new(info, annotated),
        recorder: ResultRecorder::new(info, staging)?,
    };

    let progress = job.console.progress("analysing", frames.total);
    // Images of the model are of the state after each frame.
    let is_frame_by_frame = outputs.pictures.has_background();
    let most = if is_frame_by_frame { 1 } else { BATCH };
    // The frames before the current ones, and their regions: they are tracked while those of the current ones are found.
    let (mut last, mut found) = (Vec::new(), Vec::new());
    let step = |pipeline: &mut Pipeline, found, batch: &[Arc<Frame>]| {
        let frames: Vec<&Frame> = batch.iter().map(Arc::as_ref).collect();
        pipeline.step_staggered(found, &frames).with_context(|| job.video.clone())
    };
    loop {
        // Stopping ends a recording; any other work is then incomplete.
        if interrupt::is_stop_requested() && !info.live {
            bail!("stopped before the end of {}; nothing was written", job.video);
        }
        let Batch { frames: batch, after } = frames.batch(most);
        let batch: Vec<_> = batch.into_iter().map(Arc::new).collect();
        let advanced = batch.len();
        let (analyses, next) = step(&mut pipeline, found, &batch)?;
        outputs.add(&last, &analyses, &pipeline)?;
        (last, found) = (batch, next);
        if is_frame_by_frame || matches!(after, Some(Item::End)) {
            let (analyses, next) = step(&mut pipeline, found, &[])?;
            outputs.add(&last, &analyses, &pipeline)?;
            (last, found) = (Vec::new(), next);
        }
        progress.advance(advanced);
        match after {
            None | Some(Item::Frame(_)) => {}
            Some(Item::Warning(text)) => {
                progress.warn(&text);
                outputs.recorder.add_warning(text);
            }
            Some(Item::Failed(error)) => return Err(error),
            Some(Item::End) => break,
        }
    }
    drop(progress);
    outputs.pictures.finish()?;
    if outputs.recorder.frames() == 0 {
        bail!("{} has no frames; nothing was written", job.video);
    }
    Ok(outputs.recorder.finish(&pipeline)?)
}

/// What takes the results of the frames.
struct Outputs<'a> {
    pictures: Pictures,
    labels: Option<&'a mut LabelSpool>,
    live: Option<LiveAnnotation<'a>>,
    recorder: ResultRecorder,
}

impl Outputs<'_> {
    /// Adds the next frames. Where there are images of the model, `pipeline` is in its state after the last frame.
    fn add(
        &mut self,
        frames: &[Arc<Frame>],
        analyses: &[Analysis],
        pipeline: &Pipeline,
    ) -> anyhow::Result<()> {
        for (frame, analysis) in frames.iter().zip(analyses) {
            self.pictures.write(frame, analysis, pipeline)?;
            if let Some(spool) = &mut self.labels {
                spool.add(&analysis.labels)?;
            }
            if let Some(live) = &mut self.live {
                live.write(frame, analysis)?;
            }
            self.recorder.add(frame, analysis)?;
        }
        Ok(())
    }
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
