//! Scenes drawn by rule, with their exact truth: who is where, how much of them is seen, who hides whom.
//!
//! A [`Scene`] says what stands and walks where. A [`Renderer`] draws any frame of it and, from the
//! same geometry, a [`FrameTruth`]. [`Recorder`] turns the truth of all frames into the events and
//! episodes of [`Truth`]. [`catalogue`] has the scenes by name, [`write()`] puts one into files.
//!
//! ```
//! use occluscope::synth::{self, Parameters, Recorder};
//! use occluscope::frame::Size;
//!
//! let small = Parameters { size: Size::new(96, 72), ..Parameters::default() };
//! let scene = synth::catalogue::scene("crossing", &small).expect("it is in the catalogue");
//! let mut recorder = Recorder::new(scene.fps);
//! for (frame, truth) in synth::render(&scene) {
//!     assert_eq!(frame.number, truth.number);
//!     recorder.push(&truth);
//! }
//! assert_eq!(recorder.finish().episodes.len(), 1);
//! ```
//!
//! The same scene and seed give the same bits, whatever the thread count and the order of frames.

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

pub use catalogue::Parameters;
pub use render::{FrameTruth, Renderer, Silhouette, render};
pub use scene::Scene;
pub use truth::{Recorder, Truth, TruthEvent};
pub use write::{WriteError, write};
