//! What is kept of every analysed frame: all but the pixels, and those as runs.

use std::sync::Arc;

use memchr::memchr;

use crate::frame::{Mask, Size};
use crate::pipeline::Analysis;
use crate::regions::Labels;

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
            no_labels: Arc::new(Labels { size: none, data: Vec::new() }),
        }
    }

    /// How many frames are on record.
    pub(super) fn len(&self) -> u32 {
        self.entries.len() as u32
    }

    /// Takes in the analysis of the next frame.
    pub(super) fn push(&mut self, analysis: Analysis) {
        let runs = encode(&analysis.mask.data, &analysis.labels.data).into_boxed_slice();
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

/// Runs of equal pixels in row order, each its length and what it is: 0 background, 1 foreground
/// of no region, 2 and above a region's label plus 1. A last run of background is left out.
///
/// Each number is 7 bits a byte, the low ones first: a run takes 2 to 4 bytes.
fn encode(mask: &[u8], labels: &[u32]) -> Vec<u8> {
    let mut runs = Vec::new();
    let mut end = 0;
    while let Some(background) = memchr(Mask::FOREGROUND, &mask[end..]) {
        let start = end + background;
        end = memchr(Mask::BACKGROUND, &mask[start..]).map_or(mask.len(), |length| start + length);
        if background > 0 {
            write(&mut runs, background as u32);
            write(&mut runs, 0);
        }
        for run in labels[start..end].chunk_by(|a, b| a == b) {
            write(&mut runs, run.len() as u32);
            write(&mut runs, run[0] + 1);
        }
    }
    runs
}

fn decode(mut runs: &[u8], size: Size) -> (Mask, Labels) {
    let mut mask = Mask::empty(size);
    let mut labels = Labels { size, data: vec![0; size.pixels()] };
    let mut start = 0;
    while !runs.is_empty() {
        let end = start + read(&mut runs) as usize;
        let kind = read(&mut runs);
        if kind > 0 {
            mask.data[start..end].fill(Mask::FOREGROUND);
            labels.data[start..end].fill(kind - 1);
        }
        start = end;
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

    fn round_trip(size: Size, pixel: impl Fn(usize) -> (u8, u32)) -> usize {
        let (mask, labels): (Vec<u8>, Vec<u32>) = (0..size.pixels()).map(pixel).unzip();
        let runs = encode(&mask, &labels);
        let (decoded, decoded_labels) = decode(&runs, size);
        assert!(decoded.data == mask && decoded_labels.data == labels);
        assert!(decoded.size == size && decoded_labels.size == size);
        runs.len()
    }

    #[test]
    fn masks_and_labels_come_back_as_they_were() {
        let size = Size::new(300, 200);
        assert_eq!(round_trip(size, |_| (0, 0)), 0);
        assert_eq!(round_trip(size, |_| (255, 0)), 4);
        round_trip(size, |_| (255, u32::MAX - 1));
        round_trip(size, |i| if i % 2 == 0 { (255, 0) } else { (0, 0) });
        round_trip(Size::new(0, 0), |_| (0, 0));
        round_trip(Size::new(1, 1), |_| (255, 7));
        let bytes = round_trip(size, |i| match i * i % 1009 % 16 {
            0 => (255, i as u32 % 400),
            1 => (255, 0),
            _ => (0, 0),
        });
        assert!(bytes < size.pixels(), "{bytes}");
    }
}
