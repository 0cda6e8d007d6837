//! "Performance over extended periods of time without human intervention", indoors and outdoors.

use occluscope::frame::Size;
use occluscope::settings::Settings;
use occluscope::synth::scene::Background;
use occluscope::synth::{Scene, SceneParameters, catalogue};

use crate::measure::{Counts, watch};

/// The number of frames after which the walkers repeat.
const ROUND: u32 = 800;

#[test]
fn the_model_does_not_drift_in_thousands_of_frames() {
    for (background, rounds) in [(Background::Plaza, 4), (Background::Room, 2)] {
        let frames = Some(ROUND * rounds);
        let parameters = SceneParameters { size: Size::new(128, 96), frames, ..SceneParameters::default() };
        let scene = catalogue::scene("passers-by", &parameters).expect("it is in the catalogue");
        let scene = Scene { background, ..scene };
        let mut passing = vec![Counts::default(); rounds as usize];
        let mut deserted = passing.clone();
        watch(&scene, &Settings::default(), |truth, mask, pipeline| {
            let round = ((truth.number - 1) / ROUND) as usize;
            let counts = if truth.silhouettes.is_empty() { &mut deserted } else { &mut passing };
            counts[round].add(truth, mask, |_| true);
            if truth.number == scene.frames {
                let mixture = pipeline.mixture().expect("it is the mixture");
                for place in 0..90 {
                    let pixel = mixture.pixel(place + 20, place).expect("inside");
                    let sum: f32 = pixel.components().iter().map(|component| component.weight).sum();
                    assert!((sum - 1.0).abs() < 1e-3, "weights sum to 1: {pixel:?}");
                }
            }
        });
        let f: Vec<f64> = passing.iter().map(Counts::f).collect();
        assert!(f.iter().all(|f| *f > 0.75), "{background:?}: {f:?}");
        assert!(f[f.len() - 1] > f[0] - 0.03, "{background:?} at the end as at the start: {f:?}");
        for round in &deserted {
            assert!(round.false_share() < 1e-5, "{background:?} deserted: {round:?}");
        }
    }
}
