//! Writes videos frame by frame through FFmpeg's libraries, which report every error of writing.

mod encoder;

use std::fs::OpenOptions;
use std::io;
use std::path::{Path, PathBuf};

use ffmpeg::codec::Id;
use ffmpeg::encoder::video::Encoder;
use ffmpeg::filter::Graph;
use ffmpeg::format::Pixel;
use ffmpeg::format::context::Output;
use ffmpeg::frame::Video as Picture;
use ffmpeg::{Dictionary, Packet, Rational};

pub use encoder::VideoKind;
use encoder::{MPEG4, converter, open_encoder, rate};

use super::staging::probe;
use super::write_failure::describe;
use crate::frame::{Frame, Size};
use crate::libav::{address, wants_data};
use crate::source::silence_libraries;

/// A video in progress, of one [`VideoKind`]. MP4 has its index at the start of the file.
///
/// Where the encoder needs even sides, odd sizes are extended by a copy of the last row and column. There are no B-frames, so
/// that frames are decoded in the order in which they are shown. The file is complete after [`Self::finish`].
pub struct VideoFile {
    path: PathBuf,
    output: Output,
    encoder: Encoder,
    is_h264: bool,
    converter: Graph,
    size: Size,
    encoded_size: Size,
    /// The encoder's unit of time, in seconds.
    tick: Rational,
    /// The unit of time of the file.
    file_tick: Rational,
    /// The length of a frame at the nominal rate, in ticks.
    nominal_step: i64,
    frames: i64,
    /// The time of the first frame, in seconds: the video starts at 0.
    start: f64,
    /// The time of the last frame, in ticks.
    last: i64,
    /// The number of the last frame.
    last_number: u32,
}

/// An error of writing a video.
#[derive(Debug, thiserror::Error)]
pub enum VideoError {
    /// No encoder is installed, or none supports this size and rate.
    #[error(
        "no encoder of FFmpeg's accepts {size} pixels at {fps} frames per second; install FFmpeg with {best}, or choose \
         another size"
    )]
    Encoder {
        /// The name of the best encoder of this kind of video.
        best: &'static str,
        /// The video's size.
        size: Size,
        /// The video's frame rate.
        fps: f32,
    },
    /// The encoder failed after it had been opened.
    #[error("FFmpeg's encoder failed at frame {0}; choose another size")]
    Frame(u32),
    /// The file cannot be created or written.
    #[error("{0}")]
    File(io::Error),
}

impl VideoFile {
    /// Starts a video of about `fps` frames per second, whose pixels are `pixel_aspect` wide and high; square without.
    /// Fails if there is no encoder for this size and rate, or the file cannot be created.
    pub fn create(
        kind: VideoKind,
        path: &Path,
        size: Size,
        fps: f32,
        pixel_aspect: Option<(u32, u32)>,
    ) -> Result<Self, VideoError> {
        Self::create_with(kind, kind.encoders(), path, size, fps, pixel_aspect)
    }

    /// Uses the first of these encoders that accepts the video.
    fn create_with(
        kind: VideoKind,
        encoders: &[&str],
        path: &Path,
        size: Size,
        fps: f32,
        pixel_aspect: Option<(u32, u32)>,
    ) -> Result<Self, VideoError> {
        silence_libraries();
        let encoded_size = kind.encoded_size(size);
        let rate = rate(fps);
        let refused = || VideoError::Encoder { best: kind.best_encoder(), size, fps };
        let opened = encoders
            .iter()
            .find_map(|&name| Some((name, open_encoder(kind, name, encoded_size, rate, pixel_aspect).ok()?)));
        let (name, (encoder, tick)) = opened.ok_or_else(refused)?;
        let converter = converter(kind, encoded_size).map_err(|_| refused())?;
        let (output, file_tick) = open_output(kind, path, &encoder, rate, tick)?;
        Ok(Self {
            path: path.to_owned(),
            output,
            encoder,
            is_h264: kind == VideoKind::Playback && name != MPEG4,
            converter,
            size,
            encoded_size,
            tick,
            file_tick,
            nominal_step: (1.0 / (f64::from(rate) * f64::from(tick))).round() as i64,
            frames: 0,
            start: 0.0,
            last: 0,
            last_number: 0,
        })
    }

    /// Whether the video is H.264, which browsers play.
    pub fn is_h264(&self) -> bool {
        self.is_h264
    }

    /// Adds a frame of the video's size that is shown from `time` on, in seconds. Times increase; the first may be any. Those of a
    /// lossless video are a frame period apart.
    pub fn write(&mut self, frame: &Frame, time: f64) -> Result<(), VideoError> {
        if self.frames == 0 {
            self.start = time;
        } else {
            // Encoders refuse a time that is not later than the last.
            let ticks = ((time - self.start) / f64::from(self.tick)).round() as i64;
            self.last = ticks.max(self.last + 1);
        }
        self.frames += 1;
        self.last_number = frame.number;
        let mut picture = self.picture(frame).ok_or(VideoError::Frame(frame.number))?;
        picture.set_pts(Some(self.last));
        self.encoder.send_frame(&picture).map_err(|_| VideoError::Frame(frame.number))?;
        self.write_packets()
    }

