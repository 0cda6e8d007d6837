//! The results of the frames, kept until the files with the offline result are written.

use std::io;

use sha2::{Digest, Sha256};

use super::input_hash::{hexadecimal, is_images};
use super::result_spool::{ResultSpool, ResultWriter};
use crate::export::Staging;
use crate::frame::{Frame, Size};
use crate::pipeline::{Analysis, LateDecisions, Pipeline};
use crate::source::SourceInfo;

/// The recorded results of the whole sequence.
pub(super) struct RunRecord {
    /// The tracks and regions of the frames, with all events and episodes.
    pub results: ResultSpool,
    /// The numbers and times of the frames, in order.
    pub times: Vec<(u32, f64)>,
    /// Mean share of foreground pixels, 0..=1.
    pub foreground_share: f64,
    /// Warnings about the input, one sentence each.
    pub warnings: Vec<String>,
    /// The hash of all decoded frames; `None` for a camera or a video file, which has its own hash.
    pub frames_hash: Option<String>,
}

/// Records the results frame by frame.
pub(super) struct ResultRecorder {
    size: Size,
    spool: ResultWriter,
    decisions: LateDecisions,
    times: Vec<(u32, f64)>,
    foreground_pixels: usize,
    warnings: Vec<String>,
    hasher: Option<Sha256>,
}

impl ResultRecorder {
    /// Before the first frame of this source.
    pub(super) fn new(info: &SourceInfo, staging: &Staging) -> io::Result<Self> {
        Ok(Self {
            size: info.size,
            spool: ResultWriter::new(staging)?,
            decisions: LateDecisions::default(),
            times: Vec::new(),
            foreground_pixels: 0,
            warnings: Vec::new(),
            hasher: is_images(info).then(Sha256::new),
        })
    }

    /// Adds the next frame.
    pub(super) fn add(&mut self, frame: &Frame, analysis: &Analysis) -> io::Result<()> {
        if let Some(hasher) = &mut self.hasher {
            hasher.update(&frame.rgb);
        }
        self.foreground_pixels += analysis.mask.foreground_pixels();
        self.times.push((analysis.number, analysis.time));
        self.decisions.add(&analysis.settled, &analysis.events);
        self.spool.add(analysis)
    }

    /// Adds a warning about the input.
    pub(super) fn add_warning(&mut self, text: String) {
        self.warnings.push(text);
    }

    /// Number of frames so far.
    pub(super) const fn frames(&self) -> usize {
        self.times.len()
    }

    /// The record of all added frames, after `pipeline` has processed the last of them.
    pub(super) fn finish(mut self, pipeline: &Pipeline) -> io::Result<RunRecord> {
        self.decisions.finish(&pipeline.decide_pending());
        let pixels = self.times.len() * self.size.pixels();
        Ok(RunRecord {
            results: self.spool.finish(self.decisions)?,
            foreground_share: self.foreground_pixels as f64 / pixels as f64,
            times: self.times,
            warnings: self.warnings,
            frames_hash: self.hasher.map(|hasher| hexadecimal(&hasher.finalize())),
        })
    }
}
