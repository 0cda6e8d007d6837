//! `occluscope score`: scores the output of `run`, or anybody's tracks or masks, against ground truth.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::console::Console;
use super::flags;
use super::run::hexadecimal;
use super::scored_results::ScoredResults;
use super::standard_output;
use crate::source::name_of;
use crate::truth::comparison::Comparison;
use crate::truth::event_scoring::{self, EventScore};
use crate::truth::hota::Hota;
use crate::truth::mask_score;
use crate::truth::masks::MaskFiles;
use crate::truth::measures::Measures;
use crate::truth::meetings::MeetingScore;
use crate::truth::run_summary::{self, MasksOfRun};
use crate::truth::sequence_truth::{Occlusions, Scores, SequenceTruth};
use crate::truth::survival::Survival;
use crate::truth::{TruthError, alignment, counted};

/// Defines the subcommand.
pub fn command() -> Command {
    let command = Command::new("score")
        .about("Score the results of `run`, tracks or masks against ground truth")
        .after_help(
            "PATH is one of\n  a MOTChallenge gt.txt with any separator, or its sequence folder; CVAT for video XML \
             1.1; CAVIAR's CVML; COCO JSON with tracks; a zip that CVAT exports; a folder of label images: CLEAR-MOT and IDF1 at IoU \
             0.5 and 0.3, HOTA, identities kept through occlusion;\n  a CDnet folder (groundtruth/, ROI.bmp, \
             temporalROI.txt), or a folder of masks of 0 and 255: the seven mask measures; `run` needs \
             --masks;\n  a scene written by `synth`: tracks, events and episodes by kind (tolerance of 8 frames), \
             and masks if available.\n\nOnly frames that were analysed are judged: those in summary.json, else \
             all that seqinfo.ini states, or from the first to the last of a file of tracks; with --crop, only what is inside it. Boxes of confidence 0 and \
             of MOTChallenge's distractors are neither found nor missed. Frames that CVAT and CAVIAR number from 0 are read from 1.\n\n\
             Examples:\n  occluscope score results --truth gt.txt\n  occluscope score results --truth highway \
             --json\n  occluscope score results --truth crossing\n  occluscope score tracker.txt --truth MOT17-09\n  \
             occluscope score results --truth gt.txt --offset 1",
        )
        .arg(
            Arg::new("results")
                .value_name("DIR")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("Output folder of `run`, or a file of tracks, or a folder of masks or label images"),
        )
        .arg(
            Arg::new("truth")
                .long("truth")
                .value_name("PATH")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help(format!("Ground truth: {}; see below", flags::TRUTH)),
        )
        .arg(flags::offset())
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
    let offset = matches.get_one::<i64>("offset").copied().unwrap_or_default();
    let Scored { scores, notes } = Scored::of(&path("results"), &path("truth"), offset)?;
    let console = Console::new(matches);
    for note in &notes {
        console.note(note);
    }
    standard_output::write(|out| {
        if !matches.get_flag("json") {
            return Ok(print(&scores, out)?);
        }
        let json = Json {
            measures: scores.measures(),
            scores: &scores,
            truth_path: name_of(path("truth")),
            offset,
            summary_sha256: hash_of_summary(&path("results")),
        };
        serde_json::to_writer(&mut *out, &json).map_err(io::Error::from)?;
        Ok(writeln!(out)?)
    })
}

/// The SHA-256 of the summary in the output folder of a run, if there is one: it tells whether a score is of this run.
pub(super) fn hash_of_summary(folder: &Path) -> Option<String> {
    let summary = fs::read(folder.join(run_summary::FILE)).ok()?;
    Some(hexadecimal(&Sha256::digest(summary)))
}

/// What `--json` prints: the measures under short names, and all scores by what they are of.
#[derive(Serialize)]
struct Json<'a> {
    #[serde(flatten)]
    measures: Measures,
    #[serde(flatten)]
    scores: &'a Scores,
    truth_path: String,
    offset: i64,
    /// The hash of the summary of the run that is scored.
    #[serde(skip_serializing_if = "Option::is_none")]
    summary_sha256: Option<String>,
}

/// Scores, and what is to be known of them.
#[derive(Default)]
struct Scored {
    scores: Scores,
    notes: Vec<String>,
}

impl Scored {
    fn of(results: &Path, truth: &Path, offset: i64) -> anyhow::Result<Self> {
        let (results, mut truth) = (ScoredResults::of(results)?, SequenceTruth::read(truth, offset)?);
        if let Some(part) = results.part() {
            truth = truth.within(part);
        }
        let mut scored = Self::default();
        if results.has_roi() {
            scored.notes.push(
                "note: ground truth outside the region of interest of the run counts as missed; --crop of `run` leaves it \
                 out"
                .to_owned(),
            );
        }
        if let Some(masks) = &truth.masks {
            // Of a scene, which has boxes, too, the masks are judged where there are some.
            let may_lack = truth.tracks.is_some();
            let folder = if results.has_only_tracks() && may_lack {
                None
            } else {
                scored.masks_of(&results, may_lack)?
            };
            if let Some(folder) = folder {
                scored.add_masks(&folder, masks, &truth.path)?;
                if results.has_only_masks() {
                    return Ok(scored);
                }
            }
        }
        if let Some(tracks) = &truth.tracks {
            let found = results.tracks()?;
            let analysed = results.analysed(&found.boxes, &truth);
            let comparison = Comparison::new(tracks, &found, &analysed, offset);
            if truth.occlusions.is_none() && scored.scores.masks.is_none() {
                comparison.check_frames(&truth.path)?;
            }
            let reported =
                results.folder().filter(|folder| truth.occlusions.is_some() || Occlusions::are_in(folder));
            let reported = reported.map(Occlusions::read).transpose()?;
            scored.scores.add_tracks(&comparison, &truth, reported.as_ref());
            scored.add_notes(&comparison, &truth.path);
        }
        Ok(scored)
    }

