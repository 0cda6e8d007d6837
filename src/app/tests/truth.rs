//! Loaded ground truth: boxes, masks, and scores against them.

use super::inspector::inspected_state;
use super::*;
use crate::app::commands::action::Action;
use crate::explain::tuning::{RegionTuning, grid};
use crate::truth::decisions::Decisions;
use crate::truth::masks::{Label, TrueMask, TrueMasks};

const AT: (u32, u32) = (80, 60);

/// The frame's mask shifted slightly to the right, with an ignored strip at the bottom.
fn true_mask(position: u32) -> TrueMask {
    let mask = shown_at(position).analysis.mask.clone();
    let label = |at: usize| {
        let (x, y) = (at as u32 % SIZE.width, at as u32 / SIZE.width);
        match () {
            () if y >= SIZE.height - 16 => Label::Uncounted,
            () if x >= 4 && mask.is_foreground(x - 4, y) => Label::Foreground,
            () => Label::Background,
        }
    };
    TrueMask::new(SIZE, (0..SIZE.pixels()).map(label))
}

fn truth(position: u32) -> Arc<Truth> {
    let masks = BTreeMap::from([(position + 1, Arc::new(true_mask(position)))]);
    Arc::new(Truth { boxes: None, masks: TrueMasks::new(masks).map(Arc::new), ..Truth::default() })
}

/// A result of the worker: best at the right and in the middle.
fn tuning_of(state: &State, side: u32) -> RegionTuning {
    let parameters = state.pixel.as_ref().unwrap().parameters;
    let (axes, cells) = grid(&parameters, [TunableSetting::Alpha, TunableSetting::T]);
    let all = u64::from(side * side * 50);
    let decide = |index: usize| {
        let (column, row) = (index % 24, index / 24);
        let missed = (row.abs_diff(11) * 9 + (23 - column) * 4) as u64;
        Decisions { tp: 400 - missed, fn_: missed, fp: 60, tn: all - 460 }
    };
    let cells: Vec<_> = (0..cells.len()).map(decide).collect();
    let present = Decisions { tp: 310, fn_: 90, fp: 80, tn: all - 480 };
    RegionTuning { at: AT, side, parameters, extent: [side; 2], frames: 50, present, axes, cells }
}

/// A scene with ground truth and a chosen pixel whose tuning tab is open.
fn judged(size: (f32, f32), theme: Theme) -> (Harness<'static, Window>, RecordingPlayer) {
    let state = inspected_state(58);
    let (mut harness, scene) = window(Some(state), size, theme);
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::Choose(Some(AT)));
    harness.run_steps(3);
    harness.get_by_label("Tuning").click();
    harness.run_steps(4);
    (harness, scene)
}

fn load(harness: &mut Harness<'_, Window>, truth: Arc<Truth>) {
    let ctx = harness.ctx.clone();
    harness.state_mut().handle_result(&ctx, DialogResult::Truth(Ok(truth)));
    harness.state_mut().toasts = crate::app::panels::toasts::Toasts::default();
    settle(harness);
}

fn asked(scene: &RecordingPlayer) -> Vec<Option<((u32, u32), u32)>> {
    let asked = scene.asked.borrow();
    asked
        .iter()
        .filter_map(|asked| if let PlayerCall::TuneRegion(region) = asked { Some(*region) } else { None })
        .map(|region| region.map(|region| (region.centre, region.side)))
        .collect()
}

#[test]
fn ground_truth_masks_show_true_and_false_decisions() {
    let (mut harness, _) = ready(58);
    let ctx = harness.ctx.clone();
    let seen = |harness: &Harness<'_, Window>| harness.query_by_label("Mask errors view").is_some();
    assert!(!seen(&harness));
    load(&mut harness, truth(58));
    assert!(seen(&harness), "the view opens with the masks");
    picture(&mut harness, "right-all-views");
    harness.key_press(Key::Num9);
    settle(&mut harness);
    assert_eq!(harness.state().model.display.maximised, Some(View::MaskErrors));
    let (mask, truth) = (shown_at(58).analysis.mask.clone(), true_mask(58));
    let mut judge = truth.judge();
    mask.runs().for_each(|run| judge.take(run));
    let expected = judge.decisions();
    assert!(expected.tp > 100 && expected.fp > 50 && expected.fn_ > 50, "{expected:?}");
    assert_eq!(harness.state().pictures.in_view().unwrap().decisions(), Some(expected));
    let image = harness.render().unwrap();
    let rect = harness.get_by_label("Mask errors view").rect();
    let canvas = crate::app::views::ViewCanvas::new(rect, SIZE, harness.state().model.display.camera);
    // A pixel of each kind has its colour on the screen.
    for (label, found, colour) in [
        (Label::Foreground, true, [228, 232, 238]),
        (Label::Background, true, [232, 92, 28]),
        (Label::Foreground, false, [86, 180, 233]),
        (Label::Uncounted, false, [58, 52, 66]),
    ] {
        let places = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
        let mut places = places.filter(|&(x, y)| {
            truth.at(x, y) == Some(label)
                && mask.is_foreground(x, y) == found
                && (y < 70 || label == Label::Uncounted)
        });
        let (x, y) = places.nth(20).unwrap();
        let at = canvas.place_pixel((x, y)).center();
        let pixel = image.get_pixel(at.x as u32, at.y as u32).0;
        let near = (0..3).all(|channel| f32::from(pixel[channel]) > 0.6 * colour[channel] as f32);
        let bound = (0..3).all(|channel| u32::from(pixel[channel]) <= colour[channel] + 2);
        assert!(near && bound, "{label:?} {found}: {pixel:?} for {colour:?}");
    }
    picture(&mut harness, "right-alone");
    // The other frame has no ground-truth mask.
    harness.state_mut().apply(&ctx, Command::GoTo(40));
    settle(&mut harness);
    assert_eq!(harness.state().pictures.in_view().unwrap().decisions(), None);
    picture(&mut harness, "right-none");
}

