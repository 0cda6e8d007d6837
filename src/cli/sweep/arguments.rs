//! The definition of the subcommand, and its arguments.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context as _, bail};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};

use crate::cli::console::Console;
use crate::cli::flags::{self, FrameRange, UsageError};
use crate::cli::source_flags;
use crate::regions::Roi;
use crate::settings::Settings;
use crate::source::{Options, path_of};
use crate::sweep::data_set::{self, Sequence};
use crate::sweep::grid::{Axis, Grid, GridError};
use crate::truth::measures::{self, MeasureColumn, OBJECTIVE};

/// Defines the subcommand.
pub fn command() -> Command {
    let path = |name: &'static str, value: &'static str, help: &'static str| {
        Arg::new(name).long(name).value_name(value).value_parser(value_parser!(PathBuf)).help(help)
    };
    let measures: Vec<_> = measures::COLUMNS.iter().map(|column| column.name).collect();
    let command = Command::new("sweep")
        .about("Score every combination of some settings against ground truth, on a video or a data set")
        .after_help(
            "Writes into DIR: sweep.csv (a row per sequence and combination), categories.csv (CDnet's means of masks by category, where \
             sequences are in folders of categories), settings.toml (the settings outside the \
             grid), heatmaps/, report.html; rows.jsonl holds the rows that are complete, so that the same command goes \
             on where an earlier one was stopped, and computes only what a changed grid adds.\n\nThe best rows are \
             printed: of each sequence, and of the one setting that is best overall, where categories (the folders \
             between ROOT and the sequences) weigh the same.\n\nExamples:\n  occluscope sweep street.mp4 --truth gt.txt \
             --grid k=3,4,5 --grid alpha=log:0.0005..0.05:9 --out swept\n  occluscope sweep --dataset CDnet2014 --out \
             scores\n  occluscope sweep --dataset MOT17 --grid t=0.5..0.9:5 --by idf1 --out swept",
        )
        .arg(flags::video())
        .arg(
            Arg::new("truth")
                .long("truth")
                .value_name("PATH")
                .value_parser(value_parser!(PathBuf))
                .help(format!("Ground truth of VIDEO: {}", flags::TRUTH)),
        )
        .arg(flags::offset())
        .arg(path(
            "dataset",
            "ROOT",
            "All sequences below this folder: folders with images in input/ or img1/, or one video file, beside \
             groundtruth/ or gt/gt.txt, and scenes written by `synth`",
        ))
        .arg(
            Arg::new("sequence")
                .long("sequence")
                .value_names(["NAME", "VIDEO", "TRUTH"])
                .value_parser(flags::source_name())
                .num_args(3)
                .action(ArgAction::Append)
                .help("A sequence with its ground truth; repeat it for several"),
        )
        .arg(
            Arg::new("grid")
                .long("grid")
                .value_name("SETTING=VALUES")
                .action(ArgAction::Append)
                .help(
                    "Values of a setting: a list (k=3,4,5), a range of N at equal steps (t=0.5..0.9:N) or at equal \
                     ratios (alpha=log:0.0005..0.05:N); repeat it for several settings. Without it the settings as they \
                     are",
                ),
        )
        .arg(Arg::new("by").long("by").value_name("MEASURE").help(format!(
            "The measure by which settings are ranked: {} [default: {}]",
            measures.join(", "),
            OBJECTIVE.meaning
        )))
        .arg(path(
            "results",
            "DIR",
            "Take the rows whose runs are below this folder, in output folders of `run` with the output of `score \
             --json` as score.json, instead of computing them",
        ))
        .arg(
            path("out", "DIR", "Output folder; created if it does not exist").required(true),
        );
    flags::with_settings(flags::with_common(flags::with_roi(flags::with_range(source_flags::with_options(
        command,
    )))))
}

/// The arguments of a sweep.
pub(super) struct SweepJob {
    pub sequences: Vec<Sequence>,
    /// The folder of the data set, if the sequences are those of one.
    pub data_set: Option<PathBuf>,
    pub grid: Grid,
    /// The settings outside the grid.
    pub base: Settings,
    /// What is added to the frame numbers of the ground truth.
    pub offset: i64,
    pub roi: Option<Arc<Roi>>,
    pub range: Option<FrameRange>,
    pub options: Options,
    /// The measure by which combinations are ranked.
    pub by: &'static MeasureColumn,
    /// The folder with results of `run`.
    pub results: Option<PathBuf>,
    pub out: PathBuf,
    pub console: Console,
}

