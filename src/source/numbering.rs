//! Frame numbers from file names.

use std::path::Path;

/// The frame number of each file of an ordered list: the last run of digits in its name without the extension
/// (`in000470.jpg` is 470) if all names have one and the numbers rise strictly, else 1, 2, 3, …
pub(super) fn frame_numbers(files: &[impl AsRef<Path>]) -> Vec<u32> {
    let named: Option<Vec<u32>> = files.iter().map(|file| last_number(file.as_ref())).collect();
    match named {
        Some(numbers) if numbers.is_sorted_by(|a, b| a < b) => numbers,
        _ => (1..).take(files.len()).collect(),
    }
}

fn last_number(file: &Path) -> Option<u32> {
    let stem = file.file_stem()?.to_string_lossy();
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = stem[..end].rfind(|c: char| !c.is_ascii_digit()).map_or(0, |at| {
        // The character before the digits may have several bytes.
        at + stem[at..].chars().next().map_or(1, char::len_utf8)
    });
    stem[start..end].parse().ok()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

    use super::*;

    #[test]
    fn frame_numbers_are_the_last_digits_of_names() {
        assert_eq!(frame_numbers(&["in000470.jpg", "in000471.jpg"]), [470, 471]);
        assert_eq!(frame_numbers(&["cam2_7x.png", "cam2_12x.png"]), [7, 12]);
        assert_eq!(
            frame_numbers(&["é5.jp2", "é6.jp2"]),
            [5, 6],
            "the extension's digits are not the frame's"
        );
        assert_eq!(frame_numbers(&["0.png", "1.png"]), [0, 1]);
    }

    #[test]
    fn frames_are_counted_where_names_have_no_usable_numbers() {
        assert_eq!(frame_numbers(&["a.png", "b2.png"]), [1, 2]);
        assert_eq!(frame_numbers(&["1.png", "01.png"]), [1, 2], "not distinct");
        assert_eq!(frame_numbers(&["a2.png", "b1.png"]), [1, 2], "not rising");
        assert_eq!(frame_numbers(&["99999999999.png"]), [1], "too large");
    }
}
