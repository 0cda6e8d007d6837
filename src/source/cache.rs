//! Decoded frames by position in the sequence, within a memory budget.
//!
//! A source is read from the first frame to the last, a little ahead of the requested position. An evicted frame is
//! decoded again by a second reader, [`RandomAccess`]; a third one decodes the frames before the one in view while the user
//! steps back.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Duration;

use lru::LruCache;

use super::ahead::{Ahead, Decoded};
use super::random_access::{Fingerprint, RandomAccess, Step, fingerprint};
use super::step_back::StepBackReader;
use super::{Options, Source, SourceError, SourceInfo};
use crate::frame::Frame;
use crate::registration::{Alignment, Registered};

/// The result of one step towards a frame.
#[derive(Debug, PartialEq)]
pub enum Fetched {
    /// The frame.
    Frame(Arc<Frame>),
    /// One earlier frame was decoded; call again.
    OnTheWay,
    /// The sequence ends before the frame.
    End,
    /// A frame of a live source that is no longer cached and cannot be read again.
    Gone,
}

/// Whether a frame that is decoded again may evict others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// It may: the frame or its neighbours are likely to be requested again.
    Yes,
    /// Only where there is room: for a single pass over the sequence that needs each frame once.
    IfRoom,
}

/// Number of frames before the target at which a seek aims, because stepping back requests those next.
const RUN_UP_FRAMES: u32 = 24;
/// The longest that is waited for a live source at once: the caller has other work.
const MAX_LIVE_WAIT: Duration = Duration::from_millis(20);
/// Largest number of frames that are decoded ahead.
const MAX_FRAMES_AHEAD: usize = 32;
/// Smallest and largest number of frames that are decoded at once for steps back. A run takes the time to decode from
/// its key frame on: the longer it is, the less of that falls to each frame.
const RUN_FRAMES: (usize, usize) = (4, 64);
/// Largest number of frames between two frames in view that are a step back.
const MAX_STEP_BACK: u32 = 8;

/// Random access to the frames of a source.
pub struct FrameCache {
    info: Arc<SourceInfo>,
    /// The reader at the furthest position, `numbers.len()`.
    front: Ahead<(Frame, Fingerprint)>,
    numbers: Vec<u32>,
    /// The time of each frame in seconds since the first.
    times: Vec<f64>,
    fingerprints: Vec<Fingerprint>,
    /// The alignment of each frame to those before it.
    alignments: Vec<Alignment>,
    complete: bool,
    /// The error that ended the sequence, returned to the next request for a frame.
    failed: Option<SourceError>,
    /// The reader of evicted frames; `None` for a live source.
    random_access: Option<Box<dyn RandomAccess>>,
    /// The reader of frames for steps back.
    step_back: StepBackReader,
    /// Number of frames that it reads at once; 0 where there is no room for them.
    run_frames: u32,
    /// The position of the frame in view.
    viewed: u32,
    /// Number of frames that may be cached, those decoded for steps back included.
    room: usize,
    /// Decoded frames by position.
    kept: LruCache<u32, Arc<Frame>>,
    warnings: Vec<String>,
}

impl FrameCache {
    /// Opens the source of this name and caches up to `budget` bytes of its frames, at least two frames.
    pub fn open(name: &str, options: Options, budget: usize) -> Result<Self, SourceError> {
        let source = super::open(name, options)?;
        let random_access = source.random_access();
        Self::with_readers(source, random_access, budget)
    }

    /// Caches up to `budget` bytes of the frames of the source that `open` returns. `open` is called again when
    /// evicted frames of a source without [`Source::random_access`] are requested.
    #[cfg(test)]
    pub(crate) fn new(
        mut open: impl FnMut() -> Result<Box<dyn Source>, SourceError> + Send + 'static,
        budget: usize,
    ) -> Result<Self, SourceError> {
        use super::reopened::ReopenedSource;

        let source = open()?;
        let name = source.info().name.clone();
        let random_access =
            source.random_access().unwrap_or_else(|| Box::new(ReopenedSource::new(Box::new(open), &name)));
        Self::with_readers(source, Some(random_access), budget)
    }

