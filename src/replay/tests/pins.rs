//! Pinned pixels, and the share of foreground around one.

use super::*;
use crate::explain::pixel::region_shares::{PixelRegion, region_bounds};

const PINS: [(u32, u32); 3] = [(30, 30), PIXEL, (0, 63)];

/// The histories of pixels, and the masks before and after cleaning, from a single pass.
fn single_pass_pins(video: &Path, settings: &Settings) -> (Vec<PixelHistory>, Vec<Mask>, Vec<Arc<Mask>>) {
    let (info, frames, first) = decoded(video, settings);
    let first = &frames[..first];
    let mut pipeline = learned_pipeline(settings, &info, first);
    let mut model = crate::mixture::Mixture::new(info.size, Parameters::new(settings));
    model.learn(&first.iter().collect::<Vec<_>>());
    let mut histories = PINS.map(|at| learned_history(at, settings, first));
    let (mut raw, mut cleaned) = (Vec::new(), Vec::new());
    for frame in &frames {
        raw.push(model.step(frame));
        cleaned.push(pipeline.step(frame).unwrap().mask);
        for history in &mut histories {
            history.push(frame);
        }
    }
    (histories.into(), raw, cleaned)
}

#[test]
fn histories_of_pinned_pixels_equal_those_of_chosen_pixels() {
    let folder = scene();
    let settings = settings();
    for budget in [1 << 30, 0] {
        let watched = WatchedSession::open(folder.path(), settings.clone(), Start::First, budget);
        watched.request(Request::Pin(PINS[..1].to_vec()));
        watched.show_and_wait(20);
        // One more pixel, whose history needs earlier frames.
        watched.request(Request::Pin([PINS[1], (500, 2), PINS[0], PINS[2]].to_vec()));
        let order = [PINS[1], PINS[0], PINS[2]];
        let complete = |state: &State| {
            state.pins.iter().map(|pin| pin.at).eq(order)
                && state.pins.iter().all(|pin| pin.states.len() == FRAMES as usize)
        };
        let expected = single_pass_pins(folder.path(), &settings).0;
        let state = watched.wait_until(complete);
        assert_eq!(*state.pins[0], expected[1]);
        assert_eq!((&*state.pins[1], &*state.pins[2]), (&expected[0], &expected[2]));

        let other = Settings { alpha: 0.1, ..settings.clone() };
        watched.request(settings_request(other.clone(), None));
        let of_other = |state: &State| {
            complete(state) && state.pins.iter().all(|pin| pin.parameters.equal_settings(&other))
        };
        let state = watched.wait_until(of_other);
        assert_eq!(*state.pins[0], single_pass_pins(folder.path(), &other).0[1]);
        watched.request(Request::Pin(Vec::new()));
        watched.wait_until(|state| state.pins.is_empty());
    }
}

#[test]
fn the_share_of_a_region_equals_that_of_the_masks() {
    let folder = scene();
    let watched = WatchedSession::open(folder.path(), settings(), Start::First, 1 << 30);
    for (at, side, settings) in [
        (PIXEL, 9, settings()),
        (PIXEL, 1, settings()),
        ((0, 30), 15, settings()),
        (PIXEL, 9, Settings { median: 0, min_area: 0, ..settings() }),
        (PIXEL, 9, Settings { t: 0.99, ..settings() }),
    ] {
        watched.request(settings_request(settings.clone(), None));
        watched.request(Request::CountRegion(Some(PixelRegion { centre: at, side })));
        let (_, raw, cleaned) = single_pass_pins(folder.path(), &settings);
        let (columns, rows) = region_bounds(at, side, Size::new(WIDTH, HEIGHT));
        let pixels = (columns.len() * rows.len()) as f32;
        let share = |mask: &Mask| {
            let all = rows.clone().flat_map(|y| columns.clone().map(move |x| (x, y)));
            all.filter(|&(x, y)| mask.is_foreground(x, y)).count() as f32 / pixels
        };
        let model: Vec<_> = raw.iter().map(share).collect();
        let cleaned: Vec<_> = cleaned.iter().map(|mask| share(mask)).collect();
        // Counts under the previous settings may be published for a moment.
        let state = watched.wait_until(|state| {
            let region = state.region.as_ref().filter(|region| (region.at, region.side) == (at, side));
            region.is_some_and(|region| region.model == model && region.cleaned == cleaned)
        });
        let region = state.region.unwrap();
        assert_eq!(region.pixels as f32, pixels);
        assert!(region.model.iter().any(|&share| share > 0.0));
    }
    watched.request(Request::CountRegion(None));
    watched.wait_until(|state| state.region.is_none());
    watched.request(Request::CountRegion(Some(PixelRegion { centre: (WIDTH, 3), side: 5 })));
    watched.request(Request::Show(3));
    assert!(watched.wait_until(|state| shows(state, 3)).region.is_none(), "outside the image");
}