impl SweepJob {
    pub(super) fn new(matches: &ArgMatches) -> anyhow::Result<Self> {
        let texts = matches.get_many::<String>("grid").into_iter().flatten();
        let axes = texts.map(|text| Axis::of_text(text)).collect::<Result<_, _>>().map_err(usage)?;
        Ok(Self {
            sequences: sequences(matches)?,
            data_set: matches.get_one("dataset").cloned(),
            grid: Grid::new(axes).map_err(usage)?,
            base: flags::settings(matches)?,
            offset: matches.get_one("offset").copied().unwrap_or_default(),
            roi: flags::roi(matches)?,
            range: flags::range(matches)?,
            options: source_flags::options(matches)?,
            by: measure(matches)?,
            results: matches.get_one("results").cloned(),
            out: matches.get_one::<PathBuf>("out").cloned().unwrap_or_default(),
            console: Console::new(matches),
        })
    }
}

#[allow(clippy::needless_pass_by_value)] // For `map_err`.
fn usage(error: GridError) -> UsageError {
    UsageError(error.to_string())
}

/// The sequences that are named in one of the three ways.
fn sequences(matches: &ArgMatches) -> anyhow::Result<Vec<Sequence>> {
    let video = matches.get_one::<String>("video");
    let truth = matches.get_one::<PathBuf>("truth");
    let root = matches.get_one::<PathBuf>("dataset");
    let named: Vec<&String> = matches.get_many("sequence").into_iter().flatten().collect();
    let sequences = match (video, truth, root, named.is_empty()) {
        (Some(video), Some(truth), None, true) => {
            let path = path_of(video);
            let name = data_set::sequence_name(path.file_stem().unwrap_or(path.as_os_str()));
            vec![Sequence { name, video: video.clone(), truth: truth.clone() }]
        }
        (None, None, Some(root), true) => {
            let found = data_set::sequences_below(root).with_context(|| {
                format!("{} cannot be read; check its path and permissions", root.display())
            })?;
            for (why, names) in &found.left_out {
                Console::new(matches).note(&format!(
                    "warning: {} below {} left out: {}",
                    names.join(", "),
                    root.display(),
                    why.text()
                ));
            }
            if found.sequences.is_empty() {
                bail!(
                    "{} has no sequences; they are folders with images in input/ or img1/, or one video file, beside \
                     groundtruth/ or gt/gt.txt, and scenes written by `synth`",
                    root.display()
                );
            }
            found.sequences
        }
        (None, None, None, false) => named
            .chunks_exact(3)
            .map(|of| Sequence {
                name: of[0].clone(),
                video: of[1].clone(),
                truth: path_of(of[2]).into_owned(),
            })
            .collect(),
        _ => {
            return Err(UsageError(
                "give one of: a video with its ground truth (VIDEO --truth PATH), --dataset ROOT, --sequence NAME VIDEO TRUTH"
                    .to_owned(),
            )
            .into());
        }
    };
    for (at, sequence) in sequences.iter().enumerate() {
        if sequences[..at].iter().any(|other| other.name == sequence.name) {
            return Err(UsageError(format!("two sequences have the name {}", sequence.name)).into());
        }
        if sequence.name.trim().is_empty() || sequence.name.contains(char::is_control) {
            return Err(UsageError(format!("a sequence cannot have the name {:?}", sequence.name)).into());
        }
    }
    Ok(sequences)
}

/// The measure to rank by.
fn measure(matches: &ArgMatches) -> Result<&'static MeasureColumn, UsageError> {
    let Some(name) = matches.get_one::<String>("by") else { return Ok(&OBJECTIVE) };
    measures::column(name).ok_or_else(|| {
        let names: Vec<_> = measures::COLUMNS.iter().map(|column| column.name).collect();
        UsageError(format!("--by cannot be `{name}`: the measures are {}", names.join(", ")))
    })
}
