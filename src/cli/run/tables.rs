//! The files that are always written, except the summary.

use std::fs::File;
use std::io::{self, BufWriter, Write};

use anyhow::Context as _;

use super::ROI;
use super::arguments::RunJob;
use super::record::RunRecord;
use crate::export::{Staging, episodes_csv, events_jsonl, picture, regions_csv, tracks_csv, tracks_json};

/// Writes the settings, the region of interest and the tables of the offline result.
pub(super) fn write(record: &RunRecord, job: &RunJob, staging: &Staging) -> anyhow::Result<()> {
    let RunRecord { result, regions, .. } = record;
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
        picture::write_mask(&staging.path(ROI), roi.mask())
            .with_context(|| format!("{ROI} cannot be written"))?;
    }
    write_file(staging, "tracks.csv", |out| tracks_csv::write(out, &result.tracks))?;
    write_file(staging, "tracks.json", |out| tracks_json::write(out, &result.tracks))?;
    write_file(staging, "regions.csv", |out| regions_csv::write(out, regions, &result.tracks))?;
    write_file(staging, "events.jsonl", |out| events_jsonl::write(out, &result.events, &result.tracks))?;
    write_file(staging, "episodes.csv", |out| episodes_csv::write(out, &result.episodes))
}

/// Writes one staged file.
pub(in crate::cli) fn write_file(
    staging: &Staging,
    name: &str,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> anyhow::Result<()> {
    let write = || {
        let mut out = BufWriter::new(File::create(staging.path(name))?);
        content(&mut out)?;
        out.flush()
    };
    write().with_context(|| format!("{name} cannot be written"))
}
