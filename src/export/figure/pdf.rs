//! Figures as PDF: the drawing of the SVG, with the glyphs in use embedded, so that text can be selected and searched.

use std::io;

use svg2pdf::{ConversionOptions, PageOptions, to_pdf};

use super::{Figure, raster};

/// The file of one page, as large as the figure. Fails only where the converter does.
pub fn write(figure: &Figure) -> io::Result<Vec<u8>> {
    to_pdf(&raster::tree(figure)?, ConversionOptions::default(), PageOptions::default())
        .map_err(|error| io::Error::other(error.to_string()))
}
