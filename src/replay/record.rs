//! What is kept of every analysed frame: all but the pixels, and those as runs.

use std::sync::Arc;

use crate::frame::{Mask, Size};
use crate::pipeline::Analysis;
use crate::regions::{LabelRun, Labels};

/// The analyses of a sequence from its first frame on.
pub(super) struct Record {
    size: Size,
    entries: Vec<Entry>,
    no_mask: Arc<Mask>,
    no_labels: Arc<Labels>,
}

struct Entry {
    /// With an empty mask and empty labels.
    analysis: Analysis,
    runs: Box<[u8]>,
    foreground_share: f32,
}

impl Record {
    pub(super) fn new(size: Size) -> Self {
        let none = Size::new(0, 0);
        Self {
            size,
            entries: Vec::new(),
            no_mask: Arc::new(Mask::empty(none)),
            no_labels: Arc::new(Labels::none(none)),
        }
    }

    /// How many frames are on record.
    pub(super) fn len(&self) -> u32 {
        self.entries.len() as u32
    }

    /// Takes in the analysis of the next frame.
    pub(super) fn push(&mut self, analysis: Analysis) {
        let runs = encode(&analysis.labels).into_boxed_slice();
        let foreground_share = analysis.mask.foreground_share();
        let analysis =
            Analysis { mask: Arc::clone(&self.no_mask), labels: Arc::clone(&self.no_labels), ..analysis };
        self.entries.push(Entry { analysis, runs, foreground_share });
    }

    /// Puts another reading in the place of one whose mask and regions stay.
    pub(super) fn replace(&mut self, position: u32, analysis: Analysis) {
        if let Some(entry) = self.entries.get_mut(position as usize) {
            entry.analysis = analysis;
        }
    }

    /// The analysis of a frame without its mask and labels, and its share of foreground.
    pub(super) fn outline(&self, position: u32) -> Option<(&Analysis, f32)> {
        self.entries.get(position as usize).map(|entry| (&entry.analysis, entry.foreground_share))
    }

    /// All analyses without their masks and labels.
    pub(super) fn outlines(&self) -> impl Iterator<Item = &Analysis> {
        self.entries.iter().map(|entry| &entry.analysis)
    }

    /// The analysis of a frame as it was.
    pub(super) fn analysis(&self, position: u32) -> Option<Analysis> {
        let entry = self.entries.get(position as usize)?;
        let (mask, labels) = decode(&entry.runs, self.size);
        Some(Analysis { mask: Arc::new(mask), labels: Arc::new(labels), ..entry.analysis.clone() })
    }
}

/// The runs of foreground, each as the background pixels before it, its length, and its label:
/// mask and labels follow from it. Each number is 7 bits a byte, the low ones first: a run takes 3
/// to 5 bytes.
fn encode(labels: &Labels) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut end = 0;
    for run in &labels.runs {
        write(&mut bytes, run.start - end);
        write(&mut bytes, run.length);
        write(&mut bytes, run.label);
        end = run.start + run.length;
    }
    bytes
}

fn decode(mut bytes: &[u8], size: Size) -> (Mask, Labels) {
    let mut mask = Mask::empty(size);
    let mut labels = Labels::none(size);
    let mut end = 0;
    while !bytes.is_empty() {
        let start = end + read(&mut bytes);
        let run = LabelRun { start, length: read(&mut bytes), label: read(&mut bytes) };
        mask.data[run.pixels()].fill(Mask::FOREGROUND);
        labels.runs.push(run);
        end = start + run.length;
    }
    (mask, labels)
}

fn write(bytes: &mut Vec<u8>, mut number: u32) {
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}

fn read(bytes: &mut &[u8]) -> u32 {
    let mut number = 0;
    for shift in (0..35).step_by(7) {
        let Some((&byte, rest)) = bytes.split_first() else { break };
        *bytes = rest;
        number |= u32::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            break;
        }
    }
    number
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mask and the labels of an image in which each pixel is background (`None`) or has a label.
    fn round_trip(size: Size, pixel: impl Fn(usize) -> Option<u32>) -> usize {
        let pixels: Vec<_> = (0..size.pixels()).map(pixel).collect();
        let mut labels = Labels::none(size);
        let mut start = 0;
        for row in pixels.chunks(size.width.max(1) as usize) {
            for run in row.chunk_by(|a, b| a == b) {
                let length = run.len() as u32;
                if let Some(label) = run[0] {
                    labels.runs.push(LabelRun { start, length, label });
                }
                start += length;
            }
        }
        let bytes = encode(&labels);
        let (mask, decoded) = decode(&bytes, size);
        assert!(decoded == labels);
        let expected = pixels.iter().map(|pixel| if pixel.is_some() { 255 } else { 0 });
        assert!(mask.size == size && mask.data.iter().copied().eq(expected));
        bytes.len()
    }

    #[test]
    fn masks_and_labels_come_back_as_they_were() {
        let size = Size::new(300, 200);
        assert_eq!(round_trip(size, |_| None), 0);
        assert_eq!(round_trip(size, |_| Some(0)), 200 * 4);
        round_trip(size, |_| Some(u32::MAX));
        round_trip(size, |i| (i % 2 == 0).then_some(0));
        round_trip(Size::new(0, 0), |_| None);
        round_trip(Size::new(1, 1), |_| Some(7));
        let bytes = round_trip(size, |i| match i * i % 1009 % 16 {
            0 => Some(i as u32 % 400),
            1 => Some(0),
            _ => None,
        });
        assert!(bytes < size.pixels(), "{bytes}");
    }
}
