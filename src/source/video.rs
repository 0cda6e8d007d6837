//! Video files and cameras, through OpenCV.
//!
//! OpenCV's seeking and its frame count are not exact: frames are decoded in order and counted here, and the caller
//! of a seek has to find the position.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use opencv::core::{CV_8UC1, CV_8UC3, CV_8UC4, Mat, Vec3b};
use opencv::imgproc::{COLOR_BGR2RGB, COLOR_BGRA2RGB, COLOR_GRAY2RGB, cvt_color_def};
use opencv::prelude::*;
use opencv::videoio::{
    CAP_ANY, CAP_FFMPEG, CAP_PROP_FPS, CAP_PROP_FRAME_COUNT, CAP_PROP_POS_FRAMES, CAP_PROP_POS_MSEC,
    VideoCapture,
};

use super::{FpsFrom, Options, Source, SourceError, SourceInfo, image_file, rate};
use crate::frame::{Frame, Size};

/// A video or a camera, read frame by frame.
pub(super) struct Video {
    info: SourceInfo,
    /// The file's own frame rate, on which its timestamps are based; a rate given by the user does not change it.
    said_fps: f64,
    capture: VideoCapture,
    picture: Mat,
    /// The first frame, decoded at opening because it gives the source's size.
    first: Option<Frame>,
    decoded: u32,
    /// Timestamp of the last decoded frame, in seconds from the start, where the file has one.
    last_seconds: f64,
    ended: bool,
    warnings: Vec<String>,
}

/// Opens a video file.
pub(super) fn open_file(name: &str, options: Options) -> Result<Video, SourceError> {
    let mut start = [0; 4096];
    let length = File::open(name)
        .and_then(|mut file| file.read(&mut start))
        .map_err(|error| SourceError::unusable(name, format!("{error}; check its permissions")))?;
    if length == 0 {
        return Err(SourceError::unusable(name, "the file is empty; check that it was copied completely"));
    }
    if image_file::has_image_name(Path::new(name)) && !name.to_lowercase().ends_with(".gif") {
        return Err(SourceError::unusable(
            name,
            "it is a single image; give its folder, or a pattern such as in%06d.png",
        ));
    }
    // FFmpeg would render a text file as a video of a terminal.
    if is_text(&start[..length]) {
        return Err(SourceError::unusable(name, "it is text, not a video"));
    }
    // An absolute path keeps FFmpeg from reading a name with a colon as a protocol.
    let path = fs::canonicalize(name)
        .map_err(|error| SourceError::unusable(name, format!("{error}; check the path")))?;
    let no_video = || {
        SourceError::unusable(
            name,
            "it is not a decodable video; check that it is complete and plays elsewhere, or convert it",
        )
    };
    let capture = VideoCapture::from_file(&path, CAP_FFMPEG)
        .ok()
        .filter(|capture| capture.is_opened().unwrap_or(false))
        .ok_or_else(no_video)?;
    Video::new(name, capture, false, options)?.ok_or_else(|| {
        SourceError::unusable(
            name,
            "none of its frames can be decoded; check that it is complete and plays elsewhere, or convert it",
        )
    })
}

/// Opens a camera by its number, given as text.
pub(super) fn open_camera(name: &str, index: &str, options: Options) -> Result<Video, SourceError> {
    let index: i32 = index.parse().ok().filter(|&index| (0..1000).contains(&index)).ok_or_else(|| {
        SourceError::unusable(name, "cameras are selected by number: camera:0, camera:1, …")
    })?;
    let capture = VideoCapture::new(index, CAP_ANY)
        .ok()
        .filter(|capture| capture.is_opened().unwrap_or(false))
        .ok_or_else(|| {
            SourceError::unusable(
                name,
                "there is no such camera, or another program uses it; check that it is connected and free",
            )
        })?;
    Video::new(name, capture, true, options)?.ok_or_else(|| {
        SourceError::unusable(name, "the camera returns no image; check that no other program uses it")
    })
}

impl Video {
    /// `None` when no frame can be decoded.
    fn new(
        name: &str,
        capture: VideoCapture,
        live: bool,
        options: Options,
    ) -> Result<Option<Self>, SourceError> {
        let property = |property| capture.get(property).unwrap_or(0.0);
        let said_fps = property(CAP_PROP_FPS);
        let (fps, fps_from) = match options.fps {
            Some(fps) => (fps, FpsFrom::Given),
            None if is_plausible(said_fps) => (said_fps as f32, FpsFrom::Video),
            None => (rate::ASSUMED, FpsFrom::Assumed),
        };
        let count = property(CAP_PROP_FRAME_COUNT);
        let frames = (!live && is_plausible(said_fps) && (1.0..1e8).contains(&count)).then_some(count as u32);
        let info = SourceInfo { name: name.to_owned(), size: Size::new(0, 0), fps, fps_from, frames, live };
        let mut video = Self {
            info,
            said_fps,
            capture,
            picture: Mat::default(),
            first: None,
            decoded: 0,
            last_seconds: 0.0,
            ended: false,
            warnings: Vec::new(),
        };
        let Some(frame) = video.decode()? else { return Ok(None) };
        video.info.size = frame.size;
        video.first = Some(frame);
        Ok(Some(video))
    }

