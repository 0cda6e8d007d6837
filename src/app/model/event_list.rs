//! The list of events: the kinds that it shows, and the comparison of two settings.

use crate::app::model::event_comparison::{ComparisonFilter, EventComparison};
use crate::app::model::worker::WorkerLink;
use crate::occlusion::EventKind;

/// What the list of events shows.
#[derive(Clone, Debug)]
pub(crate) struct EventList {
    /// The kinds of events that are listed and visited by key, in the order of [`EventKind::ALL`].
    pub(crate) listed_kinds: [bool; EventKind::ALL.len()],
    /// The comparison of events, `None` where nothing is compared.
    pub(crate) comparison: Option<EventComparison>,
    /// The filter of that comparison.
    pub(crate) filter: ComparisonFilter,
}

impl EventList {
    /// All kinds, without a comparison.
    pub(super) const fn new() -> Self {
        Self { listed_kinds: [true; EventKind::ALL.len()], comparison: None, filter: ComparisonFilter::All }
    }

    /// Whether events of this kind are listed.
    pub(crate) fn lists(&self, kind: EventKind) -> bool {
        EventKind::ALL.iter().zip(self.listed_kinds).any(|(&each, listed)| each == kind && listed)
    }

    /// Index and position of the next or the previous listed event.
    pub(crate) fn adjacent_event(&self, worker: &WorkerLink, forward: bool) -> Option<(usize, u32)> {
        let here = worker.position();
        let events = &worker.timeline()?.events;
        let mut listed = events
            .iter()
            .enumerate()
            .filter(|(_, (_, event))| self.lists(event.kind))
            .map(|(index, (position, _))| (index, *position));
        if forward {
            listed.filter(|(_, position)| *position > here).min_by_key(|(_, position)| *position)
        } else {
            let before = listed.by_ref().filter(|(_, position)| *position < here).collect::<Vec<_>>();
            let nearest = before.iter().map(|(_, position)| *position).max()?;
            before.into_iter().find(|(_, position)| *position == nearest)
        }
    }
}
