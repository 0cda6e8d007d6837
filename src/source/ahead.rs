//! Decodes frames on a separate thread, ahead of the consumer.

use std::any::Any;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError, bounded};

use super::{Source, SourceError};
use crate::frame::Frame;

/// The result of one read from a source.
pub(crate) struct Decoded<T> {
    /// The frame; `None` at the end of the sequence.
    pub(crate) frame: Result<Option<T>, SourceError>,
    /// Warnings of problems before the frame that did not end the sequence.
    pub(crate) warnings: Vec<String>,
}

/// A source that is read ahead. It gives nothing after the end or an error. A panic of its thread goes on in the consumer.
pub(crate) struct Ahead<T> {
    items: Option<Receiver<Decoded<T>>>,
    thread: Option<JoinHandle<()>>,
    panic: Panic,
}

/// The payload of a panic of the decoding thread.
type Panic = Arc<Mutex<Option<Box<dyn Any + Send>>>>;

impl<T: Send + 'static> Ahead<T> {
    /// Starts the decoding thread; the queue holds at most `most` frames. The thread calls `prepare` with each frame.
    /// The sequence ends at the first frame after which `is_stopped` holds.
    pub(crate) fn start(
        mut source: Box<dyn Source>,
        most: usize,
        is_stopped: impl Fn() -> bool + Send + 'static,
        prepare: impl Fn(Frame) -> T + Send + 'static,
    ) -> io::Result<Self> {
        let (sender, items) = bounded(most);
        let panic = Panic::default();
        let of_thread = Arc::clone(&panic);
        let thread = thread::Builder::new().name("decode ahead".into()).spawn(move || {
            let work = AssertUnwindSafe(|| {
                loop {
                    let next = source.next_frame();
                    let warnings = source.take_warnings();
                    let next = if is_stopped() { Ok(None) } else { next };
                    let is_over = !matches!(next, Ok(Some(_)));
                    let frame = next.map(|frame| frame.map(&prepare));
                    if sender.send(Decoded { frame, warnings }).is_err() || is_over {
                        return;
                    }
                }
            });
            if let Err(payload) = catch_unwind(work) {
                *of_thread.lock().unwrap_or_else(PoisonError::into_inner) = Some(payload);
            }
            // The consumer looks for a panic when there are no more items.
            drop(sender);
        })?;
        Ok(Self { items: Some(items), thread: Some(thread), panic })
    }

    /// Goes on with the panic of the thread, if that is why there are no more items.
    fn resume_panic(&self) {
        let payload = self.panic.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(payload) = payload {
            resume_unwind(payload);
        }
    }

    /// The next item; `None` when there are no more. Blocks until a frame is decoded.
    pub(crate) fn next(&self) -> Option<Decoded<T>> {
        let item = self.items.as_ref()?.recv().ok();
        if item.is_none() {
            self.resume_panic();
        }
        item
    }

    /// The next item as [`Self::next`], if it is decoded within a time.
    pub(crate) fn next_within(&self, time: Duration) -> Result<Option<Decoded<T>>, RecvTimeoutError> {
        let Some(items) = &self.items else { return Ok(None) };
        match items.recv_timeout(time) {
            Ok(item) => Ok(Some(item)),
            Err(RecvTimeoutError::Disconnected) => {
                self.resume_panic();
                Ok(None)
            }
            Err(timeout) => Err(timeout),
        }
    }

    /// Whether [`Self::next`] would return an item without blocking.
    pub(crate) fn is_ready(&self) -> bool {
        self.items.as_ref().is_some_and(|items| !items.is_empty())
    }
}

impl<T> Drop for Ahead<T> {
    fn drop(&mut self) {
        // Dropping the receiver ends the thread after its current frame. It must not be inside a decoder when the
        // process ends.
        self.items = None;
        if let Some(thread) = self.thread.take() {
            // It does not panic.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;
    use crate::frame::Size;
    use crate::source::{FpsFrom, SourceInfo};

    /// Frames 1, 2, … without an end, a warning before each. It counts the frames read.
    struct Endless(SourceInfo, Arc<AtomicU32>);

    impl Endless {
        fn boxed(read: &Arc<AtomicU32>) -> Box<dyn Source> {
            let info = SourceInfo {
                name: "endless".into(),
                size: Size::new(1, 1),
                pixel_aspect: None,
                fps: 25.0,
                fps_from: FpsFrom::Video,
                frames: None,
                live: true,
                reduction: None,
            };
            Box::new(Self(info, Arc::clone(read)))
        }
    }

    impl Source for Endless {
        fn info(&self) -> &SourceInfo {
            &self.0
        }

        fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
            let number = self.1.fetch_add(1, Ordering::SeqCst) + 1;
            if number == 9 {
                return Err(SourceError::unusable("endless", "it broke"));
            }
            Ok(Some(Frame::new(number, Size::new(1, 1), vec![0; 3])))
        }

        fn take_warnings(&mut self) -> Vec<String> {
            vec![format!("before {}", self.1.load(Ordering::SeqCst))]
        }
    }

    fn items(ahead: &Ahead<u32>) -> Vec<(Option<u32>, String)> {
        std::iter::from_fn(|| ahead.next())
            .map(|Decoded { frame, warnings }| (frame.unwrap_or(Some(0)), warnings.concat()))
            .collect()
    }

    #[test]
    fn a_stop_ends_the_sequence_after_the_warnings_so_far() {
        let read = Arc::new(AtomicU32::new(0));
        let count = Arc::clone(&read);
        let is_stopped = move || count.load(Ordering::SeqCst) == 3;
        let ahead = Ahead::start(Endless::boxed(&read), 1, is_stopped, |frame| frame.number).unwrap();
        let text = |number: u32| format!("before {number}");
        assert_eq!(items(&ahead), [(Some(1), text(1)), (Some(2), text(2)), (None, text(3))]);
        assert!(!ahead.is_ready());
    }

    #[test]
    fn a_panic_goes_on_in_the_consumer() {
        let read = Arc::new(AtomicU32::new(0));
        let broken = |frame: Frame| {
            assert!(frame.number < 3, "broken");
            frame.number
        };
        let ahead = Ahead::start(Endless::boxed(&read), 1, || false, broken).unwrap();
        assert_eq!(ahead.next().and_then(|item| item.frame.unwrap()), Some(1));
        assert_eq!(ahead.next().and_then(|item| item.frame.unwrap()), Some(2));
        let payload = catch_unwind(AssertUnwindSafe(|| ahead.next().is_some())).unwrap_err();
        assert_eq!(payload.downcast_ref::<&str>(), Some(&"broken"));
        assert!(ahead.next().is_none());
    }

    #[test]
    fn nothing_follows_an_error() {
        let read = Arc::new(AtomicU32::new(0));
        let ahead = Ahead::start(Endless::boxed(&read), 2, || false, |frame| frame.number).unwrap();
        let items = items(&ahead);
        assert_eq!((items.len(), &items[8]), (9, &(Some(0), "before 9".to_owned())));
    }

    #[test]
    fn the_queue_bounds_the_frames_read_ahead_and_dropping_it_ends_the_thread() {
        let read = Arc::new(AtomicU32::new(0));
        let ahead = Ahead::start(Endless::boxed(&read), 2, || false, |frame| frame.number).unwrap();
        assert!(ahead.next().is_some());
        drop(ahead);
        // One returned, two in the queue, one that waits for room.
        assert!(read.load(Ordering::SeqCst) <= 4);
        assert_eq!(Arc::strong_count(&read), 1, "the thread dropped its source");
    }
}
