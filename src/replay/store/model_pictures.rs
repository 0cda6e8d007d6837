//! The images of a model at one frame.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::frame::Frame;
use crate::mixture::{Mixture, Quantity, QuantityMap};

/// The images of a model after a frame.
#[derive(Clone)]
pub(crate) struct ModelPictures {
    pub(crate) background: Arc<Frame>,
    pub(crate) multi_mode: Option<Arc<Frame>>,
    /// The requested map, if the model has it.
    pub(crate) map: Option<Arc<QuantityMap>>,
}

impl ModelPictures {
    /// The images of a mixture after `frame`, with a map of `quantity` if the mixture after the frame determines it.
    pub(crate) fn of_mixture(mixture: &Mixture, frame: &Frame, quantity: Option<Quantity>) -> Self {
        let picture = |rgb| Arc::new(Frame::new(frame.number, frame.size, rgb));
        let images = mixture.background_images();
        let values = match quantity {
            Some(Quantity::Sigma) => Some(mixture.sigmas()),
            Some(Quantity::Weight) => Some(mixture.weights()),
            Some(Quantity::Used) => Some(mixture.used_counts()),
            Some(Quantity::BackgroundCount) => {
                Some(images.background_count.iter().map(|&count| f32::from(count)).collect())
            }
            Some(Quantity::Matched | Quantity::SinceForeground) | None => None,
        };
        let pictures = Self {
            background: picture(images.mean),
            multi_mode: Some(picture(images.multi_mode)),
            map: None,
        };
        pictures.with_map(quantity, values)
    }

    /// The same images with a map of this quantity.
    pub(crate) fn with_map(self, quantity: Option<Quantity>, values: Option<Vec<f32>>) -> Self {
        let map = quantity.zip(values).map(|(quantity, values)| Arc::new(QuantityMap { quantity, values }));
        Self { map: map.or(self.map), ..self }
    }

    /// Whether they include a map of `quantity`.
    pub(crate) fn has(&self, quantity: Quantity) -> bool {
        self.map.as_ref().is_some_and(|map| map.quantity == quantity)
    }

    /// The image of a model that has only a background image.
    pub(crate) const fn of_background(background: Arc<Frame>) -> Self {
        Self { background, multi_mode: None, map: None }
    }
}

/// The most recent images by position: stepping back revisits frames that were just replayed.
#[derive(Clone)]
pub(crate) struct RecentPictures {
    pictures: VecDeque<(u32, ModelPictures)>,
    capacity: usize,
}

impl RecentPictures {
    pub(crate) const fn new(capacity: usize) -> Self {
        Self { pictures: VecDeque::new(), capacity }
    }

    /// Sets the capacity, in frames.
    pub(crate) fn set_capacity(&mut self, capacity: usize) {
        self.capacity = capacity;
        while self.pictures.len() > self.capacity {
            self.pictures.pop_front();
        }
    }

    pub(crate) fn get(&self, position: u32) -> Option<ModelPictures> {
        self.pictures.iter().find(|(at, _)| *at == position).map(|(_, pictures)| pictures.clone())
    }

    pub(crate) fn insert(&mut self, position: u32, pictures: ModelPictures) {
        self.pictures.retain(|(at, _)| *at != position);
        self.pictures.push_back((position, pictures));
        while self.pictures.len() > self.capacity {
            self.pictures.pop_front();
        }
    }
}
