//! The frame in view with the past positions of its objects.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::replay::ShownFrame;
use crate::tracking::Track;

/// Length of a trail, in frames.
const TRAIL_FRAMES: u32 = 60;

/// The number and the objects of each analysed frame near the frame in view, by position.
pub(crate) type Trails = BTreeMap<u32, (u32, Arc<Vec<Track>>)>;

/// A frame with the trails of its objects.
#[derive(Clone, Debug)]
pub(crate) struct FrameWithTrails {
    /// The frame.
    pub(crate) shown: Arc<ShownFrame>,
    /// Past positions of its objects.
    pub(crate) trails: Arc<Trails>,
}

impl FrameWithTrails {
    /// The frame with its trails. `before` is the previously published frame, which need not be adjacent.
    pub(super) fn after(before: Option<&Self>, shown: &Arc<ShownFrame>) -> Self {
        let mut trails = before.map(|before| Arc::clone(&before.trails)).unwrap_or_default();
        let kept = Arc::make_mut(&mut trails);
        let other = |before: &Self| {
            let roi = |shown: &ShownFrame| shown.roi.as_ref().map(Arc::as_ptr);
            before.shown.settings != shown.settings || roi(&before.shown) != roi(shown)
        };
        if before.is_some_and(other) {
            kept.clear();
        }
        kept.insert(shown.position, (shown.frame.number, shown.analysis.tracks.clone()));
        let near = shown.position.saturating_sub(TRAIL_FRAMES)..=shown.position + TRAIL_FRAMES;
        kept.retain(|position, _| near.contains(position));
        Self { shown: Arc::clone(shown), trails }
    }
}
