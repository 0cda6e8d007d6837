//! The destination of annotated frames: images, a video, or both.

use std::path::PathBuf;

use anyhow::Context as _;
use rayon::prelude::*;

use super::arguments::RunJob;
use super::bulky_output::{ANNOTATED, FRAMES};
use super::pictures::numbered;
use crate::export::video::VideoFile;
use crate::export::{Staging, picture};
use crate::frame::Frame;
use crate::source::SourceInfo;

/// The destination of annotated frames.
pub(super) struct AnnotatedOutput {
    frames: Option<PathBuf>,
    video: Option<VideoFile>,
}

impl AnnotatedOutput {
    /// Creates the requested folder and video file.
    pub(super) fn new(job: &RunJob, info: &SourceInfo, staging: &Staging) -> anyhow::Result<Self> {
        let frames = job
            .wants(&FRAMES)
            .then(|| staging.folder(FRAMES.file))
            .transpose()
            .with_context(|| job.out_failure())?;
        let video = job
            .wants(&ANNOTATED)
            .then(|| VideoFile::create(&staging.path(ANNOTATED.file), info.size, info.fps))
            .transpose()?;
        Ok(Self { frames, video })
    }

    /// Writes the next annotated frames.
    pub(super) fn write(&mut self, frames: &[Frame]) -> anyhow::Result<()> {
        if let Some(folder) = &self.frames {
            frames
                .par_iter()
                .try_for_each(|frame| picture::write_frame(&numbered(folder, frame.number), frame))?;
        }
        if let Some(video) = &mut self.video {
            for frame in frames {
                video.write(frame)?;
            }
        }
        Ok(())
    }

    /// Completes the video.
    pub(super) fn finish(self) -> anyhow::Result<()> {
        Ok(self.video.map_or(Ok(()), VideoFile::finish)?)
    }
}
