//! The first reading of a video, which records its index and gives the same at every run, also where it is damaged.
//!
//! What a decoder makes of damaged data depends on its number of threads, and with several of them on chance. A damaged
//! video is decoded on one thread from the first sign of damage on. Pictures are held back before they are given, as
//! those that are shown before a damaged one may have been decoded after it. A decoder of several threads does not always
//! mark damaged pictures: FFmpeg's reports of errors, which may be about another file, are a sign, too.

use std::collections::VecDeque;

use super::Failure;
use super::decode::{Landing, Threads};
use super::file::InputFile;
use super::index::SharedIndex;
use super::raw;
use super::reader::{Reader, TimedPicture};

/// Number of pictures that are decoded again from the start of the video rather than from a key packet.
const FEW: u32 = 1500;
/// Number of pictures that are decoded again to examine a suspicion of damage. Where there are more, as in a video with
/// few key packets, it counts as damaged.
const MAX_AGAIN: u32 = 5000;
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
    /// Whether the video cannot be read again.
    is_live: bool,
    index: SharedIndex,
    damage: Damage,
    suspicions: u32,
    /// Number of reported errors so far that are no sign of damage.
    reported: u64,
    held: VecDeque<TimedPicture>,
}

impl SequentialReader {
    /// Opens a video at its start.
    pub(super) fn open(file: &InputFile) -> Result<Self, Failure> {
        let reported = raw::reported_errors();
        let reader = Reader::open(file, Threads::All)?;
        Ok(Self {
            reader,
            is_live: file.is_live(),
            index: SharedIndex::default(),
            damage: Damage::None,
            suspicions: 0,
            reported,
            held: VecDeque::new(),
        })
    }

    /// The reader of the pictures, for its properties.
    pub(super) fn reader(&self) -> &Reader {
        &self.reader
    }

    /// The index of the frames given so far.
    pub(super) fn index(&self) -> &SharedIndex {
        &self.index
    }

    /// The next picture, `None` after the last. A network stream has no index. Fails where the file had to be opened again
    /// and could not be.
    pub(super) fn next(&mut self) -> Result<Option<TimedPicture>, Failure> {
        if self.is_live {
            drop(self.reader.take_keys());
            return Ok(self.reader.next());
        }
        let picture = match self.damage {
            Damage::None => self.next_undamaged()?,
            Damage::Suspected(left) => self.next_suspected(left)?,
            Damage::Certain => self.next_decoded(),
        };
        let mut index = self.index.lock();
        index.add_keys(self.reader.take_keys());
        index.is_damaged = self.damage != Damage::None;
        let Some(picture) = picture else { return Ok(None) };
        index.push(picture.info.time);
        Ok(Some(picture))
    }

    /// The next picture if there is no sign of damage up to those that may depend on each other, else that of a single
    /// thread.
    fn next_undamaged(&mut self) -> Result<Option<TimedPicture>, Failure> {
        while self.held.len() <= self.reader.info().reordered {
            let picture = self.reader.next();
            if is_damaged(&self.reader, picture.as_ref()) || raw::reported_errors() > self.reported {
                self.suspicions += 1;
                self.index.lock().add_keys(self.reader.take_keys());
                let is_certain = self.suspicions > MAX_SUSPICIONS || self.decoded_again() > MAX_AGAIN;
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

    /// The next picture of a single thread, which marks damaged pictures. Some decoders only report what is wrong with a
    /// picture; before the first one, reports are about pictures that depend on missing ones.
    fn next_decoded(&mut self) -> Option<TimedPicture> {
        let reported = raw::reported_errors_here();
        let mut picture = self.reader.next();
        let has_report = raw::reported_errors_here() > reported && self.index.lock().len() > 0;
        if let Some(picture) = &mut picture {
            picture.info.is_damaged |= has_report;
        }
        if has_report || is_damaged(&self.reader, picture.as_ref()) {
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
        self.reader.restart(threads)?;
        let given = self.index.lock().len();
        if given > FEW {
            if self.seek_to_current().is_some() {
                return Ok(true);
            }
            self.reader.restart(threads)?;
        }
        Ok((0..given).all(|_| self.reader.next().is_some()))
    }

    /// Number of pictures that a restart decodes again.
    fn decoded_again(&self) -> u32 {
        let index = self.index.lock();
        let given = index.len();
        let approach = given.checked_sub(1).filter(|_| given > FEW).and_then(|last| index.approach(last));
        index.distance(approach.and_then(|approach| approach.keys.last().copied()), given)
    }

    /// Goes to the current picture from a key packet well before it: of some videos, whose pictures are renewed part by
    /// part, the first pictures after a key packet are incomplete.
    fn seek_to_current(&mut self) -> Option<()> {
        let index = self.index.lock();
        let last = index.len().checked_sub(1)?;
        let approach = index.approach(last)?;
        drop(index);
        let key = *approach.keys.last()?;
        if !matches!(self.reader.seek_before(key, approach.pts), Landing::At(_)) {
            return None;
        }
        self.reader.decode_until(approach.pts)?;
        (approach.anchor..last).try_for_each(|_| self.reader.next().map(drop))
    }
}

fn is_damaged(reader: &Reader, next: Option<&TimedPicture>) -> bool {
    reader.errors() > 0 || next.is_some_and(|picture| picture.info.is_damaged)
}
