//! The instruction set of vector code.

use fearless_simd::Level;

/// The best instruction set of this machine. No result depends on it: tests choose others.
pub(crate) fn level() -> Level {
    #[cfg(test)]
    if let Some(level) = tests::chosen() {
        return level;
    }
    best()
}

#[expect(clippy::disallowed_methods, reason = "the only place")]
fn best() -> Level {
    Level::new()
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used)]

    use std::sync::{Mutex, PoisonError};

    use super::*;
    use crate::frame::{Frame, Size};
    use crate::pipeline::Pipeline;
    use crate::registration::{CorrectionChoice, measure_all};
    use crate::settings::{LightCorrection, Preset, Settings, Stabilise};
    use crate::synth::{Renderer, SceneParameters, catalogue};

    /// The instruction set that a test chose, for all threads.
    static CHOSEN: Mutex<Option<Level>> = Mutex::new(None);

    pub(super) fn chosen() -> Option<Level> {
        *CHOSEN.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The instruction sets of this machine, the most basic first.
    #[cfg(target_arch = "x86_64")]
    pub(crate) fn all() -> Vec<Level> {
        let best = best();
        let sse2 = best.as_sse2().map(Level::Sse2);
        let avx2 = best.as_avx2().map(Level::Avx2);
        let avx512 = best.as_avx512().map(Level::Avx512);
        [sse2, best.as_sse4_2().map(Level::Sse4_2), avx2, avx512].into_iter().flatten().collect()
    }

    #[cfg(not(target_arch = "x86_64"))]
    pub(crate) fn all() -> Vec<Level> {
        vec![best()]
    }

    /// Frames of a scene with a shaking camera, and of one whose light changes.
    fn frames(scene: &str) -> Vec<Frame> {
        let parameters = SceneParameters {
            size: Size::new(86, 64),
            frames: Some(110),
            speed: 4.0,
            ..SceneParameters::default()
        };
        let renderer = Renderer::new(&catalogue::scene(scene, &parameters).unwrap());
        (1..=110).map(|number| renderer.frame(number).0.at_time(f64::from(number) / 25.0)).collect()
    }

    /// Everything that is known of these frames, and the number of foreground pixels.
    fn results(frames: &[Frame], settings: &Settings) -> (Vec<String>, usize) {
        let mut frames = frames.to_vec();
        measure_all(&mut frames, CorrectionChoice::new(settings));
        let mut pipeline = Pipeline::new(settings, frames[0].size, 25.0).unwrap();
        let all: Vec<&Frame> = frames.iter().collect();
        pipeline.learn(&all[..20]).unwrap();
        let analyses = pipeline.step_many(&all).unwrap();
        let foreground = analyses.iter().map(|analysis| analysis.mask.foreground_pixels()).sum();
        let seen = analyses.iter().map(|analysis| format!("{analysis:?} {:?}", analysis.mask.data));
        let mixture = pipeline.mixture().unwrap();
        let pixels = (0..frames[0].size.width).map(|x| format!("{:?}", mixture.pixel(x, x % 64)));
        let alignments = frames.iter().map(|frame| format!("{:?}", frame.alignment));
        let images = [format!("{:?}", mixture.background_images())];
        (seen.chain(pixels).chain(alignments).chain(images).collect(), foreground)
    }

    #[test]
    fn every_instruction_set_gives_the_same_results() {
        let mut foreground = 0;
        for scene in ["jitter", "sudden-light"] {
            let frames = frames(scene);
            let corrected = Settings {
                stabilise: Stabilise::Similarity,
                light: LightCorrection::Gain,
                median: 5,
                ..Settings::default()
            };
            for settings in [corrected, Settings::preset(Preset::Paper)] {
                let of = |level| {
                    *CHOSEN.lock().unwrap() = level;
                    results(&frames, &settings)
                };
                let best = of(None);
                foreground += best.1;
                for level in all() {
                    assert!(of(Some(level)) == best, "{scene}: {level:?} differs");
                }
                *CHOSEN.lock().unwrap() = None;
            }
        }
        assert!(foreground > 1000, "{foreground} foreground pixels");
    }
}
