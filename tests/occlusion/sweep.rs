//! How often each scene of the catalogue is read wrongly, over many variations: a measurement to run by hand, not a test.
//!
//! `cargo test --release --locked --no-default-features --test occlusion -- --ignored --nocapture every_scene`
//!
//! `SCENES=bag,wall` names the scenes, `TOLD=2` says in words what differs in the first two of each.

use std::sync::Mutex;

use occluscope::settings::Settings;
use occluscope::synth::catalogue;
use rayon::prelude::*;

use super::{judge, parameters};

#[test]
#[ignore = "a measurement"]
fn every_scene() {
    let named = std::env::var("SCENES").unwrap_or_default();
    let told: usize = std::env::var("TOLD").map_or(0, |told| told.parse().expect("a number"));
    let mut variations = Vec::new();
    for seed in 1..=3 {
        for size in [(320, 240), (480, 360), (640, 360)] {
            for speed in [0.6, 1.5] {
                variations.push(parameters(
                    seed,
                    size,
                    speed,
                    2.0 + 2.0 * (seed + u64::from(size.0 / 320)) as f32,
                ));
            }
        }
    }
    let settings = Settings::default();
    for entry in
        catalogue::entries().filter(|entry| named.is_empty() || named.split(',').any(|it| it == entry.name))
    {
        let wrong = Mutex::new(Vec::new());
        variations.par_iter().enumerate().for_each(|(index, variation)| {
            let differences = judge::differences(entry.name, variation, &settings);
            if !differences.is_empty() {
                wrong.lock().expect("no analysis panics").push((index, differences));
            }
        });
        let mut wrong = wrong.into_inner().expect("no analysis panics");
        wrong.sort();
        println!("{}: {} of {} variations wrong", entry.name, wrong.len(), variations.len());
        for (index, differences) in wrong.iter().take(told) {
            let it = &variations[*index];
            println!("  seed {} {} speed {} noise {}", it.seed, it.size, it.speed, it.noise.sigma);
            for line in differences {
                println!("    {line}");
            }
        }
    }
}
