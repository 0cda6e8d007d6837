//! Requests to the worker, and the queue in which they wait.

use std::mem::discriminant;
use std::sync::Arc;

use crate::explain::pixel::region_shares::PixelRegion;
use crate::explain::tuning::TunableSetting;
use crate::mixture::Quantity;
use crate::occlusion::Event;
use crate::regions::Roi;
use crate::settings::Settings;
use crate::truth::Truth;
use crate::truth::external::ExternalResults;

/// A request to a [`Session`](super::Session). Within the queue a newer one replaces an older one of its kind.
#[derive(Clone, Debug)]
pub enum Request {
    /// Show the frame at a position from 0; a position beyond the end shows the last frame. The analysis continues up
    /// to the requested frame.
    Show(u32),
    /// Change the settings in view (A) and the candidate settings to compare with them (B), `None` for none. The
    /// affected stages run again; settings that were already one of the two are not run again. The frame in view stays
    /// until it is available under the new settings.
    Settings {
        /// The settings in view.
        in_view: Box<Settings>,
        /// The candidate settings.
        candidate: Option<Box<Settings>>,
    },
    /// Set the region of interest, `None` for the whole image; it must have the frames' size. The model does not run
    /// again, because its masks are recorded.
    Roi(Option<Arc<Roi>>),
    /// Set the ground truth for scores; `None` for no scores. Masks of another size than the frames are ignored with a
    /// warning.
    Truth(Option<Arc<Truth>>),
    /// Set the results of another method to compare and score, in the source's pixels; `None` for none. Masks of another
    /// size than the frames are ignored with a warning.
    External(Option<Arc<ExternalResults>>),
    /// Continue the analysis beyond the frame in view, which is the default, or stop it and drop the pending frame.
    /// Later requests are processed in either case.
    AnalyseAhead(bool),
    /// Choose the pixel whose history is shown; `None`, or a pixel outside the image, chooses none.
    Inspect(Option<(u32, u32)>),
    /// Pin these pixels, in place of the previous ones. Their histories are computed after that of the chosen pixel.
    Pin(Vec<(u32, u32)>),
    /// Map a quantity with every shown frame; `None` to stop.
    Map(Option<Quantity>),
    /// Count the share of foreground in a region in each frame; `None` to stop.
    CountRegion(Option<PixelRegion>),
    /// Compute the verdict on the chosen pixel in the frame in view over a grid of these two settings, and for each
    /// alone; `None` to stop.
    Tune(Option<[TunableSetting; 2]>),
    /// Compute the accuracy of the mixture in a region, over the grid of [`Self::Tune`]; `None` to stop. It needs true
    /// masks, and is computed after all other work.
    TuneRegion(Option<PixelRegion>),
    /// Compute the counterfactuals of an event under the settings in view; `None` to stop.
    Explain(Option<Box<Event>>),
}

/// The requests that are not processed yet, at most one of each kind, in the order of their arrival.
#[derive(Default)]
pub(super) struct RequestQueue {
    waiting: Vec<Request>,
    closed: bool,
}

impl RequestQueue {
    /// Adds a request and removes those that it replaces.
    pub(super) fn push(&mut self, request: Request) {
        let stops = matches!(request, Request::AnalyseAhead(false));
        self.waiting.retain(|older| {
            discriminant(older) != discriminant(&request) && !(stops && matches!(older, Request::Show(_)))
        });
        self.waiting.push(request);
    }

    /// Ends the queue: the worker has to stop.
    pub(super) const fn close(&mut self) {
        self.closed = true;
    }

    /// Whether the worker has a reason to look into the queue.
    pub(super) const fn is_ready(&self) -> bool {
        self.closed || !self.waiting.is_empty()
    }

    /// Takes all requests; `None` once the queue is closed.
    pub(super) fn take(&mut self) -> Option<Vec<Request>> {
        if self.closed { None } else { Some(std::mem::take(&mut self.waiting)) }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// The requests of a queue after these were pushed, as debug output.
    fn queued(requests: &[Request]) -> Vec<String> {
        let mut queue = RequestQueue::default();
        requests.iter().cloned().for_each(|request| queue.push(request));
        queue.take().unwrap().iter().map(|request| format!("{request:?}")).collect()
    }

    #[test]
    fn the_newest_request_of_a_kind_replaces_older_ones() {
        let requests = [Request::Show(3), Request::Show(4), Request::Map(None), Request::Show(5)];
        assert_eq!(queued(&requests), ["Map(None)", "Show(5)"]);
        let requests = [Request::Inspect(Some((1, 2))), Request::Inspect(None)];
        assert_eq!(queued(&requests), ["Inspect(None)"], "a request for nothing is a request");
    }

    #[test]
    fn regions_to_count_and_to_tune_are_different_kinds() {
        let near = Some(PixelRegion { centre: (1, 2), side: 3 });
        let far = Some(PixelRegion { centre: (4, 5), side: 6 });
        let requests = [Request::CountRegion(near), Request::TuneRegion(far), Request::CountRegion(far)];
        assert_eq!(queued(&requests), [format!("TuneRegion({far:?})"), format!("CountRegion({far:?})")]);
    }

    #[test]
    fn requests_of_every_kind_are_taken_once_in_the_order_of_arrival() {
        let settings = Box::<Settings>::default();
        let requests = [
            Request::Roi(None),
            Request::Settings { in_view: settings.clone(), candidate: Some(settings) },
            Request::Truth(None),
            Request::External(None),
            Request::AnalyseAhead(true),
            Request::Inspect(None),
            Request::Pin(vec![(1, 2)]),
            Request::Map(None),
            Request::CountRegion(None),
            Request::Tune(None),
            Request::TuneRegion(None),
            Request::Explain(None),
            Request::Show(1),
        ];
        let expected: Vec<_> = requests.iter().map(|request| format!("{request:?}")).collect();
        assert_eq!(queued(&requests), expected);

        let mut queue = RequestQueue::default();
        assert!(!queue.is_ready());
        queue.push(Request::Show(1));
        assert!(queue.is_ready());
        assert_eq!(queue.take().unwrap().len(), 1);
        assert!(!queue.is_ready() && queue.take().unwrap().is_empty());
    }

    #[test]
    fn stopping_the_analysis_drops_the_pending_frame_but_no_later_one() {
        let (stop, go_on) = (Request::AnalyseAhead(false), Request::AnalyseAhead(true));
        assert_eq!(queued(&[Request::Show(3), stop.clone()]), ["AnalyseAhead(false)"]);
        assert_eq!(queued(&[stop.clone(), Request::Show(3)]), ["AnalyseAhead(false)", "Show(3)"]);
        assert_eq!(queued(&[Request::Show(3), go_on]), ["Show(3)", "AnalyseAhead(true)"]);
        assert_eq!(
            queued(&[Request::Show(3), Request::Map(None), stop]),
            ["Map(None)", "AnalyseAhead(false)"]
        );
    }

    #[test]
    fn a_closed_queue_is_ready_and_gives_no_requests() {
        let mut queue = RequestQueue::default();
        queue.push(Request::Show(1));
        queue.close();
        assert!(queue.is_ready() && queue.take().is_none());
    }
}
