//! Compares maps of the whole image with the histories of single pixels.

use super::*;
use crate::mixture::{Quantity, QuantityMap};

/// Pixels across the image, including some under the squares.
fn pixels() -> Vec<(u32, u32)> {
    let scatter = |n: u32| (n.wrapping_mul(2_654_435_761) >> 8) as usize;
    let scattered = (1..60).map(|n| (scatter(n) as u32 % WIDTH, scatter(n * 7 + 3) as u32 % HEIGHT));
    scattered.chain([PIXEL, (30, 30), (60, 35), (0, 0), (WIDTH - 1, HEIGHT - 1)]).collect()
}

fn histories(video: &Path, settings: &Settings) -> Vec<PixelHistory> {
    let (_, frames, first) = decoded(video, settings);
    let mut histories: Vec<_> =
        pixels().into_iter().map(|at| learned_history(at, settings, &frames[..first])).collect();
    for frame in &frames {
        for history in &mut histories {
            history.push(frame);
        }
    }
    histories
}

/// The value of a map by the reference implementation.
fn expected(quantity: Quantity, history: &PixelHistory, index: usize) -> f32 {
    let state = &history.states[index];
    let first = state.pixel.components()[0];
    match quantity {
        Quantity::Sigma => first.sigma(),
        Quantity::Weight => first.weight,
        Quantity::Used => state.pixel.used() as f32,
        Quantity::BackgroundCount => f32::from(state.outcome.background_count),
        Quantity::Matched => f32::from(state.outcome.matched),
        Quantity::SinceForeground => {
            let past = history.states[..=index].iter().rev();
            past.into_iter()
                .position(|state| state.outcome.foreground)
                .map_or(f32::INFINITY, |ago| ago as f32)
        }
    }
}

fn map_at(state: &State, position: u32) -> Option<&QuantityMap> {
    state.shown.as_ref().filter(|shown| shown.position == position)?.map.as_deref()
}

#[test]
fn every_map_equals_the_histories_of_its_pixels_forwards_and_after_jumping_back() {
    let folder = scene();
    // Without stages that depend on neighbours, which a single pixel's history does not have.
    let alone = Settings { shadow_floor: 1.0, light_ceiling: 1.0, hysteresis: 0.0, ..settings() };
    let settings = Settings { t: 0.8, min_sigma: 4.0, ..alone };
    let histories = histories(folder.path(), &settings);
    let frame_bytes = (WIDTH * HEIGHT * 3) as usize;
    let mut seen = Vec::new();
    for budget in [1 << 30, frame_bytes * 160, 0] {
        let watched = WatchedSession::open(folder.path(), settings.clone(), Start::First, budget);
        for (step, position) in [0, 1, 2, 20, 21, 22, 40, 39, 38, 5, 59, 58, 0, 33].into_iter().enumerate() {
            watched.request(Request::Show(position));
            for turn in 0..Quantity::ALL.len() {
                let quantity = Quantity::ALL[(step + turn) % Quantity::ALL.len()];
                watched.request(Request::Map(Some(quantity)));
                let state = watched
                    .wait_until(|state| map_at(state, position).is_some_and(|map| map.quantity == quantity));
                let map = map_at(&state, position).unwrap();
                for history in &histories {
                    let (x, y) = history.at;
                    let value = map.values[(y * WIDTH + x) as usize];
                    let expected = expected(quantity, history, position as usize);
                    assert_eq!(value, expected, "{quantity:?} at {position}, pixel {x}, {y}");
                    seen.push((quantity, value.to_bits()));
                }
            }
        }
        // One quantity from frame to frame, as in playback, forwards and backwards.
        for quantity in [Quantity::Matched, Quantity::SinceForeground] {
            watched.request(Request::Map(Some(quantity)));
            for position in (10..30).chain((10..30).rev()) {
                watched.request(Request::Show(position));
                let state = watched
                    .wait_until(|state| map_at(state, position).is_some_and(|map| map.quantity == quantity));
                let map = map_at(&state, position).unwrap();
                for history in &histories {
                    let value = map.values[(history.at.1 * WIDTH + history.at.0) as usize];
                    assert_eq!(
                        value,
                        expected(quantity, history, position as usize),
                        "{quantity:?} at {position}"
                    );
                }
            }
        }
    }
    for quantity in Quantity::ALL {
        let mut values: Vec<_> =
            seen.iter().filter(|(of, _)| *of == quantity).map(|(_, bits)| bits).collect();
        values.sort_unstable();
        values.dedup();
        assert!(values.len() > 1, "{quantity:?} is almost constant: {}", values.len());
    }
}

