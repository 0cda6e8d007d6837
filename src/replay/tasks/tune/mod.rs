//! The chosen pixel, and the region around it, under other settings of the mixture.

pub(crate) mod pixel_tuner;
pub(crate) mod region_tuner;
