//! Decoded frames within a budget of memory, by their position in the sequence.
//!
//! Sources are read from the first frame to the last, a little ahead of what is asked for. A frame
//! that was dropped is decoded again by a fresh reader. That may jump towards it, and as jumps in
//! videos land anywhere, the place is told by the frames themselves: each is known by a fingerprint
//! from when it was first decoded. Where that does not help, the reader starts from the beginning:
//! slow, and the same frame.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::ahead::{Ahead, Fingerprint, Item, fingerprint};
use super::{Options, Source, SourceError, SourceInfo};
use crate::frame::Frame;
use crate::registration::{Alignment, Registered};

type Opener = Box<dyn FnMut() -> Result<Box<dyn Source>, SourceError> + Send>;

/// What one step towards a frame gave.
#[derive(Debug, PartialEq)]
pub enum Fetched {
    /// The frame.
    Frame(Arc<Frame>),
    /// One frame on the way to it was decoded: ask again.
    OnTheWay,
    /// The sequence ends before it.
    End,
    /// A live source gave it once, and it is no longer kept.
    Gone,
}

/// Whether a frame that had to be decoded again may push others out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// It may: it, or its neighbours, will be asked for again.
    Yes,
    /// Only where there is room: a pass over the whole sequence that needs each frame once.
    IfRoom,
}

/// Decoding so many frames in order takes no longer than to open a source again and jump.
const FAR: u32 = 48;
/// A jump goes so many frames before the one that is wanted: whoever steps back will want those next.
const RUN_UP_FRAMES: u32 = 24;
/// Number of equal frames in a row that leave the position after a jump undecided.
const MAX_EQUAL_FRAMES: usize = 8;
/// Largest number of frames that are decoded ahead.
const MAX_FRAMES_AHEAD: usize = 32;

/// A second reader of the source, for frames that were dropped.
struct RewoundSource {
    source: Box<dyn Source>,
    /// The position that it gives next.
    next: u32,
    /// Whether it jumped there.
    jumped: bool,
}

/// Random access to the frames of a source.
pub struct FrameCache {
    open: Opener,
    info: Arc<SourceInfo>,
    /// The reader that has come furthest; it is at position `numbers.len()`.
    front: Ahead,
    numbers: Vec<u32>,
    fingerprints: Vec<Fingerprint>,
    /// How each lies against those before it.
    alignments: Vec<Alignment>,
    complete: bool,
    /// Why there are no more frames, for who asks for one next.
    failed: Option<SourceError>,
    again: Option<RewoundSource>,
    /// Whether jumps have been of use so far.
    jumps: bool,
    kept: HashMap<u32, (Arc<Frame>, u64)>,
    /// Positions by the time they were last useful.
    by_use: BTreeMap<u64, u32>,
    clock: u64,
    room: usize,
    warnings: Vec<String>,
}

impl FrameCache {
    /// Opens the source of this name and keeps up to `budget` bytes of its frames, at least two frames.
    pub fn open(name: &str, options: Options, budget: usize) -> Result<Self, SourceError> {
        let (name, options) = (name.to_owned(), options);
        Self::new(move || super::open(&name, options), budget)
    }

    /// Keeps up to `budget` bytes of the frames of the source that `open` gives; it is called again
    /// when frames that were dropped are wanted.
    pub fn new(
        mut open: impl FnMut() -> Result<Box<dyn Source>, SourceError> + Send + 'static,
        budget: usize,
    ) -> Result<Self, SourceError> {
        let front: Box<dyn Source> = Box::new(Registered::new(open()?));
        let info = Arc::new(front.info().clone());
        let frame_bytes = (info.size.pixels() * 3).max(1);
        let room = budget / frame_bytes;
        let ahead = (room / 4).clamp(1, if info.live { 2 } else { MAX_FRAMES_AHEAD });
        let front = Ahead::start(front, ahead).map_err(|error| {
            SourceError::unusable(&info.name, format!("no thread to decode it can be started ({error})"))
        })?;
        Ok(Self {
            open: Box::new(open),
            info,
            front,
            numbers: Vec::new(),
            fingerprints: Vec::new(),
            alignments: Vec::new(),
            complete: false,
            failed: None,
            again: None,
            jumps: true,
            kept: HashMap::new(),
            by_use: BTreeMap::new(),
            clock: 0,
            room: room.saturating_sub(ahead).max(2),
            warnings: Vec::new(),
        })
    }

    /// What is known of the source.
    pub fn info(&self) -> &Arc<SourceInfo> {
        &self.info
    }

    /// How many frames are kept at most.
    pub fn room(&self) -> usize {
        self.room
    }

