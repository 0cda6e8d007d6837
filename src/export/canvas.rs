//! Anti-aliased lines, areas and text on an RGB image.

use std::ops::Range;
use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use tiny_skia::{FillRule, IntSize, LineCap, LineJoin, Mask, Path, PathBuilder, Stroke, Transform};

use crate::frame::{Frame, Size};
use crate::regions::{Rect, Rgb};

/// Coordinates further outside the image, in pixels, are moved to this distance: f32 resolves 1/256 of a pixel there.
const FAR: f32 = 32_768.0;
/// Largest height of text, in pixels, which bounds the memory of a glyph.
const MAX_TEXT_HEIGHT: f32 = 1000.0;

/// Hack, a typeface that is legible at ten pixels.
static FONT: LazyLock<Option<FontRef<'static>>> =
    LazyLock::new(|| FontRef::try_from_slice(epaint_default_fonts::HACK_REGULAR).ok());

/// An image to draw on. Coordinates are in pixels, pixel (x, y) covering [x, x + 1) × [y, y + 1); drawing is clipped
/// to the image. A shape with a coordinate that is not finite is not drawn.
pub struct Canvas<'a> {
    size: Size,
    rgb: &'a mut [u8],
    /// The memory of the last shape's coverage, for the next one.
    coverage: Vec<u8>,
}

/// Colour and opacity of a drawing operation.
#[derive(Clone, Copy, Debug)]
pub struct Paint {
    /// Its colour.
    pub colour: Rgb,
    /// The opacity, 0..=1.
    pub opacity: f32,
}

impl Paint {
    /// An opaque paint.
    pub const fn solid(colour: Rgb) -> Self {
        Self { colour, opacity: 1.0 }
    }

    /// A translucent paint.
    pub const fn sheer(colour: Rgb, opacity: f32) -> Self {
        Self { colour, opacity }
    }
}

impl<'a> Canvas<'a> {
    /// A canvas on this frame.
    pub fn new(frame: &'a mut Frame) -> Self {
        Self { size: frame.size, rgb: &mut frame.rgb, coverage: Vec::new() }
    }

    /// The picture's size.
    pub fn size(&self) -> Size {
        self.size
    }

    /// A straight line of `width` pixels with round ends. It covers each pixel once.
    pub fn line(&mut self, from: [f32; 2], to: [f32; 2], width: f32, paint: Paint) {
        self.stroke(&[&[from, to]], false, width, paint);
    }

    /// The outline of a rectangle, with dashes and gaps of `dash` pixels; solid if it is 0.
    pub fn outline(&mut self, rect: &Rect, width: f32, dash: f32, paint: Paint) {
        let Some([left, top]) = self.near([rect.x, rect.y]) else { return };
        let Some([right, bottom]) = self.near([rect.right(), rect.bottom()]) else { return };
        let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
        if dash <= 0.0 {
            self.stroke(&[&corners], true, width, paint);
            return;
        }
        let mut dashes = Vec::new();
        for (a, b) in corners.into_iter().zip(corners.into_iter().cycle().skip(1)) {
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            // An odd number of equal parts, so that each corner is drawn.
            let parts = ((length / dash / 2.0).floor().clamp(1.0, 10_000.0) as u32) * 2 + 1;
            let at = |part: u32| {
                let share = part as f32 / parts as f32;
                [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share]
            };
            dashes.extend((0..parts).step_by(2).map(|part| [at(part), at(part + 1)]));
        }
        let dashes: Vec<_> = dashes.iter().map(<[_; 2]>::as_slice).collect();
        self.stroke(&dashes, false, width, paint);
    }

    /// A circle. One that is more than 32,768 pixels large or away is not drawn: a moved centre gives another circle.
    pub fn circle(&mut self, centre: [f32; 2], radius: f32, width: f32, paint: Paint) {
        if self.near(centre) != Some(centre) || radius > FAR {
            return;
        }
        if let Some(circle) = PathBuilder::from_circle(centre[0], centre[1], radius) {
            self.stroke_path(&circle, width, paint);
        }
    }

