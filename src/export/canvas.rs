//! Anti-aliased lines, areas and text on an RGB image.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};

use crate::frame::{Frame, Size};
use crate::regions::{Rect, Rgb};

/// Hack, a typeface that is legible at ten pixels.
static FONT: LazyLock<Option<FontRef<'static>>> =
    LazyLock::new(|| FontRef::try_from_slice(epaint_default_fonts::HACK_REGULAR).ok());

/// An image to draw on. Coordinates are in pixels, pixel (x, y) covering [x, x + 1) × [y, y + 1); drawing is clipped
/// to the image.
pub struct Canvas<'a> {
    size: Size,
    rgb: &'a mut [u8],
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
        Self { size: frame.size, rgb: &mut frame.rgb }
    }

    /// The picture's size.
    pub fn size(&self) -> Size {
        self.size
    }

    /// A straight line of `width` pixels with round ends.
    pub fn line(&mut self, from: [f32; 2], to: [f32; 2], width: f32, paint: Paint) {
        self.lines(&[from, to], width, paint);
    }

    /// A polyline, which covers each pixel once even where it overlaps itself.
    pub fn lines(&mut self, points: &[[f32; 2]], width: f32, paint: Paint) {
        if points.iter().flatten().any(|value| !value.is_finite()) {
            return;
        }
        let reach = width / 2.0 + 1.0;
        let mut coverage = std::collections::BTreeMap::new();
        for pair in points.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let xs = self.columns(a[0].min(b[0]) - reach, a[0].max(b[0]) + reach);
            for y in self.rows(a[1].min(b[1]) - reach, a[1].max(b[1]) + reach) {
                for x in xs.clone() {
                    let distance = distance_to_segment([x as f32 + 0.5, y as f32 + 0.5], a, b);
                    let share = (width / 2.0 + 0.5 - distance).clamp(0.0, 1.0);
                    if share > 0.0 {
                        let most: &mut f32 = coverage.entry((y, x)).or_default();
                        *most = most.max(share);
                    }
                }
            }
        }
        for ((y, x), share) in coverage {
            self.blend(x, y, paint, share);
        }
    }

    /// The outline of a rectangle, with dashes and gaps of `dash` pixels; solid if it is 0.
    pub fn outline(&mut self, rect: &Rect, width: f32, dash: f32, paint: Paint) {
        let corners = [
            [rect.x, rect.y],
            [rect.right(), rect.y],
            [rect.right(), rect.bottom()],
            [rect.x, rect.bottom()],
            [rect.x, rect.y],
        ];
        if dash <= 0.0 {
            self.lines(&corners, width, paint);
            return;
        }
        for side in corners.windows(2) {
            let (a, b) = (side[0], side[1]);
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            // An odd number of equal parts, so that each corner is drawn.
            let parts = ((length / dash / 2.0).floor().clamp(1.0, 10_000.0) as u32) * 2 + 1;
            let at = |part: u32| {
                let share = part as f32 / parts as f32;
                [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share]
            };
            for part in (0..parts).step_by(2) {
                self.line(at(part), at(part + 1), width, paint);
            }
        }
    }

    /// A circle.
    pub fn circle(&mut self, centre: [f32; 2], radius: f32, width: f32, paint: Paint) {
        let points: Vec<_> = (0..=48)
            .map(|step| {
                let (sin, cos) = (step as f32 * std::f32::consts::TAU / 48.0).sin_cos();
                [centre[0] + radius * cos, centre[1] + radius * sin]
            })
            .collect();
        self.lines(&points, width, paint);
    }

    /// A filled rectangle with anti-aliased edges.
    pub fn fill(&mut self, rect: &Rect, paint: Paint) {
        let share =
            |at: u32, from: f32, to: f32| ((at as f32 + 1.0).min(to) - (at as f32).max(from)).clamp(0.0, 1.0);
        for y in self.rows(rect.y, rect.bottom()) {
            for x in self.columns(rect.x, rect.right()) {
                let covered = share(x, rect.x, rect.right()) * share(y, rect.y, rect.bottom());
                self.blend(x, y, paint, covered);
            }
        }
    }

    /// A line of text `height` pixels high, with its upper left corner at (x, y).
    pub fn text(&mut self, [x, y]: [f32; 2], height: f32, text: &str, paint: Paint) {
        for glyph in glyphs(x, y, height, text) {
            let Some(outline) = FONT.as_ref().and_then(|font| font.outline_glyph(glyph)) else { continue };
            let bounds = outline.px_bounds();
            outline.draw(|dx, dy, share| {
                let (x, y) = (bounds.min.x + dx as f32, bounds.min.y + dy as f32);
                if x >= 0.0 && y >= 0.0 {
                    self.blend(x as u32, y as u32, paint, share);
                }
            });
        }
    }

    fn blend(&mut self, x: u32, y: u32, paint: Paint, share: f32) {
        let Some(at) = self.size.index(x, y) else { return };
        let opacity = (paint.opacity * share).clamp(0.0, 1.0);
        for (channel, colour) in self.rgb[at * 3..at * 3 + 3].iter_mut().zip(paint.colour) {
            let (below, above) = (f32::from(*channel), f32::from(colour));
            *channel = (below + (above - below) * opacity).round() as u8;
        }
    }

    fn columns(&self, from: f32, to: f32) -> std::ops::Range<u32> {
        clamped(from, to, self.size.width)
    }

    fn rows(&self, from: f32, to: f32) -> std::ops::Range<u32> {
        clamped(from, to, self.size.height)
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

fn clamped(from: f32, to: f32, end: u32) -> std::ops::Range<u32> {
    let end = end as f32;
    from.floor().clamp(0.0, end) as u32..to.ceil().clamp(0.0, end) as u32
}

fn distance_to_segment(p: [f32; 2], a: [f32; 2], b: [f32; 2]) -> f32 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length_squared = dx * dx + dy * dy;
    let along = if length_squared > 0.0 {
        (((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (p[0] - a[0] - along * dx).hypot(p[1] - a[1] - along * dy)
}

#[cfg(test)]
mod tests {
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
        assert_eq!(frame.pixel(5, 1), Some([64; 3]));
        assert_eq!(frame.pixel(5, 0), Some([0; 3]));
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
