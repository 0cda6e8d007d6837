//! The scenes of `synth`: the ground truth agrees with their descriptions and with the pixels.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use occluscope::frame::{Frame, Mask, Size};
use occluscope::occlusion::EventKind::{self, Demerge, Disappear, Enter, Exit, Merge, Reappear};
use occluscope::regions::find_regions;
use occluscope::synth::noise::CameraNoise;
use occluscope::synth::render::FrameTruth;
use occluscope::synth::{
    Recorder, Renderer, Scene, SceneParameters, SceneTruth, Silhouette, catalogue, render, write,
};
use occluscope::tracking::Identity;

/// Small parameters without noise.
fn small(seed: u64) -> SceneParameters {
    let sizes = [Size::new(96, 72), Size::new(128, 72), Size::new(160, 120)];
    SceneParameters {
        size: sizes[seed as usize % sizes.len()],
        seed,
        noise: CameraNoise { sigma: 0.0, signal_dependent: false },
        speed: [1.0, 0.7, 1.6][(seed / 2) as usize % 3],
        ..SceneParameters::default()
    }
}

fn scene(name: &str, parameters: &SceneParameters) -> Scene {
    catalogue::scene(name, parameters).unwrap()
}

fn truth_of(scene: &Scene) -> SceneTruth {
    let mut recorder = Recorder::new(scene.fps);
    render(scene).for_each(|(_, truth)| recorder.push(&truth));
    recorder.finish()
}

fn frame_of(truth: &SceneTruth, kind: EventKind) -> u32 {
    truth.events.iter().find(|event| event.kind == kind).unwrap().frame
}

/// The largest absolute difference over the channels of a pixel in two frames, in levels.
fn difference(a: &Frame, b: &Frame, at: usize) -> u8 {
    (3 * at..3 * at + 3).map(|channel| a.rgb[channel].abs_diff(b.rgb[channel])).max().unwrap()
}

fn mean(frame: &Frame) -> f64 {
    frame.rgb.iter().map(|&level| f64::from(level)).sum::<f64>() / frame.rgb.len() as f64
}

#[test]
fn scenes_have_the_described_events() {
    let meets: &[(EventKind, &[Identity])] =
        &[(Exit, &[1]), (Exit, &[2]), (Demerge, &[1, 2]), (Merge, &[1, 2]), (Enter, &[1]), (Enter, &[2])];
    let stays: &[(EventKind, &[Identity])] =
        &[(Exit, &[1]), (Exit, &[2]), (Merge, &[1, 2]), (Enter, &[1]), (Enter, &[2])];
    let passes: &[(EventKind, &[Identity])] = &[(Exit, &[1]), (Enter, &[1])];
    let hides: &[(EventKind, &[Identity])] =
        &[(Exit, &[1]), (Disappear, &[1]), (Reappear, &[1]), (Enter, &[1])];
    let told = [
        ("crossing-diagonal", meets),
        ("crossing-steep", meets),
        ("meet-and-part", meets),
        ("enter-together", meets),
        ("room", meets),
        ("shadows", meets),
        ("slow-light", meets),
        ("low-light", meets),
        ("jitter", meets),
        ("child", stays),
        ("leave-together", stays),
        ("bag", passes),
        ("arms", passes),
        ("shade", passes),
        ("flag", passes),
        ("lamp", passes),
        ("monitor", passes),
        ("glints", passes),
        ("swaying-tree", passes),
        ("sudden-light", passes),
        ("car", passes),
        ("wall-edge", hides),
    ];
    for (name, expected) in told {
        for seed in 1..=4 {
            let truth = truth_of(&scene(name, &small(seed)));
            let mut events: Vec<_> =
                truth.events.iter().map(|event| (event.kind, event.objects.as_slice())).collect();
            events.sort();
            assert_eq!(events, expected, "{name} {seed}");
            assert!(truth.boxes[0].0 > catalogue::SETTLE, "{name} {seed}: the scene is empty at the start");
        }
    }
}

