//! `occluscope export`: the tracks of a results folder in the formats of other tools.

mod results;

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::PathBuf;

use anyhow::Context as _;
use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgMatches, Command, value_parser};

use super::console::Console;
use super::flags;
use super::inputs;
use super::out_file::OutFile;
use crate::export::staging::IsFolder;
use crate::export::track_table::TrackTable;
use crate::export::{coco_json, cvat_xml, mot_zip};

/// A format of another tool.
struct Format {
    /// Its name on the command line.
    word: &'static str,
    /// The name of its file.
    file: &'static str,
    write: fn(&mut BufWriter<File>, &TrackTable) -> io::Result<()>,
}

const FORMATS: [Format; 3] = [
    Format { word: "coco", file: "coco.json", write: coco_json::write },
    Format { word: "cvat", file: "cvat.xml", write: cvat_xml::write },
    Format { word: "mot", file: "mot.zip", write: mot_zip::write },
];

/// Defines the subcommand.
pub fn command() -> Command {
    let command = Command::new("export")
        .about("Convert the tracks of `run` into a format of other tools")
        .after_help(
            "Formats:\n  coco  COCO JSON with videos, frame_id and track_id; images are named as by `run \
             --plain-frames`\n  cvat  \"CVAT for video 1.1\": a track for each object, occluded where its box is \
             predicted\n  mot   \"MOT 1.1\": gt/gt.txt and gt/labels.txt in a ZIP file\n\nIt reads tracks.json and \
             summary.json. All objects have the label `object`, which a CVAT task must have.\n\nExamples:\n  \
             occluscope export results --format coco\n  occluscope export results --format cvat --out \
             street.xml\n  occluscope export results --format mot --first 470",
        )
        .arg(
            Arg::new("results")
                .value_name("DIR")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("Output folder of `run`"),
        )
        .arg(
            Arg::new("format")
                .long("format")
                .value_name("NAME")
                .required(true)
                .value_parser(PossibleValuesParser::new(FORMATS.map(|format| format.word)))
                .help("The format"),
        )
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("FILE")
                .value_parser(value_parser!(PathBuf))
                .help("Output file [default: coco.json, cvat.xml or mot.zip in DIR]"),
        )
        .arg(
            Arg::new("first")
                .long("first")
                .value_name("N")
                .default_value("1")
                .value_parser(value_parser!(u32))
                .help("The number of the frame that the other tool counts as its first"),
        );
    flags::with_common(command)
}

/// The files of a results folder, which none of these formats may replace.
const TABLES: [&str; 7] = [
    "summary.json",
    "tracks.csv",
    "tracks.json",
    "regions.csv",
    "events.jsonl",
    "episodes.csv",
    "settings.toml",
];

/// Writes the file.
pub fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    let path = |name: &str| matches.get_one::<PathBuf>(name).cloned();
    let folder = path("results").unwrap_or_default();
    let word = matches.get_one::<String>("format").map_or("", String::as_str);
    let first = matches.get_one::<u32>("first").copied().unwrap_or(1);
    let console = Console::new(matches);
    // The command line accepts the words of the table only.
    let format = FORMATS.iter().find(|format| format.word == word).context("the format is unknown")?;

    let table = results::read(&folder, first, console)?;
    let out = path("out").unwrap_or_else(|| folder.join(format.file));
    let tables = TABLES.map(|name| folder.join(name));
    inputs::protect(&tables, [(out.as_path(), IsFolder::No)])?;
    OutFile::begin(&out)?.write(|file| Ok((format.write)(file, &table)?))?;
    console.note(&format!("{} boxes; written to {}", table.boxes.len(), out.display()));
    Ok(())
}
