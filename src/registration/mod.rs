//! Registration of frames before the mixture: a camera that shakes, and light that changes in the whole image.
//!
//! An [`Estimator`] compares each frame with a slow average of those before it and finds the [`Alignment`]: how far the
//! camera has moved ([`Motion`]) and how much brighter or darker it is ([`Light`]). It does so once for each frame, in
//! order, whatever the settings are, and the result stays with the frame. A [`Correction`] is what the settings make of
//! it; it changes each pixel by itself, so that single pixels, batches and frames that are decoded again agree bit for bit.

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
