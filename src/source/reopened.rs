//! Frames again of the sources of tests, which have no second reader.

use super::random_access::{Fingerprint, RandomAccess, Step, is_same};
use super::{Source, SourceError};

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
        let frame = frame.filter(|frame| is_same(fingerprints, position, frame));
        let frame = frame.ok_or_else(|| SourceError::changed(&self.name))?;
        self.source = Some(source);
        self.next = position + 1;
        Ok(Step::Frame(position, frame))
    }
}
