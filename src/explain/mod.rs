//! Explanations of decisions: the data behind the inspector and the evidence, computed from finished results.
//!
//! [`pixel`] reports on one pixel: its history, components, statistics and verdict. [`tuning`] re-runs a pixel under
//! other settings. [`events`] compares the events of two analyses and finds the settings that prevent an event.
//! Nothing here changes a result.

pub mod events;
pub mod pixel;
pub mod tuning;
