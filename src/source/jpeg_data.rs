//! Whether the coded data of a JPEG holds the blocks that its header announces.
//!
//! A decoder makes a picture of any data: behind a changed bit or a stretch of zeros the codes mean other values at other
//! places, which the model would learn. As the codes differ in length, such data nearly always ends too early or too late,
//! or has a code that does not exist. The codes are followed without computing their values. Progressive and arithmetic
//! coding are not followed.

use std::iter;

const SCAN: u8 = 0xda;
const TABLES: u8 = 0xc4;
const RESTART_INTERVAL: u8 = 0xdd;
const END: u8 = 0xd9;
/// The starts of frames whose scans are followed: baseline, and sequential with Huffman codes.
const FOLLOWED_FRAMES: [u8; 2] = [0xc0, 0xc1];

/// Whether the data contradicts the header.
pub(super) fn is_damaged(jpeg: &[u8]) -> bool {
    let mut header = Header::default();
    let mut at = 2;
    loop {
        let Some((marker, segment)) = next_segment(jpeg, at) else { return false };
        at = segment.end;
        let Some(content) = jpeg.get(segment) else { return false };
        let followed = match marker {
            END => return false,
            TABLES => header.add_tables(content),
            RESTART_INTERVAL => header.set_restart_interval(content),
            marker if FOLLOWED_FRAMES.contains(&marker) => header.set_frame(content),
            // Other starts of frames, except tables and what is reserved between them.
            0xc2..=0xcf => None,
            SCAN => match header.scan(content) {
                Some(scan) => match scan.follow(&jpeg[at..]) {
                    Ok(length) => {
                        at += length;
                        Some(())
                    }
                    Err(Damaged) => return true,
                },
                None => None,
            },
            _ => Some(()),
        };
        if followed.is_none() {
            return false;
        }
    }
}

/// The data contradicts the header.
#[derive(Debug)]
struct Damaged;

/// The marker of the next segment from `at` on, and the place of its content.
fn next_segment(jpeg: &[u8], at: usize) -> Option<(u8, std::ops::Range<usize>)> {
    let mut at = at + memchr::memchr(0xff, jpeg.get(at..)?)?;
    while *jpeg.get(at)? == 0xff {
        at += 1;
    }
    let marker = jpeg[at];
    if marker == END {
        return Some((marker, at + 1..at + 1));
    }
    let length = u16::from_be_bytes([*jpeg.get(at + 1)?, *jpeg.get(at + 2)?]);
    Some((marker, at + 3..at + 1 + usize::from(length.max(2))))
}

/// The length and the value of the code at the start of each 16 bits; 0 where there is none.
type Codes = [(u8, u8)];

/// What was read of the header so far.
#[derive(Default)]
struct Header {
    /// By class, 0 of first coefficients and 1 of others, and index.
    tables: [[Option<Box<Codes>>; 4]; 2],
    /// Number of units between restarts; 0 without any.
    restart_interval: usize,
    width: usize,
    height: usize,
    components: Vec<Component>,
}

#[derive(Clone, Copy)]
struct Component {
    id: u8,
    /// Number of blocks of a unit in a row and in a column.
    across: usize,
    down: usize,
}

impl Header {
    fn add_tables(&mut self, mut content: &[u8]) -> Option<()> {
        while let Some((&kind, rest)) = content.split_first() {
            let (lengths, rest) = rest.split_at_checked(16)?;
            let count: usize = lengths.iter().map(|&count| usize::from(count)).sum();
            let (values, rest) = rest.split_at_checked(count)?;
            let place = self.tables.get_mut(usize::from(kind >> 4))?.get_mut(usize::from(kind & 15))?;
            *place = Some(code_table(lengths, values)?);
            content = rest;
        }
        Some(())
    }

    fn set_restart_interval(&mut self, content: &[u8]) -> Option<()> {
        self.restart_interval = usize::from(u16::from_be_bytes([*content.first()?, *content.get(1)?]));
        Some(())
    }

    fn set_frame(&mut self, content: &[u8]) -> Option<()> {
        let &[_, h1, h0, w1, w0, _, ref components @ ..] = content else { return None };
        (self.height, self.width) =
            (usize::from(u16::from_be_bytes([h1, h0])), usize::from(u16::from_be_bytes([w1, w0])));
        let components = components.as_chunks::<3>().0;
        self.components = components
            .iter()
            .map(|&[id, sides, _]| Component {
                id,
                across: usize::from(sides >> 4),
                down: usize::from(sides & 15),
            })
            .collect();
        let is_valid = |component: &Component| component.across > 0 && component.down > 0;
        // The height may follow the scan.
        (self.width > 0 && self.height > 0 && self.components.iter().all(is_valid)).then_some(())
    }

