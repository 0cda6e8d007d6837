//! `occluscope score`: scores the output of `run` against ground truth.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use serde::{Deserialize, Serialize};

use super::flags;
use crate::source::Options;
use crate::truth::boxes::{self, Boxes};
use crate::truth::event_scoring::{self, EventScore, ScoredEvent};
use crate::truth::mask_score::{self, MaskScore};
use crate::truth::masks::MaskFiles;
use crate::truth::summary::{self, TrackScore};
use crate::truth::survival::Survival;
use crate::truth::{self, TruthSource};

/// Largest deviation in frames of events and of the ends of episodes.
const TOLERANCE: u32 = 8;

/// Defines the subcommand.
pub fn command() -> Command {
    let command = Command::new("score")
        .about("Score the results of `run` against ground truth")
        .after_help(
            "PATH is one of\n  a MOTChallenge gt.txt: CLEAR-MOT and IDF1 at IoU 0.5 and 0.3, identities \
             kept through occlusion;\n  a CDnet folder (groundtruth/, ROI.bmp, temporalROI.txt): the seven \
             mask measures; `run` needs --masks;\n  a scene written by `synth`: tracks, events and \
             episodes by kind (tolerance of 8 frames), and masks if available.\n\nExamples:\n  occluscope \
             score results --truth gt.txt\n  occluscope score results --truth highway --json\n  occluscope \
             score results --truth crossing",
        )
        .arg(
            Arg::new("results")
                .value_name("DIR")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("Output folder of `run`"),
        )
        .arg(
            Arg::new("truth")
                .long("truth")
                .value_name("PATH")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("A MOTChallenge file, a CDnet folder, or a scene written by `synth`"),
        )
        .arg(
            Arg::new("json")
                .long("json")
                .action(ArgAction::SetTrue)
                .help("Print one JSON object instead of text"),
        );
    flags::with_common(command)
}

/// Computes and prints the scores.
pub fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    flags::start_threads(matches)?;
    let path = |name: &str| matches.get_one::<PathBuf>(name).cloned().unwrap_or_default();
    let scores = Scores::of(&path("results"), &path("truth"))?;
    let mut out = io::stdout().lock();
    if matches.get_flag("json") {
        serde_json::to_writer(&mut out, &scores)?;
        writeln!(out)?;
    } else {
        scores.print(&mut out)?;
    }
    Ok(out.flush()?)
}

/// All scores that the ground truth permits.
#[derive(Default, Serialize)]
struct Scores {
    #[serde(flatten)]
    tracks: Option<TrackScore>,
    #[serde(skip_serializing_if = "Option::is_none")]
    events: Option<BTreeMap<String, EventScore>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    episodes: Option<BTreeMap<String, EventScore>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    masks: Option<MaskScore>,
}

impl Scores {
    fn of(results: &Path, truth: &Path) -> anyhow::Result<Self> {
        if !results.is_dir() {
            bail!("{} is not a results folder; give the output folder of `run --out`", results.display());
        }
        match TruthSource::of(truth)? {
            TruthSource::Boxes(file) => Ok(Self::of_tracks(&boxes::read(&file)?, &tracks(results)?, results)),
            TruthSource::Cdnet(folder) => {
                let masks = mask_score::score(&results.join("masks"), &MaskFiles::of_cdnet(&folder)?)?;
                Ok(Self { masks: Some(masks), ..Self::default() })
            }
            TruthSource::Scene(folder) => Self::of_scene(results, &folder),
        }
    }

    fn of_tracks(truth: &Boxes, found: &Boxes, results: &Path) -> Self {
        let tracks = match Sampling::of(results) {
            Some(sampling) => summary::score_of_frames(truth, found, |number| sampling.contains(number)),
            None => summary::score(truth, found),
        };
        Self { tracks: Some(tracks), ..Self::default() }
    }

