//! A view of a frame, composed on the graphics card.

use std::sync::Arc;

use eframe::egui::{PaintCallback, PaintCallbackInfo, Rect};
use eframe::egui_wgpu::wgpu;
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait, ScreenDescriptor};

use super::canvas::ViewCanvas;
use super::compose_style::ComposeStyle;
use super::composer::{Composer, LOUPE_SLOT, UNIFORM_BYTES};
use super::uploaded_frame::UploadedFrame;
use crate::app::model::view::View;

/// A view of a frame, drawn by an egui paint callback.
pub(crate) struct Composition {
    composer: Arc<Composer>,
    /// Retained until it is drawn, so that its textures are not reused before.
    set: Arc<UploadedFrame>,
    /// The index of its uniforms in the composer.
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
        Self::of_slot(composer, set, LOUPE_SLOT, style, canvas)
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

    /// The bytes of the shader's `ViewUniforms`.
    fn values(&self, screen: &ScreenDescriptor) -> [u8; UNIFORM_BYTES as usize] {
        let dense = screen.pixels_per_point;
        let whole = self.canvas.whole();
        let [width, height] = screen.size_in_pixels.map(|side| side as f32);
        let texels = self.set.texels();
        let [r, g, b, a] = self.style.overlay;
        let other_colour = self.style.other_colour;
        let [kind, offset, low, high] = self.style.scale;
        let texel = self.canvas.pixel_size() * dense * self.set.every as f32;
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
            texel.x,
            texel.y,
            self.style.tint,
            dense,
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
        self.composer.write(queue, self.slot, &self.values(screen));
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
        self.composer.draw(pass, self.style.what, self.slot, &self.set.group);
    }
}
