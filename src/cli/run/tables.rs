//! The files that are always written, except the summary.

use std::collections::BTreeSet;
use std::io::{self, Write};

use super::ROI;
use super::arguments::RunJob;
use super::record::RunRecord;
use super::result_spool::{FrameResults, ResultSpool};
use crate::cli::staged_file::{StagedFile, write_file};
use crate::export::tracks_json::TracksJson;
use crate::export::{Staging, episodes_csv, events_jsonl, picture, regions_csv, tracks_csv};
use crate::pipeline::LateDecisions;

/// The names of the files that are always written, except the region of interest.
pub(super) const FILES: [&str; 6] =
    ["settings.toml", "tracks.csv", "tracks.json", "regions.csv", "events.jsonl", "episodes.csv"];

/// Writes the settings, the region of interest and the tables of the offline result. Returns the number of identities.
pub(super) fn write(record: &RunRecord, job: &RunJob, staging: &Staging) -> io::Result<usize> {
    write_file(staging, "settings.toml", |out| {
        out.write_all(job.settings.to_toml().as_bytes())?;
        if job.roi.is_some() {
            writeln!(
                out,
                "# Only the bright pixels of {ROI} are analysed; to repeat this run, add --roi {ROI}"
            )?;
        }
        Ok(())
    })?;
    if let Some(roi) = &job.roi {
        picture::write_mask(&staging.path(ROI), roi.mask())?;
    }
    let LateDecisions { events, episodes, .. } = &record.results.decisions;
    write_file(staging, "events.jsonl", |out| events_jsonl::write(out, events, &record.times))?;
    write_file(staging, "episodes.csv", |out| episodes_csv::write(out, episodes))?;
    // Only to work on a thread of the pool, which shares its work at less cost than one outside of it.
    rayon::scope(|_| write_by_frame(&record.results, staging))
}

/// Writes the tables that have rows for each frame, in a single pass. Returns the number of identities.
fn write_by_frame(results: &ResultSpool, staging: &Staging) -> io::Result<usize> {
    let create = |name| StagedFile::create(staging, name);
    let (mut tracks_out, mut regions_out) = (create("tracks.csv")?, create("regions.csv")?);
    let mut json = TracksJson::new(create("tracks.json")?)?;
    regions_csv::write_header(&mut regions_out)?;
    let mut identities = BTreeSet::new();
    for frame in results.frames()? {
        let FrameResults { tracks, regions } = frame?;
        identities.extend(tracks.tracks.iter().map(|track| track.id));
        let (of_tracks, (of_json, of_regions)) = rayon::join(
            || tracks_csv::write_frame(&mut tracks_out, &tracks),
            || {
                rayon::join(
                    || json.write_frame(&tracks),
                    || regions_csv::write_frame(&mut regions_out, &regions, &tracks.tracks),
                )
            },
        );
        of_tracks.and(of_json).and(of_regions)?;
    }
    tracks_out.flush()?;
    json.finish()?;
    regions_out.flush()?;
    Ok(identities.len())
}