    fn decode(&mut self) -> Result<Option<Frame>, SourceError> {
        // An exception in a decoder ends the stream like any other error; earlier frames remain valid.
        if !self.capture.read(&mut self.picture).unwrap_or(false) || self.picture.empty() {
            return Ok(None);
        }
        let (size, rgb) = rgb_of(&self.picture).map_err(|why| SourceError::unusable(&self.info.name, why))?;
        self.decoded += 1;
        if !self.info.live {
            self.last_seconds = self.capture.get(CAP_PROP_POS_MSEC).unwrap_or(0.0) / 1000.0;
        }
        Ok(Some(Frame::new(self.decoded, size, rgb)))
    }

    fn end(&mut self) {
        self.ended = true;
        let Self { info, decoded, .. } = self;
        if info.live {
            self.warnings.push(format!(
                "{} returned no more images after frame {decoded}; check its connection",
                info.name
            ));
        } else if let Some(expected) = info.frames
            && is_clearly_short(*decoded, expected, self.last_seconds, self.said_fps)
        {
            self.warnings.push(format!(
                "{} ends after frame {decoded}, but its header announces about {expected}; the decoded \
                 frames are used",
                info.name
            ));
        }
    }
}

impl Source for Video {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        if let Some(first) = self.first.take() {
            return Ok(Some(first));
        }
        if self.ended {
            return Ok(None);
        }
        let frame = self.decode()?;
        match &frame {
            None => self.end(),
            Some(frame) if frame.size != self.info.size => {
                self.warnings.push(format!(
                    "{} changes its size from {} to {} at frame {}; the frames before are used",
                    self.info.name, self.info.size, frame.size, frame.number
                ));
                self.ended = true;
                return Ok(None);
            }
            Some(_) => {}
        }
        Ok(frame)
    }

    fn seek(&mut self, position: u32) -> bool {
        if self.info.live {
            return false;
        }
        self.first = None;
        self.capture.set(CAP_PROP_POS_FRAMES, f64::from(position)).unwrap_or(false)
    }

    fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }
}

/// Whether the rate is plausible as a frame rate. 1000 and above are clock rates of containers.
fn is_plausible(fps: f64) -> bool {
    (0.05..1000.0).contains(&fps)
}

/// Whether a video ended well before the length in its header. The header's frame count may be an estimate from the
/// duration, or too large, so the timestamp of the last frame has to be short as well.
fn is_clearly_short(decoded: u32, expected: u32, last_seconds: f64, fps: f64) -> bool {
    let missing = f64::from(expected) - f64::from(decoded);
    let margin = (0.05 * f64::from(expected)).max(1.5);
    let missing_by_time = f64::from(expected) - (last_seconds * fps + 1.0);
    missing > margin && (last_seconds <= 0.0 || missing_by_time > margin)
}

fn is_text(start: &[u8]) -> bool {
    let text = match std::str::from_utf8(start) {
        Ok(text) => text,
        // The end of the buffer may split a character.
        Err(error) if error.error_len().is_none() => {
            std::str::from_utf8(&start[..error.valid_up_to()]).unwrap_or_default()
        }
        Err(_) => return false,
    };
    text.chars().all(|c| !c.is_control() || matches!(c, '\n' | '\r' | '\t' | '\x0c' | '\x1b'))
}

fn rgb_of(picture: &Mat) -> Result<(Size, Vec<u8>), String> {
    let code = match picture.typ() {
        CV_8UC1 => COLOR_GRAY2RGB,
        CV_8UC3 => COLOR_BGR2RGB,
        CV_8UC4 => COLOR_BGRA2RGB,
        other => {
            return Err(format!("its images have OpenCV's type {other}; convert it to 8-bit colour"));
        }
    };
    let size = Size::new(picture.cols() as u32, picture.rows() as u32);
    let mut rgb = vec![0; size.pixels() * 3];
    // Decoding into the final buffer saves a copy.
    let mut target = Mat::new_rows_cols_with_bytes_mut::<Vec3b>(picture.rows(), picture.cols(), &mut rgb)
        .map_err(|error| error.message)?;
    cvt_color_def(picture, &mut target, code).map_err(|error| error.message)?;
    Ok((size, rgb))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

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

    #[test]
    fn text_files_are_distinguished_from_video() {
        assert!(is_text("Grüße\n".as_bytes()));
        assert!(is_text(&"Grüße".as_bytes()[..3]), "cut within a character");
        assert!(!is_text(b"RIFF\x24\x00\x00\x00AVI "));
        assert!(!is_text(b"\x00\x00\x00\x20ftypisom"));
        assert!(!is_text(b"\x1a\x45\xdf\xa3\xff"));
    }
}
