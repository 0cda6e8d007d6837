//! Reads the tracks of a results folder.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use anyhow::{Context as _, bail};
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::cli::console::Console;
use crate::export::track_table::{TrackBox, TrackTable};
use crate::frame::Size;
use crate::source::Options;
use crate::truth::analysed_frames::AnalysedFrames;

/// Largest number of frames that is believed of a summary, a month at 25 per second: their numbers are kept in memory.
const MAX_FRAMES: u32 = 1 << 26;

/// What is read of `summary.json`.
#[derive(Deserialize)]
struct Summary {
    input: Input,
}

#[derive(Deserialize)]
struct Input {
    path: String,
    size: Size,
    fps: f32,
    frames: u32,
    first_frame: u32,
    last_frame: u32,
    /// Older summaries do not have it.
    analysed: Option<AnalysedFrames>,
    #[serde(default)]
    options: Options,
}

/// The tracks of a results folder, for a tool whose first frame has the number `first`. Notes if not all frames are
/// known.
pub(super) fn read(folder: &Path, first: u32, console: Console) -> anyhow::Result<TrackTable> {
    if !folder.is_dir() {
        bail!("{} is not a results folder; give the output folder of `run --out`", folder.display());
    }
    let summary = folder.join("summary.json");
    let Summary { input } = json(&summary)?;
    if input.last_frame < input.first_frame {
        bail!(
            "{}: the last frame, {}, is before the first, {}; repeat the run",
            summary.display(),
            input.last_frame,
            input.first_frame
        );
    }
    if input.frames > MAX_FRAMES || !input.options.is_valid() {
        bail!("{} has numbers that no run has; repeat the run", summary.display());
    }
    let tracks = folder.join("tracks.json");
    let mut boxes: Vec<TrackBox> = json(&tracks)?;
    boxes.sort_by_key(|object| (object.frame, object.id));
    if input.first_frame < first {
        bail!(
            "{} begins at frame {}, before --first {first}; give a lower number",
            folder.display(),
            input.first_frame
        );
    }
    let is_valid = |object: &TrackBox| {
        let TrackBox { x, y, w, h, visible_share, .. } = *object;
        [x, y, w, h, visible_share].iter().all(|value| value.is_finite()) && w >= 0.0 && h >= 0.0
    };
    if let Some(object) = boxes.iter().find(|object| !is_valid(object)) {
        bail!(
            "{}: the box of {} in frame {} is invalid; repeat the run",
            tracks.display(),
            object.id,
            object.frame
        );
    }
    let (frames, every) = frames(&input, &boxes, folder, console);
    if let Some(object) = boxes.iter().find(|object| frames.binary_search(&object.frame).is_err()) {
        bail!(
            "frame {} of {} is not in summary.json; the files are not of the same run; repeat it",
            object.frame,
            tracks.display()
        );
    }
    Ok(TrackTable { video: input.path, size: input.size, fps: input.fps, first, frames, every, boxes })
}

fn json<T: DeserializeOwned>(path: &Path) -> anyhow::Result<T> {
    let failed = || format!("{} cannot be read; give the output folder of `run --out`", path.display());
    let file = File::open(path).with_context(failed)?;
    serde_json::from_reader(BufReader::new(file)).with_context(failed)
}

/// The numbers of the analysed frames, the first of which is not after the last, and their distance.
fn frames(input: &Input, boxes: &[TrackBox], folder: &Path, console: Console) -> (Vec<u32>, u32) {
    let &Input { frames, first_frame, last_frame, .. } = input;
    let every = input.options.every.map_or(1, u32::from);
    if let Some(analysed) = input.analysed.as_ref().filter(|analysed| analysed.count() == u64::from(frames)) {
        return (analysed.numbers().collect(), every);
    }
    if u64::from((last_frame - first_frame) / every) + 1 == u64::from(frames) {
        return ((first_frame..=last_frame).step_by(every as usize).collect(), every);
    }
    // Which numbers the images lack is not in older summaries.
    let with_boxes = boxes.iter().map(|object| object.frame);
    let known = with_boxes.filter(|number| (first_frame..=last_frame).contains(number));
    let known: BTreeSet<u32> = known.chain([first_frame, last_frame]).collect();
    console.note(&format!(
        "note: {} has gaps in its frame numbers; frames without objects are left out",
        folder.display()
    ));
    (known.into_iter().collect(), every)
}
