//! The chosen pixel, object and event.

use crate::app::model::camera::Hover;
use crate::app::model::event_comparison::EventRef;
use crate::app::model::worker::WorkerLink;
use crate::frame::Size;
use crate::occlusion::Event;
use crate::replay::ShownFrame;
use crate::tracking::{Identity, Track};

/// Minimum IoU of two boxes of the same object.
const MIN_SAME_OBJECT_IOU: f32 = 0.3;

/// The subject of the panel on the right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Subject {
    /// The chosen pixel.
    Pixel,
    /// The chosen object.
    Object,
}

/// What is chosen in the views and in the list of events.
#[derive(Clone, Debug)]
pub(crate) struct Selection {
    /// The chosen pixel.
    pub(crate) pixel: Option<(u32, u32)>,
    /// The chosen object.
    pub(crate) object: Option<Identity>,
    /// The subject of the panel on the right.
    pub(crate) subject: Subject,
    /// The pixel under the pointer.
    pub(crate) hovered: Option<Hover>,
    /// The event whose evidence is shown, by its current index.
    pub(crate) event: Option<EventRef>,
    /// A copy of that event, to find it again when its index changes.
    event_copy: Option<Event>,
}

impl Selection {
    /// Nothing is chosen.
    pub(super) const NONE: Self = Self {
        pixel: None,
        object: None,
        subject: Subject::Pixel,
        hovered: None,
        event: None,
        event_copy: None,
    };

    /// Shows the evidence of an event, or of none.
    pub(crate) fn choose_event(&mut self, worker: &WorkerLink, event: Option<EventRef>) {
        self.event = event;
        self.event_copy = event.and_then(|event| Some(worker.event(event)?.1.clone()));
    }

    /// The event in view whose evidence is shown.
    pub(super) fn event_in_view(&self) -> Option<&Event> {
        self.event_copy.as_ref().filter(|_| matches!(self.event, Some(EventRef::InView(_))))
    }

    /// Updates the index of the event whose evidence is shown. Late decisions insert events before it, and may remove
    /// it.
    pub(super) fn find_event_again(&mut self, worker: &WorkerLink) {
        let (Some(chosen), Some(event)) = (self.event, &self.event_copy) else { return };
        if worker.event(chosen).is_some_and(|(_, other)| other.is_same(event)) {
            return;
        }
        let (timeline, at): (_, fn(usize) -> EventRef) = match chosen {
            EventRef::InView(_) => (worker.timeline(), EventRef::InView),
            EventRef::Compared(_) => (worker.compared_timeline(), EventRef::Compared),
        };
        let found = timeline
            .and_then(|timeline| timeline.events.iter().position(|(_, other)| other.is_same(event)).map(at));
        self.choose_event(worker, found);
    }

    /// Updates the chosen object after a change of settings. The same object may have another identity: the object
    /// with the largest IoU is chosen.
    pub(super) fn find_object_again(&mut self, before: &ShownFrame, now: &ShownFrame) {
        let Some(id) = self.object.filter(|_| before.settings != now.settings) else { return };
        let place = before.analysis.tracks.iter().find(|track| track.id == id).map(|track| track.bbox);
        let place = place.filter(|_| before.position == now.position);
        self.object = place.and_then(|place| {
            let nearest = now.analysis.tracks.iter().max_by(|a, b| {
                let iou = |track: &Track| track.bbox.iou(&place);
                iou(a).total_cmp(&iou(b))
            });
            nearest.filter(|track| track.bbox.iou(&place) >= MIN_SAME_OBJECT_IOU).map(|track| track.id)
        });
    }

    /// The pixel at an offset from the chosen one, clamped to an image of this size; the centre pixel where none is
    /// chosen.
    pub(crate) fn adjacent_pixel(&self, size: Size, columns: i32, rows: i32) -> (u32, u32) {
        let Some((x, y)) = self.pixel else { return (size.width / 2, size.height / 2) };
        let within = |at: u32, by: i32, all: u32| at.saturating_add_signed(by).min(all.saturating_sub(1));
        (within(x, columns, size.width), within(y, rows, size.height))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_adjacent_pixel_stays_within_the_image() {
        let size = Size::new(40, 30);
        let at = |pixel| Selection { pixel, ..Selection::NONE };
        assert_eq!(at(None).adjacent_pixel(size, 1, 0), (20, 15));
        assert_eq!(at(Some((3, 4))).adjacent_pixel(size, -1, 2), (2, 6));
        assert_eq!(at(Some((0, 29))).adjacent_pixel(size, -1, 1), (0, 29));
        assert_eq!(at(Some((39, 0))).adjacent_pixel(size, 1, -1), (39, 0));
    }
}