    /// A filled rectangle with anti-aliased edges.
    pub fn fill(&mut self, rect: &Rect, paint: Paint) {
        let Some([left, top]) = self.near([rect.x, rect.y]) else { return };
        let Some([right, bottom]) = self.near([rect.right(), rect.bottom()]) else { return };
        if let Some(rect) = tiny_skia::Rect::from_ltrb(left, top, right, bottom) {
            self.fill_path(&PathBuilder::from_rect(rect), paint);
        }
    }

    /// A line of text `height` pixels high, with its upper left corner at `corner`.
    pub fn text(&mut self, corner: [f32; 2], height: f32, text: &str, paint: Paint) {
        let Some([x, y]) = self.near(corner) else { return };
        if !(height > 0.0 && height <= MAX_TEXT_HEIGHT) {
            return;
        }
        for glyph in glyphs(x, y, height, text) {
            let Some(outline) = FONT.as_ref().and_then(|font| font.outline_glyph(glyph)) else { continue };
            let bounds = outline.px_bounds();
            outline.draw(|dx, dy, share| {
                let (x, y) = (bounds.min.x + dx as f32, bounds.min.y + dy as f32);
                if x >= 0.0
                    && y >= 0.0
                    && let Some(at) = self.size.index(x as u32, y as u32)
                {
                    blend(&mut self.rgb[at * 3..at * 3 + 3], paint, share);
                }
            });
        }
    }

    /// Polylines, which together cover each pixel once even where they overlap.
    fn stroke(&mut self, polylines: &[&[[f32; 2]]], closed: bool, width: f32, paint: Paint) {
        let mut path = PathBuilder::new();
        for polyline in polylines {
            for (index, &point) in polyline.iter().enumerate() {
                let Some([x, y]) = self.near(point) else { return };
                if index == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
            }
            if closed {
                path.close();
            }
        }
        if let Some(path) = path.finish() {
            self.stroke_path(&path, width, paint);
        }
    }

    fn stroke_path(&mut self, path: &Path, width: f32, paint: Paint) {
        let (line_cap, line_join) = (LineCap::Round, LineJoin::Round);
        let stroke = Stroke { width: width.clamp(0.0, FAR), line_cap, line_join, ..Stroke::default() };
        if let Some(area) = path.stroke(&stroke, 1.0) {
            self.fill_path(&area, paint);
        }
    }

    /// Draws an area, through its coverage within its bounding box.
    fn fill_path(&mut self, path: &Path, paint: Paint) {
        let bounds = path.bounds();
        let columns = clamped(bounds.left(), bounds.right(), self.size.width);
        let rows = clamped(bounds.top(), bounds.bottom(), self.size.height);
        let (width, start) = (columns.len(), self.size.index(columns.start, rows.start));
        let size = IntSize::from_wh(width as u32, rows.len() as u32);
        let (Some(size), Some(start)) = (size, start) else { return };
        let mut coverage = std::mem::take(&mut self.coverage);
        coverage.clear();
        coverage.resize(width * rows.len(), 0);
        let Some(mut mask) = Mask::from_vec(coverage, size) else { return };
        let to_mask = Transform::from_translate(-(columns.start as f32), -(rows.start as f32));
        mask.fill_path(path, FillRule::Winding, true, to_mask);
        let lines = self.rgb[start * 3..].chunks_mut(self.size.width as usize * 3);
        for (line, shares) in lines.zip(mask.data().chunks_exact(width)) {
            for (pixel, &share) in line.chunks_exact_mut(3).zip(shares) {
                if share > 0 {
                    blend(pixel, paint, f32::from(share) / 255.0);
                }
            }
        }
        self.coverage = mask.take();
    }

    /// The point, or one at a distance of [`FAR`] if it is further away; `None` if it is not finite.
    fn near(&self, [x, y]: [f32; 2]) -> Option<[f32; 2]> {
        let near = |value: f32, end: u32| value.clamp(-FAR, end as f32 + FAR);
        (x.is_finite() && y.is_finite()).then(|| [near(x, self.size.width), near(y, self.size.height)])
    }
}

fn blend(pixel: &mut [u8], paint: Paint, share: f32) {
    let opacity = (paint.opacity * share).clamp(0.0, 1.0);
    for (channel, colour) in pixel.iter_mut().zip(paint.colour) {
        let (below, above) = (f32::from(*channel), f32::from(colour));
        *channel = (below + (above - below) * opacity).round() as u8;
    }
}

