//! Measures of a model on a scene.

use occluscope::frame::{Mask, Size};
use occluscope::pipeline::Pipeline;
use occluscope::registration::{CorrectionChoice, Estimator};
use occluscope::settings::Settings;
use occluscope::synth::noise::CameraNoise;
use occluscope::synth::render::FrameTruth;
use occluscope::synth::{Scene, SceneParameters, catalogue, render};

/// A scene of the catalogue at a small size.
pub(crate) fn scene(name: &str) -> Scene {
    let noise = CameraNoise { sigma: 4.0, signal_dependent: false };
    let parameters = SceneParameters { size: Size::new(160, 120), noise, ..SceneParameters::default() };
    catalogue::scene(name, &parameters).expect("a scene of the catalogue")
}

/// The same scene without people, for this many frames.
pub(crate) fn deserted(name: &str, frames: u32) -> Scene {
    Scene { actors: Vec::new(), cars: Vec::new(), frames, ..scene(name) }
}

/// Runs all stages on a scene; calls `see` with each frame's truth and mask, and the model after it.
pub(crate) fn watch(scene: &Scene, settings: &Settings, mut see: impl FnMut(&FrameTruth, &Mask, &Pipeline)) {
    let mut pipeline = Pipeline::new(settings, scene.size, scene.fps).expect("settings in range");
    let mut estimator = Estimator::of(scene.size, CorrectionChoice::new(settings));
    for (mut frame, truth) in render(scene) {
        frame.alignment = estimator.step(&frame);
        let analysis = pipeline.step(&frame).expect("a frame of the scene's size");
        see(&truth, &analysis.mask, &pipeline);
    }
}

/// The confusion matrix of pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    hit: u32,
    wrong: u32,
    missed: u32,
    all: u32,
}

impl Counts {
    /// Adds the pixels of a frame for which `counts` holds.
    pub(crate) fn add(&mut self, truth: &FrameTruth, mask: &Mask, counts: impl Fn(usize) -> bool) {
        for (at, (&who, &level)) in truth.identities.iter().zip(&mask.data).enumerate() {
            if !counts(at) {
                continue;
            }
            self.all += 1;
            match (who > 0, level > 0) {
                (true, true) => self.hit += 1,
                (false, true) => self.wrong += 1,
                (true, false) => self.missed += 1,
                (false, false) => {}
            }
        }
    }

    /// The F-measure of the foreground.
    pub(crate) fn f(&self) -> f64 {
        f64::from(2 * self.hit) / f64::from((2 * self.hit + self.wrong + self.missed).max(1))
    }

    /// The false positive rate.
    pub(crate) fn false_share(&self) -> f64 {
        f64::from(self.wrong) / f64::from((self.all - self.hit - self.missed).max(1))
    }
}

/// The confusion matrix of a scene's frames from `first` to `last`.
pub(crate) fn counts(scene: &Scene, settings: &Settings, first: u32, last: u32) -> Counts {
    let mut counts = Counts::default();
    watch(&Scene { frames: scene.frames.min(last), ..scene.clone() }, settings, |truth, mask, _| {
        if truth.number >= first {
            counts.add(truth, mask, |_| true);
        }
    });
    counts
}