#[test]
fn without_masks_the_views_show_how_to_load_them() {
    let (mut harness, scene) = judged((1600.0, 1000.0), Theme::Dark);
    harness.get_by_label("Load ground truth folder…");
    picture(&mut harness, "judged-without-masks");
    // Ignored pixels have no mark in the views either.
    assert_eq!(asked(&scene), [Some((AT, 9))]);
    assert!(!harness.state().model.has_true_masks());
    let other =
        TrueMasks::new(BTreeMap::from([(1, Arc::new(TrueMask::of_identities(Size::new(2, 2), &[0; 4])))]));
    load(&mut harness, Arc::new(Truth { boxes: None, masks: other.map(Arc::new), ..Truth::default() }));
    assert!(!harness.state().model.has_true_masks(), "masks of another size are of another video");
}

#[test]
fn accuracy_under_other_settings_is_requested_shown_and_applied() {
    let (mut harness, scene) = judged((1600.0, 1600.0), Theme::Dark);
    load(&mut harness, truth(58));
    harness.get_by_label_contains("Map of accuracy against the ground truth");
    harness.get_by_label("15×15").click();
    harness.run_steps(3);
    assert_eq!(asked(&scene), [Some((AT, 9)), Some((AT, 15))], "once each");
    let tuning = tuning_of(&scene.state.borrow(), 15);
    scene.state.borrow_mut().region_tuning = Some(Arc::new(tuning.clone()));
    settle(&mut harness);
    harness.run_steps(3);
    harness.get_by_label_contains("Current: accuracy 98.49 % of 11250: FP 80, FN 90");
    right_panel_looks_as_before(&mut harness, "judged");
    harness.get_by_label_contains("Best: accuracy 99.47 % of 11250: FP 60, FN 0");
    let [alpha, t] = [tuning.axes[0].values[23], tuning.axes[1].values[11]];
    let number = crate::explain::pixel::verdict::number;
    harness.get_by_label(&format!("α = {},  T = {}", number(alpha), number(t))).click();
    harness.run_steps(8);
    let settings = given(&scene).expect("the best cell was not applied");
    assert_eq!((settings.alpha, settings.t), (alpha, t));
    harness.get_all_by_label("F").last().unwrap().click();
    harness.run_steps(4);
    harness.get_by_label_contains("Map of F-measure against the ground truth");
}

#[test]
fn a_hidden_tab_requests_nothing() {
    use crate::app::model::selection::Subject;
    let (mut harness, scene) = judged((1600.0, 1000.0), Theme::Dark);
    let tuned = |scene: &RecordingPlayer| {
        let asked = scene.asked.borrow();
        let last = asked
            .iter()
            .rev()
            .find_map(|asked| if let PlayerCall::Tune(settings) = asked { Some(*settings) } else { None });
        last.flatten()
    };
    assert!(tuned(&scene).is_some());
    let ctx = harness.ctx.clone();
    harness.state_mut().apply(&ctx, Command::ShowSubject(Subject::Object));
    harness.run_steps(3);
    assert_eq!((tuned(&scene), asked(&scene).last().copied()), (None, Some(None)), "the object tab is open");
    harness.state_mut().apply(&ctx, Command::ShowSubject(Subject::Pixel));
    harness.run_steps(3);
    assert!(tuned(&scene).is_some());
    harness.state_mut().apply(&ctx, Command::Act(Action::InspectorPanel));
    harness.run_steps(3);
    assert_eq!(tuned(&scene), None, "the panel is closed");
}

