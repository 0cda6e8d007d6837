//! The frames of a source or of a range of it, decoded ahead.

use std::collections::VecDeque;
use std::iter;

use anyhow::{Context as _, anyhow, bail};

use super::console::Console;
use super::flags::FrameRange;
use super::interrupt;
use crate::frame::Frame;
use crate::mixture::BATCH;
use crate::registration::{CorrectionChoice, Estimator, Registered};
use crate::settings::Settings;
use crate::source::ahead::{Ahead, Decoded};
use crate::source::{self, Options, Source, SourceInfo};

/// Largest and least number of frames decoded ahead, and the memory that limits it in between.
const MAX_FRAMES_AHEAD: usize = 2 * BATCH;
const MIN_FRAMES_AHEAD: usize = 4;
const MAX_BYTES_AHEAD: usize = 256 << 20;

/// An item from a source.
pub(super) enum Item {
    /// The next frame.
    Frame(Frame),
    /// A warning of a problem that did not end the sequence.
    Warning(String),
    /// An error that ends the sequence.
    Failed(anyhow::Error),
    /// The end.
    End,
}

/// Frames that are processed together.
pub(super) struct Batch {
    /// The frames in order.
    pub frames: Vec<Frame>,
    /// The item after them, if it is available and not a frame.
    pub after: Option<Item>,
}

/// Largest memory of frames that are learned from and kept until they are classified; beyond it they are decoded
/// again.
const MAX_KEPT_BYTES: usize = 512 << 20;

/// The frames of a source, or of a range of it.
pub(super) struct Frames {
    /// Properties of the source.
    pub info: SourceInfo,
    /// Number of frames, as far as known.
    pub total: Option<u32>,
    options: Options,
    range: Option<FrameRange>,
    /// The correction of frames before the mixture, if they are measured for it.
    choice: Option<CorrectionChoice>,
    /// Items that were received and come before those of `decoder`.
    held: VecDeque<Item>,
    /// The source; `None` after the last frame of the range or an error.
    decoder: Option<Ahead<Frame>>,
    /// The number of the last frame received up to the end of the range.
    last_number: Option<u32>,
    /// Whether a frame of the range has been received.
    has_begun: bool,
}

impl Frames {
    /// Opens `video` and starts decoding; with `choice`, alignments are estimated as far as it needs them.
    pub(super) fn open(
        video: &str,
        options: Options,
        range: Option<FrameRange>,
        choice: Option<CorrectionChoice>,
    ) -> anyhow::Result<Self> {
        interrupt::watch();
        let source = source::open(video, options)?;
        let info = source.info().clone();
        let of_range = range.map(|range| range.count().div_ceil(info.every()));
        let total = of_range.into_iter().chain(info.frames).min();
        let ahead = MAX_BYTES_AHEAD / (info.size.pixels() * 3).max(1);
        let source: Box<dyn Source> = match choice {
            None => source,
            Some(choice) => {
                let first = range.map_or(0, |range| range.first);
                Box::new(Registered::by(source, Estimator::of(info.size, choice), first))
            }
        };
        // A camera has no end: interrupting it ends the recording.
        let live = info.live;
        let is_stopped = move || live && interrupt::is_stop_requested();
        let ahead = ahead.clamp(MIN_FRAMES_AHEAD, MAX_FRAMES_AHEAD);
        let decoder = Ahead::start(source, ahead, is_stopped, |frame| frame);
        let decoder = Some(decoder.context("no thread can be started; end other programs")?);
        let held = VecDeque::new();
        Ok(Self { info, total, options, range, choice, held, decoder, last_number: None, has_begun: false })
    }

    /// Calls `learn` with the first frames in order, in batches, as many as `settings` have for learning. The
    /// sequence then starts with the first of them again.
    pub(super) fn learn(
        &mut self,
        settings: &Settings,
        console: Console,
        learn: impl FnMut(&[&Frame]) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let most = self.info.bootstrap(settings);
        if self.info.live && settings.bootstrap.frames(self.info.fps) > 0 {
            console.note(&format!(
                "note: {} is a live source: bootstrap is skipped, and the model starts with the first frame",
                self.info.name
            ));
        }
        if most == 0 {
            return Ok(());
        }
        let progress = console.progress("learning", Some(self.total.map_or(most, |total| total.min(most))));
        self.learn_first(most, learn, |count| progress.advance(count))
    }

    /// Calls `learn` with the first frames in order, in batches, up to `most`, and `advance` with the size of each batch.
    /// The sequence then starts with the first of them again.
    pub(super) fn learn_first(
        &mut self,
        most: u32,
        mut learn: impl FnMut(&[&Frame]) -> anyhow::Result<()>,
        advance: impl Fn(usize),
    ) -> anyhow::Result<()> {
        self.learn_within(MAX_KEPT_BYTES, most, |frames| {
            advance(frames.len());
            learn(frames)
        })
    }

