//! The first pass: every frame through all stages.

use std::mem;
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
use crate::pipeline::{Analysis, Pipeline, SegmentedFrame};
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
    let mut pass = Pass {
        video: &job.video,
        pipeline: prepare(job, roi, frames)?,
        segmented: (Vec::new(), Vec::new()),
        outputs: Outputs {
            pictures: Pictures::new(job, info, staging)?,
            labels,
            live: LiveAnnotation::new(info, annotated),
            recorder: ResultRecorder::new(info, staging)?,
        },
    };

    let progress = job.console.progress("analysing", frames.total);
    // Images of the model are of the state after each frame.
    let is_frame_by_frame = pass.outputs.pictures.has_background();
    let most = if is_frame_by_frame { 1 } else { BATCH };
    loop {
        // Stopping ends a recording; any other work is then incomplete.
        if interrupt::is_stop_requested() && !info.live {
            bail!("stopped before the end of {}; nothing was written", job.video);
        }
        let Batch { frames: batch, after } = frames.batch(most);
        let count = batch.len();
        pass.advance(batch.into_iter().map(Arc::new).collect())?;
        if is_frame_by_frame || matches!(after, Some(Item::End)) {
            pass.advance(Vec::new())?;
        }
        progress.advance(count);
        match after {
            None | Some(Item::Frame(_)) => {}
            Some(Item::Warning(text)) => {
                progress.warn(&text);
                pass.outputs.recorder.add_warning(text);
            }
            Some(Item::Failed(error)) => return Err(error),
            Some(Item::End) => break,
        }
    }
    drop(progress);
    let Pass { pipeline, outputs, .. } = pass;
    outputs.pictures.finish()?;
    if outputs.recorder.frames() == 0 {
        bail!("{} has no frames; nothing was written", job.video);
    }
    Ok(outputs.recorder.finish(&pipeline)?)
}

/// The stages, and the frames between them.
struct Pass<'a> {
    video: &'a str,
    pipeline: Pipeline,
    /// The frames that are still to be tracked, and their regions.
    segmented: (Vec<Arc<Frame>>, Vec<SegmentedFrame>),
    outputs: Outputs<'a>,
}

impl Pass<'_> {
    /// Segments the next frames, and tracks those of the last call.
    fn advance(&mut self, frames: Vec<Arc<Frame>>) -> anyhow::Result<()> {
        let borrowed: Vec<&Frame> = frames.iter().map(Arc::as_ref).collect();
        let (before, segmented) = mem::take(&mut self.segmented);
        let stepped = self.pipeline.step_staggered(segmented, &borrowed);
        let (analyses, segmented) = stepped.with_context(|| self.video.to_owned())?;
        self.outputs.add(&before, &analyses, &self.pipeline)?;
        self.segmented = (frames, segmented);
        Ok(())
    }
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
        debug_assert_eq!(frames.len(), analyses.len());
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
