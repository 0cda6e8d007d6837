//! What the fuzz targets do with an input. `tests/fuzzed.rs` runs the same on seeds and their mutations.
//!
//! A target fails by a panic: of the program, or of an assertion about its result.

// Each target is a program of its own, which uses one of them.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

pub mod arguments;
mod bytes;
mod folder;
pub mod images;
pub mod names;
pub mod pipeline;
pub mod results;
pub mod settings;
pub mod tables;
pub mod tracks;
pub mod videos;

/// Runs the code under test on an input.
pub type Target = fn(&[u8]);

/// All targets by name.
pub const ALL: [(&str, Target); 9] = [
    ("arguments", arguments::run),
    ("images", images::run),
    ("names", names::run),
    ("pipeline", pipeline::run),
    ("results", results::run),
    ("settings", settings::run),
    ("tables", tables::run),
    ("tracks", tracks::run),
    ("videos", videos::run),
];

/// A message to a user is one line.
fn check_message(message: &str) {
    assert!(!message.is_empty() && !message.contains('\n'), "{message:?}");
}
