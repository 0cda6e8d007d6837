//! The layers of a frame: raw textures, from which the graphics card composes every view.

use std::sync::Arc;

use eframe::egui_wgpu::wgpu::TextureFormat;

use super::{ramp, region_colours};
use crate::frame::{Frame, Size};
use crate::regions::Labels;
use crate::replay::ShownFrame;
use crate::truth::masks::Label;

/// A layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ViewLayer {
    /// The input's colours.
    Input,
    /// The mean of component 1.
    Mean,
    /// The weighted mean of the background components.
    Modes,
    /// A per-pixel quantity.
    Map,
    /// The mask.
    Mask,
    /// The region label of each pixel.
    Labels,
    /// The colour ramp in the first row, the colours of counts in the second, the colours of the regions from the
    /// third.
    Palette,
    /// The ignored pixels.
    Ignored,
    /// The mean of component 1 under the compared settings.
    ComparedMean,
    /// The mask of the compared settings.
    ComparedMask,
    /// The ground-truth foreground, and the pixels that are not ignored.
    Truth,
    /// The mask of the external results.
    External,
}

/// Texels in a row of the palette.
const PALETTE_WIDTH: usize = 256;
/// Rows of the palette before the colours of the regions.
const PALETTE_ROWS: u32 = 2;
/// The largest label with its own colour; larger labels share it.
const LAST_LABEL: u32 = u16::MAX as u32;

impl ViewLayer {
    /// All layers, in the order of their bindings in the shader.
    pub(crate) const ALL: [Self; 12] = [
        Self::Input,
        Self::Mean,
        Self::Modes,
        Self::Map,
        Self::Mask,
        Self::Labels,
        Self::Palette,
        Self::Ignored,
        Self::ComparedMean,
        Self::ComparedMask,
        Self::Truth,
        Self::External,
    ];

    /// The texture format.
    pub(crate) const fn format(self) -> TextureFormat {
        match self {
            Self::Input | Self::Mean | Self::Modes | Self::Palette | Self::ComparedMean => {
                TextureFormat::Rgba8Unorm
            }
            Self::Map => TextureFormat::R32Float,
            Self::Mask | Self::Ignored | Self::ComparedMask | Self::External => TextureFormat::R8Unorm,
            Self::Labels => TextureFormat::R16Uint,
            Self::Truth => TextureFormat::Rg8Unorm,
        }
    }

    /// Bytes per texel.
    pub(crate) const fn texel_bytes(self) -> usize {
        match self {
            Self::Input | Self::Mean | Self::Modes | Self::Map | Self::Palette | Self::ComparedMean => 4,
            Self::Mask | Self::Ignored | Self::ComparedMask | Self::External => 1,
            Self::Labels | Self::Truth => 2,
        }
    }

    /// Whether a frame has the layer. `Modes` needs a mixture; `Map`, `Truth`, `External`, `Ignored` and the compared
    /// layers need their data in the frame.
    pub(crate) const fn is_in(self, shown: &ShownFrame) -> bool {
        match self {
            Self::Modes => shown.multi_mode.is_some(),
            Self::Map => shown.map.is_some(),
            Self::Ignored => shown.roi.is_some(),
            Self::ComparedMean | Self::ComparedMask => shown.compared.is_some(),
            Self::Truth => shown.truth.is_some(),
            Self::External => shown.external.is_some(),
            _ => true,
        }
    }

