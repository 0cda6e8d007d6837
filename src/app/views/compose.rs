//! Composition of a view on the graphics card from the layers of a frame.

use std::sync::Arc;

use eframe::egui::{PaintCallback, PaintCallbackInfo, Rect};
use eframe::egui_wgpu::wgpu::{self, util::DeviceExt as _};
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait, RenderState, ScreenDescriptor};

use super::ViewCanvas;
use super::layer::ViewLayer;
use super::pictures::UploadedFrame;
use crate::app::model::view::View;

/// The kind of composition, in the order of the shader's constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Compose {
    /// The input.
    Input,
    /// The input under the mask overlay.
    Masked,
    /// The mean of component 1.
    Mean,
    /// The mean of the background components.
    Modes,
    /// A per-pixel quantity in the colours of its scale.
    Map,
    /// The mask.
    Mask,
    /// The regions in their colours over a dark input.
    Regions,
    /// The difference of the input from the mean.
    Difference,
    /// The mean of component 1 under the compared settings.
    ComparedMean,
    /// The mask of the compared settings.
    ComparedMask,
    /// Both masks in two colours over a dark input.
    Agreement,
    /// False decisions of the mask, in two colours over a dark input.
    MaskErrors,
}

impl Compose {
    /// All kinds in order.
    const ALL: [Self; 12] = [
        Self::Input,
        Self::Masked,
        Self::Mean,
        Self::Modes,
        Self::Map,
        Self::Mask,
        Self::Regions,
        Self::Difference,
        Self::ComparedMean,
        Self::ComparedMask,
        Self::Agreement,
        Self::MaskErrors,
    ];

    /// The layers that it needs.
    pub(crate) const fn layers(self) -> &'static [ViewLayer] {
        match self {
            Self::Input => &[ViewLayer::Input],
            Self::Masked => &[ViewLayer::Input, ViewLayer::Mask],
            Self::Mean => &[ViewLayer::Mean],
            Self::Modes => &[ViewLayer::Modes],
            Self::Map => &[ViewLayer::Map, ViewLayer::Palette],
            Self::Mask => &[ViewLayer::Mask],
            Self::Regions => &[ViewLayer::Input, ViewLayer::Labels, ViewLayer::Palette],
            Self::Difference => &[ViewLayer::Input, ViewLayer::Mean],
            Self::ComparedMean => &[ViewLayer::ComparedMean],
            Self::ComparedMask => &[ViewLayer::ComparedMask],
            Self::Agreement => &[ViewLayer::Input, ViewLayer::Mask, ViewLayer::ComparedMask],
            Self::MaskErrors => &[ViewLayer::Input, ViewLayer::Mask, ViewLayer::Truth],
        }
    }
}

/// The parameters of a composition.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ComposeStyle {
    /// The kind of composition.
    pub(crate) what: Compose,
    /// A factor of all colours.
    pub(crate) tint: f32,
    /// The colour over foreground in [`Compose::Masked`], and of pixels that are foreground in the mask only in
    /// [`Compose::Agreement`] and [`Compose::MaskErrors`]: red, green, blue and opacity, each 0..=1.
    pub(crate) overlay: [f32; 4],
    /// The colour of pixels that are foreground only in the other mask, or only in the ground truth.
    pub(crate) other_colour: [f32; 4],
    /// The parameters of the colour scale of [`Compose::Map`].
    pub(crate) scale: [f32; 4],
}

impl ComposeStyle {
    /// Without tint, overlay or scale.
    pub(crate) const fn plain(what: Compose) -> Self {
        Self { what, tint: 1.0, overlay: [0.0; 4], other_colour: [0.0; 4], scale: [0.0; 4] }
    }
}

/// Offset between the uniforms of two views, in bytes: the largest alignment that a card may require.
const UNIFORM_STRIDE_BYTES: u64 = 256;
/// The number of slots: one for each view, and one for the loupe.
const UNIFORM_SLOTS: u64 = View::ALL.len() as u64 + 1;
/// Size of the shader's `View` struct, in bytes.
const UNIFORM_BYTES: u64 = 96;