    /// The frame numbers of the positions that are known so far.
    pub fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// How the frames of the positions that are known lie against those before them.
    pub fn alignments(&self) -> &[Alignment] {
        &self.alignments
    }

    /// The positions whose frames are kept decoded, as ranges with both ends in them, in order.
    pub fn kept_ranges(&self) -> Vec<(u32, u32)> {
        let mut positions: Vec<u32> = self.kept.keys().copied().collect();
        positions.sort_unstable();
        let ranges = positions.chunk_by(|a, b| a + 1 == *b);
        ranges.filter_map(|range| Some((*range.first()?, *range.last()?))).collect()
    }

    /// Whether the end has been found: there are no frames but those of [`Self::numbers`].
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// What went wrong without ending the sequence since this was last asked.
    pub fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    /// Forgets all frames of a live source: the next one that it gives is at position 0.
    pub fn forget(&mut self) {
        if self.info.live {
            self.numbers.clear();
            self.fingerprints.clear();
            self.alignments.clear();
            self.kept.clear();
            self.by_use.clear();
        }
    }

    /// Whether the frame at `position` is kept.
    pub fn has(&self, position: u32) -> bool {
        self.kept.contains_key(&position)
    }

    /// The frame at `position` if it is kept; it counts as used.
    pub fn kept(&mut self, position: u32) -> Option<Arc<Frame>> {
        let (frame, used) = self.kept.get_mut(&position)?;
        self.by_use.remove(used);
        self.clock += 1;
        *used = self.clock;
        self.by_use.insert(self.clock, position);
        Some(Arc::clone(frame))
    }

    /// The frame at `position` if it is kept, or is the next of the sequence and decoded already.
    pub fn at_hand(&mut self, position: u32) -> Option<Arc<Frame>> {
        if position as usize != self.numbers.len() || self.complete || !self.front.is_ready() {
            return self.kept(position);
        }
        match self.fetch_ahead(position) {
            Ok(Fetched::Frame(frame)) => Some(frame),
            Ok(_) => None,
            Err(error) => {
                self.failed = Some(error);
                None
            }
        }
    }

    /// One step towards the frame at `position`: decodes at most one frame, so that the caller can
    /// turn to something else in between.
    pub fn fetch(&mut self, position: u32, keep: Keep) -> Result<Fetched, SourceError> {
        if let Some(frame) = self.kept(position) {
            return Ok(Fetched::Frame(frame));
        }
        if position as usize >= self.numbers.len() {
            return self.fetch_ahead(position);
        }
        if self.info.live {
            return Ok(Fetched::Gone);
        }
        self.fetch_again(position, keep)
    }

    /// The frame at `position`, `None` beyond the end or where a live source's frame is no longer kept.
    pub fn get(&mut self, position: u32) -> Result<Option<Arc<Frame>>, SourceError> {
        loop {
            match self.fetch(position, Keep::Yes)? {
                Fetched::Frame(frame) => return Ok(Some(frame)),
                Fetched::OnTheWay => {}
                Fetched::End | Fetched::Gone => return Ok(None),
            }
        }
    }

    fn fetch_ahead(&mut self, position: u32) -> Result<Fetched, SourceError> {
        if let Some(error) = self.failed.take() {
            return Err(error);
        }
        if self.complete {
            return Ok(Fetched::End);
        }
        let Some(Item { frame, warnings }) = self.front.next() else {
            return Err(SourceError::unusable(&self.info.name, "its decoder failed; open it again"));
        };
        self.warnings.extend(warnings);
        let Some((frame, fingerprint)) = frame? else {
            self.complete = true;
            return Ok(Fetched::End);
        };
        let here = self.numbers.len() as u32;
        self.numbers.push(frame.number);
        self.fingerprints.push(fingerprint);
        self.alignments.push(frame.alignment);
        let frame = Arc::new(frame);
        self.insert(here, Arc::clone(&frame));
        Ok(if here == position { Fetched::Frame(frame) } else { Fetched::OnTheWay })
    }

