//! Consumers of all known frames, analysed or not.

use std::time::{Duration, Instant};

use crate::frame::Frame;
use crate::source::SourceError;
use crate::source::cache::{Fetched, FrameCache, Keep};

/// Maximum duration of a turn before other work is done.
pub(crate) const MAX_TURN: Duration = Duration::from_millis(4);

/// A consumer of frames in order, from the first on.
pub(crate) trait FrameConsumer {
    /// The position of the next frame that is needed; `None` if none is.
    fn next(&self) -> Option<u32>;
    /// Consumes the frame at a position, if it is the next.
    fn push(&mut self, position: u32, frame: &Frame);
    /// Called when all frames have been consumed; returns whether this changes the results.
    fn end(&mut self) -> bool {
        false
    }
    /// Called when the next frame is no longer available, such as a camera's first frames. All later results depend
    /// on it.
    fn lose(&mut self);
}

/// Passes decoded frames to `consumer` for a short time; returns whether there was work to do.
pub(crate) fn feed_frames(
    consumer: &mut impl FrameConsumer,
    frames: &mut FrameCache,
) -> Result<bool, SourceError> {
    let started = Instant::now();
    let mut worked = false;
    let end = frames.numbers().len() as u32;
    if frames.is_complete() && consumer.next() == Some(end) {
        worked = consumer.end();
    }
    while let Some(next) = consumer.next().filter(|&next| next < end) {
        worked = true;
        match frames.fetch(next, Keep::IfRoom)? {
            Fetched::Frame(frame) => consumer.push(next, &frame),
            Fetched::OnTheWay => {}
            Fetched::Gone | Fetched::End => consumer.lose(),
        }
        if started.elapsed() > MAX_TURN {
            break;
        }
    }
    Ok(worked)
}
