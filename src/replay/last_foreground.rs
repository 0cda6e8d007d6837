//! When each pixel was last foreground, from the masks on record.

use super::record::Record;
use super::spaced::Spaced;
use crate::frame::Size;

/// Frames that a piece of work takes in, and that what is kept lies apart at least.
const PIECE: u32 = 64;
/// In place of a position where a pixel was never foreground.
const NEVER: u32 = u32::MAX;

/// The position at which each pixel was last foreground before some frame. It goes from frame to frame with whoever
/// looks; some of the way is kept, to begin there when somebody looks back.
pub(super) struct Since {
    size: Size,
    /// Frames taken in.
    taken: u32,
    /// Nothing until somebody asks.
    last: Vec<u32>,
    kept: Spaced<Vec<u32>>,
}

impl Since {
    /// Nobody has asked yet.
    pub(super) const fn new(size: Size) -> Self {
        Self { size, taken: 0, last: Vec::new(), kept: Spaced::new(PIECE, 0) }
    }

    /// Keeps within so much memory, in bytes.
    pub(super) fn set_room(&mut self, room: usize) {
        self.kept.set_room(room);
    }

    /// Goes on towards the frame at `position`; whether it is there. Where the frame is not on record, it never is.
    pub(super) fn reach(&mut self, position: u32, record: &Record) -> bool {
        let Some(wanted) = position.checked_add(1).filter(|&wanted| wanted <= record.len()) else {
            return false;
        };
        self.begin(wanted);
        let end = wanted.min(self.taken + PIECE - self.taken % PIECE);
        for position in self.taken..end {
            record.each_raw_run(position, |run| {
                if let Some(pixels) = self.last.get_mut(run) {
                    pixels.fill(position);
                }
            });
        }
        self.taken = end;
        if self.kept.wants(end) {
            self.kept.insert(end, self.last.clone(), self.last.len() * size_of::<u32>());
        }
        end == wanted
    }

    /// How many frames before the one at `position`, which has been reached, each pixel was last foreground, infinitely
    /// many where it never was.
    pub(super) fn at(&self, position: u32) -> Vec<f32> {
        let ago = |&last: &u32| match last {
            NEVER => f32::INFINITY,
            _ => position.saturating_sub(last) as f32,
        };
        self.last.iter().map(ago).collect()
    }

    /// Begins at the nearest place before `wanted` frames, which may be where it is.
    fn begin(&mut self, wanted: u32) {
        let kept = self.kept.at_or_before(wanted);
        let nearest = kept.map_or(0, |(taken, _)| taken);
        if self.last.is_empty() || !(nearest..=wanted).contains(&self.taken) {
            self.taken = nearest;
            match kept {
                Some((_, last)) => self.last.clone_from(last),
                None => self.last = vec![NEVER; self.size.pixels()],
            }
        }
    }
}
