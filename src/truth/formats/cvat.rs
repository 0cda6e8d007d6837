//! CVAT for video XML 1.1: `<track id label><box frame outside xtl ytl xbr ybr>`, frames numbered from 0.

use roxmltree::{Document, Node};

use super::{IMPOSSIBLE_BOX, IMPOSSIBLE_NUMBER, TrackFile, at, bounds, number, whole};
use crate::truth::counted;

/// Reads the tracks. Frame 0 becomes 1. A polygon counts as its bounding box; other shapes are left out.
pub(super) fn read(document: &Document<'_>) -> Result<TrackFile, String> {
    let tracks = || document.root_element().children().filter(|node| node.has_tag_name("track"));
    if tracks().next().is_none() {
        return Err("it has no <track>; export it as `CVAT for video 1.1`".to_owned());
    }
    let mut file = TrackFile::new("CVAT XML");
    let mut left_out = 0;
    for track in tracks() {
        let identity = whole(number(track, "id")?).ok_or_else(|| at(track, IMPOSSIBLE_NUMBER))?;
        for shape in track.children().filter(Node::is_element) {
            if shape.attribute("outside") == Some("1") {
                continue;
            }
            let place = match shape.tag_name().name() {
                "box" => of_box(shape)?,
                "polygon" => of_polygon(shape)?,
                _ => {
                    left_out += 1;
                    continue;
                }
            };
            let frame = whole(number(shape, "frame")? + 1.0).ok_or_else(|| at(shape, IMPOSSIBLE_NUMBER))?;
            let place = bounds(place).ok_or_else(|| at(shape, IMPOSSIBLE_BOX))?;
            file.insert(frame, identity, place).map_err(|why| at(shape, why))?;
        }
    }
    file.remarks.push("frame 0 is read as 1".to_owned());
    if left_out > 0 {
        file.remarks.push(counted(
            left_out,
            "shape other than boxes and polygons is left out",
            "shapes other than boxes and polygons are left out",
        ));
    }
    Ok(file)
}

fn of_box(shape: Node<'_, '_>) -> Result<[f64; 4], String> {
    let [left, top, right, bottom] =
        [number(shape, "xtl")?, number(shape, "ytl")?, number(shape, "xbr")?, number(shape, "ybr")?];
    let (width, height) = (right - left, bottom - top);
    let turn = shape.attribute("rotation").map_or(Ok(0.0), |_| number(shape, "rotation"))?;
    if turn == 0.0 || width < 0.0 || height < 0.0 {
        return Ok([left, top, width, height]);
    }
    // The box is turned about its centre.
    let (sine, cosine) = turn.to_radians().sin_cos();
    let w = width * cosine.abs() + height * sine.abs();
    let h = width * sine.abs() + height * cosine.abs();
    Ok([(left + right - w) / 2.0, (top + bottom - h) / 2.0, w, h])
}

fn of_polygon(shape: Node<'_, '_>) -> Result<[f64; 4], String> {
    let points = shape.attribute("points").unwrap_or_default();
    let corners = points.split(';').map(|point| {
        let (x, y) = point.split_once(',')?;
        Some((x.trim().parse::<f64>().ok()?, y.trim().parse::<f64>().ok()?))
    });
    let corners: Option<Vec<_>> = corners.collect();
    let corners = corners.ok_or_else(|| at(shape, "expected points=\"x,y;x,y;…\""))?;
    let least = |of: fn(&(f64, f64)) -> f64| corners.iter().map(of).fold(f64::INFINITY, f64::min);
    let most = |of: fn(&(f64, f64)) -> f64| corners.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
    let (left, top) = (least(|at| at.0), least(|at| at.1));
    Ok([left, top, most(|at| at.0) - left, most(|at| at.1) - top])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::super::read_xml;
    use crate::truth::boxes::Bounds;

    #[test]
    fn tracks_are_read_where_they_are_inside() {
        let text = r#"<?xml version="1.0" encoding="utf-8"?>
<annotations><version>1.1</version><meta/>
  <track id="0" label="person">
    <box frame="0" outside="0" occluded="0" keyframe="1" xtl="10.0" ytl="20.0" xbr="15.5" ybr="26.0" z_order="0"/>
    <box frame="1" outside="1" occluded="0" keyframe="1" xtl="10.0" ytl="20.0" xbr="15.5" ybr="26.0" z_order="0"/>
  </track>
  <track id="4" label="car">
    <box frame="1" outside="0" rotation="90" xtl="0" ytl="0" xbr="10" ybr="20"/>
    <polygon frame="2" outside="0" points="1.0,2.0;5.0,2.0;3.0,9.0"/>
    <points frame="3" outside="0" points="1.0,2.0"/>
  </track>
</annotations>"#;
        let file = read_xml(text).unwrap();
        assert_eq!((file.count(), file.remarks.len()), (3, 2));
        assert_eq!(file.boxes[&1][&0], Bounds([10.0, 20.0, 5.5, 6.0]));
        let [x, y, w, h] = file.boxes[&2][&4].0;
        let turned = [x + 5.0, y - 5.0, w - 20.0, h - 10.0];
        assert!(turned.iter().all(|off| off.abs() < 1e-9), "{x} {y} {w} {h}");
        assert_eq!(file.boxes[&3][&4], Bounds([1.0, 2.0, 4.0, 7.0]));
    }

    #[test]
    fn a_turned_box_is_the_one_around_it() {
        let text = r#"<annotations><track id="1">
    <box frame="0" rotation="30" xtl="0" ytl="10" xbr="20" ybr="20"/>
    <box frame="1" rotation="0" xtl="0" ytl="10" xbr="20" ybr="20"/></track></annotations>"#;
        let file = read_xml(text).unwrap();
        let (sine, cosine) = 30.0_f64.to_radians().sin_cos();
        let (w, h) = (20.0 * cosine + 10.0 * sine, 20.0 * sine + 10.0 * cosine);
        let expected = [10.0 - w / 2.0, 15.0 - h / 2.0, w, h];
        let found = file.boxes[&1][&1].0;
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} {expected:?}");
        assert_eq!(file.boxes[&2][&1], Bounds([0.0, 10.0, 20.0, 10.0]));
    }

    #[test]
    fn what_cannot_be_fails_with_its_line() {
        let images = "<annotations>\n<image id=\"0\" name=\"a.png\"/></annotations>";
        assert!(read_xml(images).unwrap_err().contains("CVAT for video"));
        let negative = "<annotations><track id=\"1\">\n<box frame=\"0\" xtl=\"5\" ytl=\"0\" xbr=\"1\" ybr=\"2\"/></track>\
             </annotations>";
        assert!(read_xml(negative).unwrap_err().contains("line 2"));
        let twice = negative
            .replace("xtl=\"5\"", "xtl=\"0\"")
            .replace("</track>", "\n<box frame=\"0\" xtl=\"0\" ytl=\"0\" xbr=\"1\" ybr=\"2\"/></track>");
        let why = read_xml(&twice).unwrap_err();
        assert!(why.contains("line 3") && why.contains("two boxes"), "{why}");
        assert!(read_xml("<annotations><track>").unwrap_err().contains("damaged"));
        assert!(read_xml("<svg/>").unwrap_err().contains("<svg>"));
    }
}
