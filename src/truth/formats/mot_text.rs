//! MOTChallenge's text: `frame,id,x,y,w,h[,conf[,class[,visibility]]]`, or with x, y and z in the world after conf.
//!
//! Columns are separated by commas, semicolons, tabs or blanks. A header in the first line names the columns in any
//! order.

use super::{IMPOSSIBLE_BOX, IMPOSSIBLE_NUMBER, Role, TrackFile, bounds, whole};
use crate::truth::boxes::Bounds;
use crate::truth::counted;

/// MOTChallenge's class of pedestrians, who are judged.
const PEDESTRIAN: f64 = 1.0;
/// MOTChallenge's classes of what resembles a pedestrian: person on vehicle, static person, distractor, reflection.
const DISTRACTORS: [f64; 4] = [2.0, 7.0, 8.0, 12.0];
/// The last of MOTChallenge's classes.
const LAST_CLASS: f64 = 13.0;

const EXPECTED: &str = "expected numbers in MOTChallenge format: frame,id,x,y,w,h,conf,…";

/// Where each value is in a row.
struct Columns {
    frame: usize,
    identity: usize,
    corner: [usize; 2],
    extent: [usize; 2],
    /// Whether `extent` is the lower right corner instead of width and height.
    is_corner: bool,
    conf: Option<usize>,
    class: Option<usize>,
}

/// A row of numbers.
struct Row {
    line: usize,
    frame: f64,
    identity: f64,
    bounds: Bounds,
    conf: Option<f64>,
    class: Option<f64>,
}

/// Reads the tracks in `text`. Of ground truth, rows of confidence 0 are ignored, and MOTChallenge's classes hold unless
/// the file `has_labels` of its own. Fails with the line of what cannot be.
pub(super) fn read(text: &str, role: Role, has_labels: bool) -> Result<TrackFile, String> {
    let mut rows: Vec<Row> = Vec::new();
    let mut header: Option<Columns> = None;
    let mut is_first = true;
    for (line, content) in (1..).zip(text.lines()) {
        let comment = content.trim_start().strip_prefix(['#', '%']);
        let fields = fields(comment.unwrap_or(content));
        if fields.is_empty() {
            continue;
        }
        if is_first && fields.len() > 1 && fields.iter().all(|field| field.parse::<f64>().is_err()) {
            match Columns::named(&fields) {
                Ok(columns) => header = Some(columns),
                Err(_) if comment.is_some() => {}
                Err(missing) => {
                    return Err(format!(
                        "line {line} is `{}`: no column {missing}; {EXPECTED}",
                        shown(content)
                    ));
                }
            }
        } else if comment.is_none() {
            let row = row(&fields, header.as_ref(), line);
            rows.push(row.map_err(|why| format!("line {line} is `{}`: {why}", shown(content)))?);
        }
        is_first = false;
    }
    let classes = rows.iter().filter_map(|row| row.class);
    let is_class = |class: f64| class.fract() == 0.0 && (PEDESTRIAN..=LAST_CLASS).contains(&class);
    let has_classes = role == Role::Truth
        && !has_labels
        && rows.iter().all(|row| row.class.is_some_and(is_class))
        && classes.clone().any(|class| class == PEDESTRIAN);
    let mut file = TrackFile::new("MOTChallenge text");
    let (mut ignored, mut left_out) = (0, 0);
    for Row { line, frame, identity, bounds, conf, class } in rows {
        let frame = whole(frame).ok_or_else(|| format!("line {line}: {IMPOSSIBLE_NUMBER}"))?;
        let class = class.filter(|_| has_classes).unwrap_or(PEDESTRIAN);
        let is_distractor = DISTRACTORS.contains(&class);
        if class != PEDESTRIAN && !is_distractor {
            left_out += 1;
        } else if is_distractor || (role == Role::Truth && conf == Some(0.0)) {
            ignored += 1;
            file.ignore(frame, bounds);
        } else {
            let identity = whole(identity).ok_or_else(|| format!("line {line}: {IMPOSSIBLE_NUMBER}"))?;
            file.insert(frame, identity, bounds).map_err(|why| format!("line {line}: {why}"))?;
        }
    }
    if ignored > 0 {
        file.remarks.push(counted(
            ignored,
            "box of confidence 0 or a distractor's class is ignored",
            "boxes of confidence 0 or a distractor's class are ignored",
        ));
    }
    if left_out > 0 {
        file.remarks.push(counted(
            left_out,
            "box of a class other than pedestrian (1) is left out",
            "boxes of classes other than pedestrian (1) are left out",
        ));
    }
    Ok(file)
}

