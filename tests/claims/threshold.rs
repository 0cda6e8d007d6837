//! "Effectively a per pixel/per distribution threshold", which "can be perturbed with little effect", and a small T,
//! with which a single component is background.

use occluscope::settings::{Preset, Settings};
use occluscope::synth::noise::CameraNoise;
use occluscope::synth::{Scene, SceneParameters, catalogue};

use crate::measure::{Counts, counts, scene, watch};

/// F-measure in light and in shadow.
fn lit_and_shaded(scene: &Scene, settings: &Settings) -> [f64; 2] {
    let width = scene.size.width as usize;
    let mut sides = [Counts::default(); 2];
    watch(scene, settings, |truth, mask, _| {
        if truth.number > 160 {
            sides[0].add(truth, mask, |at| at % width < width / 2 - 2);
            sides[1].add(truth, mask, |at| at % width > width * 11 / 20);
        }
    });
    sides.map(|side| side.f())
}

#[test]
fn a_walker_is_segmented_in_light_and_in_shadow() {
    let noise = CameraNoise { sigma: 6.0, signal_dependent: true };
    let parameters = SceneParameters { noise, size: scene("shade").size, ..SceneParameters::default() };
    let scene = catalogue::scene("shade", &parameters).expect("it is in the catalogue");
    let plain = Settings::preset(Preset::Plain);
    let [lit, shaded] = lit_and_shaded(&scene, &plain);
    assert!(lit > 0.85 && shaded > 0.85, "F {lit} in light, {shaded} in shadow");

    // The σ of the lit part, for all pixels.
    let mut sigmas = Vec::new();
    watch(&Scene { frames: 140, ..scene.clone() }, &plain, |truth, _, pipeline| {
        if truth.number == 140 {
            let mixture = pipeline.mixture().expect("it is the mixture");
            let ground = (0..30).flat_map(|x| (70..110).map(move |y| (2 * x, y)));
            sigmas = ground.filter_map(|(x, y)| Some(mixture.pixel(x, y)?.components()[0].sigma())).collect();
        }
    });
    sigmas.sort_by(f32::total_cmp);
    let of_the_light = sigmas[sigmas.len() / 2];
    let [lit, shaded] = lit_and_shaded(&scene, &Settings { min_sigma: of_the_light, ..plain });
    assert!(lit > 0.85, "F {lit} in light");
    assert!(shaded < 0.75, "a global σ misses the walker in shadow: F {shaded}");
}

#[test]
fn the_threshold_may_be_perturbed_with_little_effect() {
    for settings in [Settings::default(), Settings::preset(Preset::Plain)] {
        for name in ["crossing", "tree"] {
            let f = [2.0, 2.5, 3.0, 3.5].map(|match_sigmas| {
                counts(&scene(name), &Settings { match_sigmas, ..settings.clone() }, 60, 1000).f()
            });
            let (least, most) =
                (f.iter().copied().fold(1.0, f64::min), f.iter().copied().fold(0.0, f64::max));
            assert!(least > 0.85 && most - least < 0.035, "{name}: {f:?}");
        }
    }
}

#[test]
fn one_component_is_background_with_a_small_t() {
    let scene = scene("crossing");
    let masks = |t: f32| {
        let settings = Settings { t, ..Settings::preset(Preset::Plain) };
        let (mut masks, mut several) = (Vec::new(), [0; 2]);
        watch(&scene, &settings, |truth, mask, pipeline| {
            masks.push(mask.data.clone());
            if truth.number == 130 {
                let mixture = pipeline.mixture().expect("it is the mixture");
                for (x, y) in (0..scene.size.height).flat_map(|y| (0..scene.size.width).map(move |x| (x, y)))
                {
                    let pixel = mixture.pixel(x, y).expect("inside");
                    several[0] += u32::from(pixel.background_count(t) > 1);
                    several[1] += u32::from(pixel.background_count(0.95) > 1);
                }
            }
        });
        (masks, several)
    };
    let ((small, several), (usual, _)) = (masks(0.2), masks(0.7));
    assert!(
        several[0] == 0 && several[1] > 300,
        "B > 1 in so many pixels at a small and a high T: {several:?}"
    );
    let differing = small.iter().flatten().zip(usual.iter().flatten()).filter(|(a, b)| a != b).count();
    let foreground = small.iter().flatten().filter(|&&level| level > 0).count();
    assert!(500 * differing < foreground, "{differing} of {foreground} foreground pixels");
}
