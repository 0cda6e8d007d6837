//! The events of two settings beside each other.

use std::sync::Arc;

use crate::occlusion::event_pairs::{self, EventPair, EventTolerance};
use crate::replay::{ComparedSequence, State, Timeline};

/// An event whose evidence is read, by its place in its timeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EventRef {
    /// Under the settings in view.
    InView(usize),
    /// Under those that are compared with them.
    Compared(usize),
}

/// Which events are listed while settings are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum ComparisonFilter {
    /// All.
    All,
    /// Those that happen under the settings in view alone.
    OnlyInView,
    /// Those that happen under the others alone.
    OnlyCompared,
    /// Those that happen at another frame.
    Moved,
}

impl ComparisonFilter {
    /// All of them in order.
    pub(crate) const ALL: [Self; 4] = [Self::All, Self::OnlyInView, Self::OnlyCompared, Self::Moved];
}

/// Which events two timelines have in common, and of which timelines that is true.
#[derive(Clone, Debug)]
pub(crate) struct EventComparison {
    in_view: Arc<Timeline>,
    compared: Arc<ComparedSequence>,
    /// In order of time.
    pub(crate) pairs: Vec<EventPair>,
}

impl EventComparison {
    /// Of what was published, if something is compared; `before` where that is still true.
    pub(crate) fn of(state: &State, fps: f32, before: Option<Self>) -> Option<Self> {
        let compared = state.compared.as_ref()?;
        let same = |before: &Self| {
            Arc::ptr_eq(&before.in_view, &state.timeline) && Arc::ptr_eq(&before.compared, compared)
        };
        if before.as_ref().is_some_and(same) {
            return before;
        }
        let tolerance = EventTolerance::of(state.info.as_ref()?.size, fps);
        let pairs = event_pairs::pair_events(&state.timeline.events, &compared.timeline.events, tolerance);
        Some(Self { in_view: Arc::clone(&state.timeline), compared: Arc::clone(compared), pairs })
    }

    /// Whether a pair belongs to a listing.
    pub(crate) fn lists(&self, listing: ComparisonFilter, pair: EventPair) -> bool {
        match listing {
            ComparisonFilter::All => true,
            ComparisonFilter::OnlyInView => matches!(pair, EventPair::First(_)),
            ComparisonFilter::OnlyCompared => matches!(pair, EventPair::Second(_)),
            ComparisonFilter::Moved => self.moved(pair).is_some_and(|frames| frames != 0),
        }
    }

    /// By how many frames the event under the other settings is later.
    pub(crate) fn moved(&self, pair: EventPair) -> Option<i64> {
        let EventPair::Both(i, j) = pair else { return None };
        let (in_view, _) = self.in_view.events.get(i)?;
        let (compared, _) = self.compared.timeline.events.get(j)?;
        Some(i64::from(*compared) - i64::from(*in_view))
    }
}
