//! The pixel process: each pixel an adaptive mixture of Gaussians, and which of them are background (§V–VI).
//!
//! [`pixel`] is the definition, one pixel in plain words. [`image`] does the same to a whole image, bit for bit,
//! fast: sixteen pixels of a `tile` side by side, many frames at a time. [`history`] follows one pixel through many
//! frames, [`component_slots`] its components through their changes of rank, [`verdict`] explains its classification
//! in words, and [`tuning`] finds the settings that change it. [`component_states`], [`downsampled_history`],
//! [`sparklines`] and [`scatter_points`] are the data of plots.

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
