//! The pixel process: each pixel an adaptive mixture of Gaussians, and which of them are background (§V–VI).
//!
//! [`pixel`] is the definition, one pixel in plain words. [`image`] does the same to a whole
//! image, bit for bit, fast. [`history`] follows one pixel through many frames.

pub mod exponential;
pub mod history;
pub mod image;
pub mod opencv;
pub mod pixel;

pub use history::{PixelHistory, PixelState};
pub use image::Mixture;
pub use pixel::{Component, MAX_K, Outcome, Parameters, Pixel};
