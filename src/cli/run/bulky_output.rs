//! The files and folders that are written only on request.

use crate::truth::run_summary::MASKS as MASKS_FOLDER;

/// A file or folder that is written only on request.
pub(super) struct BulkyOutput {
    /// The flag that requests it, without dashes.
    pub flag: &'static str,
    /// Its name in the output folder.
    pub file: &'static str,
    /// The help of the flag.
    pub help: &'static str,
}

pub(super) const MASKS: BulkyOutput = BulkyOutput {
    flag: "masks",
    file: MASKS_FOLDER,
    help: "masks/bin000001.png …: foreground masks, 0 or 255",
};
pub(super) const LABELS: BulkyOutput = BulkyOutput {
    flag: "labels",
    file: "labels",
    help: "labels/000001.png …: the identity of each pixel, 16-bit, 0 background",
};
pub(super) const FRAMES: BulkyOutput = BulkyOutput {
    flag: "frames",
    file: "frames",
    help: "frames/000001.png …: input frames with the results drawn on",
};
pub(super) const ANNOTATED: BulkyOutput =
    BulkyOutput { flag: "annotated", file: "annotated.mp4", help: "annotated.mp4: the same as a video" };
pub(super) const BACKGROUND: BulkyOutput = BulkyOutput {
    flag: "background",
    file: "background",
    help: "background/000001.png …: background model after each frame",
};
pub(super) const PLAIN_FRAMES: BulkyOutput = BulkyOutput {
    flag: "plain-frames",
    file: "plain-frames",
    help: "plain-frames/000001.png …: input frames as decoded",
};

/// All of them, in the order of the help.
pub(super) const ALL: [BulkyOutput; 6] = [MASKS, LABELS, FRAMES, ANNOTATED, BACKGROUND, PLAIN_FRAMES];