    fn fetch_again(&mut self, position: u32, keep: Keep) -> Result<Fetched, SourceError> {
        let mut again = match self.again.take() {
            Some(again) if again.next <= position && (position - again.next <= FAR || !self.jumps) => again,
            _ => {
                let mut source = (self.open)()?;
                if self.jumps && position > FAR {
                    self.jumps = source.seek(position - RUN_UP_FRAMES.min(self.room as u32 / 2));
                    if self.jumps {
                        return self.land(source, position);
                    }
                    source = (self.open)()?;
                }
                RewoundSource { source, next: 0, jumped: false }
            }
        };
        let here = again.next;
        let frame = again.source.next_frame()?.filter(|frame| {
            frame.size == self.info.size && self.fingerprints.get(here as usize) == Some(&fingerprint(frame))
        });
        let Some(mut frame) = frame else {
            if again.jumped {
                self.jumps = false;
                return Ok(Fetched::OnTheWay);
            }
            return Err(SourceError::unusable(&self.info.name, "it changed while being read; open it again"));
        };
        // After a jump a reader counts from elsewhere.
        frame.number = self.numbers[here as usize];
        // It was measured when all before it had been seen.
        frame.alignment = self.alignments[here as usize];
        again.next = here + 1;
        self.again = Some(again);
        let frame = Arc::new(frame);
        let near = (position - here) as usize <= self.room / 2;
        if keep == Keep::Yes && near || self.kept.len() < self.room {
            self.insert(here, Arc::clone(&frame));
        }
        Ok(if here == position { Fetched::Frame(frame) } else { Fetched::OnTheWay })
    }

    /// Finds out where a source that jumped is, from what it gives next; where that is not a little
    /// before `position`, or not to be told, there are no more jumps.
    fn land(&mut self, mut source: Box<dyn Source>, position: u32) -> Result<Fetched, SourceError> {
        let mut seen = Vec::new();
        self.jumps = false;
        while seen.len() < MAX_EQUAL_FRAMES {
            let Some(frame) = source.next_frame()?.filter(|frame| frame.size == self.info.size) else {
                break;
            };
            seen.push(fingerprint(&frame));
            let mut places = self
                .fingerprints
                .windows(seen.len())
                .enumerate()
                .filter(|(_, run)| *run == seen)
                .map(|(at, _)| at);
            let (Some(place), another) = (places.next(), places.next()) else { break };
            let next = (place + seen.len()) as u32;
            if !(next..=next + FAR).contains(&position) {
                break;
            }
            if another.is_none() {
                self.jumps = true;
                self.again = Some(RewoundSource { source, next, jumped: true });
                break;
            }
        }
        Ok(Fetched::OnTheWay)
    }

