//! Figures as PDF: the drawing of the SVG, with the glyphs in use embedded, so that text can be selected and searched.

use std::io;

use svg2pdf::{ConversionOptions, PageOptions, to_pdf};

use super::{Figure, raster};

const POINTS_AN_INCH: f64 = 72.0;

/// The file of one page, as large as the figure. Fails only where the converter does.
pub fn write(figure: &Figure) -> io::Result<Vec<u8>> {
    let tree = raster::tree(figure)?;
    let units_a_point = f64::from(tree.size().width()) / figure.size[0];
    let page = PageOptions { dpi: (units_a_point * POINTS_AN_INCH) as f32 };
    to_pdf(&tree, ConversionOptions::default(), page).map_err(|error| io::Error::other(error.to_string()))
}
