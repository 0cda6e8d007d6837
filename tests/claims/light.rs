//! "Deals with slow lighting changes by slowly adapting the values of the Gaussians."

use occluscope::settings::{LightCorrection, Preset, Settings};

use crate::measure::{Counts, counts, deserted, scene, watch};

/// The default settings without correction of light before the mixture.
fn by_the_mixture_alone() -> Settings {
    Settings { light: LightCorrection::Off, ..Settings::default() }
}

#[test]
fn a_slow_change_of_light_is_absorbed() {
    for settings in [by_the_mixture_alone(), Settings::preset(Preset::Plain)] {
        let walkers = counts(&scene("slow-light"), &settings, 60, 400);
        assert!(walkers.f() > 0.85 && walkers.false_share() < 0.005, "{walkers:?}");
        let at_the_end = counts(&deserted("slow-light", 351), &settings, 330, 351);
        assert!(at_the_end.false_share() < 0.001, "{at_the_end:?}");

        // A model with a much smaller α cannot follow, so the change is large enough to test adaptation.
        let rigid = Settings { alpha: settings.alpha / 100.0, ..settings };
        let at_the_end = counts(&deserted("slow-light", 351), &rigid, 330, 351);
        assert!(at_the_end.false_share() > 0.5, "{at_the_end:?}");
    }
}

#[test]
fn a_sudden_change_of_light_is_foreground_until_it_is_absorbed() {
    // Held foreground (`hold`) is absorbed twenty times as slowly.
    for settings in [Settings { hold: 1.0, ..by_the_mixture_alone() }, Settings::preset(Preset::Plain)] {
        let mut shares = Vec::new();
        watch(&deserted("sudden-light", 310), &settings, |truth, mask, _| {
            let mut counts = Counts::default();
            counts.add(truth, mask, |_| true);
            shares.push(counts.false_share());
        });
        // Frame n is at index n − 1; the light changes at frame 120.
        assert!(shares[118] < 0.001 && shares[119] > 0.9, "{} {}", shares[118], shares[119]);
        assert!(shares[309] < 0.001, "{}", shares[309]);
    }
}

#[test]
fn by_default_changes_of_light_are_not_foreground_and_walkers_are() {
    let settings = Settings::default();
    let sudden = counts(&scene("sudden-light"), &settings, 119, 200);
    let raw = counts(&scene("sudden-light"), &by_the_mixture_alone(), 119, 200);
    assert!(sudden.f() > 0.8 && sudden.false_share() < 0.005, "{sudden:?}");
    assert!(raw.f() < 0.3, "the uncorrected light causes foreground: {raw:?}");
    let slow = counts(&scene("slow-light"), &settings, 60, 400);
    assert!(slow.f() > 0.85 && slow.false_share() < 0.005, "{slow:?}");
    // The light of the recent past follows the change, and the mixture adapts to it meanwhile.
    for name in ["sudden-light", "slow-light"] {
        let later = counts(&deserted(name, 1500), &settings, 400, 1500);
        assert!(later.false_share() < 0.001, "{name}: {later:?}");
    }
}