/// The values of a line, with points for decimal commas.
fn fields(line: &str) -> Vec<String> {
    let line = line.trim();
    if line.is_empty() {
        return Vec::new();
    }
    let clean = |field: &str| field.trim().trim_matches('"').trim().to_owned();
    let separated = |separator: char| line.split(separator).map(clean);
    let mut fields: Vec<String> =
        if let Some(separator) = [';', '\t'].into_iter().find(|it| line.contains(*it)) {
            separated(separator).map(|field| field.replace(',', ".")).collect()
        } else if line.contains(',') {
            separated(',').collect()
        } else {
            line.split_whitespace().map(clean).collect()
        };
    while fields.last().is_some_and(String::is_empty) {
        fields.pop();
    }
    fields
}

impl Columns {
    /// The columns that a header names, or the name of one that is missing.
    fn named(names: &[String]) -> Result<Self, &'static str> {
        let plain = |name: &String| -> String {
            name.to_lowercase().chars().filter(char::is_ascii_alphanumeric).collect()
        };
        let names: Vec<String> = names.iter().map(plain).collect();
        let find = |known: &[&str]| names.iter().position(|name| known.contains(&name.as_str()));
        let frame =
            find(&["frame", "frameid", "framenumber", "frameno", "frameindex", "f"]).ok_or("frame")?;
        let identity =
            find(&["id", "trackid", "identity", "objectid", "targetid", "track", "object"]).ok_or("id")?;
        let left = find(&["x", "left", "bbleft", "bboxleft", "xmin", "x1", "xtl"]).ok_or("x")?;
        let top = find(&["y", "top", "bbtop", "bboxtop", "ymin", "y1", "ytl"]).ok_or("y")?;
        let width = find(&["w", "width", "bbwidth", "bboxwidth"]);
        let height = find(&["h", "height", "bbheight", "bboxheight"]);
        let right = find(&["right", "xmax", "x2", "xbr"]);
        let bottom = find(&["bottom", "ymax", "y2", "ybr"]);
        let (extent, is_corner) = match (width, height, right, bottom) {
            (Some(width), Some(height), ..) => ([width, height], false),
            (_, _, Some(right), Some(bottom)) => ([right, bottom], true),
            (None, ..) => return Err("w"),
            _ => return Err("h"),
        };
        let conf = find(&["conf", "confidence", "score", "consider", "considered", "active"]);
        let class = find(&["class", "classid", "cls"]);
        Ok(Self { frame, identity, corner: [left, top], extent, is_corner, conf, class })
    }

    /// The columns of a row of this length without a header.
    fn standard(length: usize) -> Self {
        // In rows of ten, three coordinates in the world follow the confidence.
        let class = matches!(length, 8 | 9).then_some(7);
        Self { frame: 0, identity: 1, corner: [2, 3], extent: [4, 5], is_corner: false, conf: Some(6), class }
    }
}

fn row(fields: &[String], header: Option<&Columns>, line: usize) -> Result<Row, &'static str> {
    let standard = Columns::standard(fields.len());
    let columns = header.unwrap_or(&standard);
    let number = |at: usize| fields.get(at).and_then(|field| field.parse::<f64>().ok()).ok_or(EXPECTED);
    let [left, top, mut width, mut height] = [
        number(columns.corner[0])?,
        number(columns.corner[1])?,
        number(columns.extent[0])?,
        number(columns.extent[1])?,
    ];
    if columns.is_corner {
        (width, height) = (width - left, height - top);
    }
    let conf = columns.conf.filter(|&at| fields.get(at).is_some_and(|field| !field.is_empty()));
    let class = columns.class.and_then(|at| fields.get(at)?.parse().ok());
    Ok(Row {
        line,
        frame: number(columns.frame)?,
        identity: number(columns.identity)?,
        bounds: bounds([left, top, width, height]).ok_or(IMPOSSIBLE_BOX)?,
        conf: conf.map(number).transpose()?,
        class,
    })
}

