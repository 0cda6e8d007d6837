//! CAVIAR's CVML: `<frame number><objectlist><object id><box xc yc w h>`, frames numbered from 0.

use roxmltree::Document;

use super::{IMPOSSIBLE_BOX, IMPOSSIBLE_NUMBER, TrackFile, at, bounds, number, whole};

/// Reads the objects, not the groups. Frame 0 becomes 1.
pub(super) fn read(document: &Document<'_>) -> Result<TrackFile, String> {
    let frames = || document.root_element().children().filter(|node| node.has_tag_name("frame"));
    if frames().next().is_none() {
        return Err("it has no <frame>; use CAVIAR's ground truth of a sequence".to_owned());
    }
    let mut file = TrackFile::new("CAVIAR CVML");
    for node in frames() {
        let frame = whole(number(node, "number")? + 1.0).ok_or_else(|| at(node, IMPOSSIBLE_NUMBER))?;
        let lists = node.children().filter(|node| node.has_tag_name("objectlist"));
        let objects = lists.flat_map(|list| list.children().filter(|node| node.has_tag_name("object")));
        for object in objects {
            let identity = whole(number(object, "id")?).ok_or_else(|| at(object, IMPOSSIBLE_NUMBER))?;
            let place = object.children().find(|node| node.has_tag_name("box"));
            let place = place.ok_or_else(|| at(object, "it has no <box>"))?;
            let [x, y, w, h] =
                [number(place, "xc")?, number(place, "yc")?, number(place, "w")?, number(place, "h")?];
            let sides = bounds([x - w / 2.0, y - h / 2.0, w, h]).ok_or_else(|| at(place, IMPOSSIBLE_BOX))?;
            file.insert(frame, identity, sides).map_err(|why| at(object, why))?;
        }
    }
    file.remarks.push("frame 0 is read as 1".to_owned());
    Ok(file)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::super::read_xml;
    use crate::truth::boxes::Bounds;

    #[test]
    fn boxes_are_around_their_centres_and_groups_are_none() {
        let text = r#"<?xml version="1.0" encoding="UTF-8"?>
<dataset name="walk">
 <frame number="0"><objectlist/><grouplist/></frame>
 <frame number="1">
  <objectlist><object id="3"><orientation>90</orientation><box h="30" w="10" xc="50" yc="40"/>
    <appearance>visible</appearance></object></objectlist>
  <grouplist><group id="9"><box h="99" w="99" xc="50" yc="40"/></group></grouplist>
 </frame>
</dataset>"#;
        let file = read_xml(text).unwrap();
        assert_eq!(file.count(), 1);
        assert_eq!(file.boxes[&2][&3], Bounds([45.0, 25.0, 10.0, 30.0]));
        assert!(read_xml(&text.replace("w=\"10\"", "w=\"x\"")).unwrap_err().contains("line 5"));
        assert!(read_xml("<dataset/>").unwrap_err().contains("<frame>"));
    }
}
