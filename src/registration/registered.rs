//! A source whose frames come with their alignment.

use super::Estimator;
use crate::frame::Frame;
use crate::source::{Source, SourceError, SourceInfo};

/// Measures each frame of a source as it is read.
pub struct Registered {
    source: Box<dyn Source>,
    estimator: Estimator,
}

impl Registered {
    /// Of a source of which no frame was read.
    pub fn new(source: Box<dyn Source>) -> Self {
        let estimator = Estimator::new(source.info().size);
        Self { source, estimator }
    }
}

impl Source for Registered {
    fn info(&self) -> &SourceInfo {
        self.source.info()
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        let mut frame = self.source.next_frame()?;
        if let Some(frame) = &mut frame {
            frame.alignment = self.estimator.step(frame);
        }
        Ok(frame)
    }

    fn take_warnings(&mut self) -> Vec<String> {
        self.source.take_warnings()
    }
}
