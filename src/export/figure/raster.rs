//! Rasterises figures: renders the SVG with the window's own typeface, independent of installed fonts.

use std::fs;
use std::io;
use std::path::Path;
use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use super::text::TYPEFACE;
use super::{Figure, svg};
use crate::frame::{Frame, Size};

/// Pixels per inch, as required by journals.
pub const RESOLUTION: f64 = 300.0;
const POINTS_AN_INCH: f64 = 72.0;
const METRES_AN_INCH: f64 = 0.0254;

static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(TYPEFACE.to_vec());
    fonts.set_sans_serif_family("Ubuntu");
    Arc::new(fonts)
});

/// The figure's SVG, parsed, in points, with the window's own typeface.
pub(super) fn tree(figure: &Figure) -> io::Result<Tree> {
    let options = Options { dpi: POINTS_AN_INCH as f32, fontdb: Arc::clone(&FONTS), ..Options::default() };
    Tree::from_str(&svg::write(figure), &options).map_err(io::Error::other)
}

/// Renders the figure at [`RESOLUTION`]. Fails only for figures that are too large for memory.
pub fn picture(figure: &Figure) -> io::Result<Frame> {
    let tree = tree(figure)?;
    let [width, height] =
        figure.size.map(|length| ((length * RESOLUTION / POINTS_AN_INCH).round() as u32).max(1));
    let mut pixels = Pixmap::new(width, height).ok_or_else(|| io::Error::other("the figure is too large"))?;
    pixels.fill(resvg::tiny_skia::Color::WHITE);
    let scale =
        Transform::from_scale(width as f32 / tree.size().width(), height as f32 / tree.size().height());
    resvg::render(&tree, scale, &mut pixels.as_mut());
    // The white ground leaves no pixel transparent.
    let rgb = pixels.data().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    Ok(Frame::new(1, Size::new(width, height), rgb))
}

/// Writes an image of [`picture`] as a PNG with its physical size.
pub fn write_png(path: &Path, picture: &Frame) -> io::Result<()> {
    // The encoder passes on no error of its last writes: it has memory to write to, and the file gets all bytes at once.
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.size.width, picture.size.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let each = (RESOLUTION / METRES_AN_INCH).round() as u32;
    encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: each, yppu: each, unit: png::Unit::Meter }));
    let mut writer = encoder.write_header().map_err(io::Error::from)?;
    writer.write_image_data(&picture.rgb).map_err(io::Error::from)?;
    writer.finish().map_err(io::Error::from)?;
    fs::write(path, bytes)
}
