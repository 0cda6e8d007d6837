//! What would have kept an event from happening, worked out in small pieces when there is nothing else to do.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::run::Run;
use crate::frame::Size;
use crate::occlusion::Event;
use crate::occlusion::counterfactual::{Counterfactual, CounterfactualQuery, CounterfactualSearch};
use crate::occlusion::event_pairs::EventTolerance;

/// The tracker has known those who take part for so many seconds before an event, if the video has been on for so long.
const SECONDS_BEFORE: f32 = 12.0;
/// And for no fewer frames than this.
const FRAMES_BEFORE: u32 = 100;
/// What prevents an event must do so for so many seconds after it, as far as the video has been analysed.
const SECONDS_AFTER: f32 = 10.0;
/// Between two answers that are told.
const PACE: Duration = Duration::from_millis(200);

/// Asks one question at a time.
#[derive(Default)]
pub(super) struct Asker {
    event: Option<Event>,
    search: Option<CounterfactualSearch>,
    answer: Option<Arc<Counterfactual>>,
    told: Option<Instant>,
}

impl Asker {
    /// Asks about another event, or none.
    pub(super) fn ask(&mut self, event: Option<Event>) {
        if self.event != event {
            *self = Self { event, ..Self::default() };
        }
    }

    /// Works for a short while on what `run` has on record; whether there was anything to do.
    pub(super) fn piece(&mut self, run: &Run, numbers: &[u32], size: Size, fps: f32) -> bool {
        let Some(event) = &self.event else { return false };
        if self.answer.as_ref().is_some_and(|answer| answer.done) {
            return false;
        }
        let search = match &mut self.search {
            Some(search) => search,
            none => none.insert(CounterfactualSearch::new(query(event, run, numbers, size, fps))),
        };
        let worked = search.go_on();
        if !worked || self.told.is_none_or(|told| told.elapsed() > PACE) {
            let answer = search.what_if();
            if !worked || answer.done {
                self.search = None;
            }
            self.answer = Some(Arc::new(Counterfactual { done: answer.done || !worked, ..answer }));
            self.told = Some(Instant::now());
        }
        true
    }

    /// The newest answer.
    pub(super) fn latest(&self) -> Option<Arc<Counterfactual>> {
        self.answer.clone()
    }
}

fn query(event: &Event, run: &Run, numbers: &[u32], size: Size, fps: f32) -> CounterfactualQuery {
    let at = numbers.partition_point(|&number| number < event.frame) as u32;
    let tolerance = EventTolerance::of(size, fps);
    // It may have been decided some frames after it happened.
    let decides = |position: &u32| {
        run.outline(*position)
            .is_some_and(|(analysis, _)| analysis.events.iter().any(|other| tolerance.covers(event, other)))
    };
    let most = (at + 60.max(10 * tolerance.frames)).min(run.front());
    let decided = (at..most).find(decides).unwrap_or(at);
    let from = at.saturating_sub(((SECONDS_BEFORE * fps) as u32).max(FRAMES_BEFORE));
    let after = ((SECONDS_AFTER * fps) as u32).max(tolerance.frames);
    let to = (decided + after + 1).min(run.front());
    let frames = (from..to).filter_map(|position| {
        let (analysis, _) = run.outline(position)?;
        Some((analysis.number, Arc::clone(&analysis.regions)))
    });
    CounterfactualQuery {
        event: event.clone(),
        settings: (**run.settings()).clone(),
        frames: Arc::new(frames.collect()),
        size,
        fps,
    }
}
