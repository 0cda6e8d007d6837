//! Video files and network streams, through FFmpeg's libraries.
//!
//! [`Video`] reads a file in order and records an index of times and key packets; [`IndexedReader`] gives any frame of the
//! index again. Frames are those that the `ffmpeg` program gives: every one, upright, converted with the matrix and
//! range that the file states, damaged parts concealed.

mod check;
mod convert;
mod decode;
mod file;
mod index;
mod indexed;
mod info;
mod playlist;
mod progress;
mod raw;
mod reader;
mod rotate;
mod sequential;
mod times;

use convert::{Converted, Converter};
pub(super) use file::is_address;
use file::{InputFile, without_credentials};
use indexed::IndexedReader;
use info::StreamInfo;
use progress::{INTERLACED, Progress};
use reader::PictureInfo;
use sequential::SequentialReader;
use times::PresentationTimes;

use super::random_access::RandomAccess;
use super::{Options, Source, SourceError, SourceInfo, rate};
use crate::frame::Frame;

/// The transfer characteristics of HDR video, and their names.
const HDR_TRANSFERS: [(u32, &str); 2] = [(16, "PQ"), (18, "HLG")];

/// Largest number of frames that is believed of a header.
const MAX_FRAMES: u64 = 100_000_000;

/// Why a file or a picture cannot be read.
#[derive(Debug)]
enum Failure {
    NoVideo,
    /// The file has no video stream.
    NoVideoStream,
    /// An address cannot be opened, and why.
    Unreachable(String),
    /// There is no video stream of this index; those that there are, in words.
    NoStream {
        index: usize,
        streams: String,
    },
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
            Self::NoVideoStream => {
                "it has no video stream, only sound or a cover picture; give a video".to_owned()
            }
            Self::Unreachable(why) => {
                format!("{why}; check the address, the network, and that it plays elsewhere")
            }
            Self::NoStream { index, streams } => {
                format!("it has no video stream {index}; set --stream to one of those that it has: {streams}")
            }
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

/// A video file or network stream, read frame by frame.
pub(super) struct Video {
    info: SourceInfo,
    file: InputFile,
    reader: SequentialReader,
    converter: Converter,
    progress: Progress,
    times: PresentationTimes,
    /// Number of parts of streams that are known to be missing.
    missed_parts: u64,
    is_over: bool,
    warnings: Vec<String>,
}

impl Video {
    /// Opens a video file or network stream.
    pub(super) fn open(name: &str, options: Options) -> Result<Self, SourceError> {
        let warning = if is_address(name) { None } else { check::check_file(name)? };
        let file = InputFile::new(name, options)
            .map_err(|error| SourceError::unusable(name, format!("{error}; check the path")))?;
        let shown = without_credentials(name);
        let mut video = Self::open_file(&shown, file, options).map_err(|failure| failure.of(&shown))?;
        video.warnings.extend(warning);
        Ok(video)
    }

