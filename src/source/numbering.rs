//! Frame numbers from file names.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::name_of;

/// The frames of a folder: files with their numbers, in order.
#[derive(Debug, PartialEq)]
pub(super) struct NumberedFiles {
    pub(super) files: Vec<(PathBuf, u32)>,
    /// What is unusual about the names, one sentence each.
    pub(super) warnings: Vec<String>,
}

/// The frames of an ordered list of images.
///
/// Where most names are equal apart from their numbers, other files are left out. The frame number is the last run of
/// digits in the name without the extension (`in000470.jpg` is 470) if all names have one and the numbers rise
/// strictly, else 1, 2, 3, … Fails with the reason if a frame is there in two formats.
pub(super) fn number_frames(mut files: Vec<PathBuf>) -> Result<NumberedFiles, String> {
    let mut warnings = Vec::new();
    let common = common_shape(&files);
    if let Some(common) = &common {
        let all = files.len();
        let (frames, strays): (Vec<_>, Vec<_>) =
            files.into_iter().partition(|file| shape(&stem(file)) == *common);
        files = frames;
        warnings.extend(stray_warning(&files, &strays, all));
    }
    check_copies(&files)?;
    let numbers: Option<Vec<u32>> = files.iter().map(|file| last_number(file)).collect();
    let numbers = match numbers {
        Some(numbers) if numbers.is_sorted_by(|a, b| a < b) => numbers,
        other => {
            warnings.extend(counting_warning(&files, other.as_deref(), common.is_some()));
            (1..).take(files.len()).collect()
        }
    };
    Ok(NumberedFiles { files: files.into_iter().zip(numbers).collect(), warnings })
}

/// A pattern that the names equal to this one apart from the last number match: `in%06d.png`.
fn pattern_of(file: &Path) -> Option<String> {
    let name = text(file);
    let (start, end) = last_digits(&stem(file))?;
    let digits = &name[start..end];
    let number = if digits.len() > 1 && digits.starts_with('0') {
        format!("%0{}d", digits.len())
    } else {
        "%d".to_owned()
    };
    let [before, after] = [&name[..start], &name[end..]].map(|part| part.replace('%', "%%"));
    Some(format!("{before}{number}{after}"))
}

/// The shape of more than half of the names.
fn common_shape(files: &[PathBuf]) -> Option<String> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for file in files {
        *counts.entry(shape(&stem(file))).or_default() += 1;
    }
    counts.into_iter().find(|(_, count)| 2 * count > files.len()).map(|(shape, _)| shape)
}

fn stray_warning(frames: &[PathBuf], strays: &[PathBuf], all: usize) -> Option<String> {
    let (example, stray) = (frames.first()?, strays.first()?);
    let (is, its, dots) =
        if strays.len() == 1 { ("is", "its name does", "") } else { ("are", "their names do", ", …") };
    Some(format!(
        "{} of {all} images {is} left out because {its} not fit the others, such as {}: {}{dots}; move what is no \
         frame out of the folder",
        strays.len(),
        text(example),
        text(stray),
    ))
}

/// Why frames are counted although their names have numbers; `numbers` are those, where all can be used.
fn counting_warning(files: &[PathBuf], numbers: Option<&[u32]>, is_common: bool) -> Option<String> {
    let first = files.first()?;
    let before = |file: &Path| last_digits(&stem(file)).map(|(start, _)| text(file)[..start].to_owned());
    let (why, a, b) = if !is_common {
        let numbered = files.iter().find(|file| last_digits(&stem(file)).is_some())?;
        let other = files.iter().find(|file| *file != numbered)?;
        ("have no common form", numbered, other)
    } else if let Some(other) = files.iter().find(|file| before(file) != before(first)) {
        ("differ before their last number", first, other)
    } else {
        let at = numbers?.windows(2).position(|pair| pair[0] >= pair[1])?;
        ("have one number", &files[at], &files[at + 1])
    };
    let pattern = pattern_of(a).unwrap_or_default();
    Some(format!(
        "frames are counted 1, 2, 3, … in the order of their names, because {} and {} {why}; give a pattern such as \
         {pattern} to read a part of them",
        text(a),
        text(b)
    ))
}

/// Fails if two files differ in the extension only.
fn check_copies(files: &[PathBuf]) -> Result<(), String> {
    let mut stems: BTreeMap<String, &Path> = BTreeMap::new();
    for file in files {
        if let Some(other) = stems.insert(stem(file), file) {
            let pattern = pattern_of(other)
                .map_or_else(String::new, |pattern| format!(", or give a pattern such as {pattern}"));
            return Err(format!(
                "{} and {} are copies of one image; keep one of them in the folder{pattern}",
                text(other),
                text(file)
            ));
        }
    }
    Ok(())
}

/// The name with `#` in place of each run of digits.
fn shape(stem: &str) -> String {
    let mut shape = String::new();
    for c in stem.chars() {
        match c {
            '0'..='9' if shape.ends_with('#') => {}
            '0'..='9' => shape.push('#'),
            c => shape.push(c),
        }
    }
    shape
}

/// Times of frames by their numbers: a gap in the numbers is a gap in time.
#[derive(Clone, Copy, Debug)]
pub(super) struct NumberClock {
    first: u32,
    /// Numbers per second.
    rate: f64,
}