/// The shader, its pipeline and its uniforms, for all views.
pub(crate) struct Composer {
    pipelines: [wgpu::RenderPipeline; Compose::ALL.len()],
    layers: wgpu::BindGroupLayout,
    values: wgpu::Buffer,
    views: wgpu::BindGroup,
    /// Replacements for layers that were not uploaded.
    blank: Vec<wgpu::TextureView>,
}

impl Composer {
    /// Creates the pipeline for a graphics card and the window's colour format.
    pub(crate) fn new(gpu: &RenderState) -> Self {
        let device = &gpu.device;
        let module = device.create_shader_module(wgpu::include_wgsl!("compose.wgsl"));
        let values = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("views"),
            size: UNIFORM_STRIDE_BYTES * UNIFORM_SLOTS,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let of_view = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("view"),
            entries: &[
                wgpu::BindGroupLayoutEntry {
                    binding: 0,
                    visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                    ty: wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: true,
                        min_binding_size: wgpu::BufferSize::new(UNIFORM_BYTES),
                    },
                    count: None,
                },
                wgpu::BindGroupLayoutEntry {
                    binding: 1,
                    visibility: wgpu::ShaderStages::FRAGMENT,
                    ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                    count: None,
                },
            ],
        });
        let entries = ViewLayer::ALL.map(|layer| wgpu::BindGroupLayoutEntry {
            binding: layer as u32,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: layer
                    .format()
                    .sample_type(None, None)
                    .unwrap_or(wgpu::TextureSampleType::Float { filterable: true }),
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        });
        let layers = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("layers"),
            entries: &entries,
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("views"),
            bind_group_layouts: &[Some(&of_view), Some(&layers)],
            immediate_size: 0,
        });
        let to = if gpu.target_format.is_srgb() { "to_linear" } else { "to_gamma" };
        let pipelines = Compose::ALL.map(|what| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("views"),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("corner"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState {
                    topology: wgpu::PrimitiveTopology::TriangleStrip,
                    ..wgpu::PrimitiveState::default()
                },
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(to),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &[("WHAT", f64::from(what as u32))],
                        ..wgpu::PipelineCompilationOptions::default()
                    },
                    targets: &[Some(gpu.target_format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        });
        let smooth = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("smooth"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        let views = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("view"),
            layout: &of_view,
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer: &values,
                        offset: 0,
                        size: wgpu::BufferSize::new(UNIFORM_BYTES),
                    }),
                },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&smooth) },
            ],
        });
        let blank = ViewLayer::ALL.map(|layer| {
            let descriptor = wgpu::TextureDescriptor {
                label: Some("no layer"),
                size: wgpu::Extent3d::default(),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: layer.format(),
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            };
            let bytes = vec![0; layer.texel_bytes()];
            let order = wgpu::util::TextureDataOrder::LayerMajor;
            device
                .create_texture_with_data(&gpu.queue, &descriptor, order, &bytes)
                .create_view(&wgpu::TextureViewDescriptor::default())
        });
        Self { pipelines, layers, values, views, blank: blank.into() }
    }

    /// Binds the layers of a frame. Missing layers are black.
    pub(crate) fn bind<'a>(
        &'a self,
        device: &wgpu::Device,
        layer: impl Fn(ViewLayer) -> Option<&'a wgpu::TextureView>,
    ) -> wgpu::BindGroup {
        let entries = ViewLayer::ALL.map(|which| wgpu::BindGroupEntry {
            binding: which as u32,
            resource: wgpu::BindingResource::TextureView(layer(which).unwrap_or(&self.blank[which as usize])),
        });
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("layers"),
            layout: &self.layers,
            entries: &entries,
        })
    }
}