    /// Completes the file, waits until it is stored, and reads it back.
    pub fn finish(mut self) -> Result<(), VideoError> {
        self.encoder.send_eof().map_err(|_| VideoError::Frame(self.last_number))?;
        self.write_packets()?;
        self.output.write_trailer().map_err(|error| file_error(&self.path, error))?;
        // Closing reports no errors; the operating system gives them to whoever asks next.
        drop(self.output);
        let file = OpenOptions::new().write(true).open(&self.path);
        file.and_then(|file| file.sync_all())
            .map_err(|error| VideoError::File(describe(&self.path, error)))?;
        // Players would open no part of a file of which some bytes are missing.
        let readable = count_frames(&self.path).map_err(|error| file_error(&self.path, error))?;
        if readable == self.frames {
            return Ok(());
        }
        let why = format!("only {readable} of {} frames can be read back", self.frames);
        Err(VideoError::File(describe(&self.path, cause(&self.path, why))))
    }

    /// The frame in the encoder's pixel format.
    fn picture(&mut self, frame: &Frame) -> Option<Picture> {
        if frame.size != self.size {
            return None;
        }
        let Size { width, height } = self.encoded_size;
        let mut picture = Picture::new(Pixel::RGB24, width, height);
        // The crate panics on pictures without planes, which there are where memory is short.
        if picture.planes() == 0 {
            return None;
        }
        let (stride, row) = (picture.stride(0), self.size.width as usize * 3);
        let rows = frame.rgb.chunks_exact(row);
        let rows = rows.clone().chain(rows.last());
        for (line, pixels) in picture.data_mut(0).chunks_exact_mut(stride).zip(rows) {
            line[..row].copy_from_slice(pixels);
            if width > self.size.width {
                line[row..row + 3].copy_from_slice(&pixels[row - 3..]);
            }
        }
        self.converter.get("in")?.source().add(&picture).ok()?;
        let mut converted = Picture::empty();
        self.converter.get("out")?.sink().frame(&mut converted).ok()?;
        Some(converted)
    }

    /// Writes what the encoder has ready.
    fn write_packets(&mut self) -> Result<(), VideoError> {
        let mut packet = Packet::empty();
        loop {
            match self.encoder.receive_packet(&mut packet) {
                Ok(()) => {}
                Err(ffmpeg::Error::Eof) => return Ok(()),
                Err(error) if wants_data(error) => return Ok(()),
                Err(_) => return Err(VideoError::Frame(self.last_number)),
            }
            packet.set_stream(0);
            // Only that of the last packet counts; others end where the next begins.
            packet.set_duration(self.mean_step());
            packet.rescale_ts(self.tick, self.file_tick);
            let written = packet.write_interleaved(&mut self.output);
            written.map_err(|error| file_error(&self.path, error))?;
        }
    }

    /// The mean length of the frames so far, in ticks.
    fn mean_step(&self) -> i64 {
        if self.frames < 2 {
            return self.nominal_step;
        }
        (self.last as f64 / (self.frames - 1) as f64).round() as i64
    }
}

/// Creates the file; it and its unit of time.
fn open_output(
    kind: VideoKind,
    path: &Path,
    encoder: &Encoder,
    rate: Rational,
    tick: Rational,
) -> Result<(Output, Rational), VideoError> {
    let file_error = |error| file_error(path, error);
    let no_address = || describe(path, io::Error::from(io::ErrorKind::InvalidFilename));
    let address = address(path).ok_or_else(|| VideoError::File(no_address()))?;
    let mut output = ffmpeg::format::output_as(&address, kind.extension()).map_err(file_error)?;
    let mut stream = output.add_stream(Id::None).map_err(file_error)?;
    stream.copy_parameters_from_context(encoder.as_ref());
    stream.set_time_base(tick);
    stream.set_avg_frame_rate(rate);
    // As the encoder has rounded it: they must agree.
    let aspect = stream.parameters().sample_aspect_ratio();
    stream.set_sample_aspect_ratio(aspect);
    let mut options = Dictionary::new();
    if kind == VideoKind::Playback {
        options.set("movflags", "+faststart");
    }
    output.write_header_with(options).map_err(file_error)?;
    let file_tick = output.stream(0).map_or(tick, |stream| stream.time_base());
    Ok((output, file_tick))
}

/// The number of frames in a file, which are not decoded.
fn count_frames(path: &Path) -> Result<i64, ffmpeg::Error> {
    let Some(address) = address(path) else { return Ok(0) };
    let mut input = ffmpeg::format::input(&address)?;
    let mut count = 0;
    for packet in input.packets() {
        packet?;
        count += 1;
    }
    Ok(count)
}

/// The operating system's error, where it is one; FFmpeg's own sentences say nothing to a user.
fn file_error(path: &Path, error: ffmpeg::Error) -> VideoError {
    let error = match error {
        ffmpeg::Error::Other { errno } => io::Error::from_raw_os_error(errno),
        _ => cause(path, "FFmpeg's writer of videos failed".to_owned()),
    };
    VideoError::File(describe(path, error))
}

