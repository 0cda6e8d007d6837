//! Frames of a video again, in any order, the same as at the first reading.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::decode::{Landing, Threads};
use super::index::SharedIndex;
use super::reader::{Reader, TimedPicture};
use crate::frame::{Frame, Size};
use crate::source::random_access::{Fingerprint, RandomAccess, Step, fingerprint};
use crate::source::{SourceError, SourceInfo};

/// Number of frames whose decoding in order takes no longer than a seek.
const FAR: u32 = 48;
/// Number of seeks that led nowhere after which the video is read in order only.
const MAX_MISSES: u32 = 3;

/// Reads frames of a video again.
pub(super) struct IndexedReader {
    name: String,
    file: PathBuf,
    version: Option<Version>,
    size: Size,
    index: SharedIndex,
    reader: Option<(Reader, Threads)>,
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

/// What changes when a file is written to.
type Version = (u64, SystemTime);

fn version(file: &Path) -> Option<Version> {
    let metadata = fs::metadata(file).ok()?;
    Some((metadata.len(), metadata.modified().ok()?))
}

impl IndexedReader {
    /// A reader of the frames in `index`. It opens the file when it is used first.
    pub(super) fn new(info: &SourceInfo, file: &Path, index: &SharedIndex) -> Self {
        Self {
            name: info.name.clone(),
            file: file.to_owned(),
            version: version(file),
            size: info.size,
            index: index.clone(),
            reader: None,
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
        let open = match self.reader.take() {
            Some(open) if open.1 == threads => open,
            _ => {
                (self.next, self.has_jumped) = (0, false);
                (Reader::open(&self.file, threads).map_err(|failure| failure.of(&self.name))?, threads)
            }
        };
        if open.0.size() != self.size {
            return Err(SourceError::changed(&self.name));
        }
        self.reader = Some(open);
        Ok(())
    }

    fn rewind(&mut self) {
        self.reader = None;
        (self.next, self.has_jumped) = (0, false);
    }

    /// Reads the next frame. Goes back to the start where a seek led to another frame.
    fn read_next(&mut self, fingerprints: &[Fingerprint]) -> Result<Step, SourceError> {
        let position = self.next;
        let Some((reader, _)) = &mut self.reader else { return Ok(Step::OnTheWay) };
        let Some(picture) = reader.next() else { return self.differs(position, None) };
        // They are in the index already.
        drop(reader.take_keys());
        let time = picture.time;
        let rgb = reader.rgb(picture).map_err(|failure| failure.of(&self.name))?;
        let frame = Frame::new(position + 1, self.size, rgb);
        self.next = position + 1;
        let is_same_time =
            self.index.lock().time(position).is_none_or(|expected| {
                !(expected.is_from_file && time.is_from_file) || expected.pts == time.pts
            });
        if is_same_time && fingerprints.get(position as usize) == Some(&fingerprint(&frame)) {
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
        let frame = frame.filter(|_| version(&self.file) == self.version);
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

    /// Seeks to the frame at `position`. `None` where it is not found; the reader is then anywhere.
    fn jump(&mut self, position: u32, fingerprints: &[Fingerprint]) -> Result<Option<Frame>, SourceError> {
        let Some(approach) = self.index.lock().approach(position) else { return Ok(None) };
        let mut last_landed = None;
        for key in &approach.keys {
            let Some((reader, _)) = &mut self.reader else { break };
            let landed = match reader.seek_before(*key, approach.pts) {
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
            let found = find(reader, approach.pts, position - approach.anchor);
            let Some(rgb) = found.map(|picture| reader.rgb(picture)) else { continue };
            let frame = Frame::new(position + 1, self.size, rgb.map_err(|failure| failure.of(&self.name))?);
            if fingerprints.get(position as usize) == Some(&fingerprint(&frame)) {
                (self.next, self.has_jumped) = (position + 1, true);
                return Ok(Some(frame));
            }
        }
        Ok(None)
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
