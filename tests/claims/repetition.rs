//! "Deals with multi-modal distributions": recurring changes become background if T includes more than one component.

use occluscope::frame::Size;
use occluscope::settings::{Preset, Settings};
use occluscope::synth::{Renderer, Scene};

use crate::measure::{Counts, deserted, scene, watch};

/// The pixels of a scene without people that change by more than its noise.
fn restless(scene: &Scene) -> Vec<bool> {
    let renderer = Renderer::new(scene);
    let first = renderer.frame(1).0.rgb;
    let mut restless = vec![false; scene.size.pixels()];
    for number in (2..100).step_by(2) {
        let frame = renderer.frame(number).0.rgb;
        for (at, restless) in restless.iter_mut().enumerate() {
            *restless |= (3 * at..3 * at + 3).any(|channel| frame[channel].abs_diff(first[channel]) > 40);
        }
    }
    restless
}

/// The share of restless pixels that are foreground after `learnt` frames, and the share of them with more than one
/// background component.
fn taken_for_foreground(name: &str, settings: &Settings, learnt: u32) -> (f64, f64) {
    let scene = deserted(name, learnt + 80);
    let restless = restless(&scene);
    let Size { width, .. } = scene.size;
    let mut counts = Counts::default();
    let (mut several, mut all) = (0, 0);
    watch(&scene, settings, |truth, mask, pipeline| {
        if truth.number > learnt {
            counts.add(truth, mask, |at| restless[at]);
        }
        if truth.number == scene.frames {
            let mixture = pipeline.mixture().expect("it is the mixture");
            for at in (0..).zip(&restless).filter_map(|(at, restless)| restless.then_some(at)) {
                let pixel = mixture.pixel(at % width, at / width).expect("inside");
                several += u32::from(pixel.background_count(settings.t) > 1);
                all += 1;
            }
        }
    });
    assert!(all > 100, "{name} moves");
    (counts.false_share(), f64::from(several) / f64::from(all))
}

#[test]
fn recurring_changes_become_background_only_at_a_higher_t() {
    for name in ["lamp", "flag", "monitor", "glints", "swaying-tree"] {
        let plain = Settings { k: 5, ..Settings::preset(Preset::Plain) };
        let (high, several) = taken_for_foreground(name, &Settings { t: 0.9, ..plain.clone() }, 180);
        assert!(high < 0.07 && several > 0.5, "{name}: {high} foreground, {several} with B > 1");
        let (low, several) = taken_for_foreground(name, &Settings { t: 0.3, ..plain }, 180);
        assert!(low > 0.12 && low > 3.0 * high, "{name}: {low} foreground at a low T, {high} at a high one");
        assert!(several < 0.06, "{name}: {several} with B > 1 at a low T");
    }
}

#[test]
fn by_default_recurring_changes_are_not_foreground() {
    for name in ["lamp", "flag", "monitor", "glints", "swaying-tree"] {
        let (share, _) = taken_for_foreground(name, &Settings::default(), 420);
        assert!(share < 0.05, "{name}: {share}");
    }
}

#[test]
fn a_flashing_lamp_has_two_components() {
    let scene = deserted("lamp", 260);
    let lamp = scene.motions[0];
    let settings = Settings::preset(Preset::Plain);
    watch(&scene, &settings, |truth, _, pipeline| {
        if truth.number < scene.frames {
            return;
        }
        let mixture = pipeline.mixture().expect("it is the mixture");
        let pixel = mixture.pixel(lamp.at[0] as u32, lamp.at[1] as u32).expect("inside");
        let [one, other] = [pixel.components()[0], pixel.components()[1]];
        assert!(one.weight > 0.3 && other.weight > 0.3, "{pixel:?}");
        let apart = one.distance_squared(other.mean).sqrt();
        assert!(apart > 100.0, "off and on: {one:?} {other:?}");
        assert_eq!((pixel.background_count(0.7), pixel.background_count(0.3)), (2, 1));
    });
}

#[test]
fn one_component_cannot_distinguish_a_walker_from_the_background() {
    let f = |k: u32| {
        let settings = Settings { k, ..Settings::preset(Preset::Plain) };
        crate::measure::counts(&scene("lamp"), &settings, 160, 310).f()
    };
    let (one, four) = (f(1), f(4));
    assert!(four > 0.85 && one < 0.6, "{one} with one component, {four} with four");
}