    /// Whether the layer is made from the same data in both frames.
    pub(crate) fn is_same(self, a: &ShownFrame, b: &ShownFrame) -> bool {
        fn both<T>(a: Option<&Arc<T>>, b: Option<&Arc<T>>) -> bool {
            a.zip(b).is_some_and(|(a, b)| Arc::ptr_eq(a, b))
        }
        fn compared<'a>(a: &'a ShownFrame, b: &'a ShownFrame) -> Option<(&'a ShownFrame, &'a ShownFrame)> {
            a.compared.as_deref().zip(b.compared.as_deref())
        }
        match self {
            Self::Input => Arc::ptr_eq(&a.frame, &b.frame),
            Self::Mean => Arc::ptr_eq(&a.background, &b.background),
            Self::Modes => both(a.multi_mode.as_ref(), b.multi_mode.as_ref()),
            Self::Map => both(a.map.as_ref(), b.map.as_ref()),
            Self::Mask => Arc::ptr_eq(&a.analysis.mask, &b.analysis.mask),
            Self::Labels => Arc::ptr_eq(&a.analysis.labels, &b.analysis.labels),
            Self::Palette => Arc::ptr_eq(&a.analysis, &b.analysis),
            Self::Ignored => both(a.roi.as_ref(), b.roi.as_ref()),
            Self::ComparedMean => compared(a, b).is_some_and(|(a, b)| Self::Mean.is_same(a, b)),
            Self::ComparedMask => compared(a, b).is_some_and(|(a, b)| Self::Mask.is_same(a, b)),
            Self::Truth => both(a.truth.as_ref(), b.truth.as_ref()),
            Self::External => both(a.external.as_ref(), b.external.as_ref()),
        }
    }

    /// Width and height in texels if every `every`-th pixel of each row and column is sampled.
    pub(crate) fn texels(self, shown: &ShownFrame, every: u32) -> Size {
        if self == Self::Palette {
            let labels = region_colours::colours(&shown.analysis).len().min(LAST_LABEL as usize + 1);
            return Size::new(PALETTE_WIDTH as u32, PALETTE_ROWS + labels.div_ceil(PALETTE_WIDTH) as u32);
        }
        texels(shown.frame.size, every)
    }

    /// Calls `put` for each row of texels with the row's index, from the top.
    pub(crate) fn write(self, shown: &ShownFrame, every: u32, put: &mut dyn FnMut(usize, &[u8])) {
        let (width, every) = (shown.frame.size.width as usize, every as usize);
        match self {
            Self::Input => colours(&shown.frame, every, put),
            Self::Mean => colours(&shown.background, every, put),
            Self::Modes => {
                if let Some(modes) = &shown.multi_mode {
                    colours(modes, every, put);
                }
            }
            Self::Map => {
                if let Some(map) = &shown.map {
                    // The shader need not handle infinite values.
                    let bytes = |&value: &f32| if value.is_finite() { value } else { -1.0 }.to_le_bytes();
                    numbers(&map.values, width, every, bytes, put);
                }
            }
            Self::Mask => numbers(&shown.analysis.mask.data, width, every, |&value| [value], put),
            Self::Labels => labels(&shown.analysis.labels, every, put),
            Self::Ignored => {
                if let Some(roi) = &shown.roi {
                    numbers(&roi.mask().data, width, every, |&value| [255 - value], put);
                }
            }
            Self::Truth => {
                if let Some(truth) = &shown.truth {
                    let bytes = |label: &Label| match label {
                        Label::Background => [0, 255],
                        Label::Foreground => [255, 255],
                        Label::Uncounted => [0, 0],
                    };
                    numbers(&truth.labels(), width, every, bytes, put);
                }
            }
            Self::External => {
                if let Some(mask) = &shown.external {
                    let bytes = |label: &Label| [if *label == Label::Foreground { 255 } else { 0 }];
                    numbers(&mask.labels(), width, every, bytes, put);
                }
            }
            Self::ComparedMean | Self::ComparedMask => {
                if let Some(compared) = &shown.compared {
                    let like = if self == Self::ComparedMean { Self::Mean } else { Self::Mask };
                    like.write(compared, every as u32, put);
                }
            }
            Self::Palette => {
                let mut row = vec![0; PALETTE_WIDTH * 4];
                let ramp = (0..ramp::RAMP_COLOURS).map(ramp::ramp).chain([ramp::INFINITE_COLOUR]);
                for (texel, colour) in row.chunks_exact_mut(4).zip(ramp) {
                    texel.copy_from_slice(&colour.to_array());
                }
                put(0, &row);
                for (texel, colour) in row.chunks_exact_mut(4).zip(ramp::COUNT_COLOURS) {
                    texel.copy_from_slice(&colour.to_array());
                }
                put(1, &row);
                let colours = region_colours::colours(&shown.analysis);
                let kept = &colours[..colours.len().min(LAST_LABEL as usize + 1)];
                for (y, colours) in kept.chunks(PALETTE_WIDTH).enumerate() {
                    for (texel, colour) in row.chunks_exact_mut(4).zip(colours) {
                        texel.copy_from_slice(&colour.to_array());
                    }
                    put(y + PALETTE_ROWS as usize, &row);
                }
            }
        }
    }
}

/// A set of layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LayerSet([bool; ViewLayer::ALL.len()]);

impl LayerSet {
    /// The empty set.
    pub(crate) const NONE: Self = Self([false; ViewLayer::ALL.len()]);

    /// Adds layers.
    pub(crate) fn add(&mut self, layers: &[ViewLayer]) {
        for &layer in layers {
            self.0[layer as usize] = true;
        }
    }

    /// Whether a layer is in the set.
    pub(crate) const fn has(self, layer: ViewLayer) -> bool {
        self.0[layer as usize]
    }

    /// Whether the set contains all of `others`.
    pub(crate) fn covers(self, others: Self) -> bool {
        ViewLayer::ALL.into_iter().all(|layer| self.has(layer) || !others.has(layer))
    }
}

