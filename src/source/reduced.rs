//! A source of fewer or smaller frames than those of another.

use std::sync::{Arc, Mutex, PoisonError};

use super::random_access::{Fingerprint, RandomAccess, Step, UNCHECKED, fingerprint};
use super::{FPS_RANGE, Options, Reduction, Source, SourceError, SourceInfo};
use crate::frame::Frame;
use crate::placement::Placement;

/// The fingerprints of the inner source's frames so far; [`UNCHECKED`] for skipped ones.
type SharedFingerprints = Arc<Mutex<Vec<Fingerprint>>>;

/// The frames of another source, or each N-th of them, cropped and scaled.
pub(super) struct Reduced {
    source: Box<dyn Source>,
    info: SourceInfo,
    reduction: Reduction,
    /// Whether the first frame was read.
    has_begun: bool,
    fingerprints: SharedFingerprints,
}

impl Reduced {
    /// The source with these options for its frames; itself where nothing is reduced. Fails where the crop reaches
    /// beyond the images, or frames are so far apart that their rate is below the least.
    pub(super) fn of(source: Box<dyn Source>, options: Options) -> Result<Box<dyn Source>, SourceError> {
        let whole = source.info();
        let placement = Placement::new(whole.size, options.crop, options.scale);
        let placement = placement.ok_or_else(|| beyond(whole, options))?;
        let every = options.every.map_or(1, u32::from);
        if placement.is_identity() && every == 1 {
            return Ok(source);
        }
        let fps = whole.fps / every as f32;
        if fps < FPS_RANGE.0 {
            return Err(SourceError::unusable(
                &whole.name,
                format!(
                    "one of {every} frames at {} frames per second is less than {} per second; use a smaller --every",
                    whole.fps, FPS_RANGE.0
                ),
            ));
        }
        let reduction = Reduction { placement, every, fps: whole.fps };
        let info = SourceInfo {
            size: placement.size(),
            fps,
            frames: whole.frames.map(|frames| frames.div_ceil(every)),
            reduction: Some(reduction),
            ..whole.clone()
        };
        Ok(Box::new(Self { source, info, reduction, has_begun: false, fingerprints: Arc::default() }))
    }

    /// Records the next fingerprint if there is a second reader, which needs it.
    fn record(&self, fingerprint: impl FnOnce() -> Fingerprint) {
        if Arc::strong_count(&self.fingerprints) > 1 {
            let fingerprint = fingerprint();
            self.fingerprints.lock().unwrap_or_else(PoisonError::into_inner).push(fingerprint);
        }
    }
}

fn beyond(whole: &SourceInfo, options: Options) -> SourceError {
    let crop = options.crop.map_or_else(String::new, |crop| crop.to_string());
    SourceError::unusable(
        &whole.name,
        format!(
            "the crop {crop} (x, y, width, height) reaches beyond its images, which are {}; choose a part of them",
            whole.size
        ),
    )
}

/// The frame of an image of the source.
fn frame_of(image: Frame, placement: &Placement) -> Frame {
    if placement.is_identity() { image } else { placement.frame(&image) }
}

impl Source for Reduced {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        if self.has_begun {
            for _ in 1..self.reduction.every {
                if !self.source.skip_frame()? {
                    return Ok(None);
                }
                self.record(|| UNCHECKED);
            }
        }
        self.has_begun = true;
        let Some(image) = self.source.next_frame()? else { return Ok(None) };
        self.record(|| fingerprint(&image));
        Ok(Some(frame_of(image, &self.reduction.placement)))
    }

    fn random_access(&self) -> Option<Box<dyn RandomAccess>> {
        // Fingerprints are recorded from now on.
        let inner = self.source.random_access().filter(|_| !self.has_begun)?;
        let shared = Arc::clone(&self.fingerprints);
        Some(Box::new(ReducedAccess { inner, reduction: self.reduction, shared, fingerprints: Vec::new() }))
    }

    fn take_warnings(&mut self) -> Vec<String> {
        self.source.take_warnings()
    }
}

/// A second reader of a [`Reduced`] source.
struct ReducedAccess {
    inner: Box<dyn RandomAccess>,
    reduction: Reduction,
    shared: SharedFingerprints,
    /// A copy of the shared ones, so that the first reader does not wait for a step.
    fingerprints: Vec<Fingerprint>,
}

impl RandomAccess for ReducedAccess {
    fn step(&mut self, from: u32, goal: u32, _: &[Fingerprint]) -> Result<Step, SourceError> {
        let known = self.fingerprints.len();
        let shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        self.fingerprints.extend_from_slice(&shared[known..]);
        drop(shared);
        let every = self.reduction.every;
        // As many images of the source as frames are wanted: more would be decoded to be skipped.
        let goal_image = goal * every;
        Ok(match self.inner.step(goal_image - (goal - from), goal_image, &self.fingerprints)? {
            Step::Frame(position, image) if position.is_multiple_of(every) => {
                Step::Frame(position / every, frame_of(image, &self.reduction.placement))
            }
            Step::Frame(..) | Step::OnTheWay => Step::OnTheWay,
        })
    }