/// A view of a frame, drawn by an egui paint callback.
pub(crate) struct Composition {
    composer: Arc<Composer>,
    /// Retained until it is drawn, so that its textures are not reused before.
    set: Arc<UploadedFrame>,
    /// The index of its uniforms.
    slot: u64,
    style: ComposeStyle,
    canvas: ViewCanvas,
}

impl Composition {
    /// The paint callback for the visible part of the image; `None` where no part is visible or a layer is missing.
    pub(crate) fn shape(
        composer: &Arc<Composer>,
        set: &Arc<UploadedFrame>,
        view: View,
        style: ComposeStyle,
        canvas: ViewCanvas,
    ) -> Option<PaintCallback> {
        Self::of_slot(composer, set, view as u64, style, canvas)
    }

    /// The paint callback of the loupe.
    pub(crate) fn loupe(
        composer: &Arc<Composer>,
        set: &Arc<UploadedFrame>,
        style: ComposeStyle,
        canvas: ViewCanvas,
    ) -> Option<PaintCallback> {
        Self::of_slot(composer, set, UNIFORM_SLOTS - 1, style, canvas)
    }

    fn of_slot(
        composer: &Arc<Composer>,
        set: &Arc<UploadedFrame>,
        slot: u64,
        style: ComposeStyle,
        canvas: ViewCanvas,
    ) -> Option<PaintCallback> {
        let seen: Rect = canvas.whole().intersect(canvas.rect);
        let whole = style.what.layers().iter().all(|&layer| set.has(layer));
        (whole && seen.is_positive()).then(|| {
            let (composer, set) = (Arc::clone(composer), Arc::clone(set));
            Callback::new_paint_callback(seen, Self { composer, set, slot, style, canvas })
        })
    }

    /// The offset of its uniforms, in bytes.
    const fn offset(&self) -> u64 {
        self.slot * UNIFORM_STRIDE_BYTES
    }

    /// The bytes of the shader's `View` struct.
    fn values(&self, screen: &ScreenDescriptor) -> [u8; UNIFORM_BYTES as usize] {
        let dense = screen.pixels_per_point;
        let whole = self.canvas.whole();
        let [width, height] = screen.size_in_pixels.map(|side| side as f32);
        let texels = self.set.texels();
        let [r, g, b, a] = self.style.overlay;
        let other_colour = self.style.other_colour;
        let [kind, offset, low, high] = self.style.scale;
        let values = [
            whole.left() * dense,
            whole.top() * dense,
            width,
            height,
            whole.width() * dense,
            whole.height() * dense,
            texels.width as f32,
            texels.height as f32,
            r,
            g,
            b,
            a,
            kind,
            offset,
            low,
            high,
            self.canvas.scale * dense * self.set.every() as f32,
            self.style.tint,
            dense,
            0.0,
            other_colour[0],
            other_colour[1],
            other_colour[2],
            other_colour[3],
        ];
        let mut bytes = [0; UNIFORM_BYTES as usize];
        for (four, value) in bytes.chunks_exact_mut(4).zip(values) {
            four.copy_from_slice(&value.to_ne_bytes());
        }
        bytes
    }
}

impl CallbackTrait for Composition {
    fn prepare(
        &self,
        _device: &wgpu::Device,
        queue: &wgpu::Queue,
        screen: &ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        _resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        queue.write_buffer(&self.composer.values, self.offset(), &self.values(screen));
        Vec::new()
    }

    fn paint(
        &self,
        info: PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _resources: &CallbackResources,
    ) {
        // The shader positions the image in the whole window, with subpixel accuracy like the shapes over it.
        let [width, height] = info.screen_size_px.map(|side| side as f32);
        pass.set_viewport(0.0, 0.0, width, height, 0.0, 1.0);
        pass.set_pipeline(&self.composer.pipelines[self.style.what as usize]);
        pass.set_bind_group(0, &self.composer.views, &[self.offset() as u32]);
        pass.set_bind_group(1, self.set.group(), &[]);
        pass.draw(0..4, 0..1);
    }
}
