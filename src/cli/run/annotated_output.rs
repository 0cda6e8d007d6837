//! The destination of annotated frames: images, a video, or both.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use rayon::prelude::*;

use super::arguments::RunJob;
use super::bulky_output::{ANNOTATED, FRAMES};
use super::pictures::numbered;
use crate::export::video::{VideoError, VideoFile, VideoKind};
use crate::export::{Staging, picture};
use crate::frame::Frame;
use crate::source::SourceInfo;

/// What else to do about frames that no encoder accepts.
const REMEDY: &str = "use --frames in place of --annotated";

/// The destination of annotated frames.
///
/// A frame that no encoder accepts ends the video alone, so that images and tables are still written. A file that cannot be
/// written ends the run.
pub(super) struct AnnotatedOutput {
    frames: Option<PathBuf>,
    video: Option<Result<VideoFile, VideoError>>,
    video_path: PathBuf,
}

impl AnnotatedOutput {
    /// Creates the requested folder and video file.
    pub(super) fn new(job: &RunJob, info: &SourceInfo, staging: &Staging) -> anyhow::Result<Self> {
        let frames = job.wants(&FRAMES).then(|| staging.folder(FRAMES.file)).transpose()?;
        let video_path = staging.path(ANNOTATED.file);
        let mut output = Self { frames, video: None, video_path };
        if job.wants(&ANNOTATED) {
            let (path, kind) = (&output.video_path, VideoKind::Playback);
            match VideoFile::create(kind, path, info.size, info.fps, info.pixel_aspect) {
                Ok(video) => {
                    if !video.is_h264() {
                        job.console.note(&format!(
                            "warning: FFmpeg has no encoder for H.264 here: {} is MPEG-4 part 2, which browsers do not \
                             play; install FFmpeg with libx264",
                            ANNOTATED.file
                        ));
                    }
                    output.video = Some(Ok(video));
                }
                Err(VideoError::File(error)) => return Err(error.into()),
                Err(error) => {
                    job.console.note(&format!(
                        "warning: {} will not be written: {error}, or {REMEDY}",
                        ANNOTATED.file
                    ));
                    output.give_up_video(error);
                }
            }
        }
        Ok(output)
    }

    /// Whether frames are still to be written.
    pub(super) fn is_open(&self) -> bool {
        self.frames.is_some() || matches!(self.video, Some(Ok(_)))
    }

    /// Writes the next annotated frames. Fails where a file cannot be written.
    pub(super) fn write(&mut self, frames: &[Frame]) -> anyhow::Result<()> {
        if let Some(folder) = &self.frames {
            frames
                .par_iter()
                .try_for_each(|frame| picture::write_frame(&numbered(folder, frame.number), frame))?;
        }
        for frame in frames {
            let Some(Ok(video)) = &mut self.video else { break };
            match video.write(frame, frame.time) {
                Ok(()) => {}
                Err(VideoError::File(error)) => return Err(error.into()),
                Err(error) => self.give_up_video(error),
            }
        }
        Ok(())
    }

    /// Completes the video. Fails where its file cannot be written; returns the error that ended the video alone.
    pub(super) fn finish(self) -> anyhow::Result<anyhow::Result<()>> {
        match self.video.map_or(Ok(()), |video| video?.finish()) {
            Err(VideoError::File(error)) => Err(error.into()),
            finished => {
                if finished.is_err() {
                    remove(&self.video_path);
                }
                Ok(finished.map_err(|error| anyhow!("{error}, or {REMEDY}")))
            }
        }
    }

    /// Ends the video with this error.
    fn give_up_video(&mut self, error: VideoError) {
        self.video = Some(Err(error));
        // The images that are still to be written may need its space.
        remove(&self.video_path);
    }
}

/// Removes the incomplete file, which must not appear under its name.
fn remove(path: &Path) {
    // Fails where it was not created.
    let _ = fs::remove_file(path);
}