/// Why a file could not be written: the error of another one beside it, otherwise `why`.
fn cause(path: &Path, why: String) -> io::Error {
    let beside = path.parent().map_or(Ok(()), probe);
    beside.err().unwrap_or_else(|| io::Error::other(why))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use rand::{RngExt as _, SeedableRng as _};
    use rand_pcg::Pcg32;

    use super::*;
    use crate::source::{self, Options};

    /// A frame of one colour.
    fn plain(number: u32, size: Size, colour: [u8; 3]) -> Frame {
        Frame::new(number, size, colour.repeat(size.pixels()))
    }

    #[test]
    fn a_video_of_any_size_has_its_frames_in_order_with_any_encoder() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("video.mp4");
        let sizes = [(Size::new(64, 48), 10.0), (Size::new(65, 47), 66.667)];
        let kind = VideoKind::Playback;
        for (encoders, is_h264) in [(kind.encoders(), true), (&["no such encoder", MPEG4], false)] {
            for (size, fps) in sizes {
                let mut video =
                    VideoFile::create_with(kind, encoders, &path, size, fps, Some((4, 3))).unwrap();
                assert_eq!(video.is_h264(), is_h264);
                for number in 1..=5 {
                    let frame = plain(number, size, [number as u8 * 40, 0, 0]);
                    video.write(&frame, f64::from(number) / f64::from(fps)).unwrap();
                }
                video.finish().unwrap();

                let mut read = source::open(path.to_str().unwrap(), Options::default()).unwrap();
                assert!((read.info().fps - fps).abs() < 0.01, "{}", read.info().fps);
                assert_eq!(read.info().pixel_aspect, Some((4, 3)));
                assert_eq!(read.info().size, kind.encoded_size(size));
                let mut reds = Vec::new();
                while let Some(frame) = read.next_frame().unwrap() {
                    reds.push(frame.pixel(20, 20).unwrap()[0]);
                }
                assert_eq!(reds.len(), 5, "{size}");
                assert!(reds.is_sorted_by(|a, b| a + 20 < *b), "{reds:?}");
            }
        }
    }

    #[test]
    fn a_lossless_video_has_the_bits_and_times_of_its_frames() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("video.avi");
        for (size, fps) in [(Size::new(64, 48), 25.0), (Size::new(65, 47), 29.97), (Size::new(2, 3), 66.667)]
        {
            let mut random = Pcg32::seed_from_u64(4);
            let frames = (1..=5).map(|number| {
                let mut frame = plain(number, size, [0; 3]);
                frame.rgb.fill_with(|| random.random());
                frame.at_time(f64::from(number - 1) / f64::from(fps))
            });
            let frames: Vec<Frame> = frames.collect();
            let mut video = VideoFile::create(VideoKind::Lossless, &path, size, fps, None).unwrap();
            for frame in &frames {
                video.write(frame, frame.time).unwrap();
            }
            assert!(!video.is_h264());
            video.finish().unwrap();

            let mut read = source::open(path.to_str().unwrap(), Options::default()).unwrap();
            assert!((read.info().fps - fps).abs() < 1e-3, "{}", read.info().fps);
            for frame in &frames {
                let found = read.next_frame().unwrap().unwrap();
                assert_eq!(&found, frame, "{size}");
                assert!((found.time - frame.time).abs() < 1e-4, "{} at {}", found.time, frame.time);
            }
            assert_eq!(read.next_frame().unwrap(), None);
        }
    }

    #[test]
    fn what_cannot_be_written_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let (kind, size) = (VideoKind::Playback, Size::new(64, 48));
        let path = folder.path().join("video.mp4");
        let create = |encoders: &[&str], path: &Path, size| {
            VideoFile::create_with(kind, encoders, path, size, 25.0, None).map(drop)
        };
        assert!(matches!(create(&[], &path, size), Err(VideoError::Encoder { .. })));
        let huge = Size::new(16_400, 16);
        assert!(matches!(create(kind.encoders(), &path, huge), Err(VideoError::Encoder { .. })));
        assert!(!path.exists(), "no file without an encoder");
        let elsewhere = folder.path().join("missing/video.mp4");
        let why = create(kind.encoders(), &elsewhere, size).unwrap_err().to_string();
        let place = elsewhere.display();
        assert_eq!(
            why,
            format!(
                "{place} cannot be written: its folder does not exist; create it, or choose another place"
            )
        );

        let mut video = VideoFile::create(kind, &path, size, 25.0, None).unwrap();
        let other = plain(7, Size::new(48, 64), [0; 3]);
        assert!(matches!(video.write(&other, 0.0), Err(VideoError::Frame(7))));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error() {
        let size = Size::new(64, 48);
        let full = Path::new("/dev/full");
        for kind in [VideoKind::Playback, VideoKind::Lossless] {
            let write = || {
                let mut video = VideoFile::create(kind, full, size, 25.0, None)?;
                for number in 1..=5 {
                    video.write(&plain(number, size, [90; 3]), f64::from(number) / 25.0)?;
                }
                video.finish()
            };
            let error: VideoError = write().unwrap_err();
            assert!(error.to_string().contains("the disk is full"), "{kind:?}: {error}");
        }
    }
}