/// The beginning of a line for a message.
fn shown(line: &str) -> String {
    let line: String = line.trim().chars().map(|it| if it.is_control() { ' ' } else { it }).collect();
    if line.chars().count() > 60 { line.chars().take(60).chain(['…']).collect() } else { line }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::truth::formats::text_of;

    fn truth(text: &str) -> Result<TrackFile, String> {
        read(&text_of(text.as_bytes()).unwrap(), Role::Truth, false)
    }

    #[test]
    fn separators_headers_and_line_ends_make_no_difference() {
        let expected = truth("1,1,10.5,20,5,6,1\n2,1,11.5,20,5,6,1\n").unwrap();
        assert_eq!(expected.boxes[&2][&1], Bounds([11.5, 20.0, 5.0, 6.0]));
        for text in [
            "1 1 10.5 20 5 6 1\n2  1 11.5 20 5 6 1\n",
            "1\t1\t10.5\t20\t5\t6\t1\n2\t1\t11.5\t20\t5\t6\t1",
            "1;1;10,5;20;5;6;1;\n2;1;11,5;20;5;6;1;\n",
            "1, 1, 10.5, 20, 5, 6, 1\r\n\r\n2, 1, 11.5, 20, 5, 6, 1\r\n",
            "1,1,10.5,20,5,6,1\r2,1,11.5,20,5,6,1\r",
            "\u{feff}1.0,1.0,10.5,20,5,6,1\n2.0,1e0,11.5,20,5,6,1\n",
            "frame,id,x,y,w,h,conf\n1,1,10.5,20,5,6,1\n2,1,11.5,20,5,6,1\n",
            "# made by hand\n# frame id x y w h\n1 1 10.5 20 5 6\n2 1 11.5 20 5 6\n",
            "id;frame;bb_left;bb_top;bb_width;bb_height\n1;1;10.5;20;5;6\n1;2;11.5;20;5;6\n",
            "Track ID,Frame,x1,y1,x2,y2\n1,1,10.5,20,15.5,26\n1,2,11.5,20,16.5,26\n",
        ] {
            assert_eq!(truth(text).as_ref(), Ok(&expected), "{text:?}");
        }
    }

    #[test]
    fn other_texts_fail_with_their_line() {
        for (text, parts) in [
            ("1,1,0,0,5,5,1\n1,2,0,0,5\n", &["line 2", "1,2,0,0,5"][..]),
            ("1,1,0,0,5,5,1\n1,1,9,0,5,5,1\n", &["line 2", "identity 1", "frame 1"]),
            ("1,1,0,0,5,5,1\n1.5,2,0,0,5,5,1\n", &["line 2", "whole"]),
            ("1,-1,0,0,5,5,1\n", &["line 1", "whole"]),
            ("1,1,0,0,-5,5,1\n", &["line 1", "negative"]),
            ("1,1,0,inf,5,5,1\n", &["line 1", "finite"]),
            ("frame,label,x,y,w,h\n", &["line 1", "no column id"]),
            ("frame,id,x,y\n1,1,2,3\n", &["line 1", "no column w"]),
            ("4294967296,1,0,0,5,5\n", &["line 1", "4294967295"]),
        ] {
            let why = truth(text).unwrap_err();
            assert!(parts.iter().all(|part| why.contains(part)), "{text:?}: {why}");
        }
        let all = truth("4294967295,4294967295,0,0,5,5\n").unwrap();
        assert!(all.boxes[&u32::MAX].contains_key(&u32::MAX));
    }

    #[test]
    fn confidence_0_and_distractors_are_ignored_and_other_classes_left_out() {
        let text = "1,1,0,0,5,5,1,1,1\n1,2,20,0,5,5,0,1,1\n1,3,40,0,5,5,1,7,1\n1,4,60,0,5,5,1,3,1\n";
        let file = truth(text).unwrap();
        assert_eq!((file.count(), file.ignored[&1].len()), (1, 2));
        assert_eq!(file.remarks.len(), 2, "{:?}", file.remarks);
        // Classes that a file with labels of its own names, world coordinates, and results.
        assert_eq!(read(text, Role::Truth, true).unwrap().count(), 3);
        assert_eq!(read(text, Role::Results, false).unwrap().count(), 4);
        assert_eq!(truth("1,1,0,0,5,5,1,7,2,3\n1,2,0,0,5,5,1,1,2,3\n").unwrap().count(), 2);
        assert_eq!(truth("1,1,0,0,5,5,1,-1,-1\n1,2,0,0,5,5,1,-1,-1\n").unwrap().count(), 2);
    }
}
