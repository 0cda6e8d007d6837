//! The input, settings and results of a run, as one JSON file.

use std::io::{self, Write};

use serde::Serialize;

use crate::frame::Size;
use crate::occlusion::Counters;
use crate::settings::Settings;
use crate::source::Options;
use crate::truth::analysed_frames::AnalysedFrames;

/// The contents of `summary.json`. Equal inputs and settings give equal summaries, apart from [`Summary::timing`].
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The program's version.
    pub version: &'static str,
    /// The input.
    pub input: Input,
    /// The value of every setting.
    pub settings: Settings,
    /// The analysed share of the image, with `--roi`; the region is `roi.png` next to this file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub analysed_share: Option<f32>,
    /// Number of identities.
    pub objects: usize,
    /// Number of events of each kind.
    pub events: Counters,
    /// Number of occlusion episodes.
    pub episodes: usize,
    /// Mean share of foreground pixels, 0..=1.
    pub foreground_share: f64,
    /// The large files and folders that were written on request; others in the output folder are of earlier runs.
    pub large_files: Vec<&'static str>,
    /// Warnings about the input, one sentence each.
    pub warnings: Vec<String>,
    /// The duration of the analysis.
    pub timing: Timing,
}

/// The analysed input.
#[derive(Clone, Debug, Serialize)]
pub struct Input {
    /// The name given by the user.
    pub path: String,
    /// Width and height of the source's images, to whose pixels the files refer.
    pub size: Size,
    /// Width and height of the analysed frames, where they were cropped or scaled.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub analysed_size: Option<Size>,
    /// Frames per second of the source.
    pub fps: f32,
    /// The origin of the rate: `--fps`, `video`, `seqinfo.ini`, or `assumed`.
    pub fps_from: &'static str,
    /// The options with which it was read, unless it was read as it is.
    #[serde(skip_serializing_if = "Options::is_default")]
    pub options: Options,
    /// The requested range of frames, as in `100..250`, unless all were requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<String>,
    /// Number of analysed frames.
    pub frames: u32,
    /// The first frame number.
    pub first_frame: u32,
    /// The last frame number.
    pub last_frame: u32,
    /// The numbers of all analysed frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub analysed: Option<AnalysedFrames>,
    /// SHA-256 of the file, or of a folder's or pattern's images concatenated in order; `None` for a camera.
    pub sha256: Option<String>,
}

/// The duration of the analysis, including decoding and writing.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Timing {
    /// Wall time in seconds.
    pub seconds: f64,
    /// Frames per second of wall time.
    pub frames_per_second: f64,
}

/// Writes the summary as JSON with indentation.
pub fn write(out: &mut impl Write, summary: &Summary) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *out, summary)?;
    out.write_all(b"\n")
}
