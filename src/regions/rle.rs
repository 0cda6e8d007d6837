//! Run-length encoding of masks and labels: a few bytes per run in place of several per pixel.
//!
//! Numbers are encoded with 7 bits per byte, the low ones first (LEB128).

use std::ops::Range;

use crate::frame::{Mask, Size};
use crate::regions::{LabelRun, Labels};

/// Encodes labels as runs of foreground: for each the number of background pixels before it, its length, and its
/// label.
pub(crate) fn encode_labels(labels: &Labels) -> Box<[u8]> {
    let mut bytes = Vec::new();
    let mut end = 0;
    for run in &labels.runs {
        write(&mut bytes, run.start - end);
        write(&mut bytes, run.length);
        write(&mut bytes, run.label);
        end = run.start + run.length;
    }
    bytes.into()
}

/// Decodes labels, and the mask that they imply.
pub(crate) fn decode_labels(mut bytes: &[u8], size: Size) -> (Mask, Labels) {
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

/// Calls `take` with the pixels of each run of labels, in order.
pub(crate) fn for_each_labelled_run(mut bytes: &[u8], mut take: impl FnMut(Range<usize>)) {
    let mut end = 0;
    while !bytes.is_empty() {
        let start = end + read(&mut bytes) as usize;
        end = start + read(&mut bytes) as usize;
        read(&mut bytes);
        take(start..end);
    }
}

/// Encodes a mask as runs of foreground: for each the number of background pixels before it, and its length.
pub(crate) fn encode_mask(mask: &Mask) -> Box<[u8]> {
    let mut bytes = Vec::new();
    let mut end = 0;
    for run in mask.runs() {
        write(&mut bytes, (run.start - end) as u32);
        write(&mut bytes, run.len() as u32);
        end = run.end;
    }
    bytes.into()
}

/// Decodes a mask.
pub(crate) fn decode_mask(bytes: &[u8], size: Size) -> Mask {
    let mut mask = Mask::empty(size);
    for_each_run(bytes, |run| mask.data[run].fill(Mask::FOREGROUND));
    mask
}

/// Calls `take` with the pixels of each run of a mask, in order.
pub(crate) fn for_each_run(mut bytes: &[u8], mut take: impl FnMut(Range<usize>)) {
    let mut end = 0;
    while !bytes.is_empty() {
        let start = end + read(&mut bytes) as usize;
        end = start + read(&mut bytes) as usize;
        take(start..end);
    }
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

    /// Encodes and decodes an image in which each pixel is background (`None`) or has a label.
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
        let bytes = encode_labels(&labels);
        let (decoded_mask, decoded) = super::decode_labels(&bytes, size);
        let mut runs = Vec::new();
        for_each_labelled_run(&bytes, |run| runs.push(run));
        assert!(runs.into_iter().eq(labels.runs.iter().map(|run| run.pixels())));
        assert!(decoded == labels);
        let expected = pixels.iter().map(|pixel| if pixel.is_some() { 255 } else { 0 });
        assert!(decoded_mask.size == size && decoded_mask.data.iter().copied().eq(expected));
        assert!(decode_mask(&encode_mask(&decoded_mask), size) == decoded_mask);
        bytes.len()
    }

    #[test]
    fn decoding_inverts_encoding_of_masks_and_labels() {
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
