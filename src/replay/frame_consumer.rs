//! Pixels that are followed through all frames that are known, whether those are analysed or not.

use std::time::{Duration, Instant};

use crate::frame::Frame;
use crate::source::SourceError;
use crate::source::cache::{Fetched, FrameCache, Keep};

/// Work on it goes on for so long before other work gets its turn.
pub(super) const TURN: Duration = Duration::from_millis(4);

/// What takes in frames one after the other, from the first on.
pub(super) trait Follower {
    /// The position of the frame that is needed next, `None` where none is.
    fn next(&self) -> Option<u32>;
    /// Takes in the frame at a position, if it is the next.
    fn push(&mut self, position: u32, frame: &Frame);
    /// There are no frames but those that it took in; whether that tells it anything new.
    fn end(&mut self) -> bool {
        false
    }
    /// The next frame is not to be had any more, as the first ones of a camera, and all that comes depends on it.
    fn lose(&mut self);
}

/// Lets `follower` take in frames that were decoded before, for a short while; whether there was anything to do.
pub(super) fn gather(follower: &mut impl Follower, frames: &mut FrameCache) -> Result<bool, SourceError> {
    let started = Instant::now();
    let mut worked = false;
    let end = frames.numbers().len() as u32;
    if frames.is_complete() && follower.next() == Some(end) {
        worked = follower.end();
    }
    while let Some(next) = follower.next().filter(|&next| next < end) {
        worked = true;
        match frames.fetch(next, Keep::IfRoom)? {
            Fetched::Frame(frame) => follower.push(next, &frame),
            Fetched::OnTheWay => {}
            Fetched::Gone | Fetched::End => follower.lose(),
        }
        if started.elapsed() > TURN {
            break;
        }
    }
    Ok(worked)
}
