//! The position of an image in a view, and its change by pointer and camera.

use eframe::egui::{Pos2, Rect, Vec2, vec2};

use crate::app::model::camera::ViewCamera;
use crate::frame::Size;
use crate::regions;

/// Maximum size of an image pixel, in points.
const MAX_PIXEL_PT: f32 = 160.0;
/// Minimum magnification relative to the fitted image.
const MIN_MAGNIFICATION: f32 = 0.5;
/// The fraction of the view that a fitted image fills.
const FITTED_SHARE: f32 = 0.985;

/// An image in a view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ViewCanvas {
    /// The view's rectangle.
    pub(crate) rect: Rect,
    /// The image's size.
    pub(crate) size: Size,
    /// Points per row of the image.
    pub(crate) scale: f32,
    /// Width of an image pixel relative to its height.
    aspect: f32,
    origin: Pos2,
    fitted: f32,
    camera: ViewCamera,
}

impl ViewCanvas {
    /// The canvas of an image of `size` with square pixels in the view `rect` for a camera.
    #[cfg(test)]
    pub(crate) fn new(rect: Rect, size: Size, camera: ViewCamera) -> Self {
        Self::of_aspect(rect, size, 1.0, camera)
    }

    /// The canvas of an image of `size` in the view `rect` for a camera; pixels are wider than high by `aspect`.
    pub(crate) fn of_aspect(rect: Rect, size: Size, aspect: f32, camera: ViewCamera) -> Self {
        let (w, h) = (size.width.max(1) as f32 * aspect, size.height.max(1) as f32);
        let fitted = (rect.width() / w).min(rect.height() / h).max(1e-3) * FITTED_SHARE;
        let scale = (fitted * camera.magnification).min(MAX_PIXEL_PT.max(fitted));
        let centre = vec2(camera.centre[0] * w, camera.centre[1] * h);
        Self { rect, size, scale, aspect, origin: rect.center() - centre * scale, fitted, camera }
    }

    /// The canvas of the same image in the view `rect` with a pixel at the centre; `scale` is in points per row.
    pub(crate) fn around(&self, rect: Rect, (x, y): (u32, u32), scale: f32) -> Self {
        let whole = Self::of_aspect(rect, self.size, self.aspect, ViewCamera::FIT);
        let centre = vec2((x as f32 + 0.5) * self.aspect, y as f32 + 0.5);
        Self { scale, origin: rect.center() - centre * scale, ..whole }
    }

    /// Points per column and per row of the image.
    pub(crate) fn pixel_size(&self) -> Vec2 {
        vec2(self.aspect, 1.0) * self.scale
    }

    /// Points per row of the fitted image.
    pub(crate) const fn fitted(&self) -> f32 {
        self.fitted
    }

    /// The screen position of an image point.
    pub(crate) fn screen(&self, [x, y]: [f32; 2]) -> Pos2 {
        self.origin + vec2(x, y) * self.pixel_size()
    }

    /// The image point at a screen position.
    pub(crate) fn image(&self, at: Pos2) -> [f32; 2] {
        let offset = (at - self.origin) / self.pixel_size();
        [offset.x, offset.y]
    }

    /// The pixel at a screen position; `None` outside the image.
    pub(crate) fn pixel(&self, at: Pos2) -> Option<(u32, u32)> {
        let [x, y] = self.image(at);
        let inside = x >= 0.0 && y >= 0.0 && x < self.size.width as f32 && y < self.size.height as f32;
        inside.then_some((x as u32, y as u32))
    }

    /// The screen rectangle of the image.
    pub(crate) fn whole(&self) -> Rect {
        let size = vec2(self.size.width as f32, self.size.height as f32);
        Rect::from_min_size(self.origin, size * self.pixel_size())
    }

    /// The screen rectangle of an image rectangle.
    pub(crate) fn place(&self, rect: &regions::Rect) -> Rect {
        Rect::from_min_max(self.screen([rect.x, rect.y]), self.screen([rect.right(), rect.bottom()]))
    }

    /// The screen rectangle of a pixel.
    pub(crate) fn place_pixel(&self, (x, y): (u32, u32)) -> Rect {
        self.place(&regions::Rect::new(x as f32, y as f32, 1.0, 1.0))
    }

    /// The visible columns and rows, ends excluded.
    pub(crate) fn visible(&self) -> (std::ops::Range<u32>, std::ops::Range<u32>) {
        let (min, max) = (self.image(self.rect.min), self.image(self.rect.max));
        let columns = min[0].max(0.0) as u32..(max[0].ceil().max(0.0) as u32).min(self.size.width);
        let rows = min[1].max(0.0) as u32..(max[1].ceil().max(0.0) as u32).min(self.size.height);
        (columns, rows)
    }

