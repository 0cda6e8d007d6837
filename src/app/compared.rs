//! The events of two settings beside each other.

use std::sync::Arc;

use crate::occlusion::event_pairs::{self, EventPair, EventTolerance};
use crate::replay::{ComparedSequence, State, Timeline};

/// An event whose evidence is read, by its place in its timeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Read {
    /// Under the settings in view.
    InView(usize),
    /// Under those that are compared with them.
    Beside(usize),
}

/// Which events are listed while settings are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Listing {
    /// All.
    All,
    /// Those that happen under the settings in view alone.
    OnlyInView,
    /// Those that happen under the others alone.
    OnlyBeside,
    /// Those that happen at another frame.
    Moved,
}

impl Listing {
    /// All of them in order.
    pub(crate) const ALL: [Self; 4] = [Self::All, Self::OnlyInView, Self::OnlyBeside, Self::Moved];
}

/// Which events two timelines have in common, and of which timelines that is true.
#[derive(Clone, Debug)]
pub(crate) struct Compared {
    in_view: Arc<Timeline>,
    beside: Arc<ComparedSequence>,
    /// In order of time.
    pub(crate) pairs: Vec<EventPair>,
}

impl Compared {
    /// Of what was published, if something is compared; `before` where that is still true.
    pub(crate) fn of(state: &State, fps: f32, before: Option<Self>) -> Option<Self> {
        let beside = state.compared.as_ref()?;
        let same = |before: &Self| {
            Arc::ptr_eq(&before.in_view, &state.timeline) && Arc::ptr_eq(&before.beside, beside)
        };
        if before.as_ref().is_some_and(same) {
            return before;
        }
        let tolerance = EventTolerance::of(state.info.as_ref()?.size, fps);
        let pairs = event_pairs::pair_events(&state.timeline.events, &beside.timeline.events, tolerance);
        Some(Self { in_view: Arc::clone(&state.timeline), beside: Arc::clone(beside), pairs })
    }

    /// Whether a pair belongs to a listing.
    pub(crate) fn lists(&self, listing: Listing, pair: EventPair) -> bool {
        match listing {
            Listing::All => true,
            Listing::OnlyInView => matches!(pair, EventPair::First(_)),
            Listing::OnlyBeside => matches!(pair, EventPair::Second(_)),
            Listing::Moved => self.moved(pair).is_some_and(|frames| frames != 0),
        }
    }

    /// By how many frames the event under the other settings is later.
    pub(crate) fn moved(&self, pair: EventPair) -> Option<i64> {
        let EventPair::Both(i, j) = pair else { return None };
        let (in_view, _) = self.in_view.events.get(i)?;
        let (beside, _) = self.beside.timeline.events.get(j)?;
        Some(i64::from(*beside) - i64::from(*in_view))
    }
}
