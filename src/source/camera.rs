//! Cameras, through OpenCV.

use std::time::Instant;

use opencv::core::{CV_8UC1, CV_8UC3, CV_8UC4, Mat, Vec3b};
use opencv::imgproc::{COLOR_BGR2RGB, COLOR_BGRA2RGB, COLOR_GRAY2RGB, cvt_color_def};
use opencv::prelude::*;
use opencv::videoio::{CAP_ANY, CAP_PROP_FPS, VideoCapture};

use super::kind::CAMERA;
use super::{Options, Source, SourceError, SourceInfo, rate};
use crate::frame::{Frame, Size};

/// A camera, read frame by frame.
pub(super) struct Camera {
    info: SourceInfo,
    capture: VideoCapture,
    picture: Mat,
    /// The first frame, decoded at opening because it gives the source's size.
    first: Option<Frame>,
    decoded: u32,
    /// When the first image came, and the rate that the user gave.
    started: Option<Instant>,
    given_fps: Option<f64>,
    ended: bool,
    warnings: Vec<String>,
}

impl Camera {
    /// Opens a camera by its name, `camera:` and its number.
    pub(super) fn open(name: &str, options: Options) -> Result<Self, SourceError> {
        let index = name.strip_prefix(CAMERA).and_then(|index| index.parse::<i32>().ok());
        let index = index.filter(|&index| (0..1000).contains(&index)).ok_or_else(|| {
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
        let (fps, fps_from) = rate::choose(options.fps, capture.get(CAP_PROP_FPS).ok());
        let size = Size::new(0, 0);
        let info = SourceInfo {
            name: name.to_owned(),
            size,
            pixel_aspect: None,
            fps,
            fps_from,
            frames: None,
            live: true,
            reduction: None,
        };
        let (picture, warnings) = (Mat::default(), Vec::new());
        let given_fps = options.fps.map(f64::from);
        let mut camera = Self {
            info,
            capture,
            picture,
            first: None,
            decoded: 0,
            started: None,
            given_fps,
            ended: false,
            warnings,
        };
        let first = camera.decode()?.ok_or_else(|| {
            SourceError::unusable(name, "the camera returns no image; check that no other program uses it")
        })?;
        camera.info.size = first.size;
        camera.first = Some(first);
        Ok(camera)
    }

    fn decode(&mut self) -> Result<Option<Frame>, SourceError> {
        // An exception in a decoder ends the stream like any other error; earlier frames remain valid.
        if !self.capture.read(&mut self.picture).unwrap_or(false) || self.picture.empty() {
            return Ok(None);
        }
        let (size, rgb) = rgb_of(&self.picture).map_err(|why| SourceError::unusable(&self.info.name, why))?;
        let now = Instant::now();
        let elapsed = now.duration_since(*self.started.get_or_insert(now)).as_secs_f64();
        let time = self.given_fps.map_or(elapsed, |fps| f64::from(self.decoded) / fps);
        self.decoded += 1;
        Ok(Some(Frame::new(self.decoded, size, rgb).at_time(time)))
    }
}

impl Source for Camera {
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
        let name = &self.info.name;
        match &frame {
            None => {
                self.ended = true;
                self.warnings.push(format!(
                    "{name} returned no more images after frame {}; check its connection",
                    self.decoded
                ));
            }
            Some(frame) if frame.size != self.info.size => {
                self.ended = true;
                self.warnings.push(format!(
                    "{name} changes its size from {} to {} at frame {}; the frames before are used",
                    self.info.size, frame.size, frame.number
                ));
                return Ok(None);
            }
            Some(_) => {}
        }
        Ok(frame)
    }

    fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }
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
