//! `occluscope sweep`: scores every combination of some settings on a video or on every sequence of a data set.
//!
//! A pass over a sequence analyses several combinations at once; its rows are kept when it is complete, and a repeated
//! command computes only what is missing. Tables, pictures and the report are written at the end. The report shows frames of
//! each sequence under the combination that is best overall, for which the sequence is analysed once more, unless there is
//! one combination only.

mod arguments;
mod best_rows;
mod opened_sequence;
mod output;
mod passes;
mod row_log;
mod run_results;
mod shown_frames;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::bail;
use clap::ArgMatches;

pub use arguments::command;

use super::console::LongProgress;
use super::flags;
use super::inputs;
use super::interrupt;
use super::standard_output;
use crate::export::Staging;
use crate::sweep::pass::Outcome;
use crate::sweep::scoring;
use crate::sweep::sequence_frames::SequenceFrames;
use crate::sweep::table::{Row, SweepTable};
use crate::truth::measures::OF_MASKS;
use arguments::SweepJob;
use opened_sequence::OpenedSequence;
use passes::{Combinations, PassResult};
use row_log::RowLog;
use run_results::RunResults;

/// Computes the rows that are missing, and writes the output.
pub fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    let job = SweepJob::new(matches)?;
    flags::start_threads(matches)?;
    interrupt::watch();
    let combinations: Combinations = (0..job.grid.combinations())
        .map(|at| Ok((at, job.grid.settings(&job.base, at)?)))
        .collect::<anyhow::Result<_>>()?;
    let (sequences, failures) = open_sequences(&job)?;
    check_measure(&job, &sequences)?;
    if job.roi.is_some() {
        job.console
            .note("note: ground truth outside the region of interest counts as missed; --crop leaves it out");
    }
    let results = job.results.as_ref().map(|folder| RunResults::below(folder)).transpose()?;
    for why in results.iter().flat_map(|results| &results.unusable) {
        job.console.note(&format!("warning: {why}; its row is computed"));
    }
    let outputs = output::TARGETS.map(|(name, is_folder)| (job.out.join(name), is_folder));
    for sequence in &sequences {
        let mut inputs = inputs::of_video(&sequence.video);
        inputs.push(sequence.truth.path.clone());
        inputs::protect(&inputs, outputs.iter().map(|(path, is_folder)| (path.as_path(), *is_folder)))?;
    }
    let staging = Staging::new(&job.out)?;
    staging.check(output::TARGETS.map(|(name, is_folder)| (Path::new(name), is_folder)))?;
    let log = RowLog::open(&job.out)?;
    let mut sweep = Sweep {
        table: SweepTable {
            grid: job.grid.clone(),
            sequences: sequences.iter().map(|sequence| sequence.name.clone()).collect(),
            rows: Vec::new(),
            by: job.by,
        },
        missing: Vec::new(),
        frames: BTreeMap::new(),
        failures,
        checked: BTreeSet::new(),
        job: &job,
        sequences: &sequences,
        combinations: &combinations,
        log,
    };
    sweep.take_known_rows(results.as_ref());
    sweep.compute_missing_rows()?;
    let frames = sweep.frames_of_best()?;
    output::write(&job, &sequences, &sweep.table, &frames, &sweep.failures, staging)?;

    standard_output::write(|out| Ok(best_rows::write(out, &sweep.table)?))?;
    match sweep.failures.as_slice() {
        [] => Ok(()),
        [only] => bail!("{only}; what depends on it is missing"),
        [first, others @ ..] => {
            bail!("{first}; what depends on it is missing, and {} more failed", others.len())
        }
    }
}

/// Opens the sequences; returns with them why others cannot be. Fails where none can.
fn open_sequences(job: &SweepJob) -> anyhow::Result<(Vec<OpenedSequence>, Vec<String>)> {
    let (mut opened, mut failures, mut first) = (Vec::new(), Vec::new(), None);
    for sequence in &job.sequences {
        match OpenedSequence::new(sequence, job) {
            Ok(sequence) => opened.push(sequence),
            Err(error) => {
                failures.push(format!("{}: {error:#}", sequence.name));
                first.get_or_insert(error);
            }
        }
    }
    match first {
        Some(error) if opened.is_empty() => {
            Err(if failures.len() == 1 { error } else { error.context("no sequence can be opened") })
        }
        _ => {
            for failure in &failures {
                job.console.note(&format!("warning: {failure}"));
            }
            Ok((opened, failures))
        }
    }
}

