//! Tracks as XML of "CVAT for video 1.1". Frames count from 0; every box is a keyframe. After the last box before a gap,
//! and after the last of all, one with `outside="1"` ends the object, except at the end of the video.

use std::collections::BTreeMap;
use std::io::{self, Write};

use super::number::significant;
use super::track_table::{CATEGORY, TrackBox, TrackTable};
use crate::tracking::Identity;

/// Writes the tracks.
pub fn write(out: &mut impl Write, table: &TrackTable) -> io::Result<()> {
    let last = table.frames.last().map_or(0, |number| number - table.first);
    writeln!(out, "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<annotations>\n<version>1.1</version>")?;
    writeln!(
        out,
        "<meta><task><name>{}</name><size>{}</size><mode>interpolation</mode><start_frame>0</start_frame>\
         <stop_frame>{last}</stop_frame><labels><label><name>{CATEGORY}</name><attributes></attributes></label></labels>\
         <original_size><width>{}</width><height>{}</height></original_size></task></meta>",
        escaped(&table.video),
        u64::from(last) + 1,
        table.size.width,
        table.size.height
    )?;
    let mut tracks: BTreeMap<Identity, Vec<&TrackBox>> = BTreeMap::new();
    for object in &table.boxes {
        tracks.entry(object.id).or_default().push(object);
    }
    for (id, boxes) in tracks {
        writeln!(out, "<track id=\"{id}\" label=\"{CATEGORY}\" source=\"auto\">")?;
        for (index, object) in boxes.iter().enumerate() {
            write_box(out, object, object.frame - table.first, false)?;
            let Some(next) = object.frame.checked_add(table.every) else { continue };
            let continues = boxes.get(index + 1).is_some_and(|after| after.frame <= next);
            if !continues && next - table.first <= last {
                write_box(out, object, next - table.first, true)?;
            }
        }
        writeln!(out, "</track>")?;
    }
    writeln!(out, "</annotations>")
}

fn write_box(out: &mut impl Write, object: &TrackBox, frame: u32, outside: bool) -> io::Result<()> {
    let [left, top] = [object.x, object.y].map(significant);
    // The sums of f32 are exact in f64.
    let end = |start: f32, length: f32| significant(f64::from(start) + f64::from(length));
    let (right, bottom) = (end(object.x, object.w), end(object.y, object.h));
    let (outside, occluded) = (u8::from(outside), u8::from(object.is_occluded()));
    writeln!(
        out,
        "<box frame=\"{frame}\" keyframe=\"1\" outside=\"{outside}\" occluded=\"{occluded}\" xtl=\"{left}\" \
         ytl=\"{top}\" xbr=\"{right}\" ybr=\"{bottom}\" z_order=\"0\"></box>"
    )
}

/// The text without what XML reserves or cannot hold.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            _ if character.is_control() || "\u{fffe}\u{ffff}".contains(character) => escaped.push('?'),
            _ => escaped.push(character),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use roxmltree::{Document, Node};

    use super::*;
    use crate::export::tests::written;
    use crate::export::track_table::tests::table;

    fn attributes(node: Node<'_, '_>, names: [&str; 4]) -> [String; 4] {
        names.map(|name| node.attribute(name).unwrap().to_owned())
    }

    #[test]
    fn objects_end_where_their_boxes_do() {
        let text = written(|out| write(out, &table()));
        let document = Document::parse(&text).unwrap();
        let named = |name: &'static str| document.descendants().filter(move |node| node.has_tag_name(name));
        assert_eq!(named("version").next().unwrap().text(), Some("1.1"));
        assert_eq!(named("name").next().unwrap().text(), Some("a <b> & \"c\".mp4"));
        assert_eq!(named("size").next().unwrap().text(), Some("9"));
        let of_track = |track: Node<'_, '_>| -> Vec<[String; 4]> {
            let boxes = track.children().filter(Node::is_element);
            boxes.map(|node| attributes(node, ["frame", "outside", "occluded", "xtl"])).collect()
        };
        let tracks: Vec<_> =
            named("track").map(|track| (track.attribute("id").unwrap(), of_track(track))).collect();
        let first =
            [["2", "0", "0", "1.5"], ["4", "0", "0", "2.5"], ["6", "0", "0", "3.5"], ["8", "1", "0", "3.5"]];
        let second =
            [["2", "0", "0", "30"], ["4", "1", "0", "30"], ["6", "0", "1", "32"], ["8", "0", "0", "33"]];
        let expected = |boxes: [[&str; 4]; 4]| boxes.map(|row| row.map(str::to_owned)).to_vec();
        assert_eq!(tracks, [("1", expected(first)), ("4", expected(second))]);
        let sides = attributes(named("box").next().unwrap(), ["xbr", "ytl", "ybr", "keyframe"]);
        assert_eq!(sides, ["9.5", "2.25", "18.25", "1"]);
    }

    #[test]
    fn the_last_frame_can_have_any_number() {
        let last = TrackBox { frame: u32::MAX, ..table().boxes[0].clone() };
        let table = TrackTable { first: 0, frames: vec![u32::MAX], boxes: vec![last], ..table() };
        let text = written(|out| write(out, &table));
        assert!(text.contains("<size>4294967296</size>") && text.matches("<box").count() == 1, "{text}");
    }

    #[test]
    fn names_with_reserved_characters_are_read_back() {
        let video = "]]> &amp; <\u{1}\u{ffff}ü>".to_owned();
        let text = written(|out| write(out, &TrackTable { video, ..table() }));
        let document = Document::parse(&text).unwrap();
        let name = document.descendants().find(|node| node.has_tag_name("name")).unwrap();
        assert_eq!(name.text(), Some("]]> &amp; <??ü>"));
    }
}
