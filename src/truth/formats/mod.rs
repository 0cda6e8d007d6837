//! Readers of files of tracks: MOTChallenge's text, CVAT's and CAVIAR's XML, COCO's JSON, the archives that CVAT exports, and
//! label images.

mod archive;
mod caviar;
mod coco;
mod cvat;
pub mod label_images;
mod mot_text;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt::Display;
use std::fs;
use std::iter;
use std::path::Path;

use roxmltree::{Document, Node, ParsingOptions};

use self::archive::ArchivedTracks;
use super::TruthError;
use super::boxes::{Bounds, Boxes};
use super::ignored::Ignored;

/// What a file of tracks is read as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Ground truth: rows can be marked as not judged, and have MOTChallenge's classes.
    Truth,
    /// Results: each row counts.
    Results,
}

/// The content of a file of tracks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrackFile {
    /// The boxes that are judged.
    pub boxes: Boxes,
    /// The boxes that are neither found nor missed.
    pub ignored: Ignored,
    /// The format's name.
    pub format: &'static str,
    /// What was left out or changed, a clause each.
    pub remarks: Vec<String>,
}

impl TrackFile {
    fn new(format: &'static str) -> Self {
        Self { format, ..Self::default() }
    }

    /// Adds a box. Fails with the reason if the object has a box in the frame already.
    fn insert(&mut self, frame: u32, identity: u32, bounds: Bounds) -> Result<(), String> {
        match self.boxes.entry(frame).or_default().entry(identity) {
            Entry::Vacant(entry) => {
                entry.insert(bounds);
                Ok(())
            }
            Entry::Occupied(_) => {
                Err(format!("identity {identity} has two boxes in frame {frame}; leave one of them"))
            }
        }
    }

    fn ignore(&mut self, frame: u32, bounds: Bounds) {
        self.ignored.entry(frame).or_default().push(bounds);
    }

    /// The error that it, read from `path`, has no box that is judged.
    pub(super) fn without_box(&self, path: &Path) -> TruthError {
        let why =
            "no box of it is judged, so that no measure of tracks is defined; give ground truth with boxes";
        let clauses = iter::once(why).chain(self.remarks.iter().map(String::as_str));
        TruthError::new(path, clauses.collect::<Vec<_>>().join("; "))
    }

    /// Number of judged boxes.
    pub fn count(&self) -> usize {
        self.boxes.values().map(BTreeMap::len).sum()
    }
}

/// Reads a file of tracks, or a folder of label images. Fails with the line of what cannot be.
pub fn read(path: &Path, role: Role) -> Result<TrackFile, TruthError> {
    if path.is_dir() {
        return label_images::read(path, role);
    }
    let bytes = fs::read(path).map_err(|error| TruthError::unreadable(path, error))?;
    let content = || {
        if let Some(why) = other_file(path, role) {
            return Err(why.to_owned());
        }
        let (bytes, has_labels) = if archive::is_archive(&bytes) {
            let ArchivedTracks { bytes, has_labels } = archive::tracks(&bytes)?;
            (Cow::Owned(bytes), has_labels)
        } else {
            (Cow::Borrowed(&bytes[..]), path.with_file_name("labels.txt").is_file())
        };
        let text = text_of(&bytes)?;
        match text.trim_start().chars().next() {
            Some('<') => read_xml(&text),
            Some('{' | '[') => coco::read(&text),
            _ => mot_text::read(&text, role, has_labels),
        }
    };
    content().map_err(|why| TruthError::new(path, why))
}

/// What to give instead of a file whose name is that of one beside tracks.
fn other_file(path: &Path, role: Role) -> Option<&'static str> {
    match (path.file_name()?.to_str()?, role) {
        ("seqinfo.ini", Role::Truth) => {
            Some("it describes a MOTChallenge sequence; give the folder of the sequence, or gt/gt.txt in it")
        }
        ("seqinfo.ini", Role::Results) => Some("it describes a MOTChallenge sequence; give a file of tracks"),
        ("tracks.json" | "summary.json", _) => {
            Some("it is of the output of `run`; give tracks.csv beside it, or the folder as results")
        }
        _ => None,
    }
}