    /// The folder of masks to judge. Fails if there is none, unless the results `may_lack` one.
    fn masks_of(&mut self, results: &ScoredResults, may_lack: bool) -> anyhow::Result<Option<PathBuf>> {
        let why = match results.masks()? {
            MasksOfRun::Of(folder) => return Ok(Some(folder)),
            MasksOfRun::None if may_lack => return Ok(None),
            MasksOfRun::None => format!("{} has no masks", results.path().display()),
            MasksOfRun::OfEarlierRun(folder) => {
                format!("{} is of an earlier run: the last one wrote no masks", folder.display())
            }
        };
        if !may_lack {
            bail!("{why}; run again with --masks");
        }
        self.notes.push(format!("note: {why}; masks are not judged"));
        Ok(None)
    }

    fn add_notes(&mut self, comparison: &Comparison<'_>, truth: &Path) {
        let truth = truth.display();
        self.notes.push(format!("note: {truth}: {}", comparison.note()));
        if let Some(offset) = comparison.better_offset() {
            self.notes.push(format!(
                "warning: {truth}: its boxes match better with --offset {offset}; check where its frame numbers start"
            ));
        }
    }

    fn add_masks(&mut self, folder: &Path, masks: &MaskFiles, truth: &Path) -> Result<(), TruthError> {
        let score = mask_score::score(folder, masks)?;
        let outside = masks.part().map(|part| format!("; pixels outside the crop {part} do not count"));
        self.notes.push(format!(
            "note: {}: {}; {} judged, those with a mask in {}{}",
            truth.display(),
            counted(masks.numbers().count(), "mask", "masks"),
            counted(score.frames, "frame is", "frames are"),
            folder.display(),
            outside.unwrap_or_default()
        ));
        if let Some(remark) = masks.remark() {
            self.notes.push(format!("warning: {}: {remark}", truth.display()));
        }
        if let Some(more) = alignment::better_offset_of_masks(masks, &mask_score::results_in(folder)?)? {
            self.notes.push(format!(
                "warning: {}: its masks match better with --offset {}; check where its frame numbers start",
                truth.display(),
                masks.offset() + more
            ));
        }
        self.scores.masks = Some(score);
        Ok(())
    }
}

fn print(scores: &Scores, out: &mut impl Write) -> io::Result<()> {
    let of_tracks = scores.tracks.iter();
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
    if let Some(tracks) = &scores.tracks {
        let Hota { hota, deta, assa, loca } = tracks.hota;
        writeln!(
            out,
            "HOTA      HOTA {hota:.3}  DetA {deta:.3}  AssA {assa:.3}  LocA {loca:.3}  (means over IoU 0.05 to \
             0.95)"
        )?;
        let Survival { episodes, identities, survived, .. } = &tracks.occlusion;
        writeln!(
            out,
            "occlusion {survived} of {identities} identities kept through {}",
            counted(*episodes, "occlusion episode", "occlusion episodes")
        )?;
    }
    if let Some(MeetingScore { truth, found, recall, reported, right, precision }) = &scores.meetings {
        writeln!(
            out,
            "episodes  {found} of {} found: recall {recall:.3}  {right} of {reported} reported right: \
             precision {precision:.3}",
            counted(*truth, "true meeting", "true meetings")
        )?;
    }
    for (title, found) in [("events", &scores.events), ("episodes", &scores.episodes)] {
        let Some(found) = found else { continue };
        writeln!(out, "{title}")?;
        let all = event_scoring::total(found);
        let kinds = found.iter().map(|(kind, score)| (kind.as_str(), score));
        for (kind, EventScore { truth, reported, matched, precision, recall }) in kinds.chain([("all", &all)])
        {
            writeln!(
                out,
                "  {kind:13} TP {matched}, GT {truth}, reported {reported}: precision {precision:.3}  \
                 recall {recall:.3}"
            )?;
        }
    }
    if let Some(score) = &scores.masks {
        writeln!(
            out,
            "masks     F {:.4}  precision {:.4}  recall {:.4}  specificity {:.4}  FPR {:.4}  FNR {:.4}  PWC {:.3}  ({})",
            score.f_measure,
            score.precision,
            score.recall,
            score.specificity,
            score.fpr,
            score.fnr,
            score.pwc,
            counted(score.frames, "frame", "frames")
        )?;
    }
    Ok(())
}