/// The width of `text` at this height.
pub fn text_width(height: f32, text: &str) -> f32 {
    let Some(font) = FONT.as_ref() else { return 0.0 };
    let font = font.as_scaled(PxScale::from(height));
    text.chars().map(|letter| font.h_advance(font.glyph_id(letter))).sum()
}

fn glyphs(x: f32, y: f32, height: f32, text: &str) -> Vec<Glyph> {
    let Some(font) = FONT.as_ref() else { return Vec::new() };
    let scale = PxScale::from(height);
    let scaled = font.as_scaled(scale);
    let mut pen = x;
    text.chars()
        .map(|letter| {
            let id = font.glyph_id(letter);
            let glyph = id.with_scale_and_position(scale, point(pen, y + scaled.ascent()));
            pen += scaled.h_advance(id);
            glyph
        })
        .collect()
}

fn clamped(from: f32, to: f32, end: u32) -> Range<u32> {
    let end = end as f32;
    from.floor().clamp(0.0, end) as u32..to.ceil().clamp(0.0, end) as u32
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::*;

    const WHITE: Paint = Paint::solid([255; 3]);

    fn black(width: u32, height: u32) -> Frame {
        let size = Size::new(width, height);
        Frame::new(1, size, vec![0; size.pixels() * 3])
    }

    #[test]
    fn a_line_covers_its_pixels_and_blends_its_edges() {
        let mut frame = black(10, 5);
        Canvas::new(&mut frame).line([0.0, 2.5], [10.0, 2.5], 1.5, WHITE);
        assert_eq!(frame.pixel(5, 2), Some([255; 3]));
        // A quarter of 255, rounded down.
        assert_eq!(frame.pixel(5, 1), Some([63; 3]));
        assert_eq!(frame.pixel(5, 0), Some([0; 3]));
    }

    #[test]
    fn a_line_of_no_length_is_a_dot() {
        let mut frame = black(9, 9);
        Canvas::new(&mut frame).line([4.5, 4.5], [4.5, 4.5], 3.0, WHITE);
        assert_eq!(frame.pixel(4, 4), Some([255; 3]));
        assert_eq!(frame.pixel(4, 7), Some([0; 3]));
    }

    #[test]
    fn an_outline_covers_its_corners_once_and_leaves_its_inside() {
        for dash in [0.0, 3.0] {
            let mut frame = black(24, 20);
            let sheer = Paint::sheer([200; 3], 0.5);
            Canvas::new(&mut frame).outline(&Rect::new(3.5, 4.5, 15.0, 10.0), 1.0, dash, sheer);
            let corners = [(3, 4), (18, 4), (18, 14), (3, 14)].map(|(x, y)| frame.pixel(x, y).unwrap()[0]);
            assert!(corners.iter().all(|level| (80..=100).contains(level)), "dash {dash}: {corners:?}");
            let drawn = (3..=18).filter(|&x| frame.pixel(x, 4).unwrap()[0] > 50).count();
            assert!(if dash > 0.0 { (8..14).contains(&drawn) } else { drawn == 16 }, "dash {dash}: {drawn}");
            let inside = (5..17).flat_map(|x| (6..13).map(move |y| (x, y)));
            assert!(inside.into_iter().all(|(x, y)| frame.pixel(x, y) == Some([0; 3])), "dash {dash}");
        }
    }

    #[test]
    fn a_fill_covers_the_pixels_inside_and_shares_of_those_at_the_edge() {
        let mut frame = black(8, 8);
        Canvas::new(&mut frame).fill(&Rect::new(2.5, 3.0, 3.0, 2.0), WHITE);
        let row: Vec<_> = (0..8).map(|x| frame.pixel(x, 3).unwrap()[0]).collect();
        assert!(row[2].abs_diff(128) <= 2 && row[5].abs_diff(128) <= 2, "{row:?}");
        assert_eq!((&row[..2], &row[3..5], &row[6..]), (&[0; 2][..], &[255; 2][..], &[0; 2][..]));
        assert_eq!((frame.pixel(3, 2), frame.pixel(3, 5)), (Some([0; 3]), Some([0; 3])));
    }

    #[test]
    fn drawing_is_clipped_to_the_image() {
        let mut frame = black(8, 8);
        let mut canvas = Canvas::new(&mut frame);
        canvas.line([-1e9, -5.0], [1e9, 20.0], 2.0, WHITE);
        canvas.line([f32::NAN, 0.0], [1.0, f32::INFINITY], 2.0, WHITE);
        canvas.outline(&Rect::new(-1e6, -1e6, 2e6, 2e6), 3.0, 4.0, WHITE);
        canvas.fill(&Rect::new(-5.0, 6.0, 100.0, 100.0), WHITE);
        canvas.text([-20.0, -3.0], 14.0, "merge 3+5 → 3", WHITE);
        canvas.circle([0.0, 0.0], 1e7, 1.0, WHITE);
        assert_eq!(frame.pixel(0, 7), Some([255; 3]));

        let mut frame = black(8, 8);
        Canvas::new(&mut frame).circle([0.0, f32::MAX], 95_632.92, 20.0, WHITE);
        assert!(frame.rgb.iter().all(|&level| level == 0), "the circle is not moved into the image");
    }

    type Draw<'a> = &'a dyn Fn(&mut Canvas<'_>);

    /// Any f32, more often one in or near the image.
    fn coordinate() -> impl Strategy<Value = f32> {
        prop_oneof![
            4 => -10.0_f32..40.0,
            1 => -1e5_f32..1e5,
            1 => prop::num::f32::ANY,
            1 => prop::sample::select(vec![0.0, -0.0, f32::NAN, f32::INFINITY, f32::MAX, f32::MIN, 1e-40]),
        ]
    }

    proptest! {
        #[test]
        fn any_shape_changes_only_pixels_near_it(
            [width, height] in [1_u32..40, 1_u32..30],
            [a, b, c, d] in [coordinate(), coordinate(), coordinate(), coordinate()],
            line in coordinate(),
            dash in coordinate(),
        ) {
            let near = |from: f32, to: f32, at: u32, reach: f32| {
                let at = at as f32;
                at >= from.min(to) - reach - 1.0 && at <= from.max(to) + reach + 1.0
            };
            let rect = Rect::new(a, b, c, d);
            let shapes: [(&str, [f32; 4], Draw<'_>); 4] = [
                ("line", [a, b, c, d], &|canvas| canvas.line([a, b], [c, d], line, WHITE)),
                ("outline", [a, b, a + c, b + d], &|canvas| canvas.outline(&rect, line, dash, WHITE)),
                ("circle", [a - c, b - c, a + c, b + c], &|canvas| canvas.circle([a, b], c, line, WHITE)),
                ("fill", [a, b, a + c, b + d], &|canvas| canvas.fill(&rect, WHITE)),
            ];
            for (name, [left, top, right, bottom], draw) in shapes {
                let mut frame = black(width, height);
                draw(&mut Canvas::new(&mut frame));
                let reach = if name == "fill" { 0.0 } else { line.max(0.0) / 2.0 };
                for (x, y) in (0..width).flat_map(|x| (0..height).map(move |y| (x, y))) {
                    if frame.pixel(x, y) != Some([0; 3]) {
                        prop_assert!(near(left, right, x, reach) && near(top, bottom, y, reach), "{name} at {x}, {y}");
                    }
                }
            }
            let mut frame = black(width, height);
            Canvas::new(&mut frame).text([a, b], c, "merge 3+5 → 3", WHITE);
        }
    }

    #[test]
    fn text_is_drawn_within_its_width() {
        let mut frame = black(80, 20);
        let width = text_width(14.0, "merge →");
        assert!((40.0..70.0).contains(&width), "{width}");
        Canvas::new(&mut frame).text([2.0, 2.0], 14.0, "merge →", WHITE);
        let lit = |x: u32| (0..20).any(|y| frame.pixel(x, y).is_some_and(|colour| colour[0] > 128));
        assert!((2..12).any(lit) && lit((2.0 + width) as u32 - 5));
        assert!(!((2.0 + width) as u32 + 2..80).any(lit));
    }
}
