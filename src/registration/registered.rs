//! A source that adds the alignment to each frame.

use std::collections::VecDeque;

use super::estimator::BEGINNING_FRAMES;
use super::{CorrectionChoice, Estimator};
use crate::frame::Frame;
use crate::source::{Source, SourceError, SourceInfo};

/// Maximum memory of the frames that are read ahead, in bytes.
const HELD_BYTES: usize = 256 << 20;

/// Estimates the alignment of all of these frames, as [`Registered`] does for a file.
pub fn measure_all(frames: &mut [Frame], choice: CorrectionChoice) {
    let Some(size) = frames.first().map(|frame| frame.size) else { return };
    let mut estimator = Estimator::of(size, choice);
    for at in 0..frames.len() {
        frames[at].alignment = estimator.step(&frames[at]);
        if at + 1 == frames.len().min(BEGINNING_FRAMES as usize) {
            set_rest_of_beginning(&mut frames[..=at], &estimator);
        }
    }
}

/// Adds a shake that was detected in the beginning to the alignment of its frames.
fn set_rest_of_beginning<'a>(beginning: impl IntoIterator<Item = &'a mut Frame>, estimator: &Estimator) {
    if let Some(rest) = estimator.rest() {
        for frame in beginning {
            frame.alignment.rest = Some(rest);
        }
    }
}

/// Estimates the alignment of each frame of a source as it is read. The beginning of a file is read ahead, so that a
/// shake detected there applies from its first frame on.
pub struct Registered {
    source: Box<dyn Source>,
    estimator: Estimator,
    /// Frames with lower numbers are not measured.
    first: u32,
    /// Frames read ahead.
    held: VecDeque<Frame>,
    /// The end or error after them, if one followed.
    end: Option<Result<(), SourceError>>,
    /// Number of frames that are still to be read ahead.
    ahead: usize,
    warnings: Vec<String>,
}

impl Registered {
    /// Wraps a source of which no frame was read; everything is measured.
    pub fn new(source: Box<dyn Source>) -> Self {
        let estimator = Estimator::new(source.info().size);
        Self::by(source, estimator, 0)
    }

    /// Wraps a source of which no frame was read, with a new estimator, from the frame with the number `first` on.
    pub fn by(source: Box<dyn Source>, estimator: Estimator, first: u32) -> Self {
        let info = source.info();
        let room = HELD_BYTES / (3 * info.size.pixels()).max(1);
        let ahead = if info.live { 0 } else { room.min(BEGINNING_FRAMES as usize) };
        Self { source, estimator, first, held: VecDeque::new(), end: None, ahead, warnings: Vec::new() }
    }

    fn read(&mut self) -> Result<Option<Frame>, SourceError> {
        let next = self.source.next_frame();
        self.warnings.append(&mut self.source.take_warnings());
        let mut frame = next?;
        if let Some(frame) = frame.as_mut().filter(|frame| frame.number >= self.first) {
            frame.alignment = self.estimator.step(frame);
            self.warnings.extend(frame.alignment.warning());
        }
        Ok(frame)
    }

    /// Reads the rest of the beginning, which starts with `first`.
    fn read_ahead(&mut self, first: Frame) {
        self.held.push_back(first);
        self.ahead -= 1;
        while self.ahead > 0 {
            match self.read() {
                Ok(Some(frame)) => {
                    self.held.push_back(frame);
                    self.ahead -= 1;
                }
                Ok(None) => (self.end, self.ahead) = (Some(Ok(())), 0),
                Err(error) => (self.end, self.ahead) = (Some(Err(error)), 0),
            }
        }
        set_rest_of_beginning(&mut self.held, &self.estimator);
    }
}

impl Source for Registered {
    fn info(&self) -> &SourceInfo {
        self.source.info()
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        if let Some(frame) = self.held.pop_front() {
            return Ok(Some(frame));
        }
        if let Some(end) = self.end.take() {
            return end.map(|()| None);
        }
        let Some(frame) = self.read()? else { return Ok(None) };
        if self.ahead == 0 || frame.number < self.first {
            return Ok(Some(frame));
        }
        self.read_ahead(frame);
        Ok(self.held.pop_front())
    }

    fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }
}