    fn with_readers(
        source: Box<dyn Source>,
        random_access: Option<Box<dyn RandomAccess>>,
        budget: usize,
    ) -> Result<Self, SourceError> {
        let info = Arc::new(source.info().clone());
        let step_back = StepBackReader::new(source.random_access());
        let front: Box<dyn Source> = Box::new(Registered::new(source));
        let frame_bytes = (info.size.pixels() * 3).max(1);
        let room = budget / frame_bytes;
        let ahead = (room / 4).clamp(1, if info.live { 2 } else { MAX_FRAMES_AHEAD });
        let (least, most) = RUN_FRAMES;
        let run_frames = if info.live || room / 3 < least { 0 } else { (room / 3).min(most) };
        let with_fingerprint = |frame| {
            let fingerprint = fingerprint(&frame);
            (frame, fingerprint)
        };
        let front = Ahead::start(front, ahead, || false, with_fingerprint).map_err(|error| {
            SourceError::unusable(&info.name, format!("no thread to decode it can be started ({error})"))
        })?;
        // `LruCache::new` would allocate for all frames of the budget, which a short sequence never has.
        let mut kept = LruCache::unbounded();
        let room = room.saturating_sub(ahead).max(2);
        kept.resize(capacity(room));
        Ok(Self {
            info,
            front,
            numbers: Vec::new(),
            times: Vec::new(),
            fingerprints: Vec::new(),
            alignments: Vec::new(),
            complete: false,
            failed: None,
            random_access,
            step_back,
            run_frames: run_frames as u32,
            viewed: 0,
            room,
            kept,
            warnings: Vec::new(),
        })
    }

    /// The description of the source.
    pub fn info(&self) -> &Arc<SourceInfo> {
        &self.info
    }

    /// Maximum number of cached frames.
    pub fn room(&self) -> usize {
        self.kept.cap().get()
    }

    /// The frame numbers of the positions known so far.
    pub fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// The times of the positions known so far, in seconds since the first frame.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The alignment of the frames of the known positions to those before them.
    pub fn alignments(&self) -> &[Alignment] {
        &self.alignments
    }

    /// The positions whose decoded frames are cached, as inclusive ranges in ascending order.
    pub fn kept_ranges(&self) -> Vec<(u32, u32)> {
        let mut positions: Vec<u32> = self.kept.iter().map(|(position, _)| *position).collect();
        positions.sort_unstable();
        let ranges = positions.chunk_by(|a, b| a + 1 == *b);
        ranges.filter_map(|range| Some((*range.first()?, *range.last()?))).collect()
    }

    /// Whether the end is known: there are no frames but those of [`Self::numbers`].
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Takes the warnings since the last call, of problems that did not end the sequence.
    pub fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    /// Drops all frames of a live source: its next frame is at position 0.
    pub fn forget(&mut self) {
        if self.info.live {
            self.numbers.clear();
            self.times.clear();
            self.fingerprints.clear();
            self.alignments.clear();
            self.kept.clear();
        }
    }

    /// Whether the frame at `position` is cached.
    pub fn has(&self, position: u32) -> bool {
        self.kept.contains(&position)
    }

    /// The frame at `position` if it is cached; counts as a use.
    pub fn kept(&mut self, position: u32) -> Option<Arc<Frame>> {
        self.kept.get(&position).cloned()
    }

    /// The frame at `position` if it is cached, or is the next of the sequence and already decoded.
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

    /// Makes one step towards the frame at `position`, from 0: decodes at most one frame, so that the caller can do
    /// other work in between. Fails if the source cannot be read.
    pub fn fetch(&mut self, position: u32, keep: Keep) -> Result<Fetched, SourceError> {
        if let Some(frame) = self.kept(position) {
            return Ok(Fetched::Frame(frame));
        }
        if position as usize >= self.numbers.len() {
            return self.fetch_ahead(position);
        }
        if keep == Keep::Yes && self.step_back.covers(position) {
            match self.step_back.next() {
                Some(Step::Frame(here, frame)) => return Ok(self.take_again(here, frame, position, true)),
                Some(Step::OnTheWay) => return Ok(Fetched::OnTheWay),
                None => {}
            }
        }
        self.fetch_again(position, keep)
    }

