//! What the paper claims of its background model, each claim on a scene that shows it, with what the
//! claim is about taken away for comparison. Its claims about occlusion are in `tests/occlusion`.

#![allow(clippy::expect_used, missing_docs)]

mod endurance;
mod light;
mod measure;
mod parked;
mod repetition;
mod threshold;
