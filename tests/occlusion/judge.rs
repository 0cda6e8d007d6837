//! Compares the analysis of a scene with its ground truth.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use occluscope::frame::{Frame, Mask, Size};
use occluscope::mixture::BATCH;
use occluscope::occlusion::EventKind;
use occluscope::pipeline::{Analysis, OfflineResult, Pipeline, offline_result};
use occluscope::regions::Rect;
use occluscope::registration::{CorrectionChoice, measure_all};
use occluscope::settings::Settings;
use occluscope::synth::{Recorder, Scene, SceneParameters, SceneTruth, catalogue, render};
use occluscope::tracking::Identity;
use occluscope::truth::boxes::{Bounds, Boxes};
use occluscope::truth::clear_mot::{self, ClearMot};
use occluscope::truth::summary::boxes_of;

/// Tolerance in frames of events and of the ends of episodes at normal walking speed; proportionally larger at lower
/// speed. The first and last visible frames depend on single pixels.
const TOLERANCE: f32 = 8.0;
/// Least visibility of a person for the comparison of tracks.
const CLEAR: f32 = 0.9;

/// The analysis of a scene, as by `run` on a file.
pub(crate) struct JudgedRun {
    truth: SceneTruth,
    analyses: Vec<Analysis>,
    pipeline: Pipeline,
    /// The current settings of tracking.
    settings: Settings,
    fps: f32,
    /// The duration of motion in frames relative to normal walking at 25 frames per second.
    slowness: f32,
}

impl JudgedRun {
    /// The analysis of a scene in which people walk at `speed` times their normal speed per frame.
    pub(crate) fn new(scene: &Scene, speed: f32, settings: &Settings) -> Self {
        let mut recorder = Recorder::new(scene.fps);
        let mut frames = Vec::new();
        for (frame, truth) in render(scene) {
            recorder.push(&truth);
            frames.push(frame);
        }
        measure_all(&mut frames, CorrectionChoice::new(settings));
        let frames: Vec<&Frame> = frames.iter().collect();
        let mut pipeline = Pipeline::new(settings, scene.size, scene.fps).expect("settings in range");
        let learnt = frames.len().min(settings.bootstrap.frames(scene.fps) as usize);
        pipeline.learn(&frames[..learnt]).expect("frames of the scene's size");
        let mut analyses = Vec::new();
        for batch in frames.chunks(BATCH) {
            for analysis in pipeline.step_many(batch).expect("frames of the scene's size") {
                // Tracking uses only the regions.
                analyses.push(Analysis { mask: Arc::new(Mask::empty(Size::new(1, 1))), ..analysis });
            }
        }
        Self {
            truth: recorder.finish(),
            analyses,
            pipeline,
            settings: settings.clone(),
            fps: scene.fps,
            slowness: 1.0 / speed.min(1.0),
        }
    }

    /// Runs tracking and occlusion again on the same regions under other settings, with another frame rate.
    pub(crate) fn track_again(&mut self, settings: &Settings, fps: f32) {
        self.pipeline.restart_tracking(settings, fps);
        (self.settings, self.fps) = (settings.clone(), fps);
        for analysis in &mut self.analyses {
            *analysis = self.pipeline.track_again(analysis);
        }
    }

    /// All differences of the offline result from the truth, one line each.
    pub(crate) fn differences(&self) -> Vec<String> {
        let (truth, found) = (&self.truth, &offline_result(&self.analyses, &self.pipeline));
        let (mut differences, person_of) = confusions(truth, found);
        let people = |ids: &[Identity]| -> Vec<Identity> {
            let mut people: Vec<_> = ids.iter().map(|id| person_of.get(id).copied().unwrap_or(0)).collect();
            people.sort_unstable();
            people
        };
        let tolerance = (TOLERANCE * self.slowness).round() as u32;
        differences.extend(unmatched(
            tolerance,
            truth.events.iter().map(|event| (event.kind.name(), event.objects.clone(), [event.frame; 2])),
            found.events.iter().map(|event| (event.kind.name(), people(&event.objects), [event.frame; 2])),
        ));
        differences.extend(unmatched(
            tolerance,
            truth.episodes.iter().map(|it| (it.kind.name(), it.objects.clone(), [it.start, it.end])),
            found.episodes.iter().map(|it| (it.kind.name(), people(&it.objects), [it.start, it.end])),
        ));
        for event in found.events.iter().filter(|event| event.kind == EventKind::Demerge) {
            let members = people(&event.objects);
            if !people(&event.becomes).iter().all(|person| members.contains(person)) {
                differences
                    .push(format!("demerge {}: {:?} became {:?}", event.frame, event.objects, event.becomes));
            }
        }
        differences.extend(crate::balance::faults(&found.events, &found.tracks, &self.settings, self.fps));
        differences
    }

