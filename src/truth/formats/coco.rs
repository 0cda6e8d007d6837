//! COCO's JSON with tracks: `images` with a frame's number, `annotations` with `track_id` or `instance_id` and `bbox`.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use super::{IMPOSSIBLE_BOX, TrackFile, bounds};
use crate::truth::counted;
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

impl Image {
    /// The last number in the name of its file.
    fn named(&self) -> Option<u32> {
        last_number(self.file_name.as_deref()?.rsplit_once('.')?.0)
    }
}

/// Whether `frame_id` counts from 0: where one is 0, or where the numbers in the names of the files, else the `id`s, are one
/// more than all.
fn counts_from_zero(images: &[Image]) -> bool {
    let frames = || images.iter().filter_map(|image| image.frame_id);
    // What is added to all to get the other number.
    let addition = |other: &dyn Fn(&Image) -> Option<u64>| {
        let additions = images.iter().map(|image| other(image)?.checked_sub(image.frame_id?.into()));
        let additions: Option<BTreeSet<u64>> = additions.collect();
        additions.filter(|additions| additions.len() == 1)?.pop_first().filter(|addition| *addition <= 1)
    };
    let named = addition(&|image| image.named().map(u64::from));
    frames().any(|number| number == 0) || named.or_else(|| addition(&|image| Some(image.id))) == Some(1)
}

/// Reads the annotations of one video; those of crowds are ignored. The frame's number is `frame_id`, one more where it
/// [counts from 0](counts_from_zero), else the last number in `file_name`. Fails with the annotation that cannot be.
pub(super) fn read(text: &str) -> Result<TrackFile, String> {
    let Coco { images, annotations } = serde_json::from_str(text).map_err(|error| {
        format!("it is no COCO JSON with images, and annotations with image_id, track_id and bbox ({error})")
    })?;
    let videos: BTreeSet<_> = images.iter().filter_map(|image| image.video_id).collect();
    if videos.len() > 1 {
        return Err(format!("it has {} videos; leave the images and annotations of one", videos.len()));
    }
    let from_zero = counts_from_zero(&images);
    let mut numbers: BTreeMap<u64, u32> = BTreeMap::new();
    for image in &images {
        let number = match image.frame_id {
            Some(number) => number.checked_add(from_zero.into()),
            None => image.named(),
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
        file.remarks.push("frame_id counts from 0 and is read as one more".to_owned());
    }
    if ignored > 0 {
        file.remarks.push(counted(ignored, "box of a crowd is ignored", "boxes of crowds are ignored"));
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
        // A part of a video has no frame 0; the names of its images, or their ids, show where its numbers start.
        for (first, second, expected) in [
            (
                r#""frame_id":11,"file_name":"000012.png""#,
                r#""frame_id":12,"file_name":"000013.png""#,
                [12, 13],
            ),
            (
                r#""frame_id":12,"file_name":"000012.png""#,
                r#""frame_id":13,"file_name":"000013.png""#,
                [12, 13],
            ),
            (r#""frame_id":6,"file_name":"12.png""#, r#""frame_id":7,"file_name":"14.png""#, [7, 8]),
            (r#""frame_id":6"#, r#""frame_id":7"#, [7, 8]),
            (r#""frame_id":6,"file_name":"6.png""#, r#""frame_id":7,"file_name":"7.png""#, [6, 7]),
            (r#""frame_id":5"#, r#""frame_id":6"#, [5, 6]),
        ] {
            let part = text.replace("\"frame_id\":1", second).replace("\"frame_id\":0", first);
            assert_eq!(read(&part).unwrap().boxes.keys().copied().collect::<Vec<_>>(), expected, "{first}");
        }
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
