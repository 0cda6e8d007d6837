//! The summary of a run: its file, and what is printed.

use std::io;
use std::time::Duration;

use super::arguments::RunJob;
use super::bulky_output::{ANNOTATED, BulkyOutput};
use super::record::RunRecord;
use super::{ROI, bulky_output};
use crate::cli::frames::Frames;
use crate::cli::staged_file::write_file;
use crate::export::Staging;
use crate::export::summary::{self, Input, Summary, Timing};
use crate::occlusion::EventKind;
use crate::regions::Roi;
use crate::source::SourceInfo;
use crate::truth::analysed_frames::AnalysedFrames;
use crate::truth::counted;
pub(super) use crate::truth::run_summary::FILE;

/// Prints the properties of the input, with `-v`.
pub(super) fn print_input(job: &RunJob, frames: &Frames) {
    job.console.detail(&format!(
        "{}: {}, {} frames/s{}; {} threads",
        job.video,
        frames.info.size,
        frames.info.fps,
        frames.total.map_or_else(String::new, |total| format!(", about {total} frames")),
        rayon::current_num_threads()
    ));
}

/// What the record does not have.
pub(super) struct Counts {
    /// Number of identities.
    pub objects: usize,
    /// The hash of the input.
    pub sha256: Option<String>,
    /// How long the run took.
    pub duration: Duration,
    /// Whether the video is written if it is requested.
    pub has_video: bool,
}

/// The summary of a run; `roi` is the region of interest in the frames.
pub(super) fn summarise(
    job: &RunJob,
    roi: Option<&Roi>,
    info: &SourceInfo,
    record: &RunRecord,
    Counts { objects, sha256, duration, has_video }: Counts,
) -> Summary {
    let (times, decisions) = (&record.times, &record.results.decisions);
    let frames = times.len() as u32;
    let number = |frame: Option<&(u32, f64)>| frame.map_or(0, |&(number, _)| number);
    let seconds = duration.as_secs_f64();
    Summary {
        version: env!("CARGO_PKG_VERSION"),
        input: Input {
            path: info.name.clone(),
            size: info.source_size(),
            analysed_size: info.placement().map(|placement| placement.size()),
            fps: info.source_fps(),
            fps_from: info.fps_from.word(),
            options: job.options,
            range: job.range.map(|range| range.to_string()),
            frames,
            first_frame: number(times.first()),
            last_frame: number(times.last()),
            analysed: AnalysedFrames::of_numbers(times.iter().map(|&(number, _)| number)),
            sha256,
        },
        settings: job.settings.clone(),
        analysed_share: roi.map(Roi::share),
        objects,
        events: decisions.counters,
        episodes: decisions.episodes.len(),
        foreground_share: record.foreground_share,
        large_files: large_files(job, has_video),
        warnings: record.warnings.clone(),
        timing: Timing { seconds, frames_per_second: f64::from(frames) / seconds.max(f64::MIN_POSITIVE) },
    }
}

/// Writes the file.
pub(super) fn write(summary: &Summary, staging: &Staging) -> io::Result<()> {
    write_file(staging, FILE, |out| summary::write(out, summary))
}

/// The large files and folders that are written.
fn large_files(job: &RunJob, has_video: bool) -> Vec<&'static str> {
    let is_written = |bulky: &BulkyOutput| job.wants(bulky) && (has_video || bulky.flag != ANNOTATED.flag);
    bulky_output::ALL.iter().filter(|bulky| is_written(bulky)).map(|bulky| bulky.file).collect()
}

/// Prints the results, and a note for each large file of an earlier run.
pub(super) fn print(job: &RunJob, summary: &Summary) {
    job.console.note(&format!(
        "{}, {}, {}, {:.0} frames/s; written to {}",
        counted(summary.input.frames as usize, "frame", "frames"),
        counted(summary.objects, "object", "objects"),
        counted(summary.episodes, "occlusion episode", "occlusion episodes"),
        summary.timing.frames_per_second,
        job.out.display()
    ));
    for kind in EventKind::ALL {
        job.console.detail(&format!("{:>9}: {}", kind.name(), summary.events.of(kind)));
    }
    let bulky = bulky_output::ALL.iter().map(|bulky| (bulky.file, summary.large_files.contains(&bulky.file)));
    for (file, is_written) in bulky.chain([(ROI, job.roi.is_some())]) {
        let path = job.out.join(file);
        if !is_written && path.exists() {
            job.console.note(&format!("note: {} is not from this run", path.display()));
        }
    }
}