/// The text of a file in UTF-8 or a code page that has ASCII.
fn text_of(bytes: &[u8]) -> Result<String, &'static str> {
    if matches!(bytes, [0xFF, 0xFE, 0, 0, ..] | [0, 0, 0xFE, 0xFF, ..])
        || matches!(bytes, [0, 0, 0, other, ..] | [other, 0, 0, 0, ..] if *other != 0)
    {
        return Err("it is UTF-32 text; save it as UTF-8");
    }
    if bytes.starts_with(&[0xFF, 0xFE])
        || bytes.starts_with(&[0xFE, 0xFF])
        || matches!(bytes, [0, other, ..] | [other, 0, ..] if *other != 0)
    {
        return Err("it is UTF-16 text; save it as UTF-8");
    }
    if bytes.contains(&0) {
        return Err("it is no text; give a file of tracks");
    }
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    Ok(String::from_utf8_lossy(bytes).replace("\r\n", "\n").replace('\r', "\n"))
}

fn read_xml(text: &str) -> Result<TrackFile, String> {
    // The parser calls itself for each element within another.
    if depth(text) > MAX_DEPTH {
        return Err(format!(
            "its XML has more than {MAX_DEPTH} elements within each other; check that it is complete"
        ));
    }
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text.trim_start(), options)
        .map_err(|error| format!("its XML is damaged: {error}"))?;
    let root = document.root_element();
    match root.tag_name().name() {
        "annotations" => cvat::read(&document),
        "dataset" => caviar::read(&document),
        other => Err(format!(
            "unknown XML, whose root is <{other}>; use CVAT for video 1.1 (<annotations>) or CAVIAR's CVML (<dataset>)"
        )),
    }
}

/// Largest number of XML elements within each other; the formats have up to eight.
const MAX_DEPTH: usize = 100;

/// An upper bound of the number of elements within each other in an XML text.
fn depth(mut text: &str) -> usize {
    let (mut depth, mut deepest) = (0_usize, 0);
    while let Some(at) = text.find('<') {
        text = &text[at + 1..];
        let behind = |end: &str| text.find(end).map_or("", |at| &text[at + end.len()..]);
        if text.starts_with("!--") {
            text = behind("-->");
        } else if text.starts_with("![CDATA[") {
            text = behind("]]>");
        } else if text.starts_with('/') {
            depth = depth.saturating_sub(1);
        } else if !text.starts_with(['!', '?']) {
            let mut quote = None;
            let end = text.find(|c: char| {
                match quote {
                    Some(open) if c == open => quote = None,
                    None if matches!(c, '"' | '\'') => quote = Some(c),
                    _ => {}
                }
                c == '>' && quote.is_none()
            });
            let tag = &text[..end.unwrap_or(text.len())];
            if !tag.ends_with('/') {
                depth += 1;
                deepest = deepest.max(depth);
            }
            text = &text[tag.len()..];
        }
    }
    deepest
}

/// The number in an attribute of an element.
fn number(node: Node<'_, '_>, name: &str) -> Result<f64, String> {
    let value = node.attribute(name).ok_or_else(|| at(node, format!("it has no {name}")))?;
    value.trim().parse().map_err(|_| at(node, format!("{name} is `{value}`; expected a number")))
}

/// A message about an element, with its line.
fn at(node: Node<'_, '_>, why: impl Display) -> String {
    let line = node.document().text_pos_at(node.range().start).row;
    format!("line {line}, <{}>: {why}", node.tag_name().name())
}

/// A frame number or identity.
fn whole(value: f64) -> Option<u32> {
    let is_whole = value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value);
    is_whole.then_some(value as u32)
}

/// A box whose sides are finite and not negative.
fn bounds(sides: [f64; 4]) -> Option<Bounds> {
    (sides.iter().all(|side| side.is_finite()) && sides[2] >= 0.0 && sides[3] >= 0.0).then_some(Bounds(sides))
}

const IMPOSSIBLE_NUMBER: &str = "frame and id must be whole numbers from 0 to 4294967295";
const IMPOSSIBLE_BOX: &str = "box sides must be finite, and width and height not negative";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_depth_of_elements_is_counted() {
        for (text, expected) in [
            ("", 0),
            ("<a/>", 0),
            ("<a><b x='1'/><c></c></a><a></a>", 2),
            ("<?xml?><!-- <a><a> --><a x=\"</a><a>\"><b y='>'/><![CDATA[<a><a>]]></a>", 1),
            ("<a><a", 2),
            ("<", 1),
        ] {
            assert_eq!(depth(text), expected, "{text}");
        }
    }
}
