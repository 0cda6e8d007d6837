//! Occluscope: a microscope for background models, moving regions, tracks and occlusions in video.
//!
//! The modules are the sections of the method, in the order in which a frame meets them:
//!
//! ```text
//! source → mixture → regions → tracking → occlusion → (replay) → window, files
//! ```
//!
//! [`source`] gives [`frame::Frame`]s. [`mixture`] keeps a mixture of Gaussians for every pixel
//! and says which pixels are foreground. [`regions`] cleans that mask, finds its connected
//! components and their colours. [`tracking`] follows the components with Kalman models, several
//! hypotheses an object. [`occlusion`] reasons about those that come together, vanish, part and
//! return. [`pipeline`] takes one frame through all of it; [`replay`] goes back and forth in time.
//! [`truth`] scores results, [`export`] writes them, [`cli`] is the command line, `app` (feature `gui`) the window.

#[cfg(feature = "gui")]
pub mod app;
pub mod cli;
pub mod export;
pub mod frame;
pub mod mixture;
pub mod occlusion;
pub mod palette;
pub mod pipeline;
pub mod regions;
pub mod registration;
pub mod replay;
pub mod settings;
pub mod source;
pub mod synth;
pub mod tracking;
pub mod truth;
