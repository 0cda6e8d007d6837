//! What was read of a video so far, and the warnings that follow from it.

use super::reader::{PictureInfo, Reader};
use crate::frame::Size;
use crate::source::SourceInfo;

/// A warning after the name of an interlaced video.
pub(super) const INTERLACED: &str = "is interlaced: every other line of a frame is from another time, so moving edges \
                                     look like combs; use --deinterlace for exact outlines";

/// The pictures whose frames were given so far.
#[derive(Debug, Default)]
pub(super) struct Progress {
    /// Number of pictures.
    pub(super) frames: u32,
    /// Whether it was told that the video is interlaced, or does not matter.
    knows_interlaced: bool,
    /// The earliest and the latest time.
    times: Option<(i64, i64)>,
    /// Size of the first picture in the stream.
    size: Option<Size>,
    has_resized: bool,
    damaged: u32,
    first_damaged: Option<u32>,
}

impl Progress {
    /// No pictures. It tells of interlaced ones unless `knows_interlaced`.
    pub(super) fn new(knows_interlaced: bool) -> Self {
        Self { knows_interlaced, ..Self::default() }
    }

    /// Adds the next picture; returns warnings where it is the first of another size, or the first interlaced one.
    pub(super) fn add(&mut self, picture: &PictureInfo, info: &SourceInfo) -> Vec<String> {
        self.frames += 1;
        let pts = picture.time.pts;
        self.times = Some(self.times.map_or((pts, pts), |(first, last)| (first.min(pts), last.max(pts))));
        if picture.is_damaged {
            self.damaged += 1;
            self.first_damaged.get_or_insert(self.frames);
        }
        let mut warnings = Vec::new();
        if picture.is_interlaced && !std::mem::replace(&mut self.knows_interlaced, true) {
            warnings.push(format!("{} {INTERLACED}", info.name));
        }
        let size = picture.coded_size;
        let before = *self.size.get_or_insert(size);
        if before != size && !std::mem::replace(&mut self.has_resized, true) {
            warnings.push(format!(
                "{} changes its size from {before} to {size} at frame {}; frames of another size are scaled to {}",
                info.name, self.frames, info.size
            ));
        }
        warnings
    }

    /// The warnings after the last picture: of damage, and of an end before that which the header announces.
    pub(super) fn at_end(&self, info: &SourceInfo, reader: &Reader) -> Vec<String> {
        let Self { frames, damaged, .. } = *self;
        let name = &info.name;
        let stream = reader.info();
        let (first, last) = self.times.unwrap_or_default();
        // The length in a header may begin at 0, before a start that is later.
        let first = stream.start.map_or(first, |start| start.min(first)).min(0);
        let seconds = last.saturating_sub(first) as f64 * stream.time_base.value();
        let fps = stream.rate.unwrap_or(f64::from(info.fps));
        let expected = info.frames.filter(|&expected| is_clearly_short(frames, expected, seconds, fps));
        let mut warnings = Vec::new();
        if let Some(expected) = expected {
            let missing = expected - frames;
            let missing_seconds = f64::from(missing) / fps;
            warnings.push(format!(
                "{name} ends after frame {frames}, but its header announces about {expected}: about {missing} frames \
                 ({missing_seconds:.1} s) are missing; the decoded frames are used"
            ));
        }
        match self.first_damaged {
            // The last pictures of a video that breaks off are often incomplete: the last one in the stream, and those that
            // are shown after it.
            Some(first) if expected.is_none() || first as usize + stream.reordered < frames as usize => warnings.push(format!(
                "{name} is damaged: the missing parts of {damaged} of its {frames} frames, the first of them {first}, \
                 are filled in by the decoder"
            )),
            // The end of a connection is an error, too.
            None if expected.is_none() && !info.live && reader.errors() > 0 => warnings.push(format!(
                "{name} is damaged: parts of it cannot be decoded; frames may be missing or incomplete"
            )),
            _ => {}
        }
        warnings
    }
}

/// Whether a video ended well before the length in its header. The header's frame count may be an estimate from the
/// duration, or too large, so the timestamp of the last frame has to be short as well.
fn is_clearly_short(decoded: u32, expected: u32, last_seconds: f64, fps: f64) -> bool {
    let missing = f64::from(expected) - f64::from(decoded);
    let margin = (0.05 * f64::from(expected)).max(1.5);
    let missing_by_time = f64::from(expected) - (last_seconds * fps + 1.0);
    missing > margin && (last_seconds <= 0.0 || missing_by_time > margin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_video_is_short_in_frames_and_in_time() {
        assert!(is_clearly_short(10, 20, 0.9, 10.0));
        assert!(is_clearly_short(10, 20, 0.0, 10.0), "a file without timestamps");
        assert!(!is_clearly_short(19, 20, 1.8, 10.0), "the count may be off by one");
        assert!(!is_clearly_short(97, 100, 9.6, 10.0), "or by a few in many");
        assert!(!is_clearly_short(60, 100, 9.9, 10.0), "variable frame rate: the time is full");
        assert!(!is_clearly_short(120, 100, 12.0, 10.0));
    }
}
