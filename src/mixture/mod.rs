//! The pixel process: each pixel is an adaptive mixture of Gaussians, some of which are background (§V–VI).
//!
//! [`pixel`] is the reference implementation for one pixel. [`image`] is equal to it bit for bit and optimised for a
//! whole image: it processes sixteen pixels of a `tile` at once, and many frames per tile. [`history`] follows one
//! pixel through a sequence, [`component_slots`] its components through their changes of rank, [`verdict`] explains
//! its classification in words, and [`tuning`] finds the settings that change it. [`component_states`],
//! [`downsampled_history`], [`sparklines`] and [`scatter_points`] are the data of plots.

mod appearance;
pub mod component_slots;
pub mod component_states;
pub mod downsampled_history;
pub mod exponential;
pub mod feedback;
pub mod history;
pub mod hysteresis;
pub mod image;
pub mod maps;
mod neighbours;
pub mod opencv;
pub mod pixel;
pub mod scatter_points;
pub mod shadow;
pub mod sparklines;
pub mod statistics;
mod tile;
pub mod tuning;
pub mod verdict;

pub use appearance::Appearance;
pub use feedback::{Feedback, VerdictMemory};
pub use history::{PixelHistory, PixelState};
pub use image::{BATCH, Mixture, Snapshot};
pub use maps::{Quantity, QuantityMap};
pub use pixel::{Component, MAX_K, Outcome, Parameters, Pixel};