#[test]
fn a_map_follows_the_settings_and_is_made_only_on_request() {
    let folder = scene();
    let watched = WatchedSession::open(folder.path(), settings(), Start::First, 1 << 30);
    watched.request(Request::Map(Some(Quantity::Sigma)));
    watched.request(Request::Show(30));
    watched.wait_until(|state| map_at(state, 30).is_some());
    let other = Settings { min_sigma: 11.0, ..settings() };
    watched.request(settings_request(other.clone(), None));
    let state = watched.wait_until(|state| {
        state.shown.as_ref().is_some_and(|shown| *shown.settings == other && shown.map.is_some())
    });
    assert!(map_at(&state, 30).unwrap().values.iter().all(|&sigma| sigma >= 11.0));
    watched.request(Request::Map(None));
    watched.wait_until_analysed();
    assert!(watched.show_and_wait(31).map.is_none());
}

#[test]
fn opencv_models_have_only_the_map_of_the_time_since_foreground() {
    let folder = scene();
    let settings = Settings { background_model: BackgroundModel::Mog2, ..settings() };
    let watched = WatchedSession::open(folder.path(), settings, Start::First, 1 << 30);
    watched.request(Request::Map(Some(Quantity::Used)));
    assert!(watched.show_and_wait(40).map.is_none());
    watched.request(Request::Map(Some(Quantity::SinceForeground)));
    let state = watched.wait_until(|state| map_at(state, 40).is_some());
    let values = &map_at(&state, 40).unwrap().values;
    assert!(values.contains(&0.0) && values.iter().any(|&since| since > 20.0));
}

#[test]
fn a_camera_has_the_matched_rank_from_the_second_frame_on() {
    let watched = camera(200, 40);
    watched.wait_until(|state| state.timeline.analysed > 80);
    watched.request(Request::Map(Some(Quantity::Matched)));
    watched.wait_until(|state| state.shown.as_ref().is_some_and(|shown| shown.map.is_some()));
    let done = watched.wait_until(|state| state.timeline.complete && state.busy.is_none());
    assert_eq!(done.timeline.analysed, 200);
}

#[test]
fn a_paused_camera_frame_has_maps_while_its_frames_are_cached() {
    let watched = camera(u32::MAX, 4000);
    watched.wait_until(|state| state.timeline.analysed > 60);
    watched.show_and_wait(40);
    // All quantities except the matched rank need no more than the next frame does.
    for quantity in Quantity::ALL {
        watched.request(Request::Map(Some(quantity)));
        let state = watched.wait_until(|state| map_at(state, 40).is_some_and(|map| map.quantity == quantity));
        assert!(state.warnings.is_empty(), "{:?}", state.warnings);
    }
}

#[test]
fn a_camera_frame_without_cached_predecessors_has_no_map() {
    let watched = camera(u32::MAX, 300);
    watched.request(Request::Map(Some(Quantity::Sigma)));
    let seen = watched.wait_until(|state| state.shown.as_ref().is_some_and(|shown| shown.map.is_some()));
    let position = seen.shown.unwrap().position;
    let stays = |state: &State| {
        assert!(!shows(state, position) || state.warnings.is_empty());
        shows(state, position)
    };
    // Requesting the newest frame follows the camera again.
    watched.wait_until(|state| state.timeline.analysed > position + 20);
    watched.request(Request::Show(position));
    let unchanged = watched.wait_until(|state| stays(state) && state.timeline.analysed > position + 400);
    assert_eq!(map_at(&unchanged, position).unwrap().quantity, Quantity::Sigma);
    watched.request(Request::Map(Some(Quantity::Weight)));
    watched.wait_until(|state| {
        assert!(stays(state), "{:?}", state.warnings);
        map_at(state, position).is_none()
    });
}
