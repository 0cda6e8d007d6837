//! Measures the delay from a click to the pixel's complete history, and the accuracy of other settings around it. Run
//! by hand; not a test.
//!
//! `cargo test --release --locked --lib -- --ignored --nocapture the_time_from_a_click_to_the_history`

#![allow(clippy::unwrap_used)]

use std::sync::mpsc::channel;
use std::time::Instant;

use super::*;
use crate::explain::pixel::PixelHistory;
use crate::explain::pixel::component_slots::slots_by_rank;
use crate::explain::pixel::downsampled_history::downsample;
use crate::explain::pixel::region_shares::PixelRegion;
use crate::explain::tuning::{RegionTuning, TunableSetting};
use crate::frame::{Frame, Size};
use crate::source::cache::FrameCache;
use crate::source::{FpsFrom, Source, SourceError, SourceInfo};
use crate::truth::Truth;
use crate::truth::masks::{Label, TrueMask, TrueMasks};

const SIZE: Size = Size::new(768, 576);
const FRAMES: u32 = 800;
/// Enough for all frames, so that none is decoded twice.
const MEMORY: usize = 4 << 30;
/// Number of columns of a wide panel.
const COLUMNS: usize = 500;

/// A noisy texture without motion.
struct Texture {
    info: SourceInfo,
    number: u32,
}

impl Texture {
    fn new() -> Self {
        let info = SourceInfo {
            name: "texture".into(),
            size: SIZE,
            pixel_aspect: None,
            fps: 25.0,
            fps_from: FpsFrom::Video,
            frames: Some(FRAMES),
            live: false,
            reduction: None,
        };
        Self { info, number: 0 }
    }
}

impl Source for Texture {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        if self.number == FRAMES {
            return Ok(None);
        }
        self.number += 1;
        let number = self.number;
        let level = |at: u32| (at % 97 + at / 768 % 89 + (at * 31 + number * 17) % 13 + 40) as u8;
        let rgb = (0..SIZE.pixels() as u32).flat_map(|at| [level(at), level(at + 7), level(at + 11)]);
        Ok(Some(Frame::new(number, SIZE, rgb.collect())))
    }

    fn take_warnings(&mut self) -> Vec<String> {
        Vec::new()
    }
}

#[test]
#[ignore = "a measurement"]
fn the_time_from_a_click_to_the_history() {
    let open = || -> Result<Box<dyn Source>, SourceError> { Ok(Box::new(Texture::new())) };
    let cache = move || FrameCache::new(open, MEMORY / 2);
    let (wake, woken) = channel();
    let analysis = AnalysisOptions::default();
    let session = Session::start("texture", cache, MEMORY / 2, analysis, Start::First, move || {
        let _ = wake.send(());
    });
    let wait_until = |done: &dyn Fn(&State) -> bool| loop {
        let state = session.state();
        if done(&state) {
            return state;
        }
        woken.recv().unwrap();
    };
    wait_until(&|state| state.timeline.complete && state.timeline.analysed == FRAMES && state.busy.is_none());
    let mut times: Vec<f64> = (0..50)
        .map(|click| {
            let at = (click * 137 % SIZE.width, click * 89 % SIZE.height);
            let clicked = Instant::now();
            session.request(Request::Inspect(Some(at)));
            let whole =
                |history: &Arc<PixelHistory>| history.at == at && history.states.len() as u32 == FRAMES;
            let history = wait_until(&|state| state.pixel.as_ref().is_some_and(whole)).pixel.unwrap();
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
    session.request(Request::Truth(Some(Arc::new(Truth {
        boxes: None,
        masks: masks.map(Arc::new),
        ..Truth::default()
    }))));
    for tuned_settings in
        [[TunableSetting::Alpha, TunableSetting::T], [TunableSetting::Alpha, TunableSetting::Lambda]]
    {
        session.request(Request::Tune(Some(tuned_settings)));
        for side in [1, 9, 15] {
            let requested = Instant::now();
            session.request(Request::TuneRegion(Some(PixelRegion { centre: (300, 200), side })));
            let whole = |tuning: &Arc<RegionTuning>| {
                tuning.side == side
                    && tuning.frames as u32 == FRAMES
                    && tuning.axes.each_ref().map(|axis| axis.setting) == tuned_settings
            };
            let tuning = wait_until(&|state| state.region_tuning.as_ref().is_some_and(whole));
            let cells = tuning.region_tuning.unwrap().cells.len();
            let took = requested.elapsed().as_secs_f64() * 1000.0;
            println!(
                "{tuned_settings:?}: {took:.0} ms until {side}×{side} pixels are judged under {cells} settings"
            );
        }
    }
}
