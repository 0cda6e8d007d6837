//! The files that are always written, except the summary.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

use super::ROI;
use super::arguments::RunJob;
use super::record::RunRecord;
use super::result_spool::{FrameResults, ResultSpool};
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
    // A thread of the pool shares its work at less cost than one outside of it.
    rayon::scope(|_| write_by_frame(&record.results, staging))
}

/// Writes the tables that have rows for each frame, in a single pass. Returns the number of identities.
fn write_by_frame(results: &ResultSpool, staging: &Staging) -> io::Result<usize> {
    let create = |name| OutputFile::create(staging, name);
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

/// Writes one staged file.
pub(in crate::cli) fn write_file(
    staging: &Staging,
    name: &str,
    content: impl FnOnce(&mut OutputFile) -> io::Result<()>,
) -> io::Result<()> {
    let mut out = OutputFile::create(staging, name)?;
    content(&mut out)?;
    out.flush()
}

/// A staged file. Its errors name it, the cause, and a remedy.
pub(in crate::cli) struct OutputFile {
    path: PathBuf,
    out: BufWriter<File>,
}

impl OutputFile {
    fn create(staging: &Staging, name: &str) -> io::Result<Self> {
        let path = staging.path(name);
        let file = File::create(&path).map_err(|error| describe(&path, error))?;
        Ok(Self { path, out: BufWriter::new(file) })
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes).map_err(|error| describe(&self.path, error))
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes).map_err(|error| describe(&self.path, error))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush().map_err(|error| describe(&self.path, error))
    }
}
