//! Procedurally rendered scenes with exact ground truth: positions, visibility, and occluders.
//!
//! A [`Scene`] describes objects and their paths. A [`Renderer`] renders any frame of it and, from the same geometry,
//! a [`FrameTruth`]. [`Recorder`] derives the events and episodes of [`SceneTruth`] from the truth of all frames.
//! [`catalogue`] has the scenes by name, [`write()`] writes one to files.
//!
//! ```
//! use occluscope::synth::{self, SceneParameters, Recorder};
//! use occluscope::frame::Size;
//!
//! let small = SceneParameters { size: Size::new(96, 72), ..SceneParameters::default() };
//! let scene = synth::catalogue::scene("crossing", &small).expect("it is in the catalogue");
//! let mut recorder = Recorder::new(scene.fps);
//! for (frame, truth) in synth::render(&scene) {
//!     assert_eq!(frame.number, truth.number);
//!     recorder.push(&truth);
//! }
//! assert_eq!(recorder.finish().episodes.len(), 1);
//! ```
//!
//! The same scene and seed give the same bits, for any number of threads and any order of frames.

pub mod background;
pub mod car;
pub mod catalogue;
pub mod layer;
pub mod light;
pub mod motion;
pub mod noise;
pub mod occluder;
pub mod path;
pub mod render;
pub mod scene;
pub mod texture;
pub mod truth;
pub mod walker;
pub mod write;

pub use catalogue::SceneParameters;
pub use render::{FrameTruth, Renderer, Silhouette, render};
pub use scene::Scene;
pub use truth::{Recorder, SceneTruth, TruthEvent};
pub use write::{WriteError, write};
