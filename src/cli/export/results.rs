//! Reads the tracks of a results folder.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use crate::cli::console::Console;
use crate::export::track_table::{TrackBox, TrackTable};
use crate::truth::run_summary::{self, RunInput, RunSummary};
use anyhow::{Context as _, bail};

/// The tracks of a results folder, for a tool whose first frame has the number `first`. Notes if not all frames are
/// known.
pub(super) fn read(folder: &Path, first: u32, console: Console) -> anyhow::Result<TrackTable> {
    if !folder.is_dir() {
        bail!("{} is not a results folder; give the output folder of `run --out`", folder.display());
    }
    let summary = folder.join(run_summary::FILE);
    let Some(RunSummary { input, .. }) = RunSummary::read(folder)? else {
        bail!("{} does not exist; give the output folder of `run --out`", summary.display());
    };
    let (Some(size), Some(fps)) = (input.size, input.fps) else {
        bail!("{} does not state the size and rate of the video; run again", summary.display());
    };
    let tracks = folder.join("tracks.json");
    let mut boxes = boxes_in(&tracks)?;
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
        [x, y, w * h, visible_share].iter().all(|value| value.is_finite()) && w >= 0.0 && h >= 0.0
    };
    if let Some(object) = boxes.iter().find(|object| !is_valid(object)) {
        bail!(
            "{}: the box of {} in frame {} is invalid; run again",
            tracks.display(),
            object.id,
            object.frame
        );
    }
    let twice = boxes.windows(2).find(|pair| (pair[0].frame, pair[0].id) == (pair[1].frame, pair[1].id));
    if let Some([object, _]) = twice {
        bail!(
            "{}: object {} has two boxes in frame {}; run again",
            tracks.display(),
            object.id,
            object.frame
        );
    }
    let (frames, every) = frames(&input, &boxes, folder, console);
    if let Some(object) = boxes.iter().find(|object| frames.binary_search(&object.frame).is_err()) {
        bail!(
            "frame {} of {} is not in summary.json; the files are not of the same run; run again",
            object.frame,
            tracks.display()
        );
    }
    Ok(TrackTable { video: input.path, size, fps, first, frames, every, boxes })
}

fn boxes_in(path: &Path) -> anyhow::Result<Vec<TrackBox>> {
    let file = File::open(path)
        .with_context(|| format!("{} cannot be read; check its permissions, or run again", path.display()))?;
    serde_json::from_reader(BufReader::new(file))
        .with_context(|| format!("{} cannot be read as the tracks of a run; run again", path.display()))
}

/// The numbers of the analysed frames, the first of which is not after the last, and their distance.
fn frames(input: &RunInput, boxes: &[TrackBox], folder: &Path, console: Console) -> (Vec<u32>, u32) {
    let &RunInput { frames, first_frame, last_frame, .. } = input;
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