/// The smallest sampling step for which neither side has more than `most` texels.
pub(crate) fn thinning(size: Size, most: u32) -> u32 {
    size.width.max(size.height).div_ceil(most.max(1)).max(1)
}

fn texels(size: Size, every: u32) -> Size {
    Size::new(size.width.div_ceil(every).max(1), size.height.div_ceil(every).max(1))
}

fn colours(frame: &Frame, every: usize, put: &mut dyn FnMut(usize, &[u8])) {
    let width = frame.size.width as usize;
    let mut row = vec![255; width.div_ceil(every) * 4];
    for (y, source) in frame.rgb.chunks_exact(width.max(1) * 3).step_by(every).enumerate() {
        let texels = row.chunks_exact_mut(4);
        if every == 1 {
            for (texel, pixel) in texels.zip(source.chunks_exact(3)) {
                texel[..3].copy_from_slice(pixel);
            }
        } else {
            for (texel, pixel) in texels.zip(source.chunks_exact(3).step_by(every)) {
                texel[..3].copy_from_slice(pixel);
            }
        }
        put(y, &row);
    }
}

fn labels(labels: &Labels, every: usize, put: &mut dyn FnMut(usize, &[u8])) {
    let width = labels.size.width as usize;
    let mut row = vec![0; width.div_ceil(every) * 2];
    let mut runs = labels.runs.iter().peekable();
    for (y, start) in (0..labels.size.pixels()).step_by((width * every).max(1)).enumerate() {
        row.fill(0);
        // Rows between sampled rows are skipped.
        while runs.next_if(|run| run.pixels().end <= start).is_some() {}
        while let Some(run) = runs.next_if(|run| run.pixels().start < start + width) {
            let columns = run.pixels().start - start..run.pixels().end - start;
            let texels = columns.start.div_ceil(every) * 2..columns.end.div_ceil(every) * 2;
            let label = (run.label.min(LAST_LABEL) as u16).to_le_bytes();
            row[texels].as_chunks_mut().0.fill(label);
        }
        put(y, &row);
    }
}

fn numbers<T, const N: usize>(
    data: &[T],
    width: usize,
    every: usize,
    bytes: impl Fn(&T) -> [u8; N],
    put: &mut dyn FnMut(usize, &[u8]),
) {
    let mut row = vec![0; width.div_ceil(every) * N];
    for (y, source) in data.chunks_exact(width.max(1)).step_by(every).enumerate() {
        let texels = row.chunks_exact_mut(N);
        if every == 1 {
            for (texel, value) in texels.zip(source) {
                texel.copy_from_slice(&bytes(value));
            }
        } else {
            for (texel, value) in texels.zip(source.iter().step_by(every)) {
                texel.copy_from_slice(&bytes(value));
            }
        }
        put(y, &row);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_larger_than_the_texture_limit_is_subsampled() {
        let size = Size::new(100, 30);
        let every = thinning(size, 40);
        assert_eq!((every, texels(size, every)), (3, Size::new(34, 10)));
        assert_eq!(thinning(size, 100), 1);
        let frame = Frame::new(1, size, (0..9000).map(|byte| (byte / 3 % 100) as u8).collect());
        let mut rows = Vec::new();
        colours(&frame, 3, &mut |y, row| rows.push((y, row.to_vec())));
        assert_eq!(rows.len(), 10);
        assert_eq!(rows[9].0, 9);
        assert_eq!(rows[9].1[..8], [0, 0, 0, 255, 3, 3, 3, 255]);
        assert_eq!(rows[9].1[33 * 4..], [99, 99, 99, 255]);
    }

    #[test]
    fn labels_beyond_sixteen_bits_share_the_last_colour() {
        let many = Labels::of_image(Size::new(2, 1), &[258, 70_000]);
        let mut bytes = Vec::new();
        labels(&many, 1, &mut |_, row| bytes.extend_from_slice(row));
        assert_eq!(bytes, [2, 1, 255, 255]);
    }

    #[test]
    fn labels_are_subsampled_like_other_layers() {
        let image =
            [0, 3, 3, 3, 0, 9, 1, 1, 0, 0, 0, 0, 5, 0, 4, 4, 4, 4, 7, 7, 7, 7, 7, 7, 8, 0, 8, 0, 0, 2];
        let size = Size::new(6, 5);
        for every in 1..4 {
            let mut rows = Vec::new();
            labels(&Labels::of_image(size, &image), every, &mut |y, row| rows.push((y, row.to_vec())));
            let mut expected = Vec::new();
            let bytes = |label: &u32| (*label as u16).to_le_bytes();
            numbers(&image, 6, every, bytes, &mut |y, row| expected.push((y, row.to_vec())));
            assert_eq!(rows, expected, "every {every}");
        }
    }
}