    fn insert(&mut self, position: u32, frame: Arc<Frame>) {
        self.clock += 1;
        if let Some((_, used)) = self.kept.insert(position, (frame, self.clock)) {
            self.by_use.remove(&used);
        }
        self.by_use.insert(self.clock, position);
        while self.kept.len() > self.room
            && let Some((_, oldest)) = self.by_use.pop_first()
        {
            self.kept.remove(&oldest);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;
    use crate::frame::Size;

    const SIZE: Size = Size::new(4, 2);

    /// Frame at position p is number 10 + 2p, every byte p.
    struct Counting {
        info: SourceInfo,
        next: u32,
        length: u32,
    }

    impl Counting {
        fn boxed(length: u32, live: bool) -> Box<dyn Source> {
            let info = SourceInfo {
                name: "counting".into(),
                size: SIZE,
                fps: 25.0,
                fps_from: crate::source::FpsFrom::Video,
                frames: None,
                live,
            };
            Box::new(Self { info, next: 0, length })
        }
    }

    impl Source for Counting {
        fn info(&self) -> &SourceInfo {
            &self.info
        }

        fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
            self.next += 1;
            Ok((self.next <= self.length).then(|| frame(self.next - 1)))
        }

        fn take_warnings(&mut self) -> Vec<String> {
            if self.next > self.length { vec!["broke off".into()] } else { Vec::new() }
        }
    }

    fn frame(position: u32) -> Frame {
        Frame::new(10 + 2 * position, SIZE, vec![position as u8; SIZE.pixels() * 3])
    }

    fn cache(length: u32, frames: usize, live: bool) -> (FrameCache, Arc<AtomicU32>) {
        let opened = Arc::new(AtomicU32::new(0));
        let count = Arc::clone(&opened);
        let open = move || {
            count.fetch_add(1, Ordering::Relaxed);
            Ok(Counting::boxed(length, live))
        };
        (FrameCache::new(open, frames * SIZE.pixels() * 3).unwrap(), opened)
    }

    #[test]
    fn any_order_gives_the_same_frames_within_the_budget() {
        let (mut cache, _) = cache(40, 6, false);
        let mut position = 7;
        for _ in 0..300 {
            position = (position * 37 + 11) % 45;
            let got = cache.get(position).unwrap();
            let expected = (position < 40).then(|| frame(position));
            assert_eq!(got.as_deref(), expected.as_ref(), "position {position}");
            assert!(cache.kept.len() <= 6 && cache.by_use.len() == cache.kept.len());
        }
        assert!(cache.is_complete());
        assert_eq!(cache.numbers().len(), 40);
        assert_eq!(cache.take_warnings(), ["broke off"]);
    }

    #[test]
    fn what_was_used_last_stays() {
        let (mut cache, opened) = cache(10, 4, false);
        cache.get(2).unwrap();
        cache.kept(0).unwrap();
        cache.get(3).unwrap();
        assert!(cache.kept(0).is_some() && cache.kept(1).is_none());
        assert_eq!(opened.load(Ordering::Relaxed), 1);
        cache.get(1).unwrap().unwrap();
        assert_eq!(opened.load(Ordering::Relaxed), 2, "a dropped frame takes a fresh reader");
    }

    #[test]
    fn a_single_pass_pushes_nothing_out() {
        let (mut cache, _) = cache(10, 4, false);
        cache.get(9).unwrap();
        for position in 0..7 {
            let fetched = cache.fetch(position, Keep::IfRoom).unwrap();
            assert_eq!(fetched, Fetched::Frame(Arc::new(frame(position))));
        }
        assert!((7..10).all(|position| cache.kept(position).is_some()));
    }

    #[test]
    fn a_step_decodes_one_frame() {
        let (mut cache, _) = cache(10, 3, false);
        for _ in 0..4 {
            assert_eq!(cache.fetch(4, Keep::Yes).unwrap(), Fetched::OnTheWay);
        }
        assert_eq!(cache.fetch(4, Keep::Yes).unwrap(), Fetched::Frame(Arc::new(frame(4))));
        assert_eq!(cache.numbers(), [10, 12, 14, 16, 18]);
    }

    #[test]
    fn a_live_frame_that_was_dropped_is_gone() {
        let (mut cache, opened) = cache(10, 3, true);
        cache.get(5).unwrap().unwrap();
        assert_eq!(cache.fetch(0, Keep::Yes).unwrap(), Fetched::Gone);
        assert_eq!(opened.load(Ordering::Relaxed), 1);
    }

    #[test]
    fn a_source_that_changed_is_an_error() {
        let mut length = 20;
        let open = move || {
            length -= 10;
            Ok(Counting::boxed(length, false))
        };
        let mut cache = FrameCache::new(open, 0).unwrap();
        cache.get(9).unwrap().unwrap();
        let error = cache.get(3).unwrap_err().to_string();
        assert!(error.contains("changed"), "{error}");
    }

    /// A source that jumps: to where it is told plus `off`, and which shows each picture `still` times.
    struct Jumping {
        info: SourceInfo,
        next: i64,
        off: i64,
        still: u32,
        decoded: Arc<AtomicU32>,
    }

    impl Jumping {
        fn at(&self, position: u32) -> Frame {
            let byte = |at: usize| (position / self.still * 31 + at as u32 * 7) as u8;
            Frame::new(1 + position, SIZE, (0..SIZE.pixels() * 3).map(byte).collect())
        }
    }

    impl Source for Jumping {
        fn info(&self) -> &SourceInfo {
            &self.info
        }

        fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
            self.decoded.fetch_add(1, Ordering::Relaxed);
            self.next += 1;
            Ok((self.next <= 250).then(|| self.at(self.next as u32 - 1)))
        }

        fn seek(&mut self, position: u32) -> bool {
            self.next = (i64::from(position) + self.off).clamp(0, 249);
            true
        }

        fn take_warnings(&mut self) -> Vec<String> {
            Vec::new()
        }
    }

    #[test]
    fn wherever_a_jump_lands_the_frame_is_the_right_one() {
        for (off, still, most_decoded) in [
            (0, 1, 80),
            (-13, 1, 110),
            (11, 1, 80),
            (40, 1, 1000),
            (0, 3, 90),
            (0, 20, 1000),
            (-900, 1, 1000),
        ] {
            let decoded = Arc::new(AtomicU32::new(0));
            let count = Arc::clone(&decoded);
            let open = move || {
                let info = SourceInfo {
                    name: "jumping".into(),
                    size: SIZE,
                    fps: 25.0,
                    fps_from: crate::source::FpsFrom::Video,
                    frames: None,
                    live: false,
                };
                Ok(Box::new(Jumping { info, next: 0, off, still, decoded: Arc::clone(&count) })
                    as Box<dyn Source>)
            };
            let mut cache = FrameCache::new(open, 40 * SIZE.pixels() * 3).unwrap();
            cache.get(249).unwrap().unwrap();
            let before = decoded.load(Ordering::Relaxed);
            for position in [150, 149, 148, 140, 130, 90, 91, 10] {
                let frame = cache.get(position).unwrap().unwrap();
                let byte = (position / still * 31) as u8;
                assert_eq!((frame.number, frame.rgb[0]), (position + 1, byte), "off {off}, still {still}");
            }
            let again = decoded.load(Ordering::Relaxed) - before;
            assert!(again <= most_decoded, "off {off}, still {still}: {again} decoded again");
        }
    }
}
