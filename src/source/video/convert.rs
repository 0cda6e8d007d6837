//! Conversion of decoded pictures to upright 8-bit RGB by a filter graph, the same as that of the `ffmpeg` program.

use std::collections::VecDeque;

use ffmpeg::filter::{self, Graph};
use ffmpeg::format::{Pixel, pixel};
use ffmpeg::frame::{Video as Picture, side_data};

use super::Failure;
use super::raw::ColorNumbers;
use super::reader::{PictureInfo, TimedPicture};
use super::rotate::{self, DisplayMatrix};
use crate::frame::Size;
use crate::libav::wants_data;

/// Makes one frame of each picture, of its own time: the lines of the field that is shown first, and lines between them
/// from that field and its neighbours in time. It needs the pictures before and after; at the ends of the sequence it
/// interpolates within the picture.
///
/// All pictures are deinterlaced, also those that are not marked as interlaced: marks are often missing or wrong, and who
/// asks for it sees that it is necessary.
const DEINTERLACER: &str = "bwdif=mode=send_frame:deint=all";

/// The properties of a picture that a graph is made for.
#[derive(Clone, Debug, PartialEq)]
struct Form {
    format: Pixel,
    width: u32,
    height: u32,
    colors: ColorNumbers,
}

/// A frame, made of a picture with these properties.
pub(super) struct Converted {
    pub(super) info: PictureInfo,
    /// RGB in row order.
    pub(super) rgb: Vec<u8>,
}

/// Converts the pictures of a stream. There is one frame for each picture, in the same order. All frames have the size
/// of the first.
pub(super) struct Converter {
    display_matrix: Option<DisplayMatrix>,
    deinterlace: bool,
    graph: Option<(Form, Graph)>,
    /// The form of the first picture.
    first_form: Option<Form>,
    /// Whether the form has changed since the start or the last jump.
    has_changed: bool,
    /// Size of the first frame.
    size: Option<Size>,
    /// The properties of the pictures in the graph, in order.
    converting: VecDeque<PictureInfo>,
    converted: VecDeque<Converted>,
}

impl Converter {
    /// A converter for a stream with this display matrix in its header. Its first picture must be that of the stream.
    pub(super) fn new(display_matrix: Option<DisplayMatrix>, deinterlace: bool) -> Self {
        let (converting, converted) = (VecDeque::new(), VecDeque::new());
        Self {
            display_matrix,
            deinterlace,
            graph: None,
            first_form: None,
            has_changed: false,
            size: None,
            converting,
            converted,
        }
    }

    /// The size of all frames; `None` before the first.
    pub(super) fn size(&self) -> Option<Size> {
        self.size
    }

    /// Whether results have the width of the pictures as their height.
    pub(super) fn swaps_sides(&self) -> bool {
        self.display_matrix.as_ref().is_some_and(rotate::swaps_sides)
    }

    /// Number of pictures taken whose frames were not given.
    pub(super) fn held(&self) -> usize {
        self.converting.len() + self.converted.len()
    }

    /// The next frame, `None` after the last. Takes pictures from `next` as long as the frame depends on them.
    pub(super) fn next(
        &mut self,
        next: impl FnMut() -> Result<Option<TimedPicture>, Failure>,
    ) -> Result<Option<Converted>, Failure> {
        self.prepare(next)?;
        Ok(self.converted.pop_front())
    }

    /// Makes the next frame and holds it back; returns the properties of its picture.
    pub(super) fn prepare(
        &mut self,
        mut next: impl FnMut() -> Result<Option<TimedPicture>, Failure>,
    ) -> Result<Option<PictureInfo>, Failure> {
        while self.converted.is_empty() {
            let Some(picture) = next()? else {
                self.finish()?;
                break;
            };
            self.add(picture)?;
        }
        Ok(self.converted.front().map(|frame| frame.info))
    }

    /// Forgets the pictures so far, as the next one is from another place.
    pub(super) fn jump(&mut self) {
        self.converted.clear();
        self.converting.clear();
        if self.deinterlace || self.has_changed {
            (self.graph, self.has_changed) = (None, false);
        }
    }

    /// Converts a picture. Its planes are moved into the graph.
    fn add(&mut self, TimedPicture { picture, info }: TimedPicture) -> Result<(), Failure> {
        if self.first_form.is_none() {
            // Later pictures have the matrix of the first, if it has one.
            let data = picture.side_data(side_data::Type::DisplayMatrix);
            let matrix = data.and_then(|data| rotate::display_matrix(data.data()));
            self.display_matrix = matrix.or(self.display_matrix);
        }
        let form = Form {
            format: picture.format(),
            width: picture.width(),
            height: picture.height(),
            colors: info.colors,
        };
        if self.graph.as_ref().is_none_or(|(made_for, _)| *made_for != form) {
            self.has_changed |=
                self.graph.is_some() || *self.first_form.get_or_insert_with(|| form.clone()) != form;
            self.finish()?;
            self.graph = Some((form.clone(), self.graph_for(&form)?));
        }
        self.converting.push_back(info);
        let added = self.graph.as_mut().and_then(|(_, graph)| graph.get("in")?.source().add(&picture).ok());
        added.ok_or(Failure::Unconvertible)?;
        self.collect()
    }

    /// Takes the last frames out of the graph and drops it.
    fn finish(&mut self) -> Result<(), Failure> {
        let flushed = self.graph.as_mut().is_none_or(|(_, graph)| {
            let Some(mut source) = graph.get("in") else { return false };
            source.source().flush().is_ok()
        });
        self.collect()?;
        self.graph = None;
        if flushed && self.converting.is_empty() { Ok(()) } else { Err(Failure::Unconvertible) }
    }

    /// Takes frames out of the graph, as many as there are.
    fn collect(&mut self) -> Result<(), Failure> {
        let Some((_, graph)) = &mut self.graph else { return Ok(()) };
        loop {
            let mut result = Picture::empty();
            let mut sink = graph.get("out").ok_or(Failure::Unconvertible)?;
            match sink.sink().frame(&mut result) {
                Ok(()) => {}
                Err(error) if error == ffmpeg::Error::Eof || wants_data(error) => return Ok(()),
                Err(_) => return Err(Failure::Unconvertible),
            }
            let (size, rgb) = rgb_of(&result).ok_or(Failure::Unconvertible)?;
            let info = self.converting.pop_front().ok_or(Failure::Unconvertible)?;
            if *self.size.get_or_insert(size) != size {
                return Err(Failure::Unconvertible);
            }
            self.converted.push_back(Converted { info, rgb });
        }
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
        let mut steps = Vec::new();
        if self.deinterlace {
            // Before a rotation, while the lines of a field are rows.
            steps.push(DEINTERLACER.to_owned());
        }
        steps.extend(self.display_matrix.iter().flat_map(rotate::filters));
        // Conversions of the format are inserted where the program inserts them.
        if let Some(Size { width, height }) = self.size.filter(|_| self.has_changed) {
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