#[test]
fn meeting_people_turn_back_and_joining_people_stay() {
    for seed in 1..=4 {
        let parameters = small(seed);
        let truth = truth_of(&scene("meet-and-part", &parameters));
        for event in truth.events.iter().filter(|event| matches!(event.kind, Enter | Exit)) {
            let left = event.x < parameters.size.width as f32 / 2.0;
            assert_eq!(left, event.objects == [1], "people exit where they entered: {event:?}");
        }
        let seconds = (frame_of(&truth, Demerge) - frame_of(&truth, Merge)) as f32 / catalogue::FPS;
        assert!(seconds * parameters.speed > 1.0, "they stop for a while: {seconds} s");

        let truth = truth_of(&scene("child", &parameters));
        let height = |id| {
            let whole = truth.boxes.iter().filter(|(_, who)| who.id == id && who.inside == who.full);
            whole.map(|(_, who)| who.bbox.h).fold(0.0, f32::max)
        };
        assert!((0.5..0.7).contains(&(height(2) / height(1))), "a child: {} {}", height(2), height(1));
        assert_eq!(truth.episodes[0].end, frame_of(&truth, Exit), "until the first person exits");
    }
}

#[test]
fn merges_are_at_the_scene_s_positions() {
    for seed in 1..=4 {
        let parameters = small(seed);
        let at_edge = |name: &str, frame: &dyn Fn(&SceneTruth) -> u32| {
            let truth = truth_of(&scene(name, &parameters));
            let frame = frame(&truth);
            let near = |who: &Silhouette| {
                let gap = who.bbox.x.min(parameters.size.width as f32 - who.bbox.right());
                gap < 0.3 * who.bbox.h
            };
            truth.boxes.iter().any(|(number, who)| *number == frame && near(who))
        };
        assert!(at_edge("enter-together", &|truth| frame_of(truth, Merge)), "one person has just entered");
        assert!(at_edge("leave-together", &|truth| truth.episodes[0].end), "one person is exiting");
        assert!(!at_edge("crossing-steep", &|truth| frame_of(truth, Merge)), "both are inside");
    }
}

#[test]
fn size_changes_on_diagonals_and_turns() {
    let heights = |name, id| -> Vec<f32> {
        let truth = truth_of(&scene(name, &small(3)));
        let whole = truth.boxes.iter().filter(|(_, who)| who.id == id && who.inside == who.full);
        whole.map(|(_, who)| who.bbox.h).collect()
    };
    for id in [1, 2] {
        let nearer = heights("crossing-diagonal", id);
        assert!(nearer[nearer.len() - 1] > 1.4 * nearer[0], "{nearer:?}");
    }
    let away = heights("crossing-steep", 2);
    assert!(away[away.len() - 1] < 0.7 * away[0], "{away:?}");
}

#[test]
fn twelve_people_enter_and_exit() {
    for seed in 1..=3 {
        let scene = scene("crowd", &SceneParameters { size: Size::new(160, 120), ..small(seed) });
        let truth = truth_of(&scene);
        let count = |kind| truth.events.iter().filter(|event| event.kind == kind).count();
        assert_eq!((count(Enter), count(Exit)), (12, 12));
        assert!(count(Merge) >= 8 && truth.episodes.len() >= 8, "they meet: {:?}", truth.episodes);
        let mut clothes: Vec<_> =
            scene.actors.iter().map(|actor| (actor.clothes.shirt, actor.clothes.trousers)).collect();
        clothes.sort_unstable();
        clothes.dedup();
        assert_eq!(clothes.len(), 12, "all outfits differ");
        let at_once =
            |(number, _): &(u32, _)| truth.boxes.iter().filter(|(other, _)| other == number).count();
        assert!(truth.boxes.iter().map(at_once).max().unwrap() >= 8);
    }
}

