//! A frame beside its ground truth and its result, as pictures within the page.

use std::io;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::imageops;
use image::{ExtendedColorType, ImageEncoder, RgbImage};

use crate::export::canvas::{Canvas, Paint, text_width};
use crate::frame::{Frame, Size};
use crate::mixture::pixel::luma;
use crate::palette::{FALSE_NEGATIVE, FALSE_POSITIVE, IGNORED, TRUE_POSITIVE, identity_colour};
use crate::regions::{Rect, Rgb};
use crate::sweep::sequence_frames::{FrameMeasure, ShownFrame};
use crate::truth::boxes::Bounds;
use crate::truth::masks::{Label, TrueMask};

/// Number of frames from which on pictures are smaller.
const MANY: usize = 24;
/// Height of the identities.
const TEXT: f32 = 18.0;
/// The quality of photographs, of 100.
const QUALITY: u8 = 80;

/// The colours of decisions on pixels.
pub(super) const LEGEND: [(Rgb, &str); 4] = [
    (TRUE_POSITIVE, "true positive"),
    (FALSE_POSITIVE, "false positive"),
    (FALSE_NEGATIVE, "false negative"),
    (IGNORED, "ignored"),
];

/// The pictures of a frame, as addresses that hold them.
pub(super) struct Views {
    pub input: String,
    pub truth: String,
    pub ours: String,
    /// Their width and height.
    pub size: (u32, u32),
}

/// The largest width of pictures of this number of frames.
pub(super) const fn width(frames: usize) -> u32 {
    if frames > MANY { 320 } else { 480 }
}

/// The pictures of a frame, at most this wide.
pub(super) fn views(shown: &ShownFrame, measure: FrameMeasure, width: u32) -> io::Result<Views> {
    let input = scaled(&shown.input.rgb, shown.input.size, width)?;
    let size = shown.input.size;
    let (truth, ours) = if measure == FrameMeasure::Mask && shown.true_mask.is_some() {
        let [truth, ours] = mask_views(shown);
        (png(&scaled(&truth, size, width)?)?, png(&scaled(&ours, size, width)?)?)
    } else {
        let ground = dark(&input);
        let drawn = |boxes: &[(u32, Bounds)]| jpeg(&with_boxes(&ground, size, boxes));
        (drawn(&shown.true_boxes)?, drawn(&shown.boxes)?)
    };
    Ok(Views { input: jpeg(&input)?, truth, ours, size: input.dimensions() })
}

/// The true mask, white on black, and the decisions in their colours over the dark input.
fn mask_views(shown: &ShownFrame) -> [Vec<u8>; 2] {
    let size = shown.input.size;
    let labels = shown.true_mask.as_ref().filter(|mask| mask.size() == size).map(TrueMask::labels);
    let labels = labels.unwrap_or_else(|| vec![Label::Uncounted; size.pixels()]);
    let (mut truth, mut ours) =
        (Vec::with_capacity(size.pixels() * 3), Vec::with_capacity(size.pixels() * 3));
    for ((label, found), pixel) in labels.iter().zip(&shown.mask.data).zip(shown.input.rgb.chunks_exact(3)) {
        truth.extend(match label {
            Label::Foreground => [255; 3],
            Label::Background => [0; 3],
            Label::Uncounted => IGNORED,
        });
        ours.extend(match (label, *found != 0) {
            (Label::Foreground, true) => TRUE_POSITIVE,
            (Label::Foreground, false) => FALSE_NEGATIVE,
            (Label::Background, true) => FALSE_POSITIVE,
            // Few levels compress well.
            (Label::Background, false) => [(luma([pixel[0], pixel[1], pixel[2]]) / 4) & !7; 3],
            (Label::Uncounted, _) => IGNORED,
        });
    }
    // A mask of another size than its input ends early.
    truth.resize(size.pixels() * 3, 0);
    ours.resize(size.pixels() * 3, 0);
    [truth, ours]
}

/// The picture in gray at half its brightness, on which colours stand out.
fn dark(picture: &RgbImage) -> RgbImage {
    let mut dark = picture.clone();
    for pixel in dark.pixels_mut() {
        pixel.0 = [luma(pixel.0) / 2; 3];
    }
    dark
}

