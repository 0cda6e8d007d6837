//! Frames decoded on a thread of their own, ahead of whoever takes them.

use std::{iter, thread};

use anyhow::anyhow;
use crossbeam_channel::{Receiver, Sender, TryRecvError, bounded};

use super::flags::Range;
use super::interrupt;
use crate::frame::Frame;
use crate::mixture::BATCH;
use crate::source::{self, Source, SourceInfo};

/// How many frames are decoded ahead, at most and at least, and how much memory they may take in between.
const MOST_AHEAD: usize = 2 * BATCH;
const LEAST_AHEAD: usize = 4;
const AHEAD_BYTES: usize = 256 << 20;

/// What comes from a source.
pub(super) enum Item {
    /// The next frame.
    Frame(Frame),
    /// Something went wrong without ending the sequence.
    Warning(String),
    /// The sequence cannot go on.
    Failed(anyhow::Error),
    /// There are no more: without it, decoding broke off.
    End,
}

/// The frames of a source, or of a range of it.
pub(super) struct Frames {
    /// What is known of the source.
    pub info: SourceInfo,
    /// How many frames there will be, as far as it is known.
    pub total: Option<u32>,
    items: Receiver<Item>,
}

impl Frames {
    /// Opens `video` and starts to decode it.
    pub(super) fn open(video: &str, range: Option<Range>) -> anyhow::Result<Self> {
        interrupt::watch();
        let source = source::open(video)?;
        let info = source.info().clone();
        let total = match (range, info.frames) {
            (Some(range), Some(frames)) => Some(frames.min(range.last - range.first + 1)),
            (Some(range), None) => Some(range.last - range.first + 1),
            (None, frames) => frames,
        };
        let ahead = AHEAD_BYTES / (info.size.pixels() * 3).max(1);
        let (sender, items) = bounded(ahead.clamp(LEAST_AHEAD, MOST_AHEAD));
        thread::Builder::new().name("decode".to_owned()).spawn(move || decode(source, range, &sender))?;
        Ok(Self { info, total, items })
    }

    /// The frames that are there, at least one and up to `most`, or none where something else comes
    /// first; and what comes after them, if it is there and no frame.
    pub(super) fn batch(&self, most: usize) -> (Vec<Frame>, Option<Item>) {
        let mut frames = Vec::new();
        while frames.len() < most {
            let received = if frames.is_empty() {
                self.items.recv().map_err(|_| TryRecvError::Disconnected)
            } else {
                self.items.try_recv()
            };
            let item = match received {
                Ok(item) => item,
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => self.broke_off(),
            };
            match item {
                Item::Frame(frame) => frames.push(frame),
                other => return (frames, Some(other)),
            }
        }
        (frames, None)
    }

    fn broke_off(&self) -> Item {
        Item::Failed(anyhow!("decoding {} broke off", self.info.name))
    }

    /// The frames and what else comes, in order, to the end.
    pub(super) fn items(&self) -> impl Iterator<Item = Item> {
        let mut over = false;
        iter::from_fn(move || {
            if over {
                return None;
            }
            match self.items.recv() {
                Ok(Item::End) => None,
                Ok(item) => Some(item),
                Err(_) => {
                    over = true;
                    Some(self.broke_off())
                }
            }
        })
        .fuse()
    }
}

/// Sends everything within `range`; returns early when nobody takes it any more.
fn decode(mut source: Box<dyn Source>, range: Option<Range>, items: &Sender<Item>) {
    let mut last_number = None;
    let mut sent = false;
    // Whether the source ended before the range did.
    let mut ended_within = true;
    loop {
        let next = source.next_frame();
        for warning in source.take_warnings() {
            if items.send(Item::Warning(warning)).is_err() {
                return;
            }
        }
        // A camera has no end: to stop is how a recording ends.
        if source.info().live && interrupt::asked() {
            break;
        }
        let frame = match next {
            Ok(Some(frame)) => frame,
            Ok(None) => break,
            Err(error) => {
                let _ = items.send(Item::Failed(error.into()));
                return;
            }
        };
        if range.is_some_and(|range| frame.number > range.last) {
            ended_within = !sent;
            break;
        }
        last_number = Some(frame.number);
        if range.is_none_or(|range| frame.number >= range.first) {
            sent = true;
            if items.send(Item::Frame(frame)).is_err() {
                return;
            }
        } else if interrupt::asked() {
            let _ = items.send(Item::Failed(anyhow!("stopped; nothing was written")));
            return;
        }
    }
    if ended_within && let Some(item) = at_the_end(source.info(), range, last_number, sent) {
        let _ = items.send(item);
    }
    let _ = items.send(Item::End);
}

/// What is to be said of a sequence that ended before its range did.
fn at_the_end(info: &SourceInfo, range: Option<Range>, last_number: Option<u32>, sent: bool) -> Option<Item> {
    let name = &info.name;
    let failed = |why: String| Some(Item::Failed(anyhow!(why)));
    match (range, last_number) {
        (None, None) => failed(format!("{name} has no frames that can be read")),
        (Some(range), Some(last)) if last < range.first => failed(format!(
            "the range {range} starts beyond the end of {name}, whose last frame is {last}; choose an earlier start"
        )),
        (Some(range), _) if !sent => failed(format!("{name} has no frames in the range {range}")),
        (Some(range), Some(last)) if last < range.last => {
            Some(Item::Warning(format!("the range {range} is cut at {last}, the last frame of {name}")))
        }
        _ => None,
    }
}
