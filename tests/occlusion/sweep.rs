//! Differences from the truth over many scenes: measurements to run by hand, not tests.
//!
//! `cargo test --release --locked --no-default-features --test occlusion -- --ignored --nocapture every_scene`
//!
//! The number of differences of each scene of the catalogue. `SCENES=bag,wall` names the scenes, `PRINTED=2` prints the
//! differences of the first two of each.
//!
//! `… every_seed` instead: the scores of sixty random scenes of each kind in which people mill about, by default and
//! with each of the changes in `CHANGES="count_heads=off size_step=2"` alone.

use std::sync::Mutex;

use occluscope::settings::Settings;
use occluscope::synth::catalogue;
use rayon::prelude::*;

use super::mill::Mill;
use super::{judge, parameters};

const SEEDS: std::ops::RangeInclusive<u64> = 1..=60;

#[test]
#[ignore = "a measurement"]
fn every_scene() {
    let named = std::env::var("SCENES").unwrap_or_default();
    let printed: usize = std::env::var("PRINTED").map_or(0, |printed| printed.parse().expect("a number"));
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
        for (index, differences) in wrong.iter().take(printed) {
            let it = &variations[*index];
            println!("  seed {} {} speed {} noise {}", it.seed, it.size, it.speed, it.noise.sigma);
            for line in differences {
                println!("    {line}");
            }
        }
    }
}

#[test]
#[ignore = "a measurement"]
fn every_seed() {
    let changes = std::env::var("CHANGES").unwrap_or_default();
    let mut all = vec![("default", Settings::default())];
    for change in changes.split_whitespace() {
        let (setting, value) = change.split_once('=').expect("setting=value");
        let mut settings = Settings::default();
        settings.set(setting, value).expect("a setting in its range");
        all.push((change, settings));
    }
    for kind in [Mill::Mixed, Mill::Deep, Mill::Abreast] {
        let seeds: Vec<u64> = SEEDS.collect();
        let scores: Vec<Vec<(usize, f64)>> = seeds
            .par_iter()
            .map(|&seed| {
                let scene = kind.scene(seed);
                let mut run = judge::JudgedRun::new(&scene, 1.0, &Settings::default());
                let score = |(_, settings): &(&str, Settings)| {
                    run.track_again(settings, scene.fps);
                    (run.differences().len(), run.score().idf1)
                };
                all.iter().map(score).collect()
            })
            .collect();
        for (index, (name, _)) in all.iter().enumerate() {
            let of_all = scores.iter().filter_map(|scores| scores.get(index));
            let (differences, idf1) =
                of_all.fold((0, 0.0), |(sum, total), (differences, idf1)| (sum + differences, total + idf1));
            println!("{kind:?} {name}: IDF1 {:.3}, {differences} differences", idf1 / scores.len() as f64);
        }
    }
}
