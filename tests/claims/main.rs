//! The paper's claims about its background model, each on a scene that shows it, compared with the model without the
//! claimed property. The claims about occlusion are in `tests/occlusion`.

#![allow(clippy::expect_used, missing_docs)]

mod endurance;
mod light;
mod measure;
mod parked;
mod repetition;
mod threshold;
