//! Whether a JPEG is complete.

/// The markers of segments between scans, besides those of applications: Huffman tables, start of a scan, quantisation
/// tables, number of lines, restart interval, comment.
const BETWEEN_SCANS: [u8; 6] = [0xc4, SCAN, 0xdb, 0xdc, 0xdd, 0xfe];
const SCAN: u8 = 0xda;
const END: u8 = 0xd9;

/// Whether the end marker of a JPEG is missing. The decoder fills missing data with gray, which the model would learn.
///
/// The markers are followed from the start, so that neither the end of a thumbnail within a segment nor data behind the
/// end counts.
pub(super) fn is_cut_off(jpeg: &[u8]) -> bool {
    let mut at = 2;
    let mut in_scan = false;
    while let Some(next) = jpeg.get(at..).and_then(|rest| memchr::memchr(0xff, rest)) {
        at += next + 1;
        let Some(&marker) = jpeg.get(at) else { return true };
        if marker == END {
            return false;
        }
        // Before the first scan every marker starts a segment, except fill bytes and those without a length. Within
        // the data of a scan, other bytes after 0xff are data, restarts or damage.
        let is_segment = if in_scan {
            BETWEEN_SCANS.contains(&marker) || (0xe0..=0xef).contains(&marker)
        } else {
            !matches!(marker, 0x00 | 0x01 | 0xd0..=0xd8 | 0xff)
        };
        if is_segment {
            let Some(&[high, low]) = jpeg.get(at + 1..at + 3) else { return true };
            at += 1 + usize::from(u16::from_be_bytes([high, low]));
            in_scan |= marker == SCAN;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn jpeg() -> Vec<u8> {
        let mut bytes = Vec::new();
        let image = image::RgbImage::from_fn(40, 30, |x, y| image::Rgb([(x * y) as u8, x as u8, y as u8]));
        image.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Jpeg).unwrap();
        bytes
    }

    #[test]
    fn a_jpeg_is_complete_with_its_end_marker_and_with_anything_behind_it() {
        let whole = jpeg();
        assert!(!is_cut_off(&whole));
        let padded = [&whole[..], &vec![0; 3 * whole.len()]].concat();
        assert!(!is_cut_off(&padded));
        let two = [&whole[..], &whole[..whole.len() / 2]].concat();
        assert!(!is_cut_off(&two));
    }

    #[test]
    fn a_jpeg_is_cut_off_wherever_it_ends_before_its_end_marker() {
        let whole = jpeg();
        for length in 0..whole.len() {
            assert!(is_cut_off(&whole[..length]), "{length} of {}", whole.len());
        }
        // A thumbnail with an end marker, within a segment at the start.
        let thumbnail = [&[0xff, 0xe1][..], &(whole.len() as u16 + 2).to_be_bytes()[..], &whole[..]].concat();
        let mut with_thumbnail = whole.clone();
        with_thumbnail.splice(2..2, thumbnail);
        assert!(!is_cut_off(&with_thumbnail));
        for length in 0..with_thumbnail.len() {
            assert!(is_cut_off(&with_thumbnail[..length]), "{length} of {}", with_thumbnail.len());
        }
    }
}
