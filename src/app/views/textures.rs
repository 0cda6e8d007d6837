//! Pictures on the graphics card, sent again only when what they show is another.

use std::any::Any;
use std::collections::HashMap;
use std::sync::Arc;

use eframe::egui::{
    Color32, ColorImage, Context, TextureFilter, TextureHandle, TextureId, TextureOptions, TextureWrapMode,
};

use super::View;
use crate::frame::Size;

/// What a picture was made from; kept, so that its address cannot become another's.
type Origin = Arc<dyn Any + Send + Sync>;

/// A picture a view.
#[derive(Default)]
pub(crate) struct Textures {
    kept: HashMap<(View, u8), ([Origin; 2], TextureHandle)>,
}

/// Sharp pixels when large, smooth when small.
const OPTIONS: TextureOptions = TextureOptions {
    magnification: TextureFilter::Nearest,
    minification: TextureFilter::Linear,
    wrap_mode: TextureWrapMode::ClampToEdge,
    mipmap_mode: None,
};

impl Textures {
    /// The picture in `slot` of a view: the one that is there when it was made from the same two
    /// things, else a new one by `colour`, which gives the colour of the pixel at an index.
    pub(crate) fn get(
        &mut self,
        ctx: &Context,
        (view, slot): (View, u8),
        origin: [Origin; 2],
        size: Size,
        colour: impl Fn(usize) -> Color32,
    ) -> TextureId {
        if let Some((known, texture)) = self.kept.get(&(view, slot))
            && known.iter().zip(&origin).all(|(a, b)| std::ptr::addr_eq(Arc::as_ptr(a), Arc::as_ptr(b)))
        {
            return texture.id();
        }
        let picture = picture(size, ctx.input(|input| input.max_texture_side), colour);
        if let Some((known, texture)) = self.kept.get_mut(&(view, slot)) {
            *known = origin;
            texture.set(picture, OPTIONS);
            return texture.id();
        }
        let texture = ctx.load_texture(format!("{} {slot}", view.title()), picture, OPTIONS);
        let id = texture.id();
        self.kept.insert((view, slot), (origin, texture));
        id
    }

    /// Forgets all pictures, for another video.
    pub(crate) fn clear(&mut self) {
        self.kept.clear();
    }
}

/// A picture of an image, every n-th pixel of it where the graphics card cannot take it whole.
fn picture(size: Size, most: usize, colour: impl Fn(usize) -> Color32) -> ColorImage {
    let (width, height) = (size.width as usize, size.height as usize);
    let every = width.max(height).div_ceil(most.max(1)).max(1);
    let mut pixels = Vec::with_capacity(width.div_ceil(every) * height.div_ceil(every));
    for y in (0..height).step_by(every) {
        for x in (0..width).step_by(every) {
            pixels.push(colour(y * width + x));
        }
    }
    ColorImage::new([width.div_ceil(every), height.div_ceil(every)], pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_too_large_for_the_card_is_thinned() {
        let picture = picture(Size::new(100, 30), 40, |index| Color32::from_gray(index as u8));
        assert_eq!(picture.size, [34, 10]);
        assert_eq!(picture.pixels[1], Color32::from_gray(3));
    }
}