    /// Tells that the frame at `position`, a known one, is in view. After a step back the frames before it that are not
    /// cached are decoded on a thread, so that further steps back find them; they take up to a third of the budget.
    pub fn view(&mut self, position: u32) {
        let before = std::mem::replace(&mut self.viewed, position);
        let is_step_back = position < before && before - position <= MAX_STEP_BACK;
        if !is_step_back || self.run_frames == 0 {
            return;
        }
        let wanted_frames = position.saturating_sub(self.run_frames)..position;
        if wanted_frames.clone().any(|at| self.step_back.covers(at)) {
            return;
        }
        if let Some(last) = wanted_frames.clone().rfind(|at| !self.kept.contains(at)) {
            // Those that are next, not those that were used last, are to remain.
            for at in wanted_frames {
                self.kept.promote(&at);
            }
            self.kept.resize(capacity(self.room - self.run_frames as usize));
            let first = (last + 1).saturating_sub(self.run_frames);
            self.step_back.start(first..last + 1, &self.fingerprints);
        }
    }

    /// The frame at `position`; `None` beyond the end or where a live source's frame is no longer cached.
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
        let next = if self.info.live { self.front.next_within(MAX_LIVE_WAIT) } else { Ok(self.front.next()) };
        let Ok(next) = next else { return Ok(Fetched::OnTheWay) };
        let Some(Decoded { frame, warnings }) = next else {
            return Err(SourceError::unusable(&self.info.name, "its decoder failed; open it again"));
        };
        self.warnings.extend(warnings);
        let Some((frame, fingerprint)) = frame? else {
            self.complete = true;
            return Ok(Fetched::End);
        };
        let here = self.numbers.len() as u32;
        self.numbers.push(frame.number);
        self.times.push(frame.time);
        self.fingerprints.push(fingerprint);
        self.alignments.push(frame.alignment);
        let frame = Arc::new(frame);
        self.kept.put(here, Arc::clone(&frame));
        Ok(if here == position { Fetched::Frame(frame) } else { Fetched::OnTheWay })
    }

    fn fetch_again(&mut self, position: u32, keep: Keep) -> Result<Fetched, SourceError> {
        let run_up = RUN_UP_FRAMES.min(self.room() as u32 / 2);
        let reader = self.random_access.as_mut().filter(|_| !self.info.live);
        let Some(reader) = reader else { return Ok(Fetched::Gone) };
        let step = reader.step(position.saturating_sub(run_up), position, &self.fingerprints);
        self.warnings.extend(reader.take_warnings());
        let Step::Frame(here, frame) = step? else { return Ok(Fetched::OnTheWay) };
        let is_near = position.abs_diff(here) as usize <= self.room() / 2;
        Ok(self.take_again(here, frame, position, keep == Keep::Yes && is_near))
    }

    /// Takes a frame at `here`, on the way to the one at `position`. It may evict others, or is cached where there is
    /// room.
    fn take_again(&mut self, here: u32, mut frame: Frame, position: u32, may_evict: bool) -> Fetched {
        (frame.number, frame.time) = (self.numbers[here as usize], self.times[here as usize]);
        // The alignment was measured when all earlier frames had been read.
        frame.alignment = self.alignments[here as usize];
        let frame = Arc::new(frame);
        if may_evict || self.kept.len() < self.room() {
            self.kept.put(here, Arc::clone(&frame));
        }
        if here == position { Fetched::Frame(frame) } else { Fetched::OnTheWay }
    }
}