/// A picture with boxes in the pixels of an image of this size, each in the colour of its identity.
fn with_boxes(picture: &RgbImage, source: Size, boxes: &[(u32, Bounds)]) -> RgbImage {
    let (width, height) = picture.dimensions();
    let mut frame = Frame::new(1, Size::new(width, height), picture.as_raw().clone());
    let scale = width as f32 / source.width.max(1) as f32;
    let canvas = &mut Canvas::new(&mut frame);
    for (identity, bounds) in boxes {
        let [x, y, w, h] = bounds.0.map(|length| length as f32 * scale);
        let colour = identity_colour(*identity);
        canvas.outline(&Rect::new(x, y, w, h), 4.0, 0.0, Paint::sheer([0; 3], 0.5));
        canvas.outline(&Rect::new(x, y, w, h), 2.0, 0.0, Paint::solid(colour));
    }
    for (identity, bounds) in boxes {
        let [x, y, ..] = bounds.0.map(|length| length as f32 * scale);
        let text = identity.to_string();
        let width = text_width(TEXT, &text) + 4.0;
        // Above the box, or inside where it would be outside the picture.
        let (x, y) = (x.max(0.0), if y >= TEXT { y - TEXT } else { y.max(0.0) });
        canvas.fill(&Rect::new(x, y, width, TEXT), Paint::sheer([0; 3], 0.7));
        canvas.text([x + 2.0, y], TEXT, &text, Paint::solid(identity_colour(*identity)));
    }
    RgbImage::from_raw(width, height, frame.rgb).unwrap_or_default()
}

/// The picture, reduced to at most this width.
fn scaled(rgb: &[u8], size: Size, width: u32) -> io::Result<RgbImage> {
    let picture = RgbImage::from_raw(size.width, size.height, rgb.to_vec())
        .ok_or_else(|| io::Error::other("a frame has not three bytes for each pixel"))?;
    if size.width <= width {
        return Ok(picture);
    }
    let height = (u64::from(size.height) * u64::from(width)).div_ceil(u64::from(size.width)).max(1) as u32;
    Ok(imageops::thumbnail(&picture, width, height))
}

fn jpeg(picture: &RgbImage) -> io::Result<String> {
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, QUALITY);
    encode(encoder, picture)?;
    Ok(format!("data:image/jpeg;base64,{}", STANDARD.encode(bytes)))
}

fn png(picture: &RgbImage) -> io::Result<String> {
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::NoFilter);
    encode(encoder, picture)?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(bytes)))
}

fn encode(encoder: impl ImageEncoder, picture: &RgbImage) -> io::Result<()> {
    let (width, height) = picture.dimensions();
    let written = encoder.write_image(picture.as_raw(), width, height, ExtendedColorType::Rgb8);
    written.map_err(|error| match error {
        image::ImageError::IoError(error) => error,
        other => io::Error::other(other),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::frame::Mask;

    fn shown(size: Size) -> ShownFrame {
        let labels =
            (0..size.pixels()).map(|at| [Label::Foreground, Label::Background, Label::Uncounted][at % 3]);
        let mut mask = Mask::empty(size);
        mask.data[..3].fill(Mask::FOREGROUND);
        ShownFrame {
            input: Frame::new(7, size, vec![200; size.pixels() * 3]),
            value: 0.5,
            true_mask: Some(TrueMask::new(size, labels)),
            true_boxes: vec![(3, Bounds([-4.0, 2.0, 30.0, 20.0])), (4, Bounds([1e9, f64::NAN, 1.0, 1.0]))],
            mask,
            boxes: Vec::new(),
        }
    }

    fn decoded(address: &str) -> RgbImage {
        let (_, bytes) = address.split_once(";base64,").unwrap();
        image::load_from_memory(&STANDARD.decode(bytes).unwrap()).unwrap().into_rgb8()
    }

    #[test]
    fn decisions_have_their_colours() {
        let Views { input, truth, ours, .. } =
            views(&shown(Size::new(6, 4)), FrameMeasure::Mask, 480).unwrap();
        let (truth, ours) = (decoded(&truth), decoded(&ours));
        let row = |picture: &RgbImage| (0..6).map(|x| picture.get_pixel(x, 0).0).collect::<Vec<_>>();
        assert_eq!(row(&truth)[..3], [[255; 3], [0; 3], IGNORED]);
        assert_eq!(row(&ours), [TRUE_POSITIVE, FALSE_POSITIVE, IGNORED, FALSE_NEGATIVE, [48; 3], IGNORED]);
        assert_eq!(decoded(&input).dimensions(), (6, 4));
    }

    #[test]
    fn large_frames_are_reduced_and_boxes_drawn() {
        let shown = shown(Size::new(1000, 500));
        let Views { input, truth, ours, .. } = views(&shown, FrameMeasure::Boxes, 480).unwrap();
        for picture in [&input, &truth, &ours] {
            assert_eq!(decoded(picture).dimensions(), (480, 240));
        }
        assert_ne!(truth, input);
        assert_eq!(decoded(&ours).get_pixel(400, 200).0, [100; 3], "a dark ground without boxes");
        let small = views(&shown, FrameMeasure::Mask, 320).unwrap();
        assert_eq!(decoded(&small.ours).dimensions(), (320, 160));
        // A mask of another size does not fail.
        let other = ShownFrame { mask: Mask::empty(Size::new(3, 3)), ..shown };
        assert_eq!(decoded(&views(&other, FrameMeasure::Mask, 480).unwrap().ours).dimensions(), (480, 240));
    }
}
