//! `occluscope run`: the whole analysis without a display.
//!
//! Decoding runs ahead on its own thread, images are encoded on others. The data for tables waits in a temporary file
//! until the end, because the offline result needs all frames; label images are written then for the same reason, from
//! labels that wait in another, and annotated frames are drawn in a second pass over the video. A camera has no second
//! pass: its annotated frames show the online result. Where no encoder accepts the video of them, all other files are
//! still written, and the run fails; where a file cannot be written, none is.

mod analysis_pass;
mod annotated_output;
mod annotation_pass;
mod arguments;
mod bulky_output;
mod input_hash;
mod label_spool;
mod live_annotation;
mod pictures;
mod recent_tracks;
mod record;
mod result_spool;
mod spool;
mod summary;
mod tables;

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Context as _;
use clap::ArgMatches;

pub use arguments::command;
pub(super) use input_hash::hexadecimal;

use super::frames::Frames;
use super::{flags, inputs, source_flags};
use crate::export::Staging;
use crate::export::staging::IsFolder;
use crate::regions::Roi;
use crate::registration::CorrectionChoice;
use annotated_output::AnnotatedOutput;
use arguments::RunJob;
use bulky_output::{ANNOTATED, MASKS};
use input_hash::InputHash;
use label_spool::LabelSpool;

/// The region of interest, if it is not the whole image.
const ROI: &str = "roi.png";

/// Analyses the video and writes the output.
pub fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    let job = RunJob::new(matches)?;
    flags::start_threads(matches)?;
    let started = Instant::now();
    let outputs: Vec<_> = targets(&job).map(|(name, is_folder)| (job.out.join(name), is_folder)).collect();
    let outputs = outputs.iter().map(|(path, is_folder)| (path.as_path(), *is_folder));
    inputs::protect(&inputs::of_video(&job.video), outputs)?;
    let (mut frames, roi) = open(&job)?;
    let hash = InputHash::start(&job.video);
    summary::print_input(&job, &frames);

    let staging = Staging::new(&job.out)?;
    staging.check(targets(&job))?;
    let mut annotated = AnnotatedOutput::new(&job, &frames.info, &staging)?;
    let mut labels = LabelSpool::new(&job, &frames.info, &staging)?;
    let mut record =
        analysis_pass::analyse(&job, roi.as_ref(), &mut frames, &staging, &mut annotated, labels.as_mut())?;
    if let Some(labels) = labels {
        labels.write_images(&job, &frames.info, &record.results)?;
    }
    if annotated.is_open() && !frames.info.live {
        annotation_pass::annotate_frames(&job, &record.results, &mut annotated)?;
    }
    let video = annotated.finish()?;
    if let Some(placement) = frames.info.placement() {
        record.results.move_to_source(placement);
    }
    let sha256 = hash.finish(&record)?;
    let objects = tables::write(&record, &job, &staging)?;
    let counts = summary::Counts { objects, sha256, duration: started.elapsed(), has_video: video.is_ok() };
    let summary = summary::summarise(&job, roi.as_deref(), &frames.info, &record, counts);
    summary::write(&summary, &staging)?;
    staging.publish(summary::FILE)?;

    summary::print(&job, &summary);
    source_flags::note_assumed_fps(&frames.info, job.console);
    source_flags::note_truth(&job.video, &job.out, job.wants(&MASKS), job.console);
    let path = job.out.join(ANNOTATED.file);
    video.with_context(|| format!("the tables are written, {} is not", path.display()))
}

/// The names of all files and folders of the run.
fn targets(job: &RunJob) -> impl Iterator<Item = (&'static Path, IsFolder)> {
    let bulky = bulky_output::ALL.into_iter().filter(|bulky| job.wants(bulky)).map(|bulky| {
        let is_folder = if bulky.file == ANNOTATED.file { IsFolder::No } else { IsFolder::Yes };
        (Path::new(bulky.file), is_folder)
    });
    let roi = job.roi.is_some().then_some(ROI);
    let files = tables::FILES.into_iter().chain([summary::FILE]).chain(roi);
    files.map(|file| (Path::new(file), IsFolder::No)).chain(bulky)
}

/// Opens the video. Returns the region of interest in its frames, too.
fn open(job: &RunJob) -> anyhow::Result<(Frames, Option<Arc<Roi>>)> {
    let frames =
        Frames::open(&job.video, job.options, job.range, Some(CorrectionChoice::new(&job.settings)))?;
    let info = &frames.info;
    let roi = job.roi.as_ref().map(|roi| Roi::of_frames(roi, info.size, info.placement().as_ref()));
    let roi = roi.transpose()?;
    Ok((frames, roi))
}
