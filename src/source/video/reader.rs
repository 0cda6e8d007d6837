//! Pictures of a video with their times, from the start or from a key packet on.

use std::path::{Path, PathBuf};

use super::Failure;
use super::convert::Converter;
use super::decode::{Decoded, Decoder, Landing, Threads};
use super::index::{FrameTime, Key};
use super::info::StreamInfo;
use super::raw::{self, ColorNumbers};
use crate::frame::Size;

/// Seconds before a key packet at which to aim where a seek to it leads behind it.
const EARLIER: [f64; 3] = [0.3, 1.5, 5.0];
/// Number of pictures with later times after which a picture is not expected any more.
const MAX_LATER: usize = 64;

/// A picture with its time.
pub(super) struct TimedPicture {
    decoded: Decoded,
    pub(super) time: FrameTime,
    /// Size in the stream, before rotation and scaling.
    pub(super) coded_size: Size,
    /// The pixels, where they are converted already.
    rgb: Option<Vec<u8>>,
}

impl TimedPicture {
    /// Whether the decoder had to fill in what is missing or wrong.
    pub(super) fn is_damaged(&self) -> bool {
        self.decoded.is_damaged
    }
}

/// Reads a video. All its frames have the size of the first.
pub(super) struct Reader {
    file: PathBuf,
    decoder: Decoder,
    converter: Converter,
    /// Decoded at opening.
    first: Option<TimedPicture>,
    first_colors: ColorNumbers,
    last_pts: Option<i64>,
    /// Errors before the first picture since the start: the video starts within a group of pictures.
    early_errors: Option<u64>,
}

impl Reader {
    /// Opens a video at its start and decodes its first picture, which determines the size of all.
    pub(super) fn open(file: &Path, threads: Threads) -> Result<Self, Failure> {
        let mut decoder = Decoder::open(file, threads)?;
        let mut converter = Converter::new(decoder.info().display_matrix);
        let decoded = decoder.next().ok_or(Failure::NoFrame)?;
        converter.follow_matrix(&decoded.picture);
        let first_colors = raw::colors(&decoded.picture);
        let early_errors = Some(decoder.errors());
        let file = file.to_owned();
        let mut reader =
            Self { file, decoder, converter, first: None, first_colors, last_pts: None, early_errors };
        let mut first = reader.timed(decoded);
        first.rgb = Some(reader.converter.rgb(&first.decoded.picture)?);
        reader.first = Some(first);
        Ok(reader)
    }

    /// Opens the decoder again, at the start of the video.
    pub(super) fn restart(&mut self, threads: Threads) -> Result<(), Failure> {
        self.decoder = Decoder::open(&self.file, threads)?;
        (self.first, self.last_pts, self.early_errors) = (None, None, None);
        Ok(())
    }

    /// Properties of the stream.
    pub(super) fn info(&self) -> &StreamInfo {
        self.decoder.info()
    }

    /// Size of all frames.
    pub(super) fn size(&self) -> Size {
        self.converter.size().unwrap_or(Size::new(0, 0))
    }

    /// The colour description of the first picture.
    pub(super) fn first_colors(&self) -> ColorNumbers {
        self.first_colors
    }

    /// Number of errors that the decoder reported since the first picture.
    pub(super) fn errors(&self) -> u64 {
        self.early_errors.map_or(0, |early| self.decoder.errors() - early)
    }

    /// Takes the key packets that were read since the last call.
    pub(super) fn take_keys(&mut self) -> Vec<Key> {
        self.decoder.take_keys()
    }

    /// The next picture, `None` after the last.
    pub(super) fn next(&mut self) -> Option<TimedPicture> {
        if let Some(first) = self.first.take() {
            return Some(first);
        }
        let decoded = self.decoder.next()?;
        self.early_errors.get_or_insert(self.decoder.errors());
        Some(self.timed(decoded))
    }

    /// The pixels of a picture: RGB in row order.
    pub(super) fn rgb(&mut self, picture: TimedPicture) -> Result<Vec<u8>, Failure> {
        picture.rgb.map_or_else(|| self.converter.rgb(&picture.decoded.picture), Ok)
    }

    /// Seeks to this key packet or to one before it, not later than `time`. [`Landing::AtEnd`] where no such packet is
    /// found.
    pub(super) fn seek_before(&mut self, key: Key, time: i64) -> Landing {
        let ticks_per_second = 1.0 / self.info().time_base.value();
        let Some(decoded_at) = key.dts.or(key.pts) else { return Landing::AtEnd };
        // Some files are indexed by the time of decoding, which is earlier.
        let earlier =
            EARLIER.map(|seconds| Some(decoded_at.saturating_sub((seconds * ticks_per_second) as i64)));
        let mut last_aim = None;
        for aim in [key.pts, key.dts].into_iter().chain(earlier).flatten() {
            if last_aim.replace(aim) == Some(aim) {
                continue;
            }
            (self.first, self.last_pts) = (None, None);
            match self.decoder.seek(aim) {
                Landing::At(landed) if landed.time().is_some_and(|landed| landed <= time) => {
                    return Landing::At(landed);
                }
                Landing::At(_) | Landing::AtEnd => {}
                Landing::Refused => return Landing::Refused,
            }
        }
        Landing::AtEnd
    }

    /// Decodes up to the picture that has this time in the file. Earlier pictures that no other depends on are skipped.
    pub(super) fn decode_until(&mut self, pts: i64) -> Option<TimedPicture> {
        self.decoder.hurry_until(pts);
        let mut later = 0;
        while later < MAX_LATER {
            let picture = self.next()?;
            if picture.time == (FrameTime { pts, is_from_file: true }) {
                return Some(picture);
            }
            later += usize::from(picture.time.pts > pts);
        }
        None
    }

    fn timed(&mut self, decoded: Decoded) -> TimedPicture {
        let expected = || self.last_pts.map_or(0, |last| last.saturating_add(self.info().ticks_per_frame()));
        let pts = decoded.pts.unwrap_or_else(expected);
        self.last_pts = Some(pts);
        TimedPicture {
            time: FrameTime { pts, is_from_file: decoded.pts.is_some() },
            coded_size: Size::new(decoded.picture.width(), decoded.picture.height()),
            decoded,
            rgb: None,
        }
    }
}
