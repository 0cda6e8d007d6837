//! The shader that composes the views, with its pipelines and uniforms on the graphics card.

use eframe::egui_wgpu::RenderState;
use eframe::egui_wgpu::wgpu::{self, util::DeviceExt as _};

use super::compose_style::Compose;
use super::layer::ViewLayer;
use crate::app::model::view::View;

/// Offset between the uniforms of two views, in bytes: the largest alignment that a card may require.
const UNIFORM_STRIDE_BYTES: u64 = 256;
/// The number of slots: one for each view, and one for the loupe.
const UNIFORM_SLOTS: u64 = View::ALL.len() as u64 + 1;
/// The slot of the loupe.
pub(super) const LOUPE_SLOT: u64 = UNIFORM_SLOTS - 1;
/// Size of the shader's `ViewUniforms`, in bytes.
pub(super) const UNIFORM_BYTES: u64 = 96;

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

    /// Writes the bytes of the shader's `ViewUniforms` into a slot.
    pub(super) fn write(&self, queue: &wgpu::Queue, slot: u64, values: &[u8; UNIFORM_BYTES as usize]) {
        queue.write_buffer(&self.values, slot * UNIFORM_STRIDE_BYTES, values);
    }

    /// Draws a composition of bound layers with the values of a slot.
    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'static>,
        what: Compose,
        slot: u64,
        layers: &wgpu::BindGroup,
    ) {
        pass.set_pipeline(&self.pipelines[what as usize]);
        pass.set_bind_group(0, &self.views, &[(slot * UNIFORM_STRIDE_BYTES) as u32]);
        pass.set_bind_group(1, layers, &[]);
        pass.draw(0..4, 0..1);
    }
}
