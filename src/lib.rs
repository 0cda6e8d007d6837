//! Occluscope: a microscope for background models, moving regions, tracks and occlusions in video.
//!
//! The modules are the stages of the method, in processing order:
//!
//! ```text
//! source → mixture → regions → tracking → occlusion → (replay) → window, files
//! ```
//!
//! [`source`] provides [`frame::Frame`]s. [`mixture`] models every pixel by a mixture of Gaussians and classifies it
//! as foreground or background. [`regions`] cleans the foreground mask and finds its connected components and their
//! colours. [`tracking`] follows the components with Kalman models, several hypotheses per object. [`occlusion`]
//! resolves merges, disappearances, demerges and reappearances. [`pipeline`] runs all stages on a frame; [`replay`]
//! provides random access in time. [`truth`] scores results, [`explain`] explains decisions, [`export`] writes files,
//! [`cli`] is the command line, `app` (feature `gui`) the window.

#[cfg(feature = "gui")]
pub mod app;
pub mod cli;
pub mod explain;
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