impl NumberClock {
    /// For frames with these rising numbers at `fps` frames per second. The commonest step of the numbers, the smallest
    /// if there are several, is one frame: names can count in tens.
    pub(super) fn new(numbers: impl Iterator<Item = u32>, fps: f32) -> Self {
        let numbers: Vec<u32> = numbers.collect();
        let mut steps = BTreeMap::new();
        for pair in numbers.windows(2) {
            *steps.entry(pair[1].saturating_sub(pair[0])).or_insert(0_u32) += 1;
        }
        let commonest = steps.into_iter().rev().max_by_key(|(_, times)| *times).map_or(1, |(step, _)| step);
        let first = numbers.first().copied().unwrap_or_default();
        Self { first, rate: f64::from(fps) * f64::from(commonest.max(1)) }
    }

    /// The time of the frame with this number in seconds since the first.
    pub(super) fn time(self, number: u32) -> f64 {
        f64::from(number.saturating_sub(self.first)) / self.rate
    }
}

fn last_number(file: &Path) -> Option<u32> {
    let stem = stem(file);
    let (start, end) = last_digits(&stem)?;
    stem[start..end].parse().ok()
}

/// Where the last run of digits is.
fn last_digits(stem: &str) -> Option<(usize, usize)> {
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = stem[..end].trim_end_matches(|c: char| c.is_ascii_digit()).len();
    Some((start, end))
}

/// The file name without the extension.
fn stem(file: &Path) -> String {
    name_of(file.file_stem().unwrap_or_default())
}

/// The file name.
fn text(file: &Path) -> String {
    name_of(file.file_name().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

    use super::*;

    fn numbered(files: &[&str]) -> NumberedFiles {
        number_frames(files.iter().map(PathBuf::from).collect()).unwrap()
    }

    /// The numbers of files that are all frames.
    fn frame_numbers(files: &[&str]) -> Vec<u32> {
        let found = numbered(files);
        let (paths, numbers): (Vec<_>, Vec<_>) = found.files.into_iter().unzip();
        assert_eq!(paths, files.iter().map(PathBuf::from).collect::<Vec<_>>());
        numbers
    }

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
        assert_eq!(numbered(&["0.png", "1.jpg"]).warnings, Vec::<String>::new());
    }

    #[test]
    fn a_gap_in_the_numbers_is_a_gap_in_time() {
        let times = |numbers: &[u32]| -> Vec<f64> {
            let clock = NumberClock::new(numbers.iter().copied(), 10.0);
            numbers.iter().map(|number| clock.time(*number)).collect()
        };
        assert_eq!(times(&[470, 471, 475, 476]), [0.0, 0.1, 0.5, 0.6]);
        assert_eq!(times(&[0, 10, 20, 40]), [0.0, 0.1, 0.2, 0.4], "numbers that count in tens");
        assert_eq!(times(&[3, 7, 8]), [0.0, 0.4, 0.5], "of two steps that are as common, the smaller");
        assert_eq!(times(&[9]), [0.0]);
    }

    #[test]
    fn frames_are_counted_where_names_have_no_usable_numbers() {
        assert_eq!(frame_numbers(&["a.png", "b2.png"]), [1, 2]);
        assert_eq!(frame_numbers(&["1.png", "01.png"]), [1, 2], "not distinct");
        assert_eq!(frame_numbers(&["a2.png", "b1.png"]), [1, 2], "not rising");
        assert_eq!(frame_numbers(&["99999999999.png"]), [1], "too large");
        assert_eq!(numbered(&["a.png", "b.png", "c.png"]).warnings, Vec::<String>::new());
        assert_eq!(numbered(&["99999999999.png"]).warnings, Vec::<String>::new());
    }

    #[test]
    fn numbers_that_cannot_be_used_are_reported() {
        for (files, parts) in [
            (&["a.png", "b2.png"][..], ["b2.png and a.png have no common form", "b%d.png"]),
            (&["1.png", "01.png"][..], ["1.png and 01.png have one number", "%d.png"]),
            (
                &["d1_08.png", "d1_09.png", "d2_01.png"][..],
                ["d1_08.png and d2_01.png differ before their last number", "d1_%02d.png"],
            ),
        ] {
            let [warning] = &numbered(files).warnings[..] else { panic!("{files:?}") };
            assert!(parts.iter().all(|part| warning.contains(part)), "{warning}");
            assert!(warning.contains("counted 1, 2, 3"), "{warning}");
        }
        assert_eq!(
            numbered(&["d1_1.png", "d1_2.png", "d2_3.png"]).warnings,
            Vec::<String>::new(),
            "they rise"
        );
    }

    #[test]
    fn files_that_do_not_fit_the_others_are_left_out() {
        let found =
            numbered(&["background.jpg", "in000480 (1).jpg", "in000480.jpg", "in000481.jpg", "in000482.jpg"]);
        let frames: Vec<_> = (480..483).map(|n| (PathBuf::from(format!("in000{n}.jpg")), n)).collect();
        assert_eq!(found.files, frames);
        let [warning] = &found.warnings[..] else { panic!("{:?}", found.warnings) };
        for part in ["2 of 5 images are left out", "such as in000480.jpg", ": background.jpg, …"] {
            assert!(warning.contains(part), "{warning}");
        }
        let found = numbered(&["1.png", "2.png", "roi.png"]);
        let [warning] = &found.warnings[..] else { panic!("{:?}", found.warnings) };
        assert!(found.files.len() == 2 && warning.contains("1 of 3 images is left out"), "{warning}");
    }

    #[test]
    fn copies_in_another_format_are_refused() {
        let files = ["in%01.jpg", "in%01.png", "in%02.jpg"].map(PathBuf::from);
        let why = number_frames(files.to_vec()).unwrap_err();
        assert!(why.contains("in%01.jpg and in%01.png are copies") && why.contains("in%%%02d.jpg"), "{why}");
    }
}