/// Fails if no sequence has ground truth for the measure by which settings are ranked.
fn check_measure(job: &SweepJob, sequences: &[OpenedSequence]) -> anyhow::Result<()> {
    let (needed, is_there): (&str, fn(&OpenedSequence) -> bool) = match job.by.name {
        "score" => return Ok(()),
        name if OF_MASKS.contains(&name) => ("masks", |sequence| sequence.kinds.masks),
        "episode_recall" | "episode_precision" => {
            ("episodes", |sequence| sequence.truth.occlusions.is_some())
        }
        _ => ("tracks", |sequence| sequence.kinds.tracks),
    };
    if sequences.iter().any(is_there) {
        return Ok(());
    }
    bail!("--by {} needs ground truth with {needed}, which no sequence has", job.by.name)
}

/// Why rows could not be computed.
enum Failure {
    /// The sequence cannot be analysed or scored.
    Sequence(anyhow::Error),
    /// Rows cannot be written; no other sequence would do better.
    Output(anyhow::Error),
}

/// A sweep in progress.
struct Sweep<'a> {
    table: SweepTable,
    /// The combinations without a row of each sequence.
    missing: Vec<Combinations>,
    /// The frames of the sequences that were recorded as their rows were computed, with the combination.
    frames: BTreeMap<usize, SequenceFrames>,
    /// Sequences that could not be analysed, and why.
    failures: Vec<String>,
    /// Sequences whose frame numbers were compared with those of the results.
    checked: BTreeSet<usize>,
    job: &'a SweepJob,
    sequences: &'a [OpenedSequence],
    combinations: &'a Combinations,
    log: RowLog,
}