    /// Calls `learn` with the first frames, up to `most`. They are repeated from up to `bytes` of memory, or decoded
    /// again.
    fn learn_within(
        &mut self,
        bytes: usize,
        most: u32,
        mut learn: impl FnMut(&[&Frame]) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let room = bytes / (self.info.size.pixels() * 3).max(1);
        let expected = self.total.map_or(most, |total| total.min(most)) as usize;
        let mut held = (expected <= room).then(VecDeque::new);
        let (mut left, mut over) = (most as usize, false);
        while left > 0 && !over {
            if interrupt::is_stop_requested() {
                bail!("stopped before bootstrap on {} was complete; nothing was written", self.info.name);
            }
            let Batch { frames, after } = self.batch(left.min(BATCH));
            learn(&frames.iter().collect::<Vec<_>>())?;
            left -= frames.len();
            over = matches!(after, Some(Item::End | Item::Failed(_)));
            if let Some(held) = &mut held {
                held.extend(frames.into_iter().map(Item::Frame).chain(after));
            }
            // A video can have more frames than its header says.
            held = held.filter(|held| held.len() <= room + BATCH);
        }
        match held {
            // After the last batch, a frame can have been received together with a warning.
            Some(mut held) => {
                held.append(&mut self.held);
                self.held = held;
            }
            // Without the kept frames, the decoder is already past them.
            None => *self = Self::open(&self.info.name, self.options, self.range, self.choice)?,
        }
        Ok(())
    }

    /// The available frames, up to `most` and, unless another item comes first, at least one.
    pub(super) fn batch(&mut self, most: usize) -> Batch {
        let mut frames = Vec::new();
        while frames.len() < most && (frames.is_empty() || self.is_ready()) {
            match self.next() {
                Item::Frame(frame) => frames.push(frame),
                other => return Batch { frames, after: Some(other) },
            }
        }
        Batch { frames, after: None }
    }

    /// All remaining frames and other items, in order.
    pub(super) fn items(&mut self) -> impl Iterator<Item = Item> {
        let mut is_over = false;
        iter::from_fn(move || {
            if is_over {
                return None;
            }
            let item = self.next();
            is_over = matches!(item, Item::Failed(_) | Item::End);
            (!matches!(item, Item::End)).then_some(item)
        })
    }

    /// The next item. Blocks until a frame of the range is decoded.
    fn next(&mut self) -> Item {
        loop {
            if let Some(item) = self.held.pop_front() {
                return item;
            }
            let decoded = self.decoder.as_ref().and_then(Ahead::next);
            self.receive(decoded);
        }
    }

    /// Whether [`Self::next`] would return without blocking, once the range has begun.
    fn is_ready(&self) -> bool {
        !self.held.is_empty() || self.decoder.as_ref().is_some_and(Ahead::is_ready)
    }

    /// Adds the items that the decoded frame gives within the range to `held`.
    fn receive(&mut self, decoded: Option<Decoded<Frame>>) {
        let name = &self.info.name;
        let Some(Decoded { frame, warnings }) = decoded else {
            self.held.push_back(Item::Failed(anyhow!("decoding {name} failed")));
            self.decoder = None;
            return;
        };
        self.held.extend(warnings.into_iter().map(Item::Warning));
        let range = self.range;
        match frame {
            Ok(Some(frame)) if range.is_none_or(|range| frame.number <= range.last) => {
                self.last_number = Some(frame.number);
                if range.is_none_or(|range| frame.number >= range.first) {
                    self.has_begun = true;
                    self.held.push_back(Item::Frame(frame));
                    return;
                }
                if !interrupt::is_stop_requested() {
                    return;
                }
                self.held.push_back(Item::Failed(anyhow!("stopped; nothing was written")));
            }
            Ok(Some(_)) if self.has_begun => self.held.push_back(Item::End),
            Ok(beyond) => {
                let next = beyond.map(|frame| frame.number);
                let last = self.last_number.filter(|_| next.is_none());
                self.held.extend(at_the_end(&self.info, range, Around { last, next }, self.has_begun));
                self.held.push_back(Item::End);
            }
            Err(error) => self.held.push_back(Item::Failed(error.into())),
        }
        self.decoder = None;
    }
}

/// The frame numbers around the end of what was received.
struct Around {
    /// That of the last frame of the source, if it ended.
    last: Option<u32>,
    /// That of the first frame after the range, if there is one.
    next: Option<u32>,
}