#[test]
fn a_bag_splits_the_visible_silhouette_and_arms_widen_it() {
    let bag = scene("bag", &SceneParameters { size: Size::new(320, 240), seed: 1, ..small(1) });
    let empty = Renderer::new(&Scene { actors: Vec::new(), ..bag.clone() }).frame(1).0;
    let renderer = Renderer::new(&bag);
    let mut pieces = Vec::new();
    for number in (90..130).step_by(2) {
        let (frame, truth) = renderer.frame(number);
        let seen = |at| truth.identities[at] == 1 && difference(&frame, &empty, at) > 40;
        let data = (0..frame.size.pixels()).map(|at| if seen(at) { 255 } else { 0 }).collect();
        let large = truth.silhouettes[0].full / 8;
        pieces.push(find_regions(&frame, &Mask { size: frame.size, data }, large).1.len());
    }
    let count = |wanted| pieces.iter().filter(|&&pieces| pieces == wanted).count();
    assert!(count(1) >= 3 && count(2) >= 3, "the silhouette splits and rejoins: {pieces:?}");

    let truth = truth_of(&scene("arms", &small(2)));
    let shape = |(_, who): &(u32, Silhouette)| who.bbox.w / who.bbox.h;
    let whole = || truth.boxes.iter().filter(|(_, who)| who.inside == who.full);
    let widest = whole().map(shape).fold(0.0, f32::max);
    assert!(widest > 0.6, "arms out: {widest}");
    assert!(shape(whole().next().unwrap()) < 0.55 && shape(whole().next_back().unwrap()) < 0.55);
}

#[test]
fn a_parked_car_is_background_until_it_moves() {
    for seed in 1..=3 {
        let scene = scene("car", &small(seed));
        let frames: Vec<FrameTruth> = render(&scene).map(|(_, truth)| truth).collect();
        let is_parked = |truth: &FrameTruth| truth.silhouettes.first().is_some_and(|car| car.parked);
        let parked: Vec<u32> = frames.iter().filter(|it| is_parked(it)).map(|it| it.number).collect();
        let (first, last) = (parked[0], parked[parked.len() - 1]);
        assert_eq!(parked, (first..=last).collect::<Vec<_>>(), "the car parks once");
        assert_eq!(parked.len(), 200);
        for truth in &frames {
            let painted = truth.identities.contains(&1);
            let moves = truth.silhouettes.first().is_some_and(|car| !car.parked && car.visible > 0);
            assert_eq!(painted, moves, "frame {}", truth.number);
        }
        let middle = |number: u32| frames[number as usize - 1].silhouettes[0].bbox.centre();
        assert_eq!(middle(first), middle(last));
        assert_ne!(middle(first - 1), middle(first));
        assert_ne!(middle(last), middle(last + 1));
        let mut recorder = Recorder::new(scene.fps);
        for truth in &frames {
            recorder.push(truth);
        }
        let boxes = write::boxes_text(&recorder.finish());
        let uncounted = boxes.lines().filter(|line| line.split(',').nth(6) == Some("0")).count();
        assert_eq!(uncounted, parked.len(), "its box is not counted while it is parked");
    }
}

#[test]
fn light_changes_by_forty_per_cent() {
    for (name, before, after) in [("slow-light", 51, 351), ("sudden-light", 119, 120)] {
        let scene = Scene { actors: Vec::new(), ..scene(name, &small(1)) };
        let renderer = Renderer::new(&scene);
        let light = |number| mean(&renderer.frame(number).0);
        let growth = light(after) / light(before);
        assert!((1.385..1.405).contains(&growth), "{name}: {growth}");
        assert!((light(1) - light(before)).abs() < 1e-9 && (light(after) - light(after + 30)).abs() < 1e-9);
        let step = light(before + 1) / light(before);
        assert_eq!(step > 1.3, name == "sudden-light", "{step}");
    }
}