    fn open_file(name: &str, file: InputFile, options: Options) -> Result<Self, Failure> {
        let missed_parts = raw::missed_parts();
        let mut reader = SequentialReader::open(&file)?;
        let mut converter = Converter::new(reader.reader().info().display_matrix, file.deinterlace);
        let first = converter.prepare(|| reader.next())?.ok_or(Failure::NoFrame)?;
        let size = converter.size().ok_or(Failure::NoFrame)?;
        let stream = reader.reader().info();
        let (fps, fps_from) = rate::choose(options.fps, stream.rate);
        let frames = stream.frames.filter(|frames| stream.rate.is_some() && (1..MAX_FRAMES).contains(frames));
        let live = file.is_live();
        let frames = frames.map(|frames| frames as u32).filter(|_| !live);
        let pixel_aspect = stream.pixel_aspect.map(|aspect| {
            let (width, height) = (aspect.numerator.unsigned_abs(), aspect.denominator.unsigned_abs());
            if converter.swaps_sides() { (height, width) } else { (width, height) }
        });
        let times = match options.fps {
            Some(fps) => PresentationTimes::of_rate(fps),
            None => PresentationTimes::of_ticks(stream.time_base.value(), fps),
        };
        let info = SourceInfo {
            name: name.to_owned(),
            size,
            pixel_aspect,
            fps,
            fps_from,
            frames,
            live,
            reduction: None,
        };
        let warnings = opening_warnings(name, stream, &first, options);
        let knows_interlaced = options.deinterlace || stream.is_interlaced;
        let progress = Progress::new(knows_interlaced);
        Ok(Self { info, file, reader, converter, progress, times, missed_parts, is_over: false, warnings })
    }
}

impl Video {
    /// Notes the next picture, or the end. Returns the picture's time in seconds.
    fn pass(&mut self, picture: Option<&PictureInfo>) -> Option<f64> {
        let missed = raw::missed_parts();
        if self.info.live && missed > std::mem::replace(&mut self.missed_parts, missed) {
            self.warnings.push(format!(
                "{} lacks a part after frame {}, which its server does not give; its frames are missing",
                self.info.name, self.progress.frames
            ));
        }
        let Some(picture) = picture else {
            self.is_over = true;
            self.warnings.extend(self.progress.at_end(&self.info, self.reader.reader()));
            if self.info.live {
                self.warnings.push(format!(
                    "{} sends no more frames after frame {}; check the connection if that is too early",
                    self.info.name, self.progress.frames
                ));
            }
            return None;
        };
        self.warnings.extend(self.progress.add(picture, &self.info));
        Some(self.times.next(picture.time.pts))
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
        let next =
            self.converter.next(|| self.reader.next()).map_err(|failure| failure.of(&self.info.name))?;
        let time = self.pass(next.as_ref().map(|converted| &converted.info));
        let frame = |(Converted { rgb, .. }, time)| {
            Frame::new(self.progress.frames, self.info.size, rgb).at_time(time)
        };
        Ok(next.zip(time).map(frame))
    }

    fn skip_frame(&mut self) -> Result<bool, SourceError> {
        // A deinterlaced frame depends on the pictures around its own.
        if self.is_over || self.file.deinterlace || self.converter.held() > 0 {
            return Ok(self.next_frame()?.is_some());
        }
        let next = self.reader.next().map_err(|failure| failure.of(&self.info.name))?;
        Ok(self.pass(next.as_ref().map(|picture| &picture.info)).is_some())
    }

    fn random_access(&self) -> Option<Box<dyn RandomAccess>> {
        let reader = || IndexedReader::new(&self.info, self.file.clone(), self.reader.index());
        (!self.info.live).then(|| Box::new(reader()) as Box<dyn RandomAccess>)
    }

    fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }
}

/// What is unusual about a video as a whole.
fn opening_warnings(name: &str, stream: &StreamInfo, first: &PictureInfo, options: Options) -> Vec<String> {
    let mut warnings = Vec::new();
    if stream.video_streams > 1 && options.stream.is_none() {
        warnings.push(format!(
            "{name} holds {} video streams; stream {} of the file is used, --stream selects another",
            stream.video_streams, stream.index
        ));
    }
    match (options.deinterlace, stream.is_interlaced) {
        (false, true) => warnings.push(format!("{name} {INTERLACED}")),
        (true, false) if !first.is_interlaced => warnings.push(format!(
            "{name} is not marked as interlaced, and --deinterlace blurs frames that are not; leave it out unless \
             moving edges look like combs"
        )),
        _ => {}
    }
    let transfer = first.colors.transfer;
    if let Some((_, transfer)) = HDR_TRANSFERS.iter().find(|(number, _)| *number == transfer) {
        warnings.push(format!(
            "{name} is HDR ({transfer}): its levels are used as they are, without tone mapping"
        ));
    }
    warnings
}
