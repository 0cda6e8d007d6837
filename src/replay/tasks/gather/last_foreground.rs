//! The last frame in which each pixel was foreground, from the masks on record.

use crate::frame::Size;
use crate::replay::store::analysis_record::AnalysisRecord;
use crate::replay::store::strided_checkpoints::StridedCheckpoints;

/// Number of frames of one step, and least distance of checkpoints.
const FRAMES_PER_STEP: u32 = 64;
/// Marks a pixel that was never foreground.
const NEVER: u32 = u32::MAX;

/// The position at which each pixel was last foreground before some frame. It advances frame by frame; checkpoints
/// are used to seek back.
pub(crate) struct LastForeground {
    size: Size,
    /// Number of frames processed.
    frames_processed: u32,
    /// The last position of each pixel; empty until the first request.
    last: Vec<u32>,
    checkpoints: StridedCheckpoints<Vec<u32>>,
}

impl LastForeground {
    /// An empty state.
    pub(crate) const fn new(size: Size) -> Self {
        Self {
            size,
            frames_processed: 0,
            last: Vec::new(),
            checkpoints: StridedCheckpoints::new(FRAMES_PER_STEP, 0),
        }
    }

    /// Sets the capacity for checkpoints, in bytes.
    pub(crate) fn set_capacity(&mut self, capacity: usize) {
        self.checkpoints.set_capacity(capacity);
    }

    /// Advances towards the frame at `position`; returns whether it was reached. Does not go beyond the record.
    pub(crate) fn advance_to(&mut self, position: u32, record: &AnalysisRecord) -> bool {
        let Some(wanted) = position.checked_add(1).filter(|&wanted| wanted <= record.len()) else {
            return false;
        };
        self.seek(wanted);
        let end =
            wanted.min(self.frames_processed + FRAMES_PER_STEP - self.frames_processed % FRAMES_PER_STEP);
        for position in self.frames_processed..end {
            record.for_each_raw_run(position, |run| {
                if let Some(pixels) = self.last.get_mut(run) {
                    pixels.fill(position);
                }
            });
        }
        self.frames_processed = end;
        if self.checkpoints.accepts(end) {
            self.checkpoints.insert(end, self.last.clone(), self.last.len() * size_of::<u32>());
        }
        end == wanted
    }

    /// For each pixel the number of frames since it was last foreground at `position`, which must have been reached;
    /// infinite where it never was.
    pub(crate) fn frames_since(&self, position: u32) -> Vec<f32> {
        let ago = |&last: &u32| match last {
            NEVER => f32::INFINITY,
            _ => position.saturating_sub(last) as f32,
        };
        self.last.iter().map(ago).collect()
    }

    /// Continues from the nearest state, checkpoint or current, at or before `wanted` frames.
    fn seek(&mut self, wanted: u32) {
        let checkpoints = self.checkpoints.at_or_before(wanted);
        let nearest = checkpoints.map_or(0, |(frames_processed, _)| frames_processed);
        if self.last.is_empty() || !(nearest..=wanted).contains(&self.frames_processed) {
            self.frames_processed = nearest;
            match checkpoints {
                Some((_, last)) => self.last.clone_from(last),
                None => self.last = vec![NEVER; self.size.pixels()],
            }
        }
    }
}
