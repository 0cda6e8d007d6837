//! Occluscope: a microscope for background models, moving regions, tracks and occlusions in video.
//!
//! The method is that of K. A. Chavan and P. P. Halkarnikar, *Occlusion detection in video sequences*; sections (§) and
//! Algorithms 1–3 in the documentation are those of that paper.
//!
//! The modules are the stages of the method, in the order in which a frame passes them:
//!
//! ```text
//! source → registration → mixture → regions → tracking → occlusion → (replay) → window, files
//! ```
//!
//! - [`source`] decodes [`frame::Frame`]s; [`registration`] measures camera motion and changes of the light.
//! - [`mixture`] models every pixel by a mixture of Gaussians and classifies it as foreground or background.
//! - [`regions`] cleans the foreground mask and finds its connected components and their colours.
//! - [`tracking`] follows the components with Kalman models, several hypotheses per object.
//! - [`occlusion`] resolves merges, disappearances, demerges and reappearances.
//! - [`pipeline`] runs all stages on a frame; [`replay`] gives random access in time.
//! - [`truth`] scores results, [`explain`] explains decisions, [`export`] writes files, [`synth`] renders scenes with
//!   exact ground truth.
//! - [`settings`] is the table of all parameters. [`cli`] is the command line, `app` (feature `gui`) the window.
//!
//! # Use as a library
//!
//! Without the default feature `gui` the library needs no graphics. A [`mixture::Mixture`] takes arrays of 8-bit RGB,
//! row by row:
//!
//! ```
//! use occluscope::frame::{Frame, Size};
//! use occluscope::mixture::{Mixture, Parameters};
//! use occluscope::settings::Settings;
//!
//! let size = Size::new(64, 48);
//! let grey = vec![90; 3 * size.pixels()];
//! let mut mixture = Mixture::new(size, Parameters::new(&Settings::default()));
//! for number in 1..=50 {
//!     mixture.step(&Frame::new(number, size, grey.clone()));
//! }
//!
//! // A bright bar over rows 16 to 23.
//! let mut rgb = grey;
//! rgb[3 * 16 * 64..3 * 24 * 64].fill(220);
//! let mask = mixture.step(&Frame::new(51, size, rgb));
//! assert!(mask.is_foreground(30, 20) && !mask.is_foreground(30, 10));
//! assert_eq!(mask.foreground_pixels(), 8 * 64);
//! ```
//!
//! A [`pipeline::Pipeline`] runs all stages. The name of a source is a folder of images, a video file, a pattern such
//! as `in%06d.png`, or `camera:0`:
//!
//! ```
//! use occluscope::frame::Frame;
//! use occluscope::pipeline::{OfflineResult, Pipeline, offline_result};
//! use occluscope::settings::Settings;
//! use occluscope::source::{self, Options};
//!
//! fn analyse(name: &str) -> Result<OfflineResult, Box<dyn std::error::Error>> {
//!     let settings = Settings::default();
//!     let mut source = source::open(name, Options::default())?;
//!     let info = source.info().clone();
//!     let mut frames = Vec::new();
//!     while let Some(frame) = source.next_frame()? {
//!         frames.push(frame);
//!     }
//!
//!     let mut pipeline = Pipeline::new(&settings, info.size, info.fps)?;
//!     // The model learns from the first frames before any of them is classified.
//!     let first: Vec<&Frame> = frames.iter().take(info.bootstrap(&settings) as usize).collect();
//!     pipeline.learn(&first)?;
//!     let analyses = frames.iter().map(|frame| pipeline.step(frame)).collect::<Result<Vec<_>, _>>()?;
//!     Ok(offline_result(&analyses, &pipeline))
//! }
//!
//! let result = analyse("sample_videos/crossing.mp4")?;
//! for frame in &result.tracks {
//!     for track in &frame.tracks {
//!         println!("frame {}: object {} at {:?}", frame.number, track.id, track.bbox);
//!     }
//! }
//! assert!(result.events.iter().any(|event| event.kind == occluscope::occlusion::EventKind::Merge));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! More examples: one pixel ([`mixture::Pixel::update`]), regions of a mask ([`regions::find_regions`]), events from
//! masks ([`occlusion::Tracker`]), all stages on frames in memory ([`pipeline::Pipeline`]), scores of tracks
//! ([`truth::clear_mot::score`]), settings files ([`settings::Settings::apply_toml`]), rendered scenes ([`synth`]).

#[cfg(feature = "gui")]
pub mod app;
pub mod cli;
pub mod explain;
pub mod export;
pub mod frame;
mod instruction_set;
mod libav;
pub mod mixture;
pub mod occlusion;
pub mod palette;
mod panic_message;
pub mod pipeline;
pub mod placement;
pub mod regions;
pub mod registration;
pub mod replay;
pub mod settings;
pub mod source;
pub mod sweep;
pub mod synth;
pub mod tracking;
pub mod truth;
