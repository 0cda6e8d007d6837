//! "When something is allowed to become part of the background, it doesn't destroy the existing
//! model of the background", and the background recovers quickly when it reappears.

use occluscope::mixture::pixel::{Component, Pixel};
use occluscope::settings::Settings;

use crate::measure::{scene, watch};

/// The states of a pixel that the car covers while it is parked.
struct Spot {
    at: u32,
    /// Component 1 when the car has just stopped: the background before it.
    before: Component,
    /// Number of frames from the stop of the car until the pixel is background.
    absorbed: Option<u32>,
    /// The mixture just before the car moves again.
    parked: Option<Pixel>,
    /// The last frame in which the car covered it.
    last_covered: u32,
    /// Number of frames from then until the pixel is background.
    recovered: Option<u32>,
}

impl Spot {
    /// The component of the previous background, if it is unchanged in the mixture while the car is parked.
    fn kept(&self) -> Option<&Component> {
        let same = |it: &&Component| it.mean == self.before.mean && it.variance == self.before.variance;
        self.parked.as_ref()?.components().iter().find(same)
    }
}

fn median(frames: impl Iterator<Item = Option<u32>>) -> u32 {
    let mut frames: Vec<u32> = frames.map(|frames| frames.unwrap_or(u32::MAX)).collect();
    frames.sort_unstable();
    frames[frames.len() / 2]
}

#[test]
fn a_parked_car_is_absorbed_and_the_previous_background_recovers_when_it_leaves() {
    let scene = scene("car");
    let width = scene.size.width;
    let mut stop = scene.cars[0].path.turns.iter().filter(|turn| turn.velocity == [0.0; 2]);
    let stops = stop.next().expect("it parks").frame.ceil() as u32;
    let starts = stops + 200;
    let mut spots: Vec<Spot> = Vec::new();
    // Held foreground (`hold`) would be absorbed twenty times as slowly.
    let settings = Settings { hold: 1.0, ..Settings::default() };
    watch(&scene, &settings, |truth, mask, pipeline| {
        let mixture = pipeline.mixture().expect("it is the mixture");
        let pixel = |at: u32| mixture.pixel(at % width, at / width).expect("inside");
        let covered = |at: u32| truth.identities[at as usize] > 0;
        let number = truth.number;
        if number == stops - 1 {
            // The car has almost stopped.
            let car = (0..scene.size.pixels() as u32).filter(|&at| covered(at));
            let spot = |at| Spot {
                at,
                before: pixel(at).components()[0],
                absorbed: None,
                parked: None,
                last_covered: starts,
                recovered: None,
            };
            spots = car.map(spot).collect();
        }
        for spot in &mut spots {
            let background = mask.data[spot.at as usize] == 0;
            if (stops..starts).contains(&number) && background {
                spot.absorbed.get_or_insert(number - stops);
            }
            if number == starts - 1 {
                spot.parked = Some(pixel(spot.at));
            }
            if number >= starts && covered(spot.at) {
                (spot.last_covered, spot.recovered) = (number, None);
            } else if number > starts && background {
                spot.recovered.get_or_insert(number - spot.last_covered);
            }
        }
    });
    let kept: Vec<&Spot> =
        spots.iter().filter(|spot| spot.kept().is_some_and(|old| old.weight < spot.before.weight)).collect();
    assert!(kept.len() > 400 && 10 * kept.len() > 8 * spots.len(), "{} of {}", kept.len(), spots.len());
    let absorbed = median(kept.iter().map(|spot| spot.absorbed));
    assert!((100..200).contains(&absorbed), "a new surface is absorbed slowly: {absorbed} frames");
    let at_once = kept.iter().filter(|spot| spot.recovered.is_some_and(|frames| frames <= 5)).count();
    assert!(100 * at_once > 95 * kept.len(), "{at_once} of {} are background again at once", kept.len());
}
