//! Names of images, `seqinfo.ini` and `temporalROI.txt`: how the frames of a folder are numbered.
//!
//! A line is the name of a file; after a tab its text, in which `\r` ends lines. Files without text are images of one pixel.

use std::collections::BTreeSet;
use std::io::Cursor;
use std::sync::LazyLock;

use occluscope::source::{self, Options, SceneFolder, SourceKind};
use occluscope::sweep::data_set;
use occluscope::truth::masks::MaskFiles;
use occluscope::truth::{Truth, TruthSource};

use super::check_message;
use super::folder::Folder;

/// An image of one pixel.
static IMAGE: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut png = Cursor::new(Vec::new());
    image::GrayImage::new(1, 1).write_to(&mut png, image::ImageFormat::Png).unwrap();
    png.into_inner()
});

pub fn run(data: &[u8]) {
    let folder = Folder::new();
    let lines: Vec<&[u8]> = data.split(|&byte| byte == b'\n').take(64).collect();
    for line in &lines {
        match line.iter().position(|&byte| byte == b'\t') {
            None => folder.write_any(line, &IMAGE),
            Some(tab) => {
                let text: Vec<u8> =
                    line[tab + 1..].iter().map(|&byte| if byte == b'\r' { b'\n' } else { byte }).collect();
                folder.write_any(&line[..tab], &text);
            }
        }
    }
    let path = folder.path().to_str().unwrap();
    read(path);
    // The first name as a pattern.
    if let Some(pattern) = lines.first().and_then(|name| std::str::from_utf8(name).ok())
        && !pattern.contains(['/', '\0'])
        && !pattern.contains("..")
    {
        let name = format!("{path}/{pattern}");
        // Videos are FFmpeg's.
        if !matches!(SourceKind::of(&name), Ok(SourceKind::Video)) {
            read(&name);
        }
    }
    let _ = (SceneFolder::at(folder.path()), data_set::sequences_below(folder.path()).unwrap());
    match TruthSource::of(folder.path()) {
        Ok(_) => {
            let _ = Truth::read(folder.path()).map_err(|error| check_message(&error.to_string()));
        }
        Err(error) => check_message(&error.to_string()),
    }
    match MaskFiles::of_folder(folder.path()) {
        Ok(files) => {
            let numbers: Vec<u32> = files.numbers().collect();
            assert!(numbers.is_sorted_by(|a, b| a < b), "{numbers:?}");
        }
        Err(error) => check_message(&error.to_string()),
    }
}

/// The frames of a source have rising numbers and times, and their count is as it was announced.
fn read(name: &str) {
    let mut source = match source::open(name, Options::default()) {
        Ok(source) => source,
        Err(error) => return check_message(&error.to_string()),
    };
    assert!(source.info().fps.is_finite() && source.info().fps > 0.0);
    let announced = source.info().frames;
    let (mut numbers, mut times) = (Vec::new(), Vec::new());
    loop {
        match source.next_frame() {
            Ok(Some(frame)) => {
                numbers.push(frame.number);
                times.push(frame.time);
            }
            Ok(None) => break,
            Err(error) => return check_message(&error.to_string()),
        }
    }
    let warnings = source.take_warnings();
    for warning in &warnings {
        check_message(warning);
    }
    assert!(numbers.is_sorted_by(|a, b| a < b), "{numbers:?}");
    assert!(times.iter().all(|time| time.is_finite()) && times.is_sorted_by(|a, b| a < b), "{times:?}");
    let distinct: BTreeSet<_> = numbers.iter().collect();
    assert!(announced.is_none_or(|count| distinct.len() <= count as usize));
    if warnings.is_empty() {
        assert_eq!(announced, Some(numbers.len() as u32));
    }
}