    /// The scan with this header; `None` if it cannot be followed.
    fn scan(&self, content: &[u8]) -> Option<Scan<'_>> {
        let (&count, rest) = content.split_first()?;
        let selected = rest.as_chunks::<2>().0.get(..usize::from(count))?;
        let mut blocks = Vec::new();
        let most = |side: fn(&Component) -> usize| self.components.iter().map(side).max();
        let (most_across, most_down) = (most(|it| it.across)?, most(|it| it.down)?);
        let mut units = self.width.div_ceil(8 * most_across) * self.height.div_ceil(8 * most_down);
        for &[id, tables] in selected {
            let component = self.components.iter().find(|component| component.id == id)?;
            let table = |class: usize, index: u8| self.tables[class].get(usize::from(index))?.as_deref();
            let tables = (table(0, tables >> 4)?, table(1, tables & 15)?);
            if selected.len() == 1 {
                // The blocks of a single component that hold pixels.
                let width = (self.width * component.across).div_ceil(most_across);
                let height = (self.height * component.down).div_ceil(most_down);
                units = width.div_ceil(8) * height.div_ceil(8);
                blocks.push(tables);
            } else {
                blocks.extend(iter::repeat_n(tables, component.across * component.down));
            }
        }
        (!blocks.is_empty()).then_some(Scan { units, restart_interval: self.restart_interval, blocks })
    }
}

/// The table of the codes of which `lengths` has the number of each length from 1 on.
fn code_table(lengths: &[u8], values: &[u8]) -> Option<Box<Codes>> {
    let mut table = Vec::with_capacity(1 << 16);
    let mut values = values.iter();
    for (length, &count) in (1..).zip(lengths) {
        for &value in values.by_ref().take(usize::from(count)) {
            table.extend(iter::repeat_n((length, value), 1 << (16 - length)));
            if table.len() > 1 << 16 {
                return None;
            }
        }
    }
    table.resize(1 << 16, (0, 0));
    Some(table.into())
}

/// A scan: units of blocks, each with the tables of its first and its other coefficients.
struct Scan<'a> {
    units: usize,
    restart_interval: usize,
    blocks: Vec<(&'a Codes, &'a Codes)>,
}

impl Scan<'_> {
    /// Follows the codes; returns the length of the data.
    fn follow(&self, data: &[u8]) -> Result<usize, Damaged> {
        let mut bits = Bits { data, at: 0, buffer: 0, count: 0 };
        for unit in 0..self.units {
            if self.restart_interval > 0 && unit > 0 && unit % self.restart_interval == 0 {
                bits.restart()?;
            }
            for &(first, others) in &self.blocks {
                bits.block(first, others)?;
            }
        }
        bits.finish()?;
        Ok(bits.at)
    }
}

/// Coded data, bit by bit up to the next marker.
struct Bits<'a> {
    data: &'a [u8],
    /// The place of the first byte that is not in `buffer`.
    at: usize,
    /// The next bits, the last of them lowest.
    buffer: u64,
    count: u32,
}

