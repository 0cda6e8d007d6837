//! Measures the delay from a click to the pixel's complete history, and the accuracy of other settings around it. Run
//! by hand; not a test.
//!
//! `cargo test --release --locked --lib -- --ignored --nocapture a_pixels_whole_history`

#![allow(clippy::unwrap_used)]

use std::sync::mpsc::channel;
use std::time::Instant;

use super::*;
use crate::explain::pixel::component_slots::slots_by_rank;
use crate::explain::pixel::downsampled_history::downsample;
use crate::explain::tuning::TunableSetting;
use crate::frame::Size;
use crate::truth::Truth;
use crate::truth::masks::{Label, TrueMask, TrueMasks};

const SIZE: Size = Size::new(768, 576);
const FRAMES: u32 = 800;
/// Enough for all frames, so that none is decoded twice.
const MEMORY: usize = 4 << 30;
/// Number of columns of a wide panel.
const COLUMNS: usize = 500;

#[test]
#[ignore = "a measurement"]
fn a_pixels_whole_history() {
    let folder = tempfile::tempdir().unwrap();
    for number in 1..=FRAMES {
        let level = |at: u32| (at % 97 + at / 768 % 89 + (at * 31 + number * 17) % 13 + 40) as u8;
        let rgb = (0..SIZE.pixels() as u32).flat_map(|at| [level(at), level(at + 7), level(at + 11)]);
        let image = image::RgbImage::from_raw(SIZE.width, SIZE.height, rgb.collect()).unwrap();
        image.save(folder.path().join(format!("{number:06}.jpg"))).unwrap();
    }

    let (wake, woken) = channel();
    let name = folder.path().to_str().unwrap();
    let session = Session::open(
        name,
        crate::source::Options::default(),
        (Settings::default(), None),
        Start::First,
        Some(MEMORY),
        move || {
            let _ = wake.send(());
        },
    );
    let until = |done: &dyn Fn(&State) -> bool| loop {
        let state = session.state();
        if done(&state) {
            return state;
        }
        woken.recv().unwrap();
    };
    until(&|state| state.timeline.complete && state.timeline.analysed == FRAMES && state.busy.is_none());
    let mut times: Vec<f64> = (0..50)
        .map(|click| {
            let at = (click * 137 % SIZE.width, click * 89 % SIZE.height);
            let clicked = Instant::now();
            session.inspect(Some(at));
            let whole =
                |history: &Arc<PixelHistory>| history.at == at && history.states.len() as u32 == FRAMES;
            let history = until(&|state| state.pixel.as_ref().is_some_and(whole)).pixel.unwrap();
            assert_eq!(
                downsample(&history, &slots_by_rank(&history), 0..FRAMES as usize, COLUMNS).len(),
                COLUMNS
            );
            clicked.elapsed().as_secs_f64() * 1000.0
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!("{FRAMES} frames of {SIZE}: ms from a click to all columns of the history");
    println!("median {:.1}, longest {:.1}", times[times.len() / 2], times[times.len() - 1]);

    let labels = (0..SIZE.pixels()).map(|at| if at % 5 == 0 { Label::Foreground } else { Label::Background });
    let mask = Arc::new(TrueMask::new(SIZE, labels));
    let masks = TrueMasks::new((1..=FRAMES).map(|number| (number, Arc::clone(&mask))).collect());
    session.set_truth(Some(Arc::new(Truth { boxes: None, masks: masks.map(Arc::new) })));
    for knobs in [[TunableSetting::Alpha, TunableSetting::T], [TunableSetting::Alpha, TunableSetting::Lambda]]
    {
        session.tune(Some(knobs));
        for side in [1, 9, 15] {
            let asked = Instant::now();
            session.tune_region(Some(((300, 200), side)));
            let whole = |tuning: &Arc<RegionTuning>| {
                tuning.side == side
                    && tuning.frames as u32 == FRAMES
                    && tuning.axes.each_ref().map(|axis| axis.knob) == knobs
            };
            let tuning = until(&|state| state.region_tuning.as_ref().is_some_and(whole));
            let cells = tuning.region_tuning.unwrap().cells.len();
            let took = asked.elapsed().as_secs_f64() * 1000.0;
            println!("{knobs:?}: {took:.0} ms until {side}×{side} pixels are judged under {cells} settings");
        }
    }
}
