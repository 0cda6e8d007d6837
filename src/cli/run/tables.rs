//! The files that are always written, except the summary.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Write};

use super::ROI;
use super::arguments::RunJob;
use super::record::RunRecord;
use super::result_spool::FrameResults;
use crate::export::tracks_json::TracksJson;
use crate::export::write_failure::describe;
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
    let mut identities = BTreeSet::new();
    write_file(staging, "tracks.csv", |out| {
        record.results.frames()?.try_for_each(|frame| {
            let tracks = frame?.tracks;
            identities.extend(tracks.tracks.iter().map(|track| track.id));
            tracks_csv::write_frame(out, &tracks)
        })
    })?;
    write_file(staging, "tracks.json", |out| {
        let mut json = TracksJson::new(out)?;
        record.results.frames()?.try_for_each(|frame| json.write_frame(&frame?.tracks))?;
        json.finish()
    })?;
    write_file(staging, "regions.csv", |out| {
        regions_csv::write_header(out)?;
        record.results.frames()?.try_for_each(|frame| {
            let FrameResults { tracks, regions } = frame?;
            regions_csv::write_frame(out, &regions, &tracks.tracks)
        })
    })?;
    Ok(identities.len())
}

/// Writes one staged file.
pub(in crate::cli) fn write_file(
    staging: &Staging,
    name: &str,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    let path = staging.path(name);
    let write = || {
        let mut out = BufWriter::new(File::create(&path)?);
        content(&mut out)?;
        out.flush()
    };
    write().map_err(|error| describe(&path, error))
}