#[test]
fn shadow_is_darker_and_less_noisy() {
    let parameters =
        SceneParameters { noise: CameraNoise { sigma: 8.0, signal_dependent: false }, ..small(3) };
    let renderer = Renderer::new(&Scene { actors: Vec::new(), ..scene("shade", &parameters) });
    let (a, b) = (renderer.frame(1).0, renderer.frame(2).0);
    let Size { width, height } = parameters.size;
    let side = |columns: std::ops::Range<u32>| {
        let pixels = (0..height).flat_map(|y| columns.clone().map(move |x| (y * width + x) as usize));
        let (mut light, mut square, mut count) = (0.0, 0.0, 0.0);
        for at in pixels.flat_map(|at| 3 * at..3 * at + 3) {
            let (a, b) = (f64::from(a.rgb[at]), f64::from(b.rgb[at]));
            (light, square, count) = (light + a, square + (a - b) * (a - b), count + 1.0);
        }
        (light / count, (square / count / 2.0).sqrt())
    };
    let (lit, shaded) = (side(0..width / 2 - 2), side(width * 6 / 10..width));
    assert!(shaded.0 < 0.3 * lit.0, "{lit:?} {shaded:?}");
    assert!(shaded.1 < 0.7 * lit.1, "{lit:?} {shaded:?}");
}

#[test]
fn moving_background_is_not_in_the_truth() {
    for name in ["flag", "lamp", "monitor", "glints", "swaying-tree"] {
        let moving = Scene { actors: Vec::new(), ..scene(name, &SceneParameters { seed: 2, ..small(3) }) };
        let renderer = Renderer::new(&moving);
        let first = renderer.frame(1).0;
        let mut ever = vec![false; first.size.pixels()];
        for number in (2..80).step_by(3) {
            let (frame, truth) = renderer.frame(number);
            assert!(truth.silhouettes.is_empty() && truth.identities.iter().all(|&id| id == 0));
            for (at, changed) in ever.iter_mut().enumerate() {
                *changed |= difference(&frame, &first, at) > 25;
            }
        }
        let share = ever.iter().filter(|&&changed| changed).count() as f32 / ever.len() as f32;
        assert!((0.004..0.25).contains(&share), "{name} changes {share} of the image");
    }
}

#[test]
fn camera_shake_moves_image_and_truth_equally() {
    let shaking = scene("jitter", &small(3));
    let still = Scene { jitter: 0, ..shaking.clone() };
    let (shaking, still) = (Renderer::new(&shaking), Renderer::new(&still));
    let mut shifts = Vec::new();
    for number in (60..120).step_by(4) {
        let ((moved, moved_truth), (frame, truth)) = (shaking.frame(number), still.frame(number));
        let Size { width, height } = frame.size;
        let inner = || (1..height as i32 - 1).flat_map(|y| (1..width as i32 - 1).map(move |x| (x, y)));
        let at = |x: i32, y: i32| (y * width as i32 + x) as usize;
        let fits = |&(dx, dy): &(i32, i32)| {
            inner().all(|(x, y)| {
                let (to, from) = (at(x, y), at(x - dx, y - dy));
                difference_at(&moved, to, &frame, from) == 0
                    && moved_truth.identities[to] == truth.identities[from]
            })
        };
        let shift = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))).find(fits);
        shifts.push(shift.unwrap_or_else(|| panic!("frame {number} is not a shifted one")));
    }
    shifts.sort_unstable();
    shifts.dedup();
    assert!(shifts.len() > 4, "the camera moves in all directions: {shifts:?}");
}

fn difference_at(a: &Frame, at: usize, b: &Frame, other: usize) -> u8 {
    (0..3).map(|channel| a.rgb[3 * at + channel].abs_diff(b.rgb[3 * other + channel])).max().unwrap()
}

#[test]
fn a_person_passes_every_eight_seconds() {
    let truth = truth_of(&scene("passers-by", &SceneParameters { frames: Some(900), ..small(3) }));
    let enters: Vec<u32> =
        truth.events.iter().filter(|event| event.kind == Enter).map(|event| event.frame).collect();
    assert!(enters.len() >= 4, "{enters:?}");
    let all = catalogue::scene("passers-by", &SceneParameters { frames: Some(400_000), ..small(1) }).unwrap();
    assert!(all.actors.len() <= 255, "an identity is a byte in the truth's images");
}
