//! The files of a sweep.

use std::fs;
use std::io::Write as _;
use std::path::Path;

use super::arguments::SweepJob;
use super::opened_sequence::OpenedSequence;
use crate::cli::staged_file::write_file;
use crate::export::heat_map::{HeatMapFile, is_name_of_map};
use crate::export::report::{self, Report};
use crate::export::staging::IsFolder;
use crate::export::{Staging, categories_csv, heat_map, picture, sweep_csv};
use crate::source::Options;
use crate::sweep::sequence_frames::SequenceFrames;
use crate::sweep::table::SweepTable;

/// The name of the table.
const TABLE: &str = "sweep.csv";
/// The name of the table of categories.
const CATEGORIES: &str = "categories.csv";
/// The name of the folder of heat maps.
const MAPS: &str = "heatmaps";

/// The names of all files and folders.
pub(super) const TARGETS: [(&str, IsFolder); 5] = [
    ("settings.toml", IsFolder::No),
    (TABLE, IsFolder::No),
    (CATEGORIES, IsFolder::No),
    (MAPS, IsFolder::Yes),
    ("report.html", IsFolder::No),
];

/// Writes all files of a sweep; `failures` are those of sequences whose rows are missing.
pub(super) fn write(
    job: &SweepJob,
    sequences: &[OpenedSequence],
    table: &SweepTable,
    frames: &[SequenceFrames],
    failures: &[String],
    staging: Staging,
) -> anyhow::Result<()> {
    write_file(&staging, "settings.toml", |out| out.write_all(job.base.to_toml().as_bytes()))?;
    write_file(&staging, TABLE, |out| sweep_csv::write(out, table))?;
    let has_categories = categories_csv::has_rows(table);
    if has_categories {
        write_file(&staging, CATEGORIES, |out| categories_csv::write(out, table))?;
    }
    let (maps, left_out) = heat_map::files(table);
    if !maps.is_empty() {
        let folder = staging.folder(MAPS)?;
        for map in &maps {
            let path = folder.join(&map.name);
            picture::write_frame(&path, &map.draw(table))?;
        }
    }
    if left_out > 0 {
        job.console.note(&format!(
            "note: {left_out} heat maps are not written to {}; they are in report.html",
            job.out.join(MAPS).display()
        ));
    }
    let report = Report {
        title: &title(job),
        table,
        frames,
        base: &job.base,
        facts: &facts(job, sequences),
        warnings: failures,
    };
    write_file(&staging, "report.html", |out| report::write(out, &report))?;
    let is_repeated = job.out.join(TABLE).is_file();
    staging.publish(TABLE)?;
    if is_repeated {
        remove_other_maps(&job.out.join(MAPS), &maps);
        if !has_categories {
            remove_categories(&job.out.join(CATEGORIES));
        }
    }
    Ok(())
}

/// Removes the heat maps of an earlier sweep into the same folder. One that cannot be removed stays.
fn remove_other_maps(folder: &Path, maps: &[HeatMapFile]) {
    for path in fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if is_name_of_map(&name) && !maps.iter().any(|map| map.name == name) {
            let _ = fs::remove_file(&path);
        }
    }
}

/// Removes the table of categories of an earlier sweep into the same folder. One that cannot be removed stays.
fn remove_categories(path: &Path) {
    let start = format!("{},", categories_csv::CATEGORY);
    if fs::read(path).is_ok_and(|bytes| bytes.starts_with(start.as_bytes())) {
        let _ = fs::remove_file(path);
    }
}

/// The name of the data set, or of the sequences.
fn title(job: &SweepJob) -> String {
    match (&job.data_set, job.sequences.as_slice()) {
        (Some(root), _) => {
            let name = root.canonicalize().ok().and_then(|root| root.file_name().map(ToOwned::to_owned));
            name.map_or_else(|| root.display().to_string(), |name| name.to_string_lossy().into_owned())
        }
        (None, [only]) => only.name.clone(),
        (None, several) => format!("{} sequences", several.len()),
    }
}

/// Where the rows are from.
fn facts(job: &SweepJob, sequences: &[OpenedSequence]) -> Vec<(&'static str, String)> {
    let mut facts = vec![("version", env!("OCCLUSCOPE_VERSION").to_owned())];
    for sequence in sequences {
        let info = &sequence.info;
        let frames = info.frames.map_or_else(String::new, |frames| format!(", {frames} frames"));
        facts.push((
            "sequence",
            format!(
                "{}: {}, {}{frames}, {} frames/s; ground truth {}",
                sequence.name,
                sequence.video,
                info.source_size(),
                info.source_fps(),
                sequence.truth.path.display()
            ),
        ));
    }
    facts.extend(job.range.map(|range| ("frames", range.to_string())));
    if job.options != Options::default() {
        let options = serde_json::to_string(&job.options).unwrap_or_default();
        facts.push(("options of the source", options));
    }
    if job.offset != 0 {
        facts.push(("offset of the ground truth", job.offset.to_string()));
    }
    if let Some(roi) = &job.roi {
        facts.push(("region of interest", format!("{:.1} % of the image", 100.0 * roi.share())));
    }
    facts
}
