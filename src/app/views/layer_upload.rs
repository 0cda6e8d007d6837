//! Upload of layers to the graphics card; textures are reused as soon as no view shows them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use eframe::egui_wgpu::wgpu;

use super::layer::{LayerSet, ViewLayer};
use crate::frame::Size;
use crate::replay::ShownFrame;

/// A layer on the graphics card.
pub(crate) struct UploadedLayer {
    texture: wgpu::Texture,
    /// The view for bindings.
    pub(crate) view: wgpu::TextureView,
}

/// The layers of a frame, in the order of [`ViewLayer::ALL`].
pub(crate) type UploadedLayers = [Option<Arc<UploadedLayer>>; ViewLayer::ALL.len()];

/// A staging buffer: mapped for writing here, and the source of a copy on the card.
struct StagingBuffer {
    buffer: wgpu::Buffer,
    /// Whether the buffer may be written: the card has copied its content.
    is_ours: Arc<AtomicBool>,
}

/// Largest number of copies of a layer in flight; beyond that the upload waits for the card.
const MAX_COPIES_IN_FLIGHT: usize = 2;

/// Textures and staging buffers of a layer.
#[derive(Default)]
struct LayerBuffers {
    textures: Vec<Arc<UploadedLayer>>,
    staging: Vec<StagingBuffer>,
}

/// Uploads layers.
///
/// It does not use the queue's `write_texture`: that locks the queue during the copy, and the window's thread would
/// wait for it.
pub(crate) struct LayerUploader {
    device: wgpu::Device,
    queue: wgpu::Queue,
    stocks: [LayerBuffers; ViewLayer::ALL.len()],
    /// Bytes uploaded for the current frame.
    bytes: u64,
}

impl LayerUploader {
    pub(crate) fn new(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        Self { device, queue, stocks: Default::default(), bytes: 0 }
    }

    /// Uploads those `layers` of a frame that are not in `known`, sampled at every `every`-th pixel. Returns all
    /// layers and the number of uploaded bytes. Fails where no staging buffer can be mapped.
    pub(crate) fn send(
        &mut self,
        shown: &ShownFrame,
        layers: LayerSet,
        every: u32,
        known: impl Fn(ViewLayer) -> Option<Arc<UploadedLayer>>,
    ) -> Result<(UploadedLayers, u64), wgpu::MapRangeError> {
        self.bytes = 0;
        let mut encoder =
            self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("layers") });
        let mut uploaded = UploadedLayers::default();
        let mut filled = Vec::new();
        for layer in ViewLayer::ALL {
            if !layers.has(layer) || !layer.is_in(shown) {
                self.stocks[layer as usize] = LayerBuffers::default();
                continue;
            }
            uploaded[layer as usize] = known(layer);
            if uploaded[layer as usize].is_none() {
                let (sent, staging) = self.fill(layer, shown, every, &mut encoder)?;
                uploaded[layer as usize] = Some(sent);
                filled.push((layer, staging));
            }
        }
        if filled.is_empty() {
            return Ok((uploaded, 0));
        }
        self.queue.submit([encoder.finish()]);
        for (layer, staging) in filled {
            let is_ours = Arc::clone(&staging.is_ours);
            staging.buffer.map_async(wgpu::MapMode::Write, .., move |mapped| {
                is_ours.store(mapped.is_ok(), Ordering::Release);
            });
            self.stocks[layer as usize].staging.push(staging);
        }
        Ok((uploaded, self.bytes))
    }

    fn fill(
        &mut self,
        layer: ViewLayer,
        shown: &ShownFrame,
        every: u32,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(Arc<UploadedLayer>, StagingBuffer), wgpu::MapRangeError> {
        let texels = layer.texels(shown, every);
        let row = texels.width as usize * layer.texel_bytes();
        let stride = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize);
        let length = stride * texels.height as usize;
        let stock = &mut self.stocks[layer as usize];
        let staging = stock.staging(&self.device, length as u64);
        let sent = stock.texture(&self.device, layer, texels);
        {
            let mut memory = staging.buffer.get_mapped_range_mut(..)?;
            layer.write(shown, every, &mut |y, bytes| {
                let bytes = &bytes[..bytes.len().min(row)];
                if y < texels.height as usize {
                    memory.slice(y * stride..y * stride + bytes.len()).copy_from_slice(bytes);
                }
            });
        }
        staging.buffer.unmap();
        staging.is_ours.store(false, Ordering::Release);
        self.bytes += length as u64;
        encoder.copy_buffer_to_texture(
            wgpu::TexelCopyBufferInfo {
                buffer: &staging.buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(stride as u32),
                    rows_per_image: None,
                },
            },
            sent.texture.as_image_copy(),
            sent.texture.size(),
        );
        Ok((sent, staging))
    }
}

impl LayerBuffers {
    /// A texture that no frame uses.
    fn texture(&mut self, device: &wgpu::Device, layer: ViewLayer, texels: Size) -> Arc<UploadedLayer> {
        let fits = |sent: &Arc<UploadedLayer>| {
            (sent.texture.width(), sent.texture.height()) == (texels.width, texels.height)
        };
        self.textures.retain(fits);
        if let Some(free) = self.textures.iter().find(|sent| Arc::strong_count(sent) == 1) {
            return Arc::clone(free);
        }
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("layer"),
            size: wgpu::Extent3d { width: texels.width, height: texels.height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: layer.format(),
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let sent = Arc::new(UploadedLayer { texture, view });
        self.textures.push(Arc::clone(&sent));
        sent
    }

    /// A staging buffer of this length that may be written.
    fn staging(&mut self, device: &wgpu::Device, length: u64) -> StagingBuffer {
        self.staging.retain(|staging| staging.buffer.size() == length);
        for poll in [wgpu::PollType::Poll, wgpu::PollType::wait_indefinitely()] {
            if poll.is_wait() && self.staging.len() < MAX_COPIES_IN_FLIGHT {
                break;
            }
            // A lost device is reported by the next operation.
            let _ = device.poll(poll);
            if let Some(free) = self.staging.iter().position(|s| s.is_ours.load(Ordering::Acquire)) {
                return self.staging.swap_remove(free);
            }
        }
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("staging"),
            size: length,
            usage: wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: true,
        });
        StagingBuffer { buffer, is_ours: Arc::new(AtomicBool::new(true)) }
    }
}
