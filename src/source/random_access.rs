//! Frames of a source again, after they were read in order once.

use xxhash_rust::xxh3::xxh3_64;

use super::{Source, SourceError};
use crate::frame::Frame;

/// A hash that identifies a frame: equal frames have equal fingerprints, different frames have different ones in
/// practice.
pub type Fingerprint = u64;

/// The fingerprint of a frame's pixels.
pub(super) fn fingerprint(frame: &Frame) -> Fingerprint {
    xxh3_64(&frame.rgb)
}

/// The result of one step towards a frame.
#[derive(Debug)]
pub enum Step {
    /// The frame at this position; its number may be wrong.
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

/// Opens a source by its name.
pub(super) type Opener = Box<dyn FnMut() -> Result<Box<dyn Source>, SourceError> + Send>;

/// Reads a source again by opening it again, in order only.
pub(super) struct ReopenedSource {
    open: Opener,
    name: String,
    source: Option<Box<dyn Source>>,
    /// The position of the source's next frame.
    next: u32,
}

impl ReopenedSource {
    /// A reader of the source that `open` returns.
    pub(super) fn new(open: Opener, name: &str) -> Self {
        Self { open, name: name.to_owned(), source: None, next: 0 }
    }
}

impl RandomAccess for ReopenedSource {
    fn step(&mut self, _: u32, goal: u32, fingerprints: &[Fingerprint]) -> Result<Step, SourceError> {
        let mut source = match self.source.take() {
            Some(source) if self.next <= goal => source,
            _ => {
                self.next = 0;
                (self.open)()?
            }
        };
        let position = self.next;
        let frame = source.next_frame()?;
        let is_same = |frame: &Frame| fingerprints.get(position as usize) == Some(&fingerprint(frame));
        let frame = frame.filter(is_same).ok_or_else(|| SourceError::changed(&self.name))?;
        self.source = Some(source);
        self.next = position + 1;
        Ok(Step::Frame(position, frame))
    }
}