    /// Identity confusions in the offline result, one line each.
    pub(crate) fn confusions(&self) -> Vec<String> {
        confusions(&self.truth, &offline_result(&self.analyses, &self.pipeline)).0
    }

    /// The score of the offline result against the true boxes, at an IoU of .5.
    pub(crate) fn score(&self) -> ClearMot {
        let mut truth = Boxes::new();
        for (frame, person) in self.truth.boxes.iter().filter(|(_, person)| !person.is_hidden()) {
            let Rect { x, y, w, h } = person.bbox;
            truth.entry(*frame).or_default().insert(person.id, Bounds([x, y, w, h].map(f64::from)));
        }
        clear_mot::score(&truth, &boxes_of(&offline_result(&self.analyses, &self.pipeline)), 0.5)
    }
}

/// All differences of the analysis of a scene from the truth, one line each.
pub(crate) fn differences(scene: &str, parameters: &SceneParameters, settings: &Settings) -> Vec<String> {
    let scene = catalogue::scene(scene, parameters).expect("a scene of the catalogue");
    differences_in(&scene, parameters.speed, settings)
}

/// The same for a scene in which people walk at `speed` times their normal speed.
pub(crate) fn differences_in(scene: &Scene, speed: f32, settings: &Settings) -> Vec<String> {
    JudgedRun::new(scene, speed, settings).differences()
}

/// People with a wrong identity or with several, one line each, and the person of each identity.
fn confusions(truth: &SceneTruth, found: &OfflineResult) -> (Vec<String>, BTreeMap<Identity, Identity>) {
    let mut differences = Vec::new();
    let mut person_of = BTreeMap::new();
    for (person, ids) in &identities(truth, found) {
        if ids.len() != 1 {
            differences.push(format!("person {person} had the identities {ids:?}"));
        }
        for id in ids {
            if let Some(other) = person_of.insert(*id, *person) {
                differences.push(format!("identity {id} was on persons {other} and {person}"));
            }
        }
    }
    (differences, person_of)
}

/// Kind, people, and the first and last frame of an event or episode.
type Occurrence = (&'static str, Vec<Identity>, [u32; 2]);

/// The events of one side without a match on the other: same kind, same people, times within the tolerance, each
/// matched at most once.
fn unmatched(
    tolerance: u32,
    truth: impl Iterator<Item = Occurrence>,
    found: impl Iterator<Item = Occurrence>,
) -> Vec<String> {
    let mut found: Vec<Occurrence> = found.collect();
    let mut differences = Vec::new();
    for true_one in truth {
        let near = |time: &[u32; 2]| (0..2).all(|end| time[end].abs_diff(true_one.2[end]) <= tolerance);
        let same = found.iter().position(|it| it.0 == true_one.0 && it.1 == true_one.1 && near(&it.2));
        match same {
            Some(at) => drop(found.remove(at)),
            None => differences.push(format!("missing: {true_one:?}")),
        }
    }
    differences.extend(found.into_iter().map(|it| format!("false: {it:?}")));
    differences
}

/// For each person the identities that matched while the person was clearly visible.
fn identities(truth: &SceneTruth, found: &OfflineResult) -> BTreeMap<Identity, BTreeSet<Identity>> {
    let tracks: BTreeMap<u32, _> = found.tracks.iter().map(|frame| (frame.number, &frame.tracks)).collect();
    let mut matched: BTreeMap<Identity, BTreeSet<Identity>> = BTreeMap::new();
    for (frame, person) in &truth.boxes {
        let ids = matched.entry(person.id).or_default();
        let shares_episode = truth
            .episodes
            .iter()
            .any(|it| it.objects.contains(&person.id) && (it.start..=it.end + 4).contains(&(frame + 2)));
        if shares_episode || person.visibility() < CLEAR {
            continue;
        }
        let best = tracks[frame]
            .iter()
            .map(|track| (track.bbox.iou(&person.bbox), track.id))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((iou, id)) = best
            && iou >= 0.5
        {
            ids.insert(id);
        }
    }
    matched
}
