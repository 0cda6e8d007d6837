//! Writes an MPEG-4 video frame by frame.

use std::path::Path;

use opencv::core::{Mat, Size as CvSize, Vec3b};
use opencv::prelude::*;
use opencv::videoio::VideoWriter;

use crate::frame::{Frame, Size};

/// An MPEG-4 video in progress, a format that FFmpeg, OpenCV and common players read.
pub struct VideoFile {
    writer: VideoWriter,
    size: Size,
    bgr: Vec<u8>,
}

/// An error of writing a video.
#[derive(Debug, thiserror::Error)]
pub enum VideoError {
    /// OpenCV was built without an encoder, or the encoder does not support the size or rate.
    #[error("OpenCV cannot encode an MPEG-4 video of {size} at {fps} frames per second; omit `--annotated`")]
    Encoder {
        /// The video's size.
        size: Size,
        /// The video's frame rate.
        fps: f32,
    },
    /// Any other error of OpenCV.
    #[error("OpenCV failed to write the video: {0}")]
    OpenCv(#[from] opencv::Error),
}

impl VideoFile {
    /// Starts a video of `fps` frames per second. Fails if OpenCV cannot encode this size or rate.
    pub fn create(path: &Path, size: Size, fps: f32) -> Result<Self, VideoError> {
        let fourcc = VideoWriter::fourcc('m', 'p', '4', 'v')?;
        let cv_size = CvSize::new(size.width as i32, size.height as i32);
        let writer = VideoWriter::new(path, fourcc, fps.into(), cv_size, true)?;
        if !writer.is_opened()? {
            return Err(VideoError::Encoder { size, fps });
        }
        Ok(Self { writer, size, bgr: Vec::new() })
    }

    /// Adds a frame, which must have the video's size.
    pub fn write(&mut self, frame: &Frame) -> Result<(), VideoError> {
        self.bgr.clear();
        self.bgr.extend(frame.rgb.chunks_exact(3).flat_map(|rgb| [rgb[2], rgb[1], rgb[0]]));
        let (rows, columns) = (self.size.height as i32, self.size.width as i32);
        let image = Mat::new_rows_cols_with_bytes::<Vec3b>(rows, columns, &self.bgr)?;
        Ok(self.writer.write(&image)?)
    }

    /// Ends the file.
    pub fn finish(mut self) -> Result<(), VideoError> {
        Ok(self.writer.release()?)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use opencv::videoio::{CAP_ANY, VideoCapture};

    #[test]
    fn a_video_of_any_size_has_its_frames_in_order() {
        let folder = tempfile::tempdir().unwrap();
        for size in [Size::new(64, 48), Size::new(65, 47)] {
            let path = folder.path().join("video.mp4");
            let mut video = VideoFile::create(&path, size, 10.0).unwrap();
            for number in 1..=5 {
                let rgb = [number as u8 * 40, 0, 0].repeat(size.pixels());
                video.write(&Frame::new(number, size, rgb)).unwrap();
            }
            video.finish().unwrap();

            let mut read = VideoCapture::from_file(&path, CAP_ANY).unwrap();
            let mut image = Mat::default();
            let mut reds = Vec::new();
            while read.read(&mut image).unwrap() {
                reds.push(image.at_2d::<Vec3b>(20, 20).unwrap()[2]);
            }
            assert_eq!(reds.len(), 5, "{size}");
            assert!(reds.is_sorted_by(|a, b| a + 20 < *b), "{reds:?}");
        }
    }
}