    fn of_scene(results: &Path, scene: &Path) -> anyhow::Result<Self> {
        let (truth, found) = (truth::boxes_of_scene(scene)?, tracks(results)?);
        let people = event_scoring::people(&truth, &found);
        let compare = |truth: Vec<ScoredEvent>, found: Vec<ScoredEvent>| {
            event_scoring::compare(&truth, &found, &people, TOLERANCE)
        };
        let events = |folder: &Path| event_scoring::read_events(&folder.join("events.jsonl"));
        let episodes = |folder: &Path| event_scoring::read_episodes(&folder.join("episodes.csv"));
        let masks = results.join("masks");
        let files = if masks.is_dir() { truth::masks_of_scene(scene)? } else { None };
        Ok(Self {
            events: Some(compare(events(scene)?, events(results)?)),
            episodes: Some(compare(episodes(scene)?, episodes(results)?)),
            masks: files.map(|files| mask_score::score(&masks, &files)).transpose()?,
            ..Self::of_tracks(&truth, &found, results)
        })
    }

    fn print(&self, out: &mut impl Write) -> io::Result<()> {
        let of_tracks = self.tracks.iter();
        for (name, score) in
            of_tracks.flat_map(|tracks| [("IoU 0.5", &tracks.strict), ("IoU 0.3", &tracks.loose)])
        {
            writeln!(
                out,
                "{name}   MOTA {:.3}  IDF1 {:.3}  precision {:.3}  recall {:.3}  MOTP {:.3}  IDSW {}  \
                 fragmentations {}  mostly tracked {} of {}",
                score.mota,
                score.idf1,
                score.precision,
                score.recall,
                score.motp,
                score.num_switches,
                score.num_fragmentations,
                score.mostly_tracked,
                score.num_unique_objects
            )?;
        }
        if let Some(tracks) = &self.tracks {
            let Survival { episodes, identities, survived, .. } = &tracks.occlusion;
            writeln!(
                out,
                "occlusion {survived} of {identities} identities kept through {episodes} occlusion episodes"
            )?;
        }
        for (title, found) in [("events", &self.events), ("episodes", &self.episodes)] {
            let Some(found) = found else { continue };
            writeln!(out, "{title}")?;
            for (kind, EventScore { truth, reported, matched, precision, recall }) in found {
                writeln!(
                    out,
                    "  {kind:13} TP {matched}, GT {truth}, reported {reported}: precision {precision:.3}  \
                     recall {recall:.3}"
                )?;
            }
        }
        if let Some(score) = &self.masks {
            writeln!(
                out,
                "masks     F {:.4}  precision {:.4}  recall {:.4}  specificity {:.4}  FPR {:.4}  FNR {:.4}  PWC {:.3}  ({} frames)",
                score.f_measure,
                score.precision,
                score.recall,
                score.specificity,
                score.fpr,
                score.fnr,
                score.pwc,
                score.frames
            )?;
        }
        Ok(())
    }
}

fn tracks(results: &Path) -> anyhow::Result<Boxes> {
    Ok(boxes::read(&results.join("tracks.csv"))?)
}

/// The frames of a run that left out others.
struct Sampling {
    first_frame: u32,
    every: NonZeroU32,
}

impl Sampling {
    /// From the summary of a run; `None` where it left out no frame, or there is no summary.
    fn of(results: &Path) -> Option<Self> {
        #[derive(Deserialize)]
        struct Summary {
            input: Input,
        }
        #[derive(Deserialize)]
        struct Input {
            first_frame: u32,
            #[serde(default)]
            options: Options,
        }
        let text = fs::read_to_string(results.join("summary.json")).ok()?;
        let Summary { input } = serde_json::from_str(&text).ok()?;
        Some(Self { first_frame: input.first_frame, every: input.options.every? })
    }

    fn contains(&self, number: u32) -> bool {
        number.abs_diff(self.first_frame).is_multiple_of(self.every.get())
    }
}
