//! What the whole analysis makes of a scene, against what truly happened there.

use std::collections::{BTreeMap, BTreeSet};

use occluscope::occlusion::EventKind;
use occluscope::pipeline::{Pipeline, Reading, final_reading};
use occluscope::registration::{Choice, Estimator};
use occluscope::settings::Settings;
use occluscope::synth::{Parameters, Recorder, Scene, Truth, catalogue, render};
use occluscope::tracking::Identity;

/// An event or the ends of an episode may be so many frames off at a normal walk, and as much
/// further as people are slower: what counts as the first or last of somebody is a matter of pixels.
const TOLERANCE: f32 = 8.0;
/// A person of whom less is seen may be anywhere for the tracks.
const CLEAR: f32 = 0.9;

/// Everything in which the analysis of a scene differs from the truth, a line each.
pub(crate) fn differences(scene: &str, parameters: &Parameters, settings: &Settings) -> Vec<String> {
    let scene = catalogue::scene(scene, parameters).expect("a scene of the catalogue");
    differences_in(&scene, parameters.speed, settings)
}

/// The same of a scene in which people walk at `speed` times their usual one.
pub(crate) fn differences_in(scene: &Scene, speed: f32, settings: &Settings) -> Vec<String> {
    let mut recorder = Recorder::new(scene.fps);
    let mut pipeline = Pipeline::new(settings, scene.size, scene.fps).expect("settings in range");
    let mut analyses = Vec::new();
    let mut estimator = Estimator::of(scene.size, Choice::new(settings));
    for (mut frame, truth) in render(scene) {
        frame.alignment = estimator.step(&frame);
        recorder.push(&truth);
        analyses.push(pipeline.step(&frame).expect("a frame of the scene's size"));
    }
    let (truth, found) = (recorder.finish(), final_reading(&analyses, &pipeline));
    let held = identities(&truth, &found);
    let mut differences = Vec::new();
    let mut person_of = BTreeMap::new();
    for (person, ids) in &held {
        if ids.len() != 1 {
            differences.push(format!("person {person} was called {ids:?}"));
        }
        for id in ids {
            if let Some(other) = person_of.insert(*id, *person) {
                differences.push(format!("identity {id} was on persons {other} and {person}"));
            }
        }
    }
    let people = |ids: &[Identity]| -> Vec<Identity> {
        let mut people: Vec<_> = ids.iter().map(|id| person_of.get(id).copied().unwrap_or(0)).collect();
        people.sort_unstable();
        people
    };
    let tolerance = (TOLERANCE / speed.min(1.0)).round() as u32;
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
    differences.extend(crate::balance::faults(&found.events, &found.tracks, settings, scene.fps));
    differences
}

type What = (&'static str, Vec<Identity>, [u32; 2]);

/// What is on one side only: the same kind, the same people, times that agree, each counted once.
fn unmatched(
    tolerance: u32,
    truth: impl Iterator<Item = What>,
    found: impl Iterator<Item = What>,
) -> Vec<String> {
    let mut found: Vec<What> = found.collect();
    let mut differences = Vec::new();
    for true_one in truth {
        let near = |time: &[u32; 2]| (0..2).all(|end| time[end].abs_diff(true_one.2[end]) <= tolerance);
        let same = found.iter().position(|it| it.0 == true_one.0 && it.1 == true_one.1 && near(&it.2));
        match same {
            Some(at) => drop(found.remove(at)),
            None => differences.push(format!("missed: {true_one:?}")),
        }
    }
    differences.extend(found.into_iter().map(|it| format!("made up: {it:?}")));
    differences
}

/// For each person the identities that lay on them where they were clearly seen.
fn identities(truth: &Truth, found: &Reading) -> BTreeMap<Identity, BTreeSet<Identity>> {
    let tracks: BTreeMap<u32, _> = found.tracks.iter().map(|(frame, tracks)| (*frame, tracks)).collect();
    let mut held: BTreeMap<Identity, BTreeSet<Identity>> = BTreeMap::new();
    for (frame, person) in &truth.boxes {
        let ids = held.entry(person.id).or_default();
        let meets = truth
            .episodes
            .iter()
            .any(|it| it.objects.contains(&person.id) && (it.start..=it.end + 4).contains(&(frame + 2)));
        if meets || person.visibility() < CLEAR {
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
    held
}
