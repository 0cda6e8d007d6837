//! Pictures of a video with their times, from the start or from a key packet on.

use ffmpeg::frame::Video as Picture;

use super::Failure;
use super::decode::{Decoded, Decoder, Landing, Threads};
use super::file::InputFile;
use super::index::{FrameTime, Key};
use super::info::StreamInfo;
use super::raw::{self, ColorNumbers};
use crate::frame::Size;

/// Seconds before a key packet at which to aim where a seek to it leads behind it.
const EARLIER: [f64; 3] = [0.3, 1.5, 5.0];
/// Number of pictures with later times after which a picture is not expected any more.
const MAX_LATER: usize = 64;

/// Properties of a decoded picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct PictureInfo {
    /// Its time of presentation.
    pub(super) time: FrameTime,
    /// Size in the stream, before rotation and scaling.
    pub(super) coded_size: Size,
    pub(super) colors: ColorNumbers,
    /// Whether the decoder had to fill in what is missing or wrong.
    pub(super) is_damaged: bool,
    /// Whether the stream says that it consists of two fields of different times.
    pub(super) is_interlaced: bool,
}

/// A decoded picture with its properties.
pub(super) struct TimedPicture {
    pub(super) picture: Picture,
    pub(super) info: PictureInfo,
}

/// Reads the pictures of a video.
pub(super) struct Reader {
    file: InputFile,
    decoder: Decoder,
    last_pts: Option<i64>,
    /// Errors before the first picture since the start: the video starts within a group of pictures.
    early_errors: Option<u64>,
}

impl Reader {
    /// Opens a video at its start.
    pub(super) fn open(file: &InputFile, threads: Threads) -> Result<Self, Failure> {
        let decoder = Decoder::open(file, threads)?;
        Ok(Self { file: file.clone(), decoder, last_pts: None, early_errors: None })
    }

    /// Opens the decoder again, at the start of the video, which must not have changed.
    pub(super) fn restart(&mut self, threads: Threads) -> Result<(), Failure> {
        if !self.file.is_unchanged() {
            return Err(Failure::Changed);
        }
        self.decoder = Decoder::open(&self.file, threads).map_err(|_| Failure::Changed)?;
        (self.last_pts, self.early_errors) = (None, None);
        Ok(())
    }

    /// Properties of the stream.
    pub(super) fn info(&self) -> &StreamInfo {
        self.decoder.info()
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
        let decoded = self.decoder.next()?;
        self.early_errors.get_or_insert(self.decoder.errors());
        Some(self.timed(decoded))
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
            self.last_pts = None;
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
            if picture.info.time == (FrameTime { pts, is_from_file: true }) {
                return Some(picture);
            }
            later += usize::from(picture.info.time.pts > pts);
        }
        None
    }

    fn timed(&mut self, Decoded { picture, pts: own_pts, is_damaged }: Decoded) -> TimedPicture {
        let expected = || self.last_pts.map_or(0, |last| last.saturating_add(self.info().ticks_per_frame()));
        let pts = own_pts.unwrap_or_else(expected);
        self.last_pts = Some(pts);
        let info = PictureInfo {
            time: FrameTime { pts, is_from_file: own_pts.is_some() },
            coded_size: Size::new(picture.width(), picture.height()),
            colors: raw::colors(&picture),
            is_damaged,
            is_interlaced: raw::is_interlaced(&picture),
        };
        TimedPicture { picture, info }
    }
}
