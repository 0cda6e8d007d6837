//! Frames of a video again, in any order, the same as at the first reading.

use super::Failure;
use super::convert::{Converted, Converter};
use super::decode::{Landing, Threads};
use super::file::InputFile;
use super::index::{Key, SharedIndex};
use super::reader::{Reader, TimedPicture};
use crate::frame::{Frame, Size};
use crate::source::random_access::{Fingerprint, RandomAccess, Step, is_same};
use crate::source::{SourceError, SourceInfo};

/// Number of frames whose decoding in order takes no longer than a seek.
const FAR: u32 = 48;
/// Number of seeks that led nowhere after which the video is read in order only.
const MAX_MISSES: u32 = 3;

/// Reads frames of a video again.
pub(super) struct IndexedReader {
    name: String,
    file: InputFile,
    size: Size,
    index: SharedIndex,
    open: Option<OpenVideo>,
    /// The position of the reader's next frame.
    next: u32,
    /// Whether it got there by a seek.
    has_jumped: bool,
    /// The frame to which it is on its way.
    goal: u32,
    misses: u32,
    has_warned: bool,
    warnings: Vec<String>,
}

/// A reader with the conversion of its pictures.
struct OpenVideo {
    reader: Reader,
    threads: Threads,
    converter: Converter,
}

impl OpenVideo {
    /// Opens a video at its start. Its first frame determines the size of all.
    fn new(file: &InputFile, threads: Threads) -> Result<Self, Failure> {
        let mut reader = Reader::open(file, threads)?;
        let mut converter = Converter::new(reader.info().display_matrix, file.deinterlace);
        converter.prepare(|| Ok(reader.next()))?.ok_or(Failure::NoFrame)?;
        Ok(Self { reader, threads, converter })
    }

    /// The next frame, `None` after the last.
    fn next(&mut self) -> Result<Option<Converted>, Failure> {
        let next = self.converter.next(|| Ok(self.reader.next()));
        // They are in the index already.
        drop(self.reader.take_keys());
        next
    }

    /// The frame `skipped` frames after that of `picture`, which is the reader's last one.
    fn next_from(&mut self, picture: TimedPicture, skipped: u32) -> Result<Option<Converted>, Failure> {
        self.converter.jump();
        let mut first = Some(picture);
        let mut next = || Ok(first.take().or_else(|| self.reader.next()));
        for _ in 0..skipped {
            self.converter.next(&mut next)?;
        }
        self.converter.next(next)
    }
}

impl IndexedReader {
    /// A reader of the frames in `index`. It opens the file when it is used first.
    pub(super) fn new(info: &SourceInfo, file: InputFile, index: &SharedIndex) -> Self {
        Self {
            name: info.name.clone(),
            file,
            size: info.size,
            index: index.clone(),
            open: None,
            next: 0,
            has_jumped: false,
            goal: 0,
            misses: 0,
            has_warned: false,
            warnings: Vec::new(),
        }
    }

    /// Opens the video at its start if no reader of it reads as the first reader did.
    fn ensure_open(&mut self) -> Result<(), SourceError> {
        let threads = if self.index.lock().is_damaged { Threads::One } else { Threads::All };
        if self.open.as_ref().is_some_and(|open| open.threads == threads) {
            return Ok(());
        }
        self.rewind();
        let open = OpenVideo::new(&self.file, threads).map_err(|failure| {
            // One that is gone cannot be opened, either.
            if self.file.is_unchanged() { failure.of(&self.name) } else { SourceError::changed(&self.name) }
        })?;
        if open.converter.size() != Some(self.size) {
            return Err(SourceError::changed(&self.name));
        }
        self.open = Some(open);
        Ok(())
    }

    fn rewind(&mut self) {
        self.open = None;
        (self.next, self.has_jumped) = (0, false);
    }

    /// Reads the next frame. Goes back to the start where a seek led to another frame.
    fn read_next(&mut self, fingerprints: &[Fingerprint]) -> Result<Step, SourceError> {
        let position = self.next;
        let Some(open) = &mut self.open else { return Ok(Step::OnTheWay) };
        let next = open.next().map_err(|failure| failure.of(&self.name))?;
        let Some(Converted { info, rgb }) = next else { return self.differs(position, None) };
        let time = info.time;
        let frame = Frame::new(position + 1, self.size, rgb);
        self.next = position + 1;
        let is_same_time =
            self.index.lock().time(position).is_none_or(|expected| {
                !(expected.is_from_file && time.is_from_file) || expected.pts == time.pts
            });
        if is_same_time && is_same(fingerprints, position, &frame) {
            return Ok(Step::Frame(position, frame));
        }
        self.differs(position, is_same_time.then_some(frame))
    }