    fn take_warnings(&mut self) -> Vec<String> {
        self.inner.take_warnings()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::num::NonZeroU32;
    use std::path::Path;

    use image::{Rgb, RgbImage};

    use super::*;
    use crate::frame::Size;
    use crate::placement::Crop;
    use crate::source::cache::FrameCache;
    use crate::source::{FpsFrom, open};

    const IMAGES: u32 = 23;
    const OPTIONS: Options = Options {
        scale: Some(0.5),
        every: NonZeroU32::new(4),
        crop: Some(Crop { x: 3, y: 2, width: 10, height: 6 }),
        ..Options::AS_IS
    };

    /// Images 101…123 of 16×12 pixels, each with its own values.
    fn write_images(folder: &Path) {
        for number in 101..101 + IMAGES {
            let value = |x: u32, y: u32| [(x * 9 + number) as u8, (y * 17 + number * 3) as u8, (x * y) as u8];
            let image = RgbImage::from_fn(16, 12, |x, y| Rgb(value(x, y)));
            image.save(folder.join(format!("in{number}.png"))).unwrap();
        }
    }

    fn read_all(name: &str, options: Options) -> Vec<Frame> {
        let mut source = open(name, options).unwrap();
        std::iter::from_fn(|| source.next_frame().unwrap()).collect()
    }

    #[test]
    fn frames_are_left_out_cut_and_scaled_and_keep_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        write_images(folder.path());
        let name = folder.path().to_str().unwrap();
        let source = open(name, OPTIONS).unwrap();
        let info = source.info();
        assert_eq!((info.size, info.frames, info.fps), (Size::new(5, 3), Some(6), 6.25));
        assert_eq!((info.source_size(), info.source_fps(), info.every()), (Size::new(16, 12), 25.0, 4));
        assert_eq!(info.fps_from, FpsFrom::Assumed);
        let (whole, reduced) = (read_all(name, Options::default()), read_all(name, OPTIONS));
        let numbers: Vec<_> = reduced.iter().map(|frame| frame.number).collect();
        assert_eq!(numbers, [101, 105, 109, 113, 117, 121]);
        for (frame, image) in reduced.iter().zip(whole.iter().step_by(4)) {
            assert_eq!(*frame, info.placement().unwrap().frame(image));
        }
        // A given rate is that of the source.
        let options = Options { fps: Some(10.0), ..OPTIONS };
        assert_eq!(open(name, options).unwrap().info().fps, 2.5);
        let options = Options { scale: None, crop: None, ..OPTIONS };
        assert_eq!(read_all(name, options)[3], whole[12]);
    }

    #[test]
    fn an_unreadable_image_is_left_out_before_others_are_counted() {
        let folder = tempfile::tempdir().unwrap();
        write_images(folder.path());
        std::fs::write(folder.path().join("in103.png"), "broken").unwrap();
        let mut source = open(folder.path().to_str().unwrap(), OPTIONS).unwrap();
        let frames: Vec<_> = std::iter::from_fn(|| source.next_frame().unwrap()).collect();
        assert_eq!([frames[0].number, frames[1].number, frames[2].number], [101, 106, 110]);
        let warnings = source.take_warnings();
        assert!(warnings.len() == 1 && warnings[0].starts_with("frame 103 is skipped"), "{warnings:?}");
    }

    #[test]
    fn evicted_frames_are_the_same_again() {
        let folder = tempfile::tempdir().unwrap();
        write_images(folder.path());
        let video = folder.path().join("video.mp4");
        let pattern = folder.path().join("in%03d.png");
        let status = std::process::Command::new("ffmpeg")
            .args(["-loglevel", "error", "-start_number", "101", "-i"])
            .arg(&pattern)
            .args(["-pix_fmt", "yuv420p", "-g", "6"])
            .arg(&video)
            .status();
        assert!(status.unwrap().success());
        for name in [folder.path().to_str().unwrap(), video.to_str().unwrap()] {
            for options in [OPTIONS, Options { every: NonZeroU32::new(3), ..Options::default() }] {
                let frames = read_all(name, options);
                let last = frames.len() as u32 - 1;
                let mut cache = FrameCache::open(name, options, 0).unwrap();
                for position in (0..=last).chain([0, last, 2, 1, last - 1, 0]) {
                    let frame = cache.get(position).unwrap().unwrap();
                    assert_eq!(*frame, frames[position as usize], "{name}: {position}");
                    assert_eq!(frame.number, frames[position as usize].number);
                }
                assert_eq!(cache.get(last + 1).unwrap(), None);
                assert_eq!(cache.take_warnings(), Vec::<String>::new());
            }
        }
    }

    #[test]
    fn a_crop_beyond_the_images_and_too_few_frames_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        write_images(folder.path());
        let name = folder.path().to_str().unwrap();
        let refused = |options| open(name, options).map(|_| ()).unwrap_err().to_string();
        let crop = Some(Crop { x: 10, y: 0, width: 7, height: 5 });
        let error = refused(Options { crop, ..Options::default() });
        assert!(error.contains("crop 10,0,7,5") && error.contains("16×12"), "{error}");
        let error = refused(Options { every: NonZeroU32::new(501), ..Options::default() });
        assert!(error.contains("--every") && !error.contains('\n'), "{error}");
    }
}