#[test]
fn the_maps_fit_small_windows_and_the_light_theme() {
    for (size, theme, name) in
        [((1024.0, 640.0), Theme::Dark, "small"), ((2560.0, 1440.0), Theme::Light, "large-light")]
    {
        let (mut harness, scene) = judged(size, theme);
        load(&mut harness, truth(58));
        let tuning = tuning_of(&scene.state.borrow(), 9);
        scene.state.borrow_mut().region_tuning = Some(Arc::new(tuning));
        settle(&mut harness);
        harness.run_steps(3);
        harness.get_by_label_contains("Map of accuracy against the ground truth");
        picture(&mut harness, &format!("judged-{name}"));
    }
}

#[test]
fn masks_are_scored_beside_the_events() {
    use crate::truth::mask_score::MaskScore;
    use crate::truth::summary::Score;
    let (mut harness, scene) = ready(58);
    load(&mut harness, truth(58));
    let masks = MaskScore::new(50, Decisions { tp: 900, fp: 100, fn_: 300, tn: 8700 });
    let timeline =
        Timeline { score: Some(Arc::new(Score { tracks: None, masks: Some(masks) })), ..timeline() };
    scene.state.borrow_mut().timeline = Arc::new(timeline);
    settle(&mut harness);
    for number in [".818", ".900", ".750", "4.00"] {
        harness.get_by_label(number);
    }
    picture(&mut harness, "scores-of-masks");
}

#[test]
fn ground_truth_can_be_dropped_on_a_video() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gt.txt");
    std::fs::write(&path, "59,1,20,20,30,50,1,1,1\n").unwrap();
    let (mut harness, scene) = ready(58);
    harness.input_mut().dropped_files.push(Arc::new(Dropped(path)));
    let truth = draw_until(&mut harness, |harness| harness.state().model.truth.clone());
    assert!(truth.boxes.is_some());
    assert!(scene.asked.borrow().contains(&PlayerCall::Truth(true)));
}

/// The folder of a sequence with images and true boxes.
fn sequence() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for inner in ["img1", "gt", "groundtruth"] {
        std::fs::create_dir(folder.path().join(inner)).unwrap();
    }
    image::RgbImage::new(8, 6).save(folder.path().join("img1/000001.png")).unwrap();
    folder
}

#[test]
fn the_folder_of_a_sequence_is_opened_when_dropped_and_is_truth_for_its_own_images() {
    let folder = sequence();
    let path = folder.path().to_str().unwrap();
    let drop = |harness: &mut Harness<'_, Window>| {
        harness.input_mut().dropped_files.push(Arc::new(Dropped(folder.path().into())));
        harness.run_steps(3);
    };
    let (mut harness, _) = ready(58);
    drop(&mut harness);
    assert_eq!(harness.state().model.videos.opened.as_deref(), Some(path));

    let (mut harness, _) = ready(58);
    let images = folder.path().join("img1").to_str().unwrap().to_owned();
    harness.state_mut().model.videos.opened = Some(images.clone());
    drop(&mut harness);
    assert_eq!(harness.state().model.videos.opened.as_deref(), Some(images.as_str()));
}

#[test]
fn the_truth_beside_a_sequence_is_offered_until_it_is_loaded_or_dismissed() {
    let folder = sequence();
    std::fs::remove_dir(folder.path().join("groundtruth")).unwrap();
    let path = folder.path().join("gt/gt.txt");
    std::fs::write(&path, "59,1,20,20,30,50,1,1,1\n").unwrap();
    let (mut harness, _) = ready(58);
    let ctx = harness.ctx.clone();
    let is_offered =
        |harness: &Harness<'_, Window>| harness.query_by_label("Load its ground truth").is_some();
    let name = folder.path().to_str().unwrap().to_owned();
    harness.state_mut().apply(&ctx, Command::Open(name.clone(), Start::First));
    let offered = draw_until(&mut harness, |harness| harness.state().model.offered_truth.clone());
    assert_eq!(offered, path);
    harness.run_steps(3);
    assert!(is_offered(&harness));
    picture(&mut harness, "truth-offered");
    harness.get_by_label("Not now").click();
    harness.run_steps(3);
    assert!(!is_offered(&harness));

    let offer = DialogResult::TruthOffered("another video".into(), Some(path.clone()));
    harness.state_mut().handle_result(&ctx, offer);
    harness.run_steps(3);
    assert!(!is_offered(&harness), "the video is no longer open");
    harness.state_mut().handle_result(&ctx, DialogResult::TruthOffered(name, Some(path.clone())));
    harness.run_steps(3);
    harness.get_by_label("Load its ground truth").click();
    draw_until(&mut harness, |harness| harness.state().model.truth.clone());
    harness.run_steps(3);
    assert!(!is_offered(&harness));
}

#[derive(Debug)]
pub(super) struct Dropped(pub(super) std::path::PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}