    /// A frame is missing, or another than at first; `frame` is it where only its pixels differ.
    fn differs(&mut self, position: u32, frame: Option<Frame>) -> Result<Step, SourceError> {
        if self.has_jumped {
            self.rewind();
            self.misses += 1;
            return Ok(Step::OnTheWay);
        }
        let frame = frame.filter(|_| self.file.is_unchanged());
        let Some(frame) = frame else {
            self.rewind();
            return Err(SourceError::changed(&self.name));
        };
        if !self.has_warned {
            self.has_warned = true;
            self.warnings.push(format!(
                "{} is damaged: frame {} and perhaps others look different each time they are decoded; results are \
                 those of the first time",
                self.name,
                position + 1
            ));
        }
        Ok(Step::Frame(position, frame))
    }

    /// Goes to the frame at `position`, by a seek unless decoding goes on to it from a key packet anyway. `None` where it
    /// is not found; the reader is then anywhere.
    fn jump(&mut self, position: u32, fingerprints: &[Fingerprint]) -> Result<Option<Frame>, SourceError> {
        // A deinterlaced frame depends on the picture before its own.
        let first = if self.file.deinterlace { position.saturating_sub(1) } else { position };
        let Some(approach) = self.index.lock().approach(first) else { return Ok(None) };
        let seeks = approach.keys.iter().copied().map(Some);
        let starts = self.is_past_key(approach.anchor, approach.keys.first()).then_some(None);
        let mut last_landed = None;
        for seek in starts.into_iter().chain(seeks) {
            let Some(open) = &mut self.open else { break };
            if let Some(key) = seek {
                let landed = match open.reader.seek_before(key, approach.pts) {
                    Landing::At(landed) => landed,
                    Landing::AtEnd => break,
                    Landing::Refused => {
                        self.misses = MAX_MISSES;
                        break;
                    }
                };
                if last_landed.replace(landed) == Some(landed) {
                    continue;
                }
            }
            let found = find(&mut open.reader, approach.pts, first - approach.anchor);
            let Some(picture) = found else { continue };
            let converted =
                open.next_from(picture, position - first).map_err(|failure| failure.of(&self.name))?;
            let Some(Converted { rgb, .. }) = converted else { continue };
            let frame = Frame::new(position + 1, self.size, rgb);
            if is_same(fingerprints, position, &frame) {
                (self.next, self.has_jumped) = (position + 1, true);
                return Ok(Some(frame));
            }
        }
        Ok(None)
    }

    /// Whether a seek to this key packet for the frame at `position` would lead back over pictures that the reader has
    /// decoded.
    fn is_past_key(&self, position: u32, key: Option<&Key>) -> bool {
        let decoded = self.next + self.open.as_ref().map_or(0, |open| open.converter.held() as u32);
        let index = self.index.lock();
        let next = index.time(decoded).map(|time| time.pts);
        decoded <= position && key.and_then(Key::time).is_some_and(|key| next >= Some(key))
    }

    fn try_step(&mut self, from: u32, goal: u32, fingerprints: &[Fingerprint]) -> Result<Step, SourceError> {
        self.ensure_open()?;
        let is_on_the_way = self.next <= goal && (goal - self.next <= FAR || self.goal == goal);
        self.goal = goal;
        if is_on_the_way {
            return self.read_next(fingerprints);
        }
        if self.misses < MAX_MISSES {
            if let Some(frame) = self.jump(from, fingerprints)? {
                return Ok(Step::Frame(from, frame));
            }
            self.misses += 1;
            self.rewind();
        } else if self.next > goal {
            self.rewind();
        }
        Ok(Step::OnTheWay)
    }
}

/// Decodes up to the picture with this time and `beyond` pictures further.
fn find(reader: &mut Reader, pts: i64, beyond: u32) -> Option<TimedPicture> {
    let mut picture = reader.decode_until(pts)?;
    for _ in 0..beyond {
        picture = reader.next()?;
    }
    Some(picture)
}

impl RandomAccess for IndexedReader {
    fn step(&mut self, from: u32, goal: u32, fingerprints: &[Fingerprint]) -> Result<Step, SourceError> {
        let step = self.try_step(from, goal, fingerprints);
        if step.is_err() {
            self.rewind();
        }
        step
    }

    fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }
}
