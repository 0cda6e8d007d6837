//! Registration of frames before the mixture: camera shake and changes of light in the whole image. An addition to the
//! paper, off in the preset `plain`.
//!
//! An [`Estimator`] compares each frame with a slow average of earlier frames and estimates the [`Alignment`]: the
//! camera motion ([`Motion`]) and the change of light ([`Light`]). It does so once per frame, in order, and the
//! result is stored with the frame. A [`Correction`] applies the alignment as the settings choose. It changes each
//! pixel independently, so that single pixels, batches and frames that are decoded again agree bit for bit.

mod alignment;
mod correction;
mod estimator;
mod geometry;
mod light;
mod plane;
mod registered;
mod robust;

#[cfg(test)]
mod tests;

pub use alignment::{Alignment, Light, Motion};
pub use correction::{Applied, Corrected, Correction, CorrectionChoice, ObservedColour, corrected};
pub use estimator::Estimator;
pub use registered::{Registered, measure_all};
