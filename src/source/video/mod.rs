//! Video files, through FFmpeg's libraries.
//!
//! [`Video`] reads a file in order and records an index of times and key packets; [`IndexedReader`] gives any frame of the
//! index again. Frames are those that the `ffmpeg` program gives: every one, upright, converted with the matrix and
//! range that the file states, damaged parts concealed.

mod check;
mod convert;
mod decode;
mod index;
mod indexed;
mod info;
mod progress;
mod raw;
mod reader;
mod rotate;
mod sequential;

use std::fs;
use std::path::PathBuf;

use indexed::IndexedReader;
use progress::Progress;
use reader::Reader;
use sequential::SequentialReader;

use super::random_access::RandomAccess;
use super::{FpsFrom, Options, Source, SourceError, SourceInfo, rate};
use crate::frame::Frame;

/// The transfer characteristics of HDR video, and their names.
const HDR_TRANSFERS: [(u32, &str); 2] = [(16, "PQ"), (18, "HLG")];

/// Largest number of frames that is believed of a header.
const MAX_FRAMES: u64 = 100_000_000;

/// Why a file or a picture cannot be read.
#[derive(Debug)]
enum Failure {
    NoVideo,
    /// There is no decoder for this codec.
    NoDecoder(String),
    NoFrame,
    Unconvertible,
    /// It cannot be opened again.
    Changed,
}

impl Failure {
    fn of(self, name: &str) -> SourceError {
        let whole = "check that it is complete and plays elsewhere, or convert it";
        let why = match self {
            Self::NoVideo => format!("it is not a decodable video; {whole}"),
            Self::NoDecoder(codec) => {
                format!("there is no decoder for its codec, {codec}; convert it to H.264")
            }
            Self::Changed => return SourceError::changed(name),
            Self::NoFrame => format!("none of its frames can be decoded; {whole}"),
            Self::Unconvertible => {
                "its pictures cannot be converted to RGB; convert it to 8-bit colour".to_owned()
            }
        };
        SourceError::unusable(name, why)
    }
}

/// A video file, read frame by frame.
pub(super) struct Video {
    info: SourceInfo,
    file: PathBuf,
    reader: SequentialReader,
    progress: Progress,
    is_over: bool,
    warnings: Vec<String>,
}

impl Video {
    /// Opens a video file.
    pub(super) fn open(name: &str, options: Options) -> Result<Self, SourceError> {
        check::check_file(name)?;
        let file = fs::canonicalize(name)
            .map_err(|error| SourceError::unusable(name, format!("{error}; check the path")))?;
        let mut reader = SequentialReader::open(&file).map_err(|failure| failure.of(name))?;
        let first = reader.reader();
        let stream = first.info();
        let mut rates = [stream.average_rate, stream.base_rate].into_iter().flatten();
        let rate = rates.find(|&fps| rate::is_plausible(fps));
        let (fps, fps_from) = match (options.fps, rate) {
            (Some(fps), _) => (fps, FpsFrom::Given),
            (None, Some(fps)) => (fps as f32, FpsFrom::Video),
            (None, None) => (rate::ASSUMED, FpsFrom::Assumed),
        };
        let frames = stream.frames.filter(|frames| rate.is_some() && (1..MAX_FRAMES).contains(frames));
        let frames = frames.map(|frames| frames as u32);
        let info =
            SourceInfo { name: name.to_owned(), size: first.size(), fps, fps_from, frames, live: false };
        let warnings = opening_warnings(name, first);
        Ok(Self { info, file, reader, progress: Progress::default(), is_over: false, warnings })
    }
}

impl Source for Video {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        if self.is_over {
            return Ok(None);
        }
        let next = self.reader.next().map_err(|failure| failure.of(&self.info.name))?;
        let Some(picture) = next else {
            self.is_over = true;
            self.warnings.extend(self.progress.at_end(&self.info, self.reader.reader()));
            return Ok(None);
        };
        self.warnings.extend(self.progress.add(&picture, &self.info));
        let rgb = self.reader.reader().rgb(picture).map_err(|failure| failure.of(&self.info.name))?;
        Ok(Some(Frame::new(self.progress.frames, self.info.size, rgb)))
    }

    fn random_access(&self) -> Option<Box<dyn RandomAccess>> {
        Some(Box::new(IndexedReader::new(&self.info, &self.file, self.reader.index())))
    }

    fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }
}

/// What is unusual about a video as a whole.
fn opening_warnings(name: &str, reader: &Reader) -> Vec<String> {
    let stream = reader.info();
    let mut warnings = Vec::new();
    if stream.video_streams > 1 {
        warnings.push(format!(
            "{name} holds {} video streams; stream {} of the file is used",
            stream.video_streams, stream.index
        ));
    }
    if stream.is_interlaced {
        warnings.push(format!(
            "{name} is interlaced: every other line of a frame is from another time, so moving edges look like combs; \
             deinterlace it for exact outlines"
        ));
    }
    let transfer = reader.first_colors().transfer;
    if let Some((_, transfer)) = HDR_TRANSFERS.iter().find(|(number, _)| *number == transfer) {
        warnings.push(format!(
            "{name} is HDR ({transfer}): its levels are used as they are, without tone mapping"
        ));
    }
    warnings
}
