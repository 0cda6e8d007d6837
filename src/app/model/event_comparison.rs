//! Comparison of the events of two settings.

use std::sync::Arc;

use crate::explain::events::event_pairs::{self, EventPair, EventTolerance};
use crate::replay::{ComparedSequence, State, Timeline};

/// A reference to an event, by its index in its timeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EventRef {
    /// An event of the settings in view.
    InView(usize),
    /// An event of the compared settings.
    Compared(usize),
}

/// Filter of the event list while settings are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum ComparisonFilter {
    /// All.
    All,
    /// Events of the settings in view only.
    OnlyInView,
    /// Events of the compared settings only.
    OnlyCompared,
    /// Events of both settings at different frames.
    Moved,
}

impl ComparisonFilter {
    /// All filters in order.
    pub(crate) const ALL: [Self; 4] = [Self::All, Self::OnlyInView, Self::OnlyCompared, Self::Moved];
}

/// The paired events of two timelines, with both timelines.
#[derive(Clone, Debug)]
pub(crate) struct EventComparison {
    in_view: Arc<Timeline>,
    compared: Arc<ComparedSequence>,
    /// The pairs, in order of time.
    pub(crate) pairs: Vec<EventPair>,
}

impl EventComparison {
    /// The comparison of a published state; `None` where no settings are compared. Reuses `before` while it is valid.
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

    /// Whether a filter lists a pair.
    pub(crate) fn lists(&self, listing: ComparisonFilter, pair: EventPair) -> bool {
        match listing {
            ComparisonFilter::All => true,
            ComparisonFilter::OnlyInView => matches!(pair, EventPair::First(_)),
            ComparisonFilter::OnlyCompared => matches!(pair, EventPair::Second(_)),
            ComparisonFilter::Moved => self.moved(pair).is_some_and(|frames| frames != 0),
        }
    }

    /// By how many frames the event of the compared settings is later.
    pub(crate) fn moved(&self, pair: EventPair) -> Option<i64> {
        let EventPair::Both(i, j) = pair else { return None };
        let (in_view, _) = self.in_view.events.get(i)?;
        let (compared, _) = self.compared.timeline.events.get(j)?;
        Some(i64::from(*compared) - i64::from(*in_view))
    }
}