    /// The camera after zooming by `factor` around the point under `at`.
    pub(crate) fn zoomed(&self, at: Pos2, factor: f32) -> ViewCamera {
        let most = (MAX_PIXEL_PT / self.fitted).max(1.0);
        let magnification = (self.camera.magnification * factor).clamp(MIN_MAGNIFICATION, most);
        let pinned = self.image(at);
        let scale = vec2(self.aspect, 1.0) * self.fitted * magnification;
        let offset = (at - self.rect.center()) / scale;
        self.looking_at([pinned[0] - offset.x, pinned[1] - offset.y], magnification)
    }

    /// The camera after the image was dragged by `delta` points.
    pub(crate) fn panned(&self, delta: Vec2) -> ViewCamera {
        let middle = self.image(self.rect.center() - delta);
        self.looking_at(middle, self.camera.magnification)
    }

    fn looking_at(&self, [x, y]: [f32; 2], magnification: f32) -> ViewCamera {
        let share = |value: f32, of: u32| (value / of.max(1) as f32).clamp(0.0, 1.0);
        ViewCamera { magnification, centre: [share(x, self.size.width), share(y, self.size.height)] }
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::pos2;

    use super::*;

    fn canvas(camera: ViewCamera) -> ViewCanvas {
        ViewCanvas::new(
            Rect::from_min_size(pos2(100.0, 50.0), vec2(400.0, 300.0)),
            Size::new(200, 100),
            camera,
        )
    }

    #[test]
    fn a_fitted_image_is_complete_and_centred() {
        let canvas = canvas(ViewCamera::FIT);
        assert!(canvas.rect.contains_rect(canvas.whole()));
        assert!((canvas.whole().center() - canvas.rect.center()).length() < 0.01);
        assert_eq!(canvas.pixel(canvas.rect.min), None);
        assert_eq!(canvas.pixel(canvas.rect.center()), Some((100, 50)));
    }

    #[test]
    fn an_image_of_wide_pixels_is_wider() {
        let rect = Rect::from_min_size(pos2(100.0, 50.0), vec2(400.0, 300.0));
        let canvas = ViewCanvas::of_aspect(rect, Size::new(200, 100), 1.5, ViewCamera::FIT);
        let whole = canvas.whole();
        assert!((whole.width() / whole.height() - 3.0).abs() < 1e-3 && rect.contains_rect(whole));
        assert_eq!(canvas.pixel(canvas.place_pixel((150, 20)).center()), Some((150, 20)));
        let loupe = canvas.around(rect, (7, 9), 20.0);
        assert!((loupe.place_pixel((7, 9)).center() - rect.center()).length() < 1e-3);
        assert!((loupe.place_pixel((7, 9)).size() - vec2(30.0, 20.0)).length() < 1e-3);
        let (at, camera) = (pos2(180.0, 170.0), canvas.zoomed(pos2(180.0, 170.0), 3.0));
        let near = ViewCanvas::of_aspect(rect, Size::new(200, 100), 1.5, camera);
        assert!((near.screen(canvas.image(at)) - at).length() < 0.1, "the point under the pointer stays");
    }

    #[test]
    fn zooming_keeps_the_point_under_the_pointer() {
        let before = canvas(ViewCamera::FIT);
        let at = pos2(180.0, 170.0);
        let after = canvas(before.zoomed(at, 3.0));
        let (a, b) = (before.image(at), after.image(at));
        assert!((a[0] - b[0]).abs() < 0.05 && (a[1] - b[1]).abs() < 0.05, "{a:?} {b:?}");
        assert!((after.scale / before.scale - 3.0).abs() < 1e-3);
    }

    #[test]
    fn a_canvas_around_a_pixel_centres_it() {
        let rect = Rect::from_min_size(pos2(10.0, 20.0), vec2(90.0, 90.0));
        let canvas = ViewCanvas::new(rect, Size::new(200, 100), ViewCamera::FIT).around(rect, (3, 99), 12.0);
        assert_eq!(canvas.pixel(rect.center()), Some((3, 99)));
        assert!((canvas.place_pixel((3, 99)).center() - rect.center()).length() < 0.01);
        assert_eq!(canvas.pixel(rect.center() + vec2(0.0, 12.0)), None, "there is no row below");
    }

    #[test]
    fn dragging_moves_the_image_with_the_pointer() {
        let before = canvas(ViewCamera { magnification: 4.0, centre: [0.5, 0.5] });
        let after = canvas(before.panned(vec2(30.0, -12.0)));
        let moved = after.screen([50.0, 50.0]) - before.screen([50.0, 50.0]);
        assert!((moved - vec2(30.0, -12.0)).length() < 0.05, "{moved:?}");
    }

    #[test]
    fn pixels_outside_the_view_are_not_visible() {
        let canvas = canvas(ViewCamera { magnification: 10.0, centre: [0.5, 0.5] });
        let (columns, rows) = canvas.visible();
        assert!(columns.start > 60 && columns.end < 140 && !columns.is_empty(), "{columns:?}");
        assert!(rows.start > 20 && rows.end < 80 && !rows.is_empty(), "{rows:?}");
    }
}
