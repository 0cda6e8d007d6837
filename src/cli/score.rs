//! `occluscope score`: scores the output of `run`, or anybody's tracks or masks, against ground truth.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use serde::Serialize;

use super::console::Console;
use super::flags;
use super::scored_results::{AnalysedFrames, ScoredResults};
use crate::truth::alignment;
use crate::truth::boxes::{Boxes, shifted, shifted_number, span};
use crate::truth::event_scoring::{self, EventScore, ScoredEvent};
use crate::truth::formats::TrackFile;
use crate::truth::hota::Hota;
use crate::truth::ignored::without_ignored;
use crate::truth::mask_score::{self, MaskScore};
use crate::truth::masks::MaskFiles;
use crate::truth::measures::Measures;
use crate::truth::summary::{self, TrackScore};
use crate::truth::survival::Survival;
use crate::truth::{TruthError, TruthSource};

/// F measure of masks below which other offsets are tried.
const POOR_F: f64 = 0.5;

/// Largest deviation in frames of events and of the ends of episodes.
const TOLERANCE: u32 = 8;

/// Defines the subcommand.
pub fn command() -> Command {
    let command = Command::new("score")
        .about("Score the results of `run`, tracks or masks against ground truth")
        .after_help(
            "PATH is one of\n  a MOTChallenge gt.txt with any separator, or its sequence folder; CVAT for video XML \
             1.1; CAVIAR's CVML; COCO JSON with tracks; a folder of 16-bit label images: CLEAR-MOT and IDF1 at IoU \
             0.5 and 0.3, HOTA, identities kept through occlusion;\n  a CDnet folder (groundtruth/, ROI.bmp, \
             temporalROI.txt), or a folder of masks of 0 and 255: the seven mask measures; `run` needs \
             --masks;\n  a scene written by `synth`: tracks, events and episodes by kind (tolerance of 8 frames), \
             and masks if available.\n\nOnly frames that were analysed are judged: those in summary.json, or from \
             the first to the last of a file of tracks. Boxes of confidence 0 and of MOTChallenge's distractors are \
             neither found nor missed. Frames that CVAT and CAVIAR number from 0 are read from 1.\n\n\
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
                .help("Ground truth: tracks, masks, or a scene written by `synth`; see below"),
        )
        .arg(
            Arg::new("offset")
                .long("offset")
                .value_name("N")
                .allow_negative_numbers(true)
                .value_parser(value_parser!(i64).range(-(1 << 32)..=1 << 32))
                .default_value("0")
                .help("Add N to the frame numbers of the ground truth"),
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
    let offset = matches.get_one::<i64>("offset").copied().unwrap_or_default();
    let Scored { scores, notes } = Scored::of(&path("results"), &path("truth"), offset)?;
    let console = Console::new(matches);
    for note in &notes {
        console.note(note);
    }
    let mut out = io::stdout().lock();
    if matches.get_flag("json") {
        serde_json::to_writer(&mut out, &Json { measures: scores.measures(), scores: &scores })?;
        writeln!(out)?;
    } else {
        scores.print(&mut out)?;
    }
    Ok(out.flush()?)
}

/// What `--json` prints: the measures under short names, and all scores by what they are of.
#[derive(Serialize)]
struct Json<'a> {
    #[serde(flatten)]
    measures: Measures,
    #[serde(flatten)]
    scores: &'a Scores,
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

/// Scores, and what is to be known of them.
#[derive(Default)]
struct Scored {
    scores: Scores,
    notes: Vec<String>,
}

impl Scored {
    fn of(results: &Path, truth: &Path, offset: i64) -> anyhow::Result<Self> {
        let (results, source) = (ScoredResults::of(results)?, TruthSource::of(truth)?);
        let mut scored = Self::default();
        match &source {
            TruthSource::Boxes(_) => {
                if let Some(tracks) = source.tracks()? {
                    let compared = Compared::new(&tracks, &results, offset)?;
                    compared.check_frames(truth)?;
                    scored.add_tracks(&compared, truth);
                }
            }
            TruthSource::Cdnet(_) | TruthSource::Masks(_) => {
                if let Some(masks) = source.masks()? {
                    scored.add_masks(&results.masks()?, masks, truth, offset)?;
                }
            }
            TruthSource::Scene(folder) => scored.add_scene(&results, &source, folder, offset)?,
        }
        Ok(scored)
    }

    fn add_tracks(&mut self, compared: &Compared, truth: &Path) {
        self.notes.push(compared.note(truth));
        if let Some(offset) = compared.better {
            self.notes.push(format!(
                "warning: {}: its boxes match better with --offset {offset}; check where its frame numbers start",
                truth.display()
            ));
        }
        self.scores.tracks = Some(compared.score());
    }

    fn add_masks(
        &mut self,
        folder: &Path,
        masks: MaskFiles,
        truth: &Path,
        offset: i64,
    ) -> Result<(), TruthError> {
        let masks = masks.shifted(offset);
        let score = mask_score::score(folder, &masks)?;
        self.notes.push(format!(
            "note: {}: {} masks; {} frames are judged, those with a mask in {}",
            truth.display(),
            masks.numbers().count(),
            score.frames,
            folder.display()
        ));
        if score.f_measure < POOR_F
            && let Some(more) = alignment::better_offset_of_masks(&masks, &mask_score::results_in(folder)?)?
        {
            self.notes.push(format!(
                "warning: {}: its masks match better with --offset {}; check where its frame numbers start",
                truth.display(),
                offset + more
            ));
        }
        self.scores.masks = Some(score);
        Ok(())
    }

    fn add_scene(
        &mut self,
        results: &ScoredResults,
        source: &TruthSource,
        scene: &Path,
        offset: i64,
    ) -> anyhow::Result<()> {
        let masks = match (results, source.masks()?) {
            (ScoredResults::Tracks(_), _) | (_, None) => None,
            (_, Some(masks)) => Some((results.masks()?, masks)).filter(|(folder, _)| folder.is_dir()),
        };
        if let Some((folder, masks)) = masks {
            self.add_masks(&folder, masks, scene, offset)?;
            if let ScoredResults::Masks(_) = results {
                return Ok(());
            }
        }
        let Some(tracks) = source.tracks()? else { return Ok(()) };
        let compared = Compared::new(&tracks, results, offset)?;
        if let Some(folder) = results.folder() {
            let people = event_scoring::people(&compared.boxes, &compared.found);
            let compare = |truth: Vec<ScoredEvent>, found: Vec<ScoredEvent>| {
                event_scoring::compare(&compared.analysed_events(truth), &found, &people, TOLERANCE)
            };
            let events = |folder: &Path| event_scoring::read_events(&folder.join("events.jsonl"));
            let episodes = |folder: &Path| event_scoring::read_episodes(&folder.join("episodes.csv"));
            self.scores.events = Some(compare(events(scene)?, events(folder)?));
            self.scores.episodes = Some(compare(episodes(scene)?, episodes(folder)?));
        }
        self.add_tracks(&compared, scene);
        Ok(())
    }
}

/// True and found boxes in the analysed frames.
struct Compared {
    /// The true boxes in the range of analysed frames.
    boxes: Boxes,
    /// The found boxes that count.
    found: Boxes,
    analysed: AnalysedFrames,
    /// The first and last frame of the ground truth, analysed or not.
    all_frames: Option<(i64, i64)>,
    /// Number of frames with true boxes that were not analysed.
    left_out: usize,
    offset: i64,
    /// The offset at which the boxes match better, if there is one.
    better: Option<i64>,
    /// The offset that makes the first frame of the ground truth the first that was analysed.
    aligning: i64,
    /// What was read.
    read: String,
}

impl Compared {
    fn new(truth: &TrackFile, results: &ScoredResults, offset: i64) -> anyhow::Result<Self> {
        let found = results.tracks()?;
        let analysed = results.analysed(&found.boxes);
        let mut boxes = shifted(&truth.boxes, offset);
        let span = span(&truth.boxes).map(|(first, last)| (i64::from(first), i64::from(last)));
        let more = alignment::better_offset(&boxes, &found.boxes, analysed.first);
        let left_out = boxes.keys().filter(|number| !analysed.contains(**number)).count();
        boxes.retain(|number, _| analysed.covers(*number));
        let mut read = format!("{}, {} boxes in {} frames", truth.format, truth.count(), truth.boxes.len());
        for remark in &truth.remarks {
            read += "; ";
            read += remark;
        }
        for remark in &found.remarks {
            read += "; of the results, ";
            read += remark;
        }
        Ok(Self {
            found: without_ignored(&boxes, &shifted(&truth.ignored, offset), &found.boxes),
            aligning: i64::from(analysed.first) - span.map_or(0, |(first, _)| first),
            better: more.map(|more| offset + more),
            boxes,
            analysed,
            all_frames: span.map(|(first, last)| (first + offset, last + offset)),
            left_out,
            offset,
            read,
        })
    }

    /// Fails if no frame of the ground truth was analysed.
    fn check_frames(&self, truth: &Path) -> anyhow::Result<()> {
        let Some((first, last)) = self.all_frames.filter(|_| self.boxes.is_empty()) else { return Ok(()) };
        let (offset, reason) = match self.better {
            Some(offset) => (offset, "where the boxes match"),
            None => (self.aligning, "which makes the first numbers equal"),
        };
        bail!(
            "{}: its frames {first} to {last} are not among those that were analysed, {} to {}; score with \
             --offset {offset}, {reason}",
            truth.display(),
            self.analysed.first,
            self.analysed.last
        );
    }

    fn score(&self) -> TrackScore {
        summary::score_of_frames(&self.boxes, &self.found, |number| self.analysed.contains(number))
    }

    /// The events that lie within the analysed frames.
    fn analysed_events(&self, events: Vec<ScoredEvent>) -> Vec<ScoredEvent> {
        let moved = events.into_iter().filter_map(|event| {
            let (start, end) = event.span;
            let span = (shifted_number(start, self.offset)?, shifted_number(end, self.offset)?);
            Some(ScoredEvent { span, ..event })
        });
        moved
            .filter(|event| self.analysed.covers(event.span.0) && self.analysed.covers(event.span.1))
            .collect()
    }

    /// What was read and what is judged.
    fn note(&self, truth: &Path) -> String {
        let AnalysedFrames { first, last, is_told, .. } = self.analysed;
        let judged = if is_told || last < u32::MAX {
            let from = if is_told { "" } else { ", the first to the last with a result" };
            format!("{} frames are judged, {first} to {last}{from}", self.analysed.count())
        } else {
            "all frames are judged, as there are no results".to_owned()
        };
        let left_out = if self.left_out > 0 {
            format!("; {} frames of the ground truth that were not analysed are left out", self.left_out)
        } else {
            String::new()
        };
        format!("note: {}: {}; {judged}{left_out}", truth.display(), self.read)
    }
}

impl Scores {
    fn measures(&self) -> Measures {
        Measures {
            masks: self.masks.as_ref().map(Into::into),
            tracks: self.tracks.as_ref().map(Into::into),
            episodes: self.episodes.as_ref().map(Into::into),
        }
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
            let Hota { hota, deta, assa, loca } = tracks.hota;
            writeln!(
                out,
                "HOTA      HOTA {hota:.3}  DetA {deta:.3}  AssA {assa:.3}  LocA {loca:.3}  (means over IoU 0.05 to \
                 0.95)"
            )?;
            let Survival { episodes, identities, survived, .. } = &tracks.occlusion;
            writeln!(
                out,
                "occlusion {survived} of {identities} identities kept through {episodes} occlusion episodes"
            )?;
        }
        for (title, found) in [("events", &self.events), ("episodes", &self.episodes)] {
            let Some(found) = found else { continue };
            writeln!(out, "{title}")?;
            let all = event_scoring::total(found);
            let kinds = found.iter().map(|(kind, score)| (kind.as_str(), score));
            for (kind, EventScore { truth, reported, matched, precision, recall }) in
                kinds.chain([("all", &all)])
            {
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
