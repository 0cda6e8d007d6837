//! Results of another method: boxes over the tracks, masks compared with ours, and their row of scores.

use super::panels::settings_panel;
use super::*;
use crate::app::commands::action::Action;
use crate::app::model::overlays::TrackOverlay;
use crate::app::views::ViewCanvas;
use crate::truth::boxes::{Bounds, Boxes};
use crate::truth::decisions::Decisions;
use crate::truth::mask_score::MaskScore;
use crate::truth::masks::{Label, TrueMasks};
use crate::truth::summary::{self, Score, TrackScore};

/// The frame in view, by its position.
const HERE: u32 = 58;

/// Our boxes in all frames, moved to the right by some pixels.
fn boxes(right: f64) -> Boxes {
    let of_frame = |position: u32| {
        let boxes = tracks_at(position).into_iter().map(|track| {
            let bbox = track.bbox;
            let [x, y, w, h] = [bbox.x, bbox.y, bbox.w, bbox.h].map(f64::from);
            (track.id, Bounds([x + right, y, w, h]))
        });
        (position + 1, boxes.collect())
    };
    (0..FRAMES).map(of_frame).collect()
}

/// The mask of the frame in view, moved to the right by some pixels.
fn mask(right: u32) -> TrueMask {
    let ours = shown_at(HERE).analysis.mask.clone();
    let is_in = |at: usize| {
        let (x, y) = (at as u32 % SIZE.width, at as u32 / SIZE.width);
        x >= right && ours.is_foreground(x - right, y)
    };
    let label = |at: usize| if is_in(at) { Label::Foreground } else { Label::Background };
    TrueMask::new(SIZE, (0..SIZE.pixels()).map(label))
}

fn masks(right: u32) -> Option<Arc<TrueMasks>> {
    TrueMasks::new(BTreeMap::from([(HERE + 1, Arc::new(mask(right)))])).map(Arc::new)
}

/// Results of a method that puts everything a little too far to the right and exchanges two identities.
fn results() -> ExternalResults {
    let mut boxes = boxes(3.0);
    for boxes in boxes.range_mut(80..).map(|(_, boxes)| boxes) {
        let (one, two) = (boxes[&1], boxes[&2]);
        boxes.extend([(1, two), (2, one)]);
    }
    ExternalResults {
        name: "a-tracker-with-a-long-name.txt".into(),
        boxes: Some(boxes),
        masks: masks(5),
        remarks: Vec::new(),
    }
}

fn truth() -> Truth {
    Truth { boxes: Some(boxes(0.0)), masks: masks(3), ..Truth::default() }
}

fn load(harness: &mut Harness<'_, Window>, result: DialogResult) {
    let ctx = harness.ctx.clone();
    harness.state_mut().handle_result(&ctx, result);
    harness.state_mut().toasts = crate::app::panels::toasts::Toasts::default();
    settle(harness);
}

fn act(harness: &mut Harness<'_, Window>, action: Action) {
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Act(action));
    settle(harness);
}

/// The scores as the worker computes them.
fn publish_scores(harness: &mut Harness<'_, Window>, scene: &RecordingPlayer) -> Arc<Score> {
    let (truth, analysed) = (truth(), (1..=FRAMES).collect());
    let ours = ExternalResults { boxes: Some(boxes(0.0)), masks: masks(0), ..ExternalResults::default() };
    let external = Arc::new(results().score(&truth, &analysed, false));
    {
        let mut state = scene.state.borrow_mut();
        let score = Some(Arc::new(ours.score(&truth, &analysed, false)));
        state.timeline = Arc::new(Timeline { score, ..timeline() });
        state.external_score = Some(Arc::clone(&external));
    }
    settle(harness);
    external
}

/// The texts in the row of scores below a heading, from left to right.
fn texts_beside(harness: &Harness<'_, Window>, top: f32) -> Vec<String> {
    let panel = settings_panel(harness);
    let nodes = harness.get_all_by_role(egui::Role::Label);
    let mut texts: Vec<(f32, String)> = nodes
        .filter(|node| panel.contains_rect(node.rect()) && (node.rect().center().y - top).abs() < 3.0)
        .map(|node| (node.rect().left(), node.value().unwrap_or_default()))
        .collect();
    texts.sort_by(|a, b| a.0.total_cmp(&b.0));
    texts.into_iter().map(|(_, text)| text).collect()
}

