//! Tracks as a ZIP file of "MOT 1.1": `gt/gt.txt` and the names of its classes, `gt/labels.txt`.
//!
//! A row is `frame,id,x,y,w,h,1,1,visibility`: the seventh column says that the row counts, the eighth is the class.
//! Frames count from 1, pixels from 0.

use std::fmt::Write as _;
use std::io::{self, Write};

use super::number::significant;
use super::track_table::{CATEGORY, TrackTable};
use super::zip;

/// Writes the tracks.
pub fn write(out: &mut impl Write, table: &TrackTable) -> io::Result<()> {
    let mut rows = String::new();
    for object in &table.boxes {
        let frame = u64::from(object.frame - table.first) + 1;
        let [x, y, w, h] = [object.x, object.y, object.w, object.h].map(significant);
        let visibility = significant(object.visible_share);
        // Writing into a string does not fail.
        let _ = writeln!(rows, "{frame},{},{x},{y},{w},{h},1,1,{visibility}", object.id);
    }
    let labels = format!("{CATEGORY}\n");
    zip::write(out, &[("gt/gt.txt", rows.as_bytes()), ("gt/labels.txt", labels.as_bytes())])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::export::track_table::tests::table;
    use crate::export::zip::tests::contents;

    #[test]
    fn the_file_has_a_row_for_each_box_and_a_class() {
        let mut bytes = Vec::new();
        write(&mut bytes, &TrackTable { first: 3, ..table() }).unwrap();
        let files = contents(&bytes);
        let names: Vec<_> = files.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["gt/gt.txt", "gt/labels.txt"]);
        let text = String::from_utf8(files[0].1.clone()).unwrap();
        let rows: Vec<_> = text.lines().collect();
        assert_eq!(rows.len(), 6);
        assert_eq!(rows[0], "1,1,1.5,2.25,8,16,1,1,1");
        assert_eq!(rows[4], "5,4,32,2.25,8,16,1,1,0.25");
        assert_eq!(files[1].1, b"object\n");
    }
}
