//! Conversion of decoded pictures to upright 8-bit RGB by a filter graph, the same as that of the `ffmpeg` program.

use ffmpeg::filter::{self, Graph};
use ffmpeg::format::{Pixel, pixel};
use ffmpeg::frame::{Video as Picture, side_data};

use super::Failure;
use super::raw::{self, ColorNumbers};
use super::rotate::{self, DisplayMatrix};
use crate::frame::Size;

/// The properties of a picture that a graph is made for.
#[derive(Clone, Debug, PartialEq)]
struct Form {
    format: Pixel,
    width: u32,
    height: u32,
    colors: ColorNumbers,
}

/// Converts the pictures of a stream. All results have the size of the first.
pub(super) struct Converter {
    display_matrix: Option<DisplayMatrix>,
    graph: Option<(Form, Graph)>,
    /// Size of the first result.
    size: Option<Size>,
}

impl Converter {
    /// A converter for a stream with this display matrix in its header.
    pub(super) fn new(display_matrix: Option<DisplayMatrix>) -> Self {
        Self { display_matrix, graph: None, size: None }
    }

    /// Uses the display matrix of this picture, if it has one, for it and all later ones.
    pub(super) fn follow_matrix(&mut self, first: &Picture) {
        let data = first.side_data(side_data::Type::DisplayMatrix);
        if let Some(matrix) = data.and_then(|data| rotate::display_matrix(data.data())) {
            self.display_matrix = Some(matrix);
        }
    }

    /// The size of all results; `None` before the first.
    pub(super) fn size(&self) -> Option<Size> {
        self.size
    }

    /// Converts a picture: RGB in row order. Its planes are moved into the graph.
    pub(super) fn rgb(&mut self, picture: &Picture) -> Result<Vec<u8>, Failure> {
        let form = Form {
            format: picture.format(),
            width: picture.width(),
            height: picture.height(),
            colors: raw::colors(picture),
        };
        if self.graph.as_ref().is_none_or(|(made_for, _)| *made_for != form) {
            self.graph = Some((form.clone(), self.graph_for(&form)?));
        }
        let result = self.graph.as_mut().and_then(|(_, graph)| {
            graph.get("in")?.source().add(picture).ok()?;
            let mut result = Picture::empty();
            graph.get("out")?.sink().frame(&mut result).ok()?;
            rgb_of(&result)
        });
        let (size, rgb) = result.ok_or(Failure::Unconvertible)?;
        if *self.size.get_or_insert(size) == size { Ok(rgb) } else { Err(Failure::Unconvertible) }
    }

    fn graph_for(&self, form: &Form) -> Result<Graph, Failure> {
        self.try_graph_for(form).map_err(|_| Failure::Unconvertible)
    }

    fn try_graph_for(&self, form: &Form) -> Result<Graph, ffmpeg::Error> {
        let Form { format, width, height, colors } = form;
        let name = format.descriptor().map(pixel::Descriptor::name).ok_or(ffmpeg::Error::InvalidData)?;
        // From libavfilter 10 on, the source has to be told; before, it takes them from each picture.
        let told = if filter::version() >> 16 >= 10 {
            format!(":colorspace={}:range={}", known_matrix(colors.matrix), colors.range.min(2))
        } else {
            String::new()
        };
        let source = format!("video_size={width}x{height}:pix_fmt={name}:time_base=1/1000{told}");
        let mut steps = self.display_matrix.as_ref().map(rotate::filters).unwrap_or_default();
        // Conversions of the format are inserted where the program inserts them.
        if let Some(Size { width, height }) = self.size {
            steps.push(format!("scale=w={width}:h={height}:flags=bicubic+accurate_rnd"));
        }
        steps.push("format=pix_fmts=rgb24".to_owned());
        if *format == Pixel::RGB24 {
            // Without a conversion the rows could remain bottom up, which the crate cannot read.
            steps.push("copy".to_owned());
        }
        let find = |name| filter::find(name).ok_or(ffmpeg::Error::FilterNotFound);
        let mut graph = Graph::new();
        graph.add(&find("buffer")?, "in", &source)?;
        graph.add(&find("buffersink")?, "out", "")?;
        let steps = format!("sws_flags=bicubic;[in]{}[out]", steps.join(","));
        graph.output("in", 0)?.input("out", 0)?.parse(&steps)?;
        graph.validate()?;
        Ok(graph)
    }
}

/// The matrix, or unspecified where FFmpeg does not know it.
fn known_matrix(matrix: u32) -> u32 {
    if matrix <= 14 && matrix != 3 { matrix } else { 2 }
}

/// The size and rows of an RGB picture.
fn rgb_of(picture: &Picture) -> Option<(Size, Vec<u8>)> {
    // The crate panics on pictures without planes, and makes slices of negative strides.
    if picture.planes() == 0 || picture.format() != Pixel::RGB24 {
        return None;
    }
    let size = Size::new(picture.width(), picture.height());
    let row = size.width as usize * 3;
    let stride = picture.stride(0);
    if row == 0 || stride < row || stride > isize::MAX as usize / size.height.max(1) as usize {
        return None;
    }
    let mut rgb = Vec::with_capacity(size.pixels() * 3);
    for line in picture.data(0).chunks_exact(stride).take(size.height as usize) {
        rgb.extend_from_slice(&line[..row]);
    }
    (rgb.len() == size.pixels() * 3).then_some((size, rgb))
}
