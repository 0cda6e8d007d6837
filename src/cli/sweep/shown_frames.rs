//! The frames of a sequence for the report, from the outcome of its pass.

use std::collections::BTreeMap;

use super::arguments::SweepJob;
use super::opened_sequence::OpenedSequence;
use crate::cli::flags::FrameRange;
use crate::cli::frames::{Frames, Item};
use crate::frame::Frame;
use crate::placement::Placement;
use crate::regions::rle;
use crate::sweep::pass::{Outcome, RecordedMask};
use crate::sweep::scoring;
use crate::sweep::sequence_frames::{
    FrameMeasure, SequenceFrames, ShownFrame, values_of_boxes, values_of_masks, worst_frames,
};
use crate::truth::analysed_frames::AnalysedFrames;
use crate::truth::boxes::{Bounds, Boxes, in_frames, shifted};
use crate::truth::comparison::Comparison;
use crate::truth::formats::TrackFile;
use crate::truth::summary;

/// Largest width of the frames that are kept for the report, whose pictures are as wide.
const SHOWN_WIDTH: u32 = 480;

/// The frames of a sequence under a combination, whose masks are recorded in its `outcome`; the worst are decoded again.
pub(super) fn frames_of(
    job: &SweepJob,
    sequence: &OpenedSequence,
    (index, combination): (usize, usize),
    outcome: &Outcome,
    analysed: &AnalysedFrames,
) -> anyhow::Result<SequenceFrames> {
    let placement = sequence.info.placement();
    let masks: &[RecordedMask] = outcome.masks.as_deref().map_or(&[], Vec::as_slice);
    let (measure, values) = match (&sequence.truth.tracks, &outcome.result) {
        _ if sequence.kinds.masks => (FrameMeasure::Mask, values_of_masks(masks)),
        (Some(truth), Some(result)) => {
            let boxes = scoring::source_boxes(result, placement.as_ref());
            let results = TrackFile { boxes, ..TrackFile::default() };
            let compared = Comparison::new(truth, &results, analysed, sequence.truth.offset);
            let numbers = masks.iter().map(|mask| mask.number);
            (FrameMeasure::Boxes, values_of_boxes(&compared.boxes, &compared.found, numbers))
        }
        _ => (FrameMeasure::Boxes, Vec::new()),
    };
    let worst = worst_frames(&values);
    let boxes = outcome.result.as_ref().map(summary::boxes_of).unwrap_or_default();
    let true_boxes = true_boxes(sequence, placement.as_ref());
    let mut shown = Vec::new();
    let mut inputs = read_frames(job, sequence, &worst)?;
    for (number, value) in worst {
        let mask = masks.iter().find(|mask| mask.number == number);
        let Some((input, mask)) = inputs.remove(&number).zip(mask) else { continue };
        let true_mask = match &sequence.truth.masks {
            Some(masks) => masks.read(number)?,
            None => None,
        };
        let frame = ShownFrame {
            value,
            true_mask: true_mask
                .map(|mask| placement.map_or(mask.clone(), |placement| mask.in_frame(&placement))),
            true_boxes: boxes_at(&true_boxes, number),
            mask: rle::decode_mask(&mask.runs, input.size),
            boxes: boxes_at(&boxes, number),
            input,
        };
        shown.push(frame.at_most(SHOWN_WIDTH));
    }
    Ok(SequenceFrames { sequence: index, combination, measure, values, worst: shown })
}

/// The true boxes in the numbers and pixels of the frames.
fn true_boxes(sequence: &OpenedSequence, placement: Option<&Placement>) -> Boxes {
    let Some(tracks) = &sequence.truth.tracks else { return Boxes::new() };
    let boxes = shifted(&tracks.boxes, sequence.truth.offset);
    match placement {
        Some(placement) => in_frames(&boxes, placement),
        None => boxes,
    }
}

fn boxes_at(boxes: &Boxes, number: u32) -> Vec<(u32, Bounds)> {
    boxes.get(&number).into_iter().flatten().map(|(identity, bounds)| (*identity, *bounds)).collect()
}

/// Decodes frames by number.
fn read_frames(
    job: &SweepJob,
    sequence: &OpenedSequence,
    wanted: &[(u32, f32)],
) -> anyhow::Result<BTreeMap<u32, Frame>> {
    let numbers = wanted.iter().map(|(number, _)| *number);
    let Some((first, last)) = numbers.clone().min().zip(numbers.clone().max()) else {
        return Ok(BTreeMap::new());
    };
    let mut found = BTreeMap::new();
    let mut frames = Frames::open(&sequence.video, job.options, Some(FrameRange { first, last }), None)?;
    for item in frames.items() {
        match item {
            Item::Frame(frame) if numbers.clone().any(|number| number == frame.number) => {
                found.insert(frame.number, frame);
            }
            Item::Failed(error) => return Err(error),
            Item::Frame(_) | Item::Warning(_) | Item::End => {}
        }
    }
    Ok(found)
}