/// The error of a sequence without frames in its range, or the warning of one that ended before its range did.
fn at_the_end(
    info: &SourceInfo,
    range: Option<FrameRange>,
    Around { last, next }: Around,
    has_begun: bool,
) -> Option<Item> {
    let name = &info.name;
    let failed = |why: String| Some(Item::Failed(anyhow!(why)));
    // Frames that are left out can follow the last one.
    let left_out = info.every() - 1;
    match (range, last) {
        (None, None) => failed(format!("{name} has no frames that can be read")),
        (Some(range), Some(last)) if last.saturating_add(left_out) < range.first => failed(format!(
            "the range {range} starts beyond the end of {name}, whose last frame is {last}; choose an earlier start"
        )),
        (Some(range), _) if !has_begun => {
            let every = info.every();
            let next = next.map(|next| format!("; the next frame is {next}")).unwrap_or_default();
            let why = format!("; --every {every} counts from the source's first frame");
            let why = Some(why).filter(|_| every > 1).unwrap_or_default();
            failed(format!("{name} has no frames in the range {range}{next}{why}; choose another range"))
        }
        (Some(range), Some(last)) if last.saturating_add(left_out) < range.last => {
            Some(Item::Warning(format!("the range {range} is truncated at {last}, the last frame of {name}")))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    const PICTURES: u32 = 40;

    /// Frame numbers, and W for a warning.
    fn text_of(item: &Item) -> String {
        match item {
            Item::Frame(frame) => frame.number.to_string(),
            Item::Warning(_) => "W".to_owned(),
            Item::Failed(error) => error.to_string(),
            Item::End => "end".to_owned(),
        }
    }

    #[test]
    fn learned_frames_are_repeated_from_memory_or_decoded_again() {
        let folder = tempfile::tempdir().unwrap();
        for number in 1..=PICTURES {
            let path = folder.path().join(format!("{number:03}.png"));
            if number == 7 || number == 30 {
                std::fs::write(path, "broken").unwrap();
            } else {
                image::RgbImage::from_pixel(6, 4, image::Rgb([number as u8; 3])).save(path).unwrap();
            }
        }
        let video = folder.path().to_str().unwrap();
        let readable = |number: &u32| ![7, 30].contains(number);
        for range in [None, Some(FrameRange { first: 5, last: 20 }), Some(FrameRange { first: 35, last: 90 })]
        {
            let expected: Vec<_> = Frames::open(video, Options::default(), range, None)
                .unwrap()
                .items()
                .map(|item| text_of(&item))
                .collect();
            let first = range.map_or(1, |range| range.first);
            let numbers: Vec<_> =
                (first..=range.map_or(PICTURES, |range| range.last.min(PICTURES))).filter(readable).collect();
            for (bytes, most) in
                [(1 << 20, 0), (1 << 20, 11), (0, 11), (1 << 20, 500), (0, 500), (10 * 72, 11)]
            {
                let mut frames = Frames::open(video, Options::default(), range, None).unwrap();
                let mut learned = Vec::new();
                let learn = |frames: &[&Frame]| {
                    learned.extend(frames.iter().map(|frame| frame.number));
                    Ok(())
                };
                frames.learn_within(bytes, most, learn).unwrap();
                assert_eq!(learned, numbers[..numbers.len().min(most as usize)], "{range:?} {bytes} {most}");
                let batch = frames.batch(3);
                let first: Vec<_> = batch.frames.into_iter().map(Item::Frame).chain(batch.after).collect();
                let rest: Vec<_> = frames.items().collect();
                let again: Vec<_> = first.iter().chain(&rest).map(text_of).collect();
                assert_eq!(again, expected, "{range:?} {bytes} {most}");
            }
        }
        let beyond = Some(FrameRange { first: 90, last: 95 });
        let mut frames = Frames::open(video, Options::default(), beyond, None).unwrap();
        let learn = |frames: &[&Frame]| {
            assert!(frames.is_empty());
            Ok(())
        };
        frames.learn_within(1 << 20, 10, learn).unwrap();
        assert!(frames.items().any(|item| text_of(&item).contains("starts beyond the end")));
    }

    #[test]
    fn a_range_in_a_gap_of_the_numbers_has_no_frames() {
        let folder = tempfile::tempdir().unwrap();
        for number in [1, 2, 50, 51] {
            image::RgbImage::new(6, 4).save(folder.path().join(format!("{number:03}.png"))).unwrap();
        }
        let video = folder.path().to_str().unwrap();
        let items = |first, last| -> Vec<_> {
            let mut frames =
                Frames::open(video, Options::default(), Some(FrameRange { first, last }), None).unwrap();
            frames.items().map(|item| text_of(&item)).collect()
        };
        assert_eq!(items(2, 20), ["2"]);
        let none = |range: &str, next: u32| {
            [format!(
                "{video} has no frames in the range {range}; the next frame is {next}; choose another range"
            )]
        };
        assert_eq!(items(20, 30), none("20..30", 50));
        assert_eq!(items(0, 0), none("0..0", 1));
        let beyond = &items(60, 70)[..];
        assert!(matches!(beyond, [error] if error.contains("starts beyond the end")), "{beyond:?}");
    }
}
