//! COCO's JSON with tracks: `images` with a frame's number, `annotations` with `track_id` or `instance_id` and `bbox`.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use super::{IMPOSSIBLE_BOX, TrackFile, bounds};
use crate::truth::masks::last_number;

#[derive(Deserialize)]
struct Coco {
    images: Vec<Image>,
    annotations: Vec<Annotation>,
}

#[derive(Deserialize)]
struct Image {
    id: u64,
    video_id: Option<u64>,
    #[serde(alias = "frame_index")]
    frame_id: Option<u32>,
    file_name: Option<String>,
}

#[derive(Deserialize)]
struct Annotation {
    id: u64,
    image_id: u64,
    #[serde(alias = "instance_id")]
    track_id: Option<u32>,
    bbox: [f64; 4],
    #[serde(default)]
    iscrowd: u8,
}

/// Reads the annotations of one video; those of crowds are ignored. The frame's number is `frame_id`, else the last number
/// in `file_name`; where a `frame_id` is 0, all become one more. Fails with the annotation that cannot be.
pub(super) fn read(text: &str) -> Result<TrackFile, String> {
    let Coco { images, annotations } = serde_json::from_str(text).map_err(|error| {
        format!("it is no COCO JSON with images, and annotations with image_id, track_id and bbox ({error})")
    })?;
    let videos: BTreeSet<_> = images.iter().filter_map(|image| image.video_id).collect();
    if videos.len() > 1 {
        return Err(format!("it has {} videos; leave the images and annotations of one", videos.len()));
    }
    let from_zero = images.iter().any(|image| image.frame_id == Some(0));
    let mut numbers: BTreeMap<u64, u32> = BTreeMap::new();
    for image in &images {
        let named = || last_number(image.file_name.as_deref()?.rsplit_once('.')?.0);
        let number = match image.frame_id {
            Some(number) => number.checked_add(from_zero.into()),
            None => named(),
        };
        let number = number
            .ok_or_else(|| format!("image {} has no frame_id, and no number in its file_name", image.id))?;
        numbers.insert(image.id, number);
    }
    let mut file = TrackFile::new("COCO");
    let mut ignored = 0;
    for Annotation { id, image_id, track_id, bbox, iscrowd } in annotations {
        let fail = |why: String| format!("annotation {id}: {why}");
        let frame = *numbers.get(&image_id).ok_or_else(|| fail(format!("there is no image {image_id}")))?;
        let place = bounds(bbox).ok_or_else(|| fail(IMPOSSIBLE_BOX.to_owned()))?;
        if iscrowd != 0 {
            ignored += 1;
            file.ignore(frame, place);
            continue;
        }
        let identity = track_id.ok_or_else(|| fail("it has no track_id or instance_id".to_owned()))?;
        file.insert(frame, identity, place).map_err(fail)?;
    }
    if from_zero {
        file.remarks.push("frame 0 is read as 1".to_owned());
    }
    if ignored > 0 {
        file.remarks.push(format!("{ignored} boxes of crowds are ignored"));
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::truth::boxes::Bounds;

    #[test]
    fn annotations_have_the_numbers_of_their_images() {
        let text = r#"{"videos":[{"id":1}],
            "images":[{"id":7,"video_id":1,"frame_id":0},{"id":8,"video_id":1,"frame_id":1}],
            "annotations":[{"id":1,"image_id":7,"track_id":3,"bbox":[1,2,3.5,4]},
                           {"id":2,"image_id":8,"instance_id":3,"bbox":[2,2,3,4],"iscrowd":0},
                           {"id":3,"image_id":8,"bbox":[9,9,50,50],"iscrowd":1}]}"#;
        let file = read(text).unwrap();
        assert_eq!((file.count(), file.ignored[&2].len()), (2, 1));
        assert_eq!(file.boxes[&1][&3], Bounds([1.0, 2.0, 3.5, 4.0]));
        let named = text
            .replace("\"frame_id\":0", "\"file_name\":\"v2/img_0012.jpg\"")
            .replace("\"frame_id\":1", "\"file_name\":\"v2/img_0013.jpg\"");
        assert_eq!(read(&named).unwrap().boxes.keys().copied().collect::<Vec<_>>(), [12, 13]);
        for (from, to, part) in [
            ("\"track_id\":3,", "", "annotation 1"),
            ("3.5", "-3.5", "annotation 1"),
            ("\"image_id\":7", "\"image_id\":9", "no image 9"),
            ("\"id\":8,\"video_id\":1", "\"id\":8,\"video_id\":2", "2 videos"),
            ("\"annotations\"", "\"other\"", "COCO"),
        ] {
            let why = read(&text.replace(from, to)).unwrap_err();
            assert!(why.contains(part), "{from}: {why}");
        }
    }
}