#[test]
fn external_boxes_and_masks_are_compared_with_ours_and_scored() {
    let (mut harness, scene) = ready(HERE);
    let seen = |harness: &Harness<'_, Window>, view: View| {
        harness.query_by_label(&format!("{} view", view.title())).is_some()
    };
    assert!(!seen(&harness, View::ExternalAgreement));
    load(&mut harness, DialogResult::External(Ok(Arc::new(results()))));
    assert!(scene.asked.borrow().contains(&PlayerCall::External(true)));
    assert!(seen(&harness, View::ExternalAgreement), "the view opens with the masks");
    assert!(harness.query_by_label("HOTA").is_none(), "there is no ground truth");

    // The masks: pixels of ours only, theirs only, and both.
    let (ours, theirs) = (shown_at(HERE).analysis.mask.clone(), mask(5));
    let agreement = harness.state().pictures.in_view().unwrap().external_agreement().unwrap();
    let count = |kind: [bool; 2]| {
        let at = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
        at.filter(|&(x, y)| [ours.is_foreground(x, y), theirs.at(x, y) == Some(Label::Foreground)] == kind)
            .count()
    };
    let expected = [[true, false], [false, true], [true, true]].map(count);
    assert!(expected.iter().all(|count| *count > 100), "{expected:?}");
    assert_eq!([agreement.first, agreement.second, agreement.both], expected);
    act(&mut harness, Action::Maximise(View::ExternalAgreement));
    let rect = harness.get_by_label("Ours vs external view").rect();
    let image = harness.render().unwrap();
    let canvas = ViewCanvas::new(rect, SIZE, harness.state().model.display.camera);
    for (kind, colour) in
        [([true, false], [230, 159, 0]), ([false, true], [86, 180, 233]), ([true, true], [228, 232, 238])]
    {
        let places = (30..70).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
        let mut places = places
            .filter(|&(x, y)| [ours.is_foreground(x, y), theirs.at(x, y) == Some(Label::Foreground)] == kind);
        let at = canvas.place_pixel(places.nth(20).unwrap()).center();
        let pixel = image.get_pixel(at.x as u32, at.y as u32).0;
        let is_near = (0..3).all(|channel| {
            let (seen, full) = (f32::from(pixel[channel]), colour[channel] as f32);
            (0.6 * full..=full + 2.0).contains(&seen)
        });
        assert!(is_near, "{kind:?}: {pixel:?} for {colour:?}");
    }
    picture(&mut harness, "external-agreement");
    act(&mut harness, Action::Maximise(View::ExternalAgreement));

    // With ground truth the decisions of their masks are shown, and a row of scores.
    load(&mut harness, DialogResult::Truth(Ok(Arc::new(truth()))));
    act(&mut harness, Action::Open(View::ExternalErrors));
    assert!(seen(&harness, View::ExternalErrors));
    let decisions = mask(3).score_labels(&mask(5));
    assert_eq!(harness.state().pictures.in_view().unwrap().external_decisions(), Some(decisions));
    let score = publish_scores(&mut harness, &scene);
    let TrackScore { strict, hota, occlusion, .. } = score.tracks.clone().unwrap();
    assert_eq!(score.tracks, Some(summary::score(&boxes(0.0), &results().boxes.unwrap())));
    assert_eq!(score.masks, Some(MaskScore::new(1, decisions)));
    let name = harness.get_all_by_label_contains("a-tracker").map(|node| node.rect().center().y);
    let tops: Vec<f32> = name.collect();
    assert_eq!(tops.len(), 2, "a row of tracks and one of masks");
    let short = |value: f64| format!("{value:.3}").trim_start_matches('0').to_owned();
    let kept = format!("{}/{}", occlusion.survived, occlusion.identities);
    let texts = texts_beside(&harness, tops[0]);
    let switches = strict.num_switches.to_string();
    let expected = [short(hota.hota), short(strict.mota), short(strict.idf1), switches, kept];
    assert_eq!((texts[1..].to_vec(), strict.num_switches), (expected.to_vec(), 2));
    let Decisions { tp, fp, fn_, .. } = decisions;
    let f = 2.0 * tp as f64 / (2 * tp + fp + fn_) as f64;
    assert_eq!(texts_beside(&harness, tops[1])[1], short(f));
    harness.get_all_by_label("ours").next().unwrap();
    picture(&mut harness, "external-all");
    let end = harness.get_by_label("Registration").rect().top();
    let part = settings_panel(&harness).with_max_y(end);
    part_looks_as_before(&mut harness, part, "external-scores");

    act(&mut harness, Action::CloseExternal);
    assert!(scene.asked.borrow().contains(&PlayerCall::External(false)));
    assert!(harness.query_all_by_label_contains("a-tracker").next().is_none());
}

