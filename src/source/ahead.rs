//! Decoding on a thread of its own, a few frames ahead of whoever takes them.

use std::io;
use std::thread::{self, JoinHandle};

use crossbeam_channel::{Receiver, bounded};
use xxhash_rust::xxh3::xxh3_64;

use super::{Source, SourceError};
use crate::frame::Frame;

/// By which a frame is known again: equal frames have equal ones, others do not in practice.
pub(super) type Fingerprint = u64;

/// The fingerprint of a frame's pixels.
pub(super) fn fingerprint(frame: &Frame) -> Fingerprint {
    xxh3_64(&frame.rgb)
}

/// What a source gave when it was asked for the next frame.
pub(super) struct Item {
    /// The frame, `None` at the end.
    pub(super) frame: Result<Option<(Frame, Fingerprint)>, SourceError>,
    /// What went wrong on the way without ending the sequence.
    pub(super) warnings: Vec<String>,
}

/// A source that is read ahead. Nothing comes after the end or a failure.
pub(super) struct Ahead {
    items: Option<Receiver<Item>>,
    thread: Option<JoinHandle<()>>,
}

impl Ahead {
    /// Starts to read; at most `most` frames wait.
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

    /// The next item, which may take as long as a frame takes to decode; `None` when there are no more.
    pub(super) fn next(&self) -> Option<Item> {
        self.items.as_ref()?.recv().ok()
    }

    /// Whether [`Self::next`] would not wait.
    pub(super) fn is_ready(&self) -> bool {
        self.items.as_ref().is_some_and(|items| !items.is_empty())
    }
}

impl Drop for Ahead {
    fn drop(&mut self) {
        // Nobody takes items any more: the thread ends after the frame that it is at. It must not
        // be inside a decoder when the process ends.
        self.items = None;
        if let Some(thread) = self.thread.take() {
            // A panic in a decoder was told as an end too early.
            let _ = thread.join();
        }
    }
}
