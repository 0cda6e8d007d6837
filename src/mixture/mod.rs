//! The pixel process: each pixel is an adaptive mixture of Gaussians, some of which are background (§V–VI).
//!
//! The input is frames of 8-bit RGB in order, the output a foreground mask of each. Values, means and σ are in levels,
//! 0 to 255.
//!
//! [`pixel`] is the reference implementation for one pixel. [`image`] is equal to it bit for bit and optimised for a
//! whole image: it processes sixteen pixels of a `tile` at once, and many frames per tile. [`maps`] gives one quantity
//! of every pixel's mixture.
//!
//! [`feedback`], [`shadow`] and [`hysteresis`] are additions to the paper, off in the preset `plain`. [`opencv`] has
//! OpenCV's MOG2 and KNN, which can take the place of the mixture.

mod background_images;
pub mod exponential;
pub mod feedback;
pub mod hysteresis;
pub mod image;
pub mod maps;
mod neighbours;
pub mod opencv;
pub mod pixel;
pub mod shadow;
mod tile;

pub use background_images::BackgroundImages;
pub use feedback::{Feedback, VerdictMemory};
pub use image::{BATCH, Mixture, Snapshot};
pub use maps::{Quantity, QuantityMap};
pub use pixel::{Component, MAX_K, Outcome, Parameters, Pixel};
