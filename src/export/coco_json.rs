//! Tracks as COCO JSON with the keys for video: `videos`, `video_id` and `frame_id` of images, which counts from 0, and
//! `track_id` of annotations, which is the identity. The `id` of an image is the frame's number, its `file_name` that of
//! `run --plain-frames`. All objects have one category.

use std::io::{self, Write};

use serde::Serialize;

use super::track_table::{CATEGORY, TrackTable};
use crate::tracking::Identity;

/// The only video and the only category.
const ONLY: u32 = 1;

#[derive(Serialize)]
struct Dataset<'a> {
    videos: [Video<'a>; 1],
    images: Vec<Image>,
    annotations: Vec<Annotation>,
    categories: [Category; 1],
}

#[derive(Serialize)]
struct Video<'a> {
    id: u32,
    name: &'a str,
    width: u32,
    height: u32,
    fps: f32,
}

#[derive(Serialize)]
struct Image {
    id: u32,
    video_id: u32,
    frame_id: u32,
    file_name: String,
    width: u32,
    height: u32,
}

#[derive(Serialize)]
struct Annotation {
    id: u32,
    image_id: u32,
    video_id: u32,
    category_id: u32,
    track_id: Identity,
    bbox: [f32; 4],
    area: f32,
    /// No polygons. Readers expect the key.
    segmentation: [f32; 0],
    iscrowd: u8,
    attributes: Attributes,
}

#[derive(Serialize)]
struct Attributes {
    occluded: bool,
    /// CVAT reads it here.
    track_id: Identity,
}

#[derive(Serialize)]
struct Category {
    id: u32,
    name: &'static str,
}

/// Writes the tracks.
pub fn write(out: &mut impl Write, table: &TrackTable) -> io::Result<()> {
    let (width, height) = (table.size.width, table.size.height);
    let image = |&number: &u32| Image {
        id: number,
        video_id: ONLY,
        frame_id: number - table.first,
        file_name: format!("{number:06}.png"),
        width,
        height,
    };
    let annotations = (1..).zip(&table.boxes).map(|(id, object)| Annotation {
        id,
        image_id: object.frame,
        video_id: ONLY,
        category_id: ONLY,
        track_id: object.id,
        bbox: [object.x, object.y, object.w, object.h],
        area: object.w * object.h,
        segmentation: [],
        iscrowd: 0,
        attributes: Attributes { occluded: object.is_occluded(), track_id: object.id },
    });
    let dataset = Dataset {
        videos: [Video { id: ONLY, name: &table.video, width, height, fps: table.fps }],
        images: table.frames.iter().map(image).collect(),
        annotations: annotations.collect(),
        categories: [Category { id: ONLY, name: CATEGORY }],
    };
    serde_json::to_writer(&mut *out, &dataset)?;
    out.write_all(b"\n")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use serde_json::{Value, json};

    use super::*;
    use crate::export::tests::written;
    use crate::export::track_table::tests::table;

    #[test]
    fn annotations_refer_to_images_of_the_video() {
        let read: Value = serde_json::from_str(&written(|out| write(out, &table()))).unwrap();
        let video = json!({"id": 1, "name": "a <b> & \"c\".mp4", "width": 64, "height": 48, "fps": 12.5});
        assert_eq!(read["videos"], json!([video]));
        assert_eq!(read["categories"], json!([{"id": 1, "name": "object"}]));
        assert_eq!(read["images"].as_array().unwrap().len(), 4);
        assert_eq!(
            read["images"][1],
            json!({"id": 5, "video_id": 1, "frame_id": 4, "file_name": "000005.png", "width": 64, "height": 48})
        );
        assert_eq!(read["annotations"].as_array().unwrap().len(), 6);
        assert_eq!(
            read["annotations"][4],
            json!({
                "id": 5, "image_id": 7, "video_id": 1, "category_id": 1, "track_id": 4,
                "bbox": [32.0, 2.25, 8.0, 16.0], "area": 128.0, "segmentation": [], "iscrowd": 0,
                "attributes": {"occluded": true, "track_id": 4},
            })
        );
        assert_eq!(read["annotations"][5]["attributes"]["occluded"], false);
    }
}
