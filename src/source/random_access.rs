//! Frames of a source again, after they were read in order once.

use xxhash_rust::xxh3::xxh3_64;

use super::SourceError;
use crate::frame::Frame;

/// A hash that identifies a frame: equal frames have equal fingerprints, different frames have different ones in
/// practice.
pub type Fingerprint = u64;

/// In place of a fingerprint: the frame was skipped, and nothing is known of its pixels.
pub(super) const UNCHECKED: Fingerprint = 0;

/// Whether a frame is the one that was read at `position` at first, as far as is known.
pub(super) fn is_same(fingerprints: &[Fingerprint], position: u32, frame: &Frame) -> bool {
    let expected = fingerprints.get(position as usize);
    expected.is_some_and(|&expected| expected == UNCHECKED || expected == fingerprint(frame))
}

/// The fingerprint of a frame's pixels.
pub(super) fn fingerprint(frame: &Frame) -> Fingerprint {
    xxh3_64(&frame.rgb)
}

/// The result of one step towards a frame.
#[derive(Debug)]
pub enum Step {
    /// The frame at this position; its number and time may be wrong.
    Frame(u32, Frame),
    /// Nothing was read, but the reader is nearer to the goal.
    OnTheWay,
}

/// A second reader of a source. It gives the frames that the first reader gave before, at any position.
pub trait RandomAccess: Send {
    /// Makes a step towards the frame at `goal`, from 0: reads one frame, or goes to another place. Where it seeks, it
    /// aims at the frame `from`, which is `goal` or one before, as those between are likely to be wanted, too.
    /// `fingerprints` are the fingerprints of the frames that the first reader gave, as far as `goal` at least.
    fn step(&mut self, from: u32, goal: u32, fingerprints: &[Fingerprint]) -> Result<Step, SourceError>;

    /// Takes the warnings since the last call.
    fn take_warnings(&mut self) -> Vec<String> {
        Vec::new()
    }
}
