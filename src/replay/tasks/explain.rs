//! The counterfactual search for an event, in short steps when no other work is due.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::explain::events::counterfactual::{
    Counterfactual, CounterfactualQuery, CounterfactualSearch, FrameRegions,
};
use crate::explain::events::event_pairs::EventTolerance;
use crate::frame::Size;
use crate::occlusion::Event;
use crate::replay::tasks::analyse::model_timeline::ModelTimeline;

/// Seconds before the event at which the tracker starts, so that it learns the members, as far as the video goes
/// back.
const SECONDS_BEFORE_EVENT: f32 = 12.0;
/// Least number of frames before the event at which the tracker starts.
const MIN_FRAMES_BEFORE_EVENT: u32 = 100;
/// Seconds after the event during which the event must stay prevented, as far as the video has been analysed.
const SECONDS_AFTER_EVENT: f32 = 10.0;
/// Least interval between two published reports.
const MIN_PUBLISH_INTERVAL: Duration = Duration::from_millis(200);

/// The task of finding the counterfactuals of one event at a time.
#[derive(Default)]
pub(crate) struct CounterfactualTask {
    event: Option<Event>,
    search: Option<CounterfactualSearch>,
    report: Option<Arc<Counterfactual>>,
    published_at: Option<Instant>,
}

impl CounterfactualTask {
    /// Sets the event, or none.
    pub(crate) fn set_event(&mut self, event: Option<Event>) {
        if self.event != event {
            *self = Self { event, ..Self::default() };
        }
    }

    /// Advances for a short time on the record of `model`; returns whether there was work to do.
    pub(crate) fn advance(&mut self, model: &ModelTimeline, numbers: &[u32], size: Size, fps: f32) -> bool {
        let Some(event) = &self.event else { return false };
        if self.report.as_ref().is_some_and(|report| report.done) {
            return false;
        }
        let search = match &mut self.search {
            Some(search) => search,
            none => none.insert(CounterfactualSearch::new(query(event, model, numbers, size, fps))),
        };
        let worked = search.advance();
        if !worked
            || self.published_at.is_none_or(|published_at| published_at.elapsed() > MIN_PUBLISH_INTERVAL)
        {
            let report = search.report();
            if !worked || report.done {
                self.search = None;
            }
            self.report = Some(Arc::new(Counterfactual { done: report.done || !worked, ..report }));
            self.published_at = Some(Instant::now());
        }
        true
    }

    /// The newest report.
    pub(crate) fn latest(&self) -> Option<Arc<Counterfactual>> {
        self.report.clone()
    }
}

fn query(event: &Event, model: &ModelTimeline, numbers: &[u32], size: Size, fps: f32) -> CounterfactualQuery {
    let at = numbers.partition_point(|&number| number < event.frame) as u32;
    let tolerance = EventTolerance::of(size, fps);
    // The decision can be some frames after the event.
    let decides = |position: &u32| {
        model
            .outline(*position)
            .is_some_and(|analysis| analysis.events.iter().any(|other| tolerance.matches(event, other)))
    };
    let most = (at + 60.max(10 * tolerance.frames)).min(model.analysed());
    let decided = (at..most).find(decides).unwrap_or(at);
    let from = at.saturating_sub(((SECONDS_BEFORE_EVENT * fps) as u32).max(MIN_FRAMES_BEFORE_EVENT));
    let after = ((SECONDS_AFTER_EVENT * fps) as u32).max(tolerance.frames);
    let to = (decided + after + 1).min(model.analysed());
    let frames = (from..to).filter_map(|position| {
        let analysis = model.outline(position)?;
        let regions = Arc::clone(&analysis.regions);
        Some(FrameRegions { number: analysis.number, time: analysis.time, regions })
    });
    CounterfactualQuery {
        event: event.clone(),
        settings: (**model.settings()).clone(),
        frames: Arc::new(frames.collect()),
        size,
        fps,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::frame::Frame;
    use crate::occlusion::EventKind;
    use crate::replay::tasks::analyse::PassInputs;
    use crate::replay::tests::{info_of, scene, settings, single_pass};
    use crate::settings::{Settings, Span};

    #[test]
    fn a_search_covers_the_frames_before_the_event_and_those_after_its_decision() {
        let folder = scene();
        let settings = Settings { bootstrap: Span::Frames(0), ..settings() };
        let seen = single_pass(folder.path(), &settings);
        let size = seen[0].frame.size;
        let info = info_of(size);
        let (settings, info) = (Arc::new(settings), Arc::new(info));
        let mut model = ModelTimeline::new(PassInputs { settings, roi: None, info, budget: 0 }).unwrap();
        let numbers: Vec<_> = (1..=300).collect();
        for (&number, shown) in numbers.iter().zip(seen.iter().cycle()) {
            let frame = Frame::new(number, size, shown.frame.rgb.clone());
            model.advance(&[Arc::new(frame)]).unwrap();
        }
        let is_merge = |event: &&Event| event.kind == EventKind::Merge;
        let merge = |position| model.outline(position)?.events.iter().find(is_merge);
        let (decided, event) = (130..300).find_map(|position| Some((position, merge(position)?))).unwrap();
        // At least 100 frames before the event, or 12 seconds; 10 seconds after its decision.
        for (fps, before, after) in [(2.0, 100, 20), (10.0, 120, 100)] {
            let frames = query(event, &model, &numbers, size, fps).frames;
            let covered = frames.first().unwrap().number..=frames.last().unwrap().number;
            assert_eq!(covered, event.frame - before..=decided + 1 + after, "{fps} frames a second");
        }
    }
}
