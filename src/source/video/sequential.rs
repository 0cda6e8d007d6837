//! The first reading of a video, which records its index and gives the same at every run, also where it is damaged.
//!
//! What a decoder makes of damaged data depends on its number of threads, and with several of them on chance. A damaged
//! video is decoded on one thread from the first sign of damage on. Pictures are held back before they are given, as
//! those that are shown before a damaged one may have been decoded after it. A decoder of several threads does not always
//! mark damaged pictures: FFmpeg's reports of errors, which may be about another file, are a sign, too.

use std::collections::VecDeque;
use std::path::Path;

use super::Failure;
use super::decode::{Landing, Threads};
use super::index::SharedIndex;
use super::raw;
use super::reader::{Reader, TimedPicture};

/// Number of pictures that are decoded again from the start of the video rather than from a key packet.
const FEW: u32 = 1500;
/// Number of pictures without damage after which a message of FFmpeg's was not about damage.
const PROBATION: u32 = 100;
/// Number of suspicions after which the video counts as damaged.
const MAX_SUSPICIONS: u32 = 3;

/// What is known of the video's damage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Damage {
    /// There is no sign of it.
    None,
    /// FFmpeg reported an error; this number of pictures is still to be decoded without damage.
    Suspected(u32),
    /// There is some.
    Certain,
}

/// Reads a video once.
pub(super) struct SequentialReader {
    reader: Reader,
    index: SharedIndex,
    damage: Damage,
    suspicions: u32,
    /// Number of reported errors so far that are no sign of damage.
    reported: u64,
    held: VecDeque<TimedPicture>,
    /// Number of pictures given.
    given: u32,
}

impl SequentialReader {
    /// Opens a video at its start.
    pub(super) fn open(file: &Path) -> Result<Self, Failure> {
        let reported = raw::reported_errors();
        let reader = Reader::open(file, Threads::All)?;
        Ok(Self {
            reader,
            index: SharedIndex::default(),
            damage: Damage::None,
            suspicions: 0,
            reported,
            held: VecDeque::new(),
            given: 0,
        })
    }

    /// The reader, for properties and the conversion of pictures.
    pub(super) fn reader(&mut self) -> &mut Reader {
        &mut self.reader
    }

    /// The index of the frames given so far.
    pub(super) fn index(&self) -> &SharedIndex {
        &self.index
    }

    /// The next picture, `None` after the last. Fails where the file had to be opened again and could not be.
    pub(super) fn next(&mut self) -> Result<Option<TimedPicture>, Failure> {
        let picture = match self.damage {
            Damage::None => self.next_undamaged()?,
            Damage::Suspected(left) => self.next_suspected(left)?,
            Damage::Certain => self.reader.next(),
        };
        let mut index = self.index.lock();
        index.add_keys(self.reader.take_keys());
        index.is_damaged = self.damage != Damage::None;
        let Some(picture) = picture else { return Ok(None) };
        index.push(picture.time);
        self.given += 1;
        Ok(Some(picture))
    }

    /// The next picture if there is no sign of damage up to those that may depend on each other, else that of a single
    /// thread.
    fn next_undamaged(&mut self) -> Result<Option<TimedPicture>, Failure> {
        while self.held.len() <= self.reader.info().reordered {
            let picture = self.reader.next();
            if is_damaged(&self.reader, picture.as_ref()) || raw::reported_errors() > self.reported {
                self.suspicions += 1;
                let is_certain = self.suspicions > MAX_SUSPICIONS;
                let damage = if is_certain { Damage::Certain } else { Damage::Suspected(PROBATION) };
                return Ok(if self.restart(damage)? { self.next_decoded() } else { None });
            }
            let Some(picture) = picture else { break };
            self.held.push_back(picture);
        }
        Ok(self.held.pop_front())
    }

    /// The next picture where damage is suspected.
    fn next_suspected(&mut self, left: u32) -> Result<Option<TimedPicture>, Failure> {
        if left == 0 {
            if !self.restart(Damage::None)? {
                return Ok(None);
            }
            // Those about the pictures so far were no signs.
            self.reported = raw::reported_errors();
            return self.next_undamaged();
        }
        self.damage = Damage::Suspected(left - 1);
        Ok(self.next_decoded())
    }

    /// The next picture of a single thread, which marks damaged pictures.
    fn next_decoded(&mut self) -> Option<TimedPicture> {
        let picture = self.reader.next();
        if is_damaged(&self.reader, picture.as_ref()) {
            self.damage = Damage::Certain;
        }
        picture
    }

    /// Opens the video again and goes to the current picture; returns whether there are as many pictures this time.
    fn restart(&mut self, damage: Damage) -> Result<bool, Failure> {
        self.damage = damage;
        let threads = if damage == Damage::None { Threads::All } else { Threads::One };
        self.held.clear();
        self.index.lock().add_keys(self.reader.take_keys());
        self.reader.restart(threads).map_err(|_| Failure::Changed)?;
        if self.given > FEW {
            if self.seek_to_current().is_some() {
                return Ok(true);
            }
            self.reader.restart(threads).map_err(|_| Failure::Changed)?;
        }
        Ok((0..self.given).all(|_| self.reader.next().is_some()))
    }

    /// Goes to the current picture from a key packet well before it: of some videos, whose pictures are renewed part by
    /// part, the first pictures after a key packet are incomplete.
    fn seek_to_current(&mut self) -> Option<()> {
        let last = self.given.checked_sub(1)?;
        let approach = self.index.lock().approach(last)?;
        let key = *approach.keys.last()?;
        if !matches!(self.reader.seek_before(key, approach.pts), Landing::At(_)) {
            return None;
        }
        self.reader.decode_until(approach.pts)?;
        (approach.anchor..last).try_for_each(|_| self.reader.next().map(drop))
    }
}

fn is_damaged(reader: &Reader, next: Option<&TimedPicture>) -> bool {
    reader.errors() > 0 || next.is_some_and(TimedPicture::is_damaged)
}
