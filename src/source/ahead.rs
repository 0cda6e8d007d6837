//! Decodes frames on a separate thread, a few frames ahead of the consumer.

use std::io;
use std::thread::{self, JoinHandle};

use crossbeam_channel::{Receiver, bounded};
use xxhash_rust::xxh3::xxh3_64;

use super::{Source, SourceError};
use crate::frame::Frame;

/// A hash that identifies a frame: equal frames have equal fingerprints, different frames have different ones in
/// practice.
pub(super) type Fingerprint = u64;

/// The fingerprint of a frame's pixels.
pub(super) fn fingerprint(frame: &Frame) -> Fingerprint {
    xxh3_64(&frame.rgb)
}

/// The result of one read from a source.
pub(super) struct Item {
    /// The frame; `None` at the end of the sequence.
    pub(super) frame: Result<Option<(Frame, Fingerprint)>, SourceError>,
    /// Warnings of problems that did not end the sequence.
    pub(super) warnings: Vec<String>,
}

/// A source that is read ahead. It gives no items after the end or an error.
pub(super) struct Ahead {
    items: Option<Receiver<Item>>,
    thread: Option<JoinHandle<()>>,
}

impl Ahead {
    /// Starts the decoding thread; the queue holds at most `most` frames.
    pub(super) fn start(mut source: Box<dyn Source>, most: usize) -> io::Result<Self> {
        let (sender, items) = bounded(most);
        let thread = thread::Builder::new().name("decode ahead".into()).spawn(move || {
            loop {
                let next = source.next_frame();
                let warnings = source.take_warnings();
                let frame = next.map(|frame| {
                    frame.map(|frame| {
                        let fingerprint = fingerprint(&frame);
                        (frame, fingerprint)
                    })
                });
                let over = !matches!(frame, Ok(Some(_)));
                if sender.send(Item { frame, warnings }).is_err() || over {
                    return;
                }
            }
        })?;
        Ok(Self { items: Some(items), thread: Some(thread) })
    }

    /// The next item; `None` when there are no more. Blocks until a frame is decoded.
    pub(super) fn next(&self) -> Option<Item> {
        self.items.as_ref()?.recv().ok()
    }

    /// Whether [`Self::next`] would return without blocking.
    pub(super) fn is_ready(&self) -> bool {
        self.items.as_ref().is_some_and(|items| !items.is_empty())
    }
}

impl Drop for Ahead {
    fn drop(&mut self) {
        // Dropping the receiver ends the thread after its current frame. It must not be inside a decoder when the
        // process ends.
        self.items = None;
        if let Some(thread) = self.thread.take() {
            // A panic in a decoder was already reported as an early end.
            let _ = thread.join();
        }
    }
}