impl Bits<'_> {
    /// Has at least 32 bits ready, as far as there are any.
    fn fill(&mut self) {
        while self.count <= 48 {
            let Some(&byte) = self.data.get(self.at) else { return };
            if byte == 0xff {
                if self.data.get(self.at + 1) != Some(&0) {
                    return;
                }
                self.at += 1;
            }
            self.at += 1;
            self.buffer = self.buffer << 8 | u64::from(byte);
            self.count += 8;
        }
    }

    fn skip(&mut self, bits: u8) -> Result<(), Damaged> {
        self.count = self.count.checked_sub(u32::from(bits)).ok_or(Damaged)?;
        Ok(())
    }

    /// Reads a code and skips the bits of the value after it, whose number is in the lower half. At most 31 bits.
    fn code(&mut self, table: &Codes) -> Result<u8, Damaged> {
        if self.count < 32 {
            self.fill();
        }
        let next = if self.count >= 16 {
            self.buffer >> (self.count - 16)
        } else {
            self.buffer << (16 - self.count)
        };
        let (length, value) = table[(next & 0xffff) as usize];
        if length == 0 {
            return Err(Damaged);
        }
        self.skip(length + (value & 15))?;
        Ok(value)
    }

    fn block(&mut self, first: &Codes, others: &Codes) -> Result<(), Damaged> {
        self.code(first)?;
        let mut position = 1;
        while position < 64 {
            let value = self.code(others)?;
            let (zeros, bits) = (value >> 4, value & 15);
            if bits == 0 && zeros < 15 {
                return Ok(());
            }
            position += u32::from(zeros) + 1;
        }
        if position == 64 { Ok(()) } else { Err(Damaged) }
    }

    /// Goes to the marker behind the data. Only padding may be left: the rest of the last byte, and whole bytes of
    /// zeros or ones, which some encoders add where the data ends with a byte.
    fn finish(&mut self) -> Result<(), Damaged> {
        self.fill();
        self.count -= self.count % 8;
        while self.count > 0 {
            self.count -= 8;
            if !matches!((self.buffer >> self.count) & 0xff, 0 | 0xff) {
                return Err(Damaged);
            }
            if self.count == 0 {
                self.fill();
                self.count -= self.count % 8;
            }
        }
        Ok(())
    }

    /// Goes past the marker of a restart.
    fn restart(&mut self) -> Result<(), Damaged> {
        self.finish()?;
        while self.data.get(self.at + 1) == Some(&0xff) {
            self.at += 1;
        }
        match self.data.get(self.at + 1) {
            Some(0xd0..=0xd7) => self.at += 2,
            _ => return Err(Damaged),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use image::RgbImage;
    use image::codecs::jpeg::JpegEncoder;

    use super::*;

    fn jpeg(quality: u8) -> Vec<u8> {
        let mut bytes = Vec::new();
        let picture = RgbImage::from_fn(150, 101, |x, y| {
            image::Rgb([(x * y) as u8, (x * 5 % 91) as u8 * 2, (x ^ y) as u8])
        });
        JpegEncoder::new_with_quality(&mut bytes, quality).encode_image(&picture).unwrap();
        bytes
    }

    /// The place of the coded data.
    fn data(jpeg: &[u8]) -> std::ops::Range<usize> {
        let mut at = 2;
        loop {
            let (marker, segment) = next_segment(jpeg, at).unwrap();
            at = segment.end;
            if marker == SCAN {
                return at..jpeg.len() - 2;
            }
        }
    }

    #[test]
    fn whole_files_are_not_damaged_also_with_padding() {
        for quality in [1, 50, 100] {
            let whole = jpeg(quality);
            assert!(!is_damaged(&whole), "{quality}");
            let mut padded = whole.clone();
            padded.splice(whole.len() - 2..whole.len() - 2, [0; 9]);
            assert!(!is_damaged(&padded));
            padded.splice(padded.len() - 2..padded.len() - 2, [0xff; 5]);
            assert!(!is_damaged(&padded));
            // A whole byte of ones, with the zero that tells it from a marker.
            let mut padded = whole.clone();
            padded.splice(whole.len() - 2..whole.len() - 2, [0xff, 0]);
            assert!(!is_damaged(&padded));
            padded.splice(whole.len() - 2..whole.len(), [0x5a]);
            assert!(is_damaged(&padded));
        }
    }

    #[test]
    fn zeros_in_the_data_are_damage() {
        let whole = jpeg(75);
        let data = data(&whole);
        for (length, noticed) in [(20, 0.8), (200, 0.95), (2000, 0.95)] {
            let starts = (data.start..data.end - length).step_by(97);
            let damaged = starts.clone().filter(|&start| {
                let mut jpeg = whole.clone();
                jpeg[start..start + length].fill(0);
                is_damaged(&jpeg)
            });
            // By chance, other data can have as many blocks.
            let (damaged, all) = (damaged.count(), starts.count());
            let share = damaged as f64 / all as f64;
            assert!(share >= noticed, "{share} with {length} zeros");
        }
    }

    #[test]
    fn no_change_of_a_byte_is_a_panic() {
        let whole = jpeg(20);
        for at in 0..whole.len() {
            for change in [0xff, 1, 0x80] {
                let mut jpeg = whole.clone();
                jpeg[at] ^= change;
                is_damaged(&jpeg);
                is_damaged(&jpeg[..at]);
            }
        }
    }
}