impl Sweep<'_> {
    /// Takes the rows of an earlier sweep, and of runs.
    fn take_known_rows(&mut self, results: Option<&RunResults>) {
        let mut taken = 0;
        for (index, sequence) in self.sequences.iter().enumerate() {
            let mut missing = Combinations::new();
            for (&combination, settings) in self.combinations {
                let logged = self.log.row(&sequence.row_key(settings));
                let kinds = sequence.kinds;
                let logged = logged.filter(|row| row.measures.is_of(kinds.masks, kinds.has_box));
                let logged = logged.map(|row| (row.seconds, row.measures));
                let of_run = || results.and_then(|results| results.row(self.job, sequence, settings));
                let of_run = || of_run().inspect(|_| taken += 1);
                match logged.or_else(of_run) {
                    Some((seconds, measures)) => {
                        self.table.rows.push(Row { sequence: index, combination, measures, seconds });
                    }
                    None => {
                        missing.insert(combination, settings.clone());
                    }
                }
            }
            self.missing.push(missing);
        }
        if let Some(results) = results {
            let note = format!("note: {taken} rows are from {} scored runs", results.count);
            self.job.console.note(&note);
        }
    }

    /// Analyses each sequence under the combinations whose rows are missing.
    fn compute_missing_rows(&mut self) -> anyhow::Result<()> {
        let work = |(sequence, missing): (&OpenedSequence, &Combinations)| {
            u64::from(frames_of(self.job, sequence)) * missing.len() as u64
        };
        let total: u64 = self.sequences.iter().zip(&self.missing).map(work).sum();
        let progress = self.job.console.long_progress(total);
        let missing = std::mem::take(&mut self.missing);
        for (index, missing) in missing.iter().enumerate().filter(|(_, missing)| !missing.is_empty()) {
            let known = self.combinations.len() - missing.len();
            match self.compute_rows(index, missing, known, &progress) {
                Ok(()) => {}
                Err(_) if interrupt::is_stop_requested() => bail!(
                    "stopped; {} of {} rows are complete{}; repeat the command to go on",
                    self.table.rows.len(),
                    self.sequences.len() * self.combinations.len(),
                    match self.log.place() {
                        place if place.is_empty() => place,
                        place => format!(", the computed ones{place}"),
                    }
                ),
                Err(Failure::Output(error)) => return Err(error),
                Err(Failure::Sequence(error)) if self.sequences.len() == 1 => return Err(error),
                Err(Failure::Sequence(error)) => self.note_failure(index, &error, &progress),
            }
        }
        self.table.rows.sort_by_key(|row| (row.sequence, row.combination));
        Ok(())
    }

    fn note_failure(&mut self, index: usize, error: &anyhow::Error, progress: &LongProgress) {
        let failure = format!("{}: {error:#}", self.sequences[index].name);
        progress.note(&format!("warning: {failure}"));
        self.failures.push(failure);
    }

    fn compute_rows(
        &mut self,
        index: usize,
        missing: &Combinations,
        mut known: usize,
        progress: &LongProgress,
    ) -> Result<(), Failure> {
        let sequence = &self.sequences[index];
        let all = self.combinations.len();
        let frames = frames_of(self.job, sequence);
        for (at, pass) in passes::passes(missing, sequence, frames).iter().enumerate() {
            progress.begin(format!("{}: {} settings", sequence.name, pass.len()));
            // Where there is one combination, its frames are those of the report.
            let recorded = (all == 1).then_some(0);
            let result = passes::run(self.job, sequence, pass, recorded, progress, at == 0);
            let result = result.map_err(Failure::Sequence)?;
            if recorded.is_some() {
                self.record(index, 0, &result).map_err(Failure::Sequence)?;
            }
            self.add_rows(index, &result)?;
            known += pass.len();
            progress.part_done(&format!("{}: {known} of {all} settings", sequence.name));
        }
        Ok(())
    }

    /// Scores the outcomes of a pass and keeps their rows.
    fn add_rows(&mut self, index: usize, result: &PassResult) -> Result<(), Failure> {
        let sequence = &self.sequences[index];
        let placement = sequence.info.placement();
        let (mut rows, mut logged) = (Vec::new(), Vec::new());
        if let Some(outcome) = result.outcomes.first().filter(|_| self.checked.insert(index))
            && let Some(offset) =
                scoring::better_offset(outcome, &sequence.truth, &result.analysed, placement.as_ref())
        {
            self.job.console.note(&format!(
                "warning: {}: its boxes match better with --offset {offset}; check where its frame numbers start",
                sequence.name
            ));
        }
        for (outcome, &seconds) in result.outcomes.iter().zip(&result.seconds) {
            let measures = scoring::measures(outcome, &sequence.truth, &result.analysed, placement.as_ref());
            let measures = measures.map_err(|error| Failure::Sequence(error.into()))?;
            for &combination in &outcome.combinations {
                rows.push(Row { sequence: index, combination, measures, seconds });
                let key = sequence.row_key(&self.combinations[&combination]);
                let name = self.job.grid.name(combination);
                logged.push((key, sequence.name.clone(), name, seconds, measures));
            }
        }
        self.log.add(logged).map_err(|error| Failure::Output(error.into()))?;
        self.table.rows.extend(rows);
        Ok(())
    }

    /// Keeps the frames of a sequence under a combination for the report.
    fn record(&mut self, index: usize, combination: usize, result: &PassResult) -> anyhow::Result<()> {
        let is_recorded = |outcome: &&Outcome| outcome.combinations.contains(&combination);
        if let Some(outcome) = result.outcomes.iter().find(is_recorded) {
            let sequence = &self.sequences[index];
            let of = (index, combination);
            let frames = shown_frames::frames_of(self.job, sequence, of, outcome, &result.analysed)?;
            self.frames.insert(index, frames);
        }
        Ok(())
    }

    /// The frames of each sequence under the combination that is best overall.
    fn frames_of_best(&mut self) -> anyhow::Result<Vec<SequenceFrames>> {
        let table = &self.table;
        let with_rows = |index: &usize| table.rows.iter().any(|row| row.sequence == *index);
        let indices: Vec<usize> = (0..self.sequences.len()).filter(with_rows).collect();
        let overall = table.best_overall(table.by);
        let best: Vec<_> = indices
            .into_iter()
            .filter(|index| !self.frames.contains_key(index))
            .filter_map(|index| Some((index, overall.or_else(|| table.best(index, table.by))?)))
            .collect();
        let total = best.iter().map(|(index, _)| u64::from(frames_of(self.job, &self.sequences[*index])));
        let progress = self.job.console.long_progress(total.sum());
        for (index, combination) in best {
            let sequence = &self.sequences[index];
            progress.begin(format!("{}: worst frames", sequence.name));
            let one = Combinations::from([(combination, self.combinations[&combination].clone())]);
            let result = passes::run(self.job, sequence, &one, Some(combination), &progress, false);
            if interrupt::is_stop_requested() {
                bail!(
                    "stopped; all rows are complete{}, repeat the command for the report",
                    self.log.place()
                );
            }
            if let Err(error) = result.and_then(|result| self.record(index, combination, &result)) {
                self.note_failure(index, &error, &progress);
            }
        }
        Ok(std::mem::take(&mut self.frames).into_values().collect())
    }
}

/// Number of frames of a sequence, as far as known.
fn frames_of(job: &SweepJob, sequence: &OpenedSequence) -> u32 {
    let of_range = job.range.map(|range| range.count().div_ceil(sequence.info.every()));
    of_range.into_iter().chain(sequence.info.frames).min().unwrap_or(1000)
}
