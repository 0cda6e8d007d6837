//! What was analysed, how, and what came of it, in one JSON file.

use std::io::{self, Write};

use serde::Serialize;

use crate::frame::Size;
use crate::occlusion::Counters;
use crate::settings::Settings;

/// All that `summary.json` says. Equal inputs and settings give equal summaries, [`Summary::timing`] apart.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The program's version.
    pub version: &'static str,
    /// What was analysed.
    pub input: Input,
    /// The value of every setting.
    pub settings: Settings,
    /// The share of the image that was analysed, where `--roi` said which: `roi.png` beside this file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub analysed_share: Option<f32>,
    /// How many objects were given an identity.
    pub objects: usize,
    /// Events of each kind.
    pub events: Counters,
    /// Occlusion episodes.
    pub episodes: usize,
    /// Mean share of foreground pixels, 0..=1.
    pub foreground_share: f64,
    /// What went wrong with the input without ending the work, a sentence each.
    pub warnings: Vec<String>,
    /// How long it took.
    pub timing: Timing,
}

/// The frames that were analysed.
#[derive(Clone, Debug, Serialize)]
pub struct Input {
    /// As the user named it.
    pub path: String,
    /// Width and height in pixels.
    pub size: Size,
    /// Frames a second.
    pub fps: f32,
    /// What says so: `--fps`, `video`, `seqinfo.ini`, or `assumed` where nothing does.
    pub fps_from: &'static str,
    /// How many frames were analysed.
    pub frames: u32,
    /// The number of the first of them.
    pub first_frame: u32,
    /// The number of the last of them.
    pub last_frame: u32,
    /// SHA-256 of the file, of a folder's or pattern's images one after the other in order; none of a camera.
    pub sha256: Option<String>,
}

/// How long the analysis took, decoding and writing included.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Timing {
    /// Wall time in seconds.
    pub seconds: f64,
    /// Frames by wall time.
    pub frames_per_second: f64,
}

/// Writes the summary as JSON with indentation.
pub fn write(out: &mut impl Write, summary: &Summary) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *out, summary)?;
    out.write_all(b"\n")
}
