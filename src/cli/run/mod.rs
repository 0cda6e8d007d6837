//! `occluscope run`: the whole analysis without a display.
//!
//! Decoding runs ahead on its own thread, images are encoded on others. The data for tables is kept until the end,
//! because the offline result needs all frames; annotated frames are drawn in a second pass over the video for the
//! same reason. A camera has no second pass: its annotated frames show the online result.

mod analysis_pass;
mod annotated_output;
mod annotation_pass;
mod arguments;
mod bulky_output;
mod input_hash;
mod live_annotation;
mod pictures;
mod record;
mod summary;
mod tables;

use std::time::Instant;

use anyhow::Context as _;
use clap::ArgMatches;

pub use arguments::command;

use super::frames::Frames;
use super::{flags, source_flags};
use crate::export::Staging;
use crate::registration::CorrectionChoice;
use arguments::RunJob;
use input_hash::InputHash;

/// The region of interest, if it is not the whole image.
const ROI: &str = "roi.png";

/// Analyses the video and writes the output.
pub fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    let job = RunJob::new(matches)?;
    flags::start_threads(matches)?;
    let started = Instant::now();
    let mut frames = open(&job)?;
    let hash = InputHash::start(&job.video);
    summary::print_input(&job, &frames);

    let staging = Staging::new(&job.out).with_context(|| job.out_failure())?;
    let record = analysis_pass::analyse(&job, &mut frames, &staging)?;
    if job.is_annotated() && !frames.info.live {
        annotation_pass::annotate_frames(&job, &record.result, &staging)?;
    }
    let sha256 = hash.finish(&record)?;
    tables::write(&record, &job, &staging)?;
    let summary = summary::summarise(&job, &frames.info, &record, sha256, started.elapsed());
    summary::write(&summary, &staging)?;
    staging.publish(summary::FILE).with_context(|| job.out_failure())?;

    summary::print(&job, &summary);
    source_flags::note_assumed_fps(&frames.info, job.console);
    Ok(())
}

/// Opens the video and checks that the region of interest has its size.
fn open(job: &RunJob) -> anyhow::Result<Frames> {
    let frames =
        Frames::open(&job.video, job.options, job.range, Some(CorrectionChoice::new(&job.settings)))?;
    if let Some(roi) = &job.roi {
        roi.check(frames.info.size)?;
    }
    Ok(frames)
}
