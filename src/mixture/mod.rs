//! The pixel process: each pixel an adaptive mixture of Gaussians, and which of them are background (§V–VI).
//!
//! [`pixel`] is the definition, one pixel in plain words. [`image`] does the same to a whole
//! image, bit for bit, fast: sixteen pixels of a `tile` side by side, many frames at a time. [`history`] follows one pixel through many frames, [`follow`] its
//! components through their changes of rank, [`verdict`] says in words why it was decided so, and
//! [`tuning`] what it would take to decide otherwise. [`standing`], [`bins`], [`sparks`] and [`places`] are what plots are
//! drawn from: the mixture of one frame, many frames in few columns, the same for several pixels, and where the values lie.

mod appearance;
pub mod bins;
pub mod exponential;
pub mod feedback;
pub mod follow;
pub mod history;
pub mod hysteresis;
pub mod image;
pub mod maps;
mod neighbours;
pub mod opencv;
pub mod pixel;
pub mod places;
pub mod shadow;
pub mod sparks;
pub mod standing;
pub mod statistics;
mod tile;
pub mod tuning;
pub mod verdict;

pub use appearance::Appearance;
pub use feedback::{Feedback, Past};
pub use history::{PixelHistory, PixelState};
pub use image::{BATCH, Mixture, Snapshot};
pub use maps::{Map, Quantity};
pub use pixel::{Component, MAX_K, Outcome, Parameters, Pixel};
