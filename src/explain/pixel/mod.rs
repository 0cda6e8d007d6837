//! A report on one pixel: [`history`] follows it through a sequence, [`component_slots`] its components through their
//! changes of rank, [`statistics`] summarises it, and [`verdict`] explains its classification in words.
//! [`region_shares`] holds the foreground ratio of its neighbourhood. [`component_states`], [`downsampled_history`],
//! [`sparklines`] and [`scatter_points`] are the data of plots.

pub mod component_slots;
pub mod component_states;
pub mod downsampled_history;
pub mod history;
pub mod region_shares;
pub mod scatter_points;
pub mod sparklines;
pub mod statistics;
pub mod verdict;

pub use history::{PixelHistory, PixelState};