#[test]
fn external_boxes_are_drawn_over_the_tracks_and_can_be_hidden() {
    let (mut harness, _) = ready(HERE);
    harness.state_mut().model.display.maximised = Some(View::Tracks);
    settle(&mut harness);
    let without = harness.render().unwrap();
    let place = BTreeMap::from([(7, Bounds([20.0, 20.0, 30.0, 50.0]))]);
    let elsewhere = BTreeMap::from([(8, Bounds([100.0, 80.0, 30.0, 30.0]))]);
    let boxes = Boxes::from([(HERE + 1, place), (HERE + 2, elsewhere)]);
    let results = ExternalResults { name: "x.txt".into(), boxes: Some(boxes), ..ExternalResults::default() };
    load(&mut harness, DialogResult::External(Ok(Arc::new(results))));
    let with = harness.render().unwrap();
    let rect = harness.get_by_label("Tracks and occlusions view").rect();
    let canvas = ViewCanvas::new(rect, SIZE, harness.state().model.display.camera);
    let differs = |place: Rect| different_pixels(&with, &without, canvas.place(&place));
    assert!(differs(Rect::new(18.0, 18.0, 34.0, 54.0)) > 200);
    assert_eq!(differs(Rect::new(100.0, 80.0, 30.0, 30.0)), 0, "boxes of other frames are not drawn");
    picture(&mut harness, "external-boxes");
    act(&mut harness, Action::Draw(TrackOverlay::External));
    assert_eq!(harness.render().unwrap(), without);
}

#[test]
fn external_results_are_read_from_a_file_and_a_failure_is_a_message() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tracker.txt");
    std::fs::write(&path, "1001,1,20,20,30,50,1,-1,-1,-1\n").unwrap();
    let (mut harness, _) = ready(HERE);
    let ctx = harness.ctx.clone();
    let read = |path: &Path| ExternalResults::read(path).map(Arc::new).map_err(|error| error.to_string());
    harness.state_mut().handle_result(&ctx, DialogResult::External(read(&path)));
    harness.run_steps(3);
    act(&mut harness, Action::Messages);
    harness.get_by_label_contains("tracker.txt has no frame of the video: its frames are 1001 to 1001");
    assert!(harness.state().model.external_boxes().is_some());
    harness.state_mut().handle_result(&ctx, DialogResult::External(read(&folder.path().join("none"))));
    harness.run_steps(3);
    harness.get_by_label_contains("none cannot be used: it does not exist; check the path");
    assert!(harness.state().model.external_boxes().is_some(), "the others stay");
    harness.state_mut().apply(&ctx, Command::Open("/videos/other.mp4".into(), Start::First));
    assert!(harness.state().model.external.is_none());
}

#[test]
fn scores_fit_the_narrowest_settings_panel() {
    let (mut harness, scene) = ready(HERE);
    let before = harness.get_by_label("Input view").rect().left();
    load(&mut harness, DialogResult::External(Ok(Arc::new(results()))));
    load(&mut harness, DialogResult::Truth(Ok(Arc::new(truth()))));
    publish_scores(&mut harness, &scene);
    assert_eq!(harness.get_by_label("Input view").rect().left(), before, "the scores widen no panel");
    harness.set_size(vec2(800.0, 560.0));
    harness.run_steps(6);
    let views = views(&harness).left();
    for heading in ["HOTA", "MOTA", "IDF1", "IDSW", "kept", "precision", "PWC"] {
        let rect = harness.get_by_label(heading).rect();
        assert!(rect.right() <= views - 8.0, "{heading} at {rect}, the views begin at {views}");
    }
    picture(&mut harness, "external-small");
}
