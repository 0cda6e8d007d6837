//! The visible positions of the timeline.

use crate::app::model::Model;

/// Minimum number of visible frames.
pub(crate) const MIN_SHOWN_FRAMES: f32 = 8.0;

/// The visible positions, from and to, of a video of this number of frames.
pub(crate) fn visible_span(model: &Model, frames: u32) -> (f32, f32) {
    let span = model.panels.timeline_span;
    span.filter(|span| span.1 <= frames as f32).unwrap_or((0.0, frames as f32))
}

/// The visible positions after zooming by `zoom` around the point at `share` of the width, and panning by `pan` of
/// the width; `None` for all.
pub(crate) fn moved_span(
    (from, to): (f32, f32),
    frames: u32,
    share: f32,
    zoom: f32,
    pan: f32,
) -> Option<(f32, f32)> {
    let (length, all) = (to - from, frames as f32);
    let new = (length / zoom).clamp(MIN_SHOWN_FRAMES.min(all), all);
    let first = from + share.clamp(0.0, 1.0) * (length - new) - pan * new;
    let first = first.clamp(0.0, all - new);
    (new < all).then_some((first, first + new))
}

/// The visible positions after zooming by two around the frame in view, in if `into`, else out; `None` for all.
pub(crate) fn zoomed_span(model: &Model, into: bool) -> Option<(f32, f32)> {
    let frames = model.worker.frames().max(1);
    let span = visible_span(model, frames);
    let share = (model.worker.position() as f32 + 0.5 - span.0) / (span.1 - span.0).max(1.0);
    moved_span(span, frames, share, if into { 2.0 } else { 0.5 }, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panning_stays_within_the_video_and_zooming_out_shows_all() {
        assert_eq!(moved_span((0.0, 100.0), 100, 0.5, 2.0, 0.0), Some((25.0, 75.0)));
        assert_eq!(moved_span((25.0, 75.0), 100, 0.5, 1.0, 0.1), Some((20.0, 70.0)));
        assert_eq!(moved_span((25.0, 75.0), 100, 0.5, 1.0, 9.0), Some((0.0, 50.0)));
        assert_eq!(moved_span((25.0, 75.0), 100, 0.5, 1.0, -9.0), Some((50.0, 100.0)));
        assert_eq!(moved_span((25.0, 75.0), 100, 0.5, 0.5, 0.0), None);
        assert_eq!(moved_span((0.0, 100.0), 100, 0.0, 1e6, 0.0), Some((0.0, MIN_SHOWN_FRAMES)));
    }
}