fn capacity(frames: usize) -> NonZeroUsize {
    NonZeroUsize::new(frames).unwrap_or(NonZeroUsize::MIN)
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
                pixel_aspect: None,
                fps: 25.0,
                fps_from: crate::source::FpsFrom::Video,
                frames: None,
                live,
                reduction: None,
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
    fn frames_are_the_same_in_any_order_within_the_budget() {
        let (mut cache, _) = cache(40, 6, false);
        let mut position = 7;
        for _ in 0..300 {
            position = (position * 37 + 11) % 45;
            let got = cache.get(position).unwrap();
            let expected = (position < 40).then(|| frame(position));
            assert_eq!(got.as_deref(), expected.as_ref(), "position {position}");
            assert!(cache.kept.len() <= 6);
        }
        assert!(cache.is_complete());
        assert_eq!(cache.numbers().len(), 40);
        assert_eq!(cache.take_warnings(), ["broke off"]);
    }

    #[test]
    fn the_least_recently_used_frame_is_evicted() {
        let (mut cache, opened) = cache(10, 4, false);
        cache.get(2).unwrap();
        cache.kept(0).unwrap();
        cache.get(3).unwrap();
        assert!(cache.kept(0).is_some() && cache.kept(1).is_none());
        assert_eq!(opened.load(Ordering::Relaxed), 1);
        cache.get(1).unwrap().unwrap();
        assert_eq!(opened.load(Ordering::Relaxed), 2, "an evicted frame needs a second reader");
    }

    #[test]
    fn a_single_pass_evicts_nothing() {
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
    fn an_evicted_live_frame_cannot_be_read_again() {
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

    /// A source of 250 frames whose second reader seeks.
    struct Jumping {
        info: SourceInfo,
        next: u32,
        decoded: Arc<AtomicU32>,
    }

    impl Jumping {
        fn read(&mut self) -> Option<Frame> {
            self.decoded.fetch_add(1, Ordering::Relaxed);
            self.next += 1;
            (self.next <= 250).then(|| frame(self.next - 1))
        }
    }

    impl Source for Jumping {
        fn info(&self) -> &SourceInfo {
            &self.info
        }

        fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
            Ok(self.read())
        }

        fn random_access(&self) -> Option<Box<dyn RandomAccess>> {
            let (info, decoded) = (self.info.clone(), Arc::clone(&self.decoded));
            Some(Box::new(Self { info, next: 0, decoded }))
        }

        fn take_warnings(&mut self) -> Vec<String> {
            Vec::new()
        }
    }

    impl RandomAccess for Jumping {
        fn step(&mut self, from: u32, goal: u32, fingerprints: &[Fingerprint]) -> Result<Step, SourceError> {
            if !(from..=goal).contains(&self.next) {
                self.next = from;
                return Ok(Step::OnTheWay);
            }
            let mut frame = self.read().unwrap();
            assert_eq!(fingerprint(&frame), fingerprints[self.next as usize - 1]);
            frame.number = 0;
            Ok(Step::Frame(self.next - 1, frame))
        }
    }

    fn jumping(frames: usize) -> (FrameCache, Arc<AtomicU32>) {
        let decoded = Arc::new(AtomicU32::new(0));
        let count = Arc::clone(&decoded);
        let open = move || {
            let info = SourceInfo {
                name: "jumping".into(),
                size: SIZE,
                pixel_aspect: None,
                fps: 25.0,
                fps_from: crate::source::FpsFrom::Video,
                frames: None,
                live: false,
                reduction: None,
            };
            Ok(Box::new(Jumping { info, next: 0, decoded: Arc::clone(&count) }) as Box<dyn Source>)
        };
        (FrameCache::new(open, frames * SIZE.pixels() * 3).unwrap(), decoded)
    }

    #[test]
    fn steps_back_find_frames_that_a_thread_decoded() {
        let (mut cache, _) = jumping(60);
        cache.get(249).unwrap().unwrap();
        for position in (0..249).rev() {
            assert_eq!(cache.get(position).unwrap().as_deref(), Some(&frame(position)));
            cache.view(position);
            let is_ready = |at: u32| cache.has(at) || cache.step_back.covers(at);
            assert!((position.saturating_sub(20)..position).all(is_ready), "before {position}");
        }
        assert_eq!(cache.room(), 60 - 15 - 20, "a quarter is for frames ahead, a third for those behind");
        // Frames that are not before the one in view are decoded as usual.
        for position in [200, 120, 119, 240, 239, 230, 10] {
            assert_eq!(cache.get(position).unwrap().as_deref(), Some(&frame(position)));
            cache.view(position);
        }
    }

    #[test]
    fn nothing_is_decoded_for_steps_back_without_room_or_after_a_jump() {
        let (mut cache, _) = jumping(11);
        cache.get(249).unwrap().unwrap();
        cache.view(249);
        cache.view(248);
        assert!((0..250).all(|at| !cache.step_back.covers(at)));
        let (mut cache, _) = jumping(60);
        cache.get(249).unwrap().unwrap();
        for position in [249, 100, 101, 50] {
            cache.view(position);
            assert!((0..250).all(|at| !cache.step_back.covers(at)), "{position}");
        }
    }

    #[test]
    fn a_second_reader_gives_the_requested_frame_and_those_shortly_before_it() {
        let (mut cache, decoded) = jumping(40);
        cache.get(249).unwrap().unwrap();
        let before = decoded.load(Ordering::Relaxed);
        for position in [150, 149, 148, 140, 130, 90, 91, 10] {
            assert_eq!(cache.get(position).unwrap().as_deref(), Some(&frame(position)));
        }
        let again = decoded.load(Ordering::Relaxed) - before;
        assert!(again <= 80, "{again} decoded again");
    }
}
