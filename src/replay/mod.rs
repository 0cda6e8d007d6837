//! Random access in time: a worker that analyses ahead, keeps records and checkpoints, and reproduces the results of
//! any frame.
//!
//! The window holds a [`Session`] and sends [`Request`]s; the worker publishes a [`State`] after every change. Neither
//! blocks the other.
//!
//! `worker` decides which step of work is the most urgent. `tasks` holds the kinds of work, `store` what is kept of each
//! frame. A new request is a variant of [`Request`] and an arm of the worker's `match`; a new result a field of
//! [`State`].

mod memory;
mod published;
mod requests;
mod session;
mod shared;
mod store;
mod tasks;
mod worker;

#[cfg(test)]
mod measure;
#[cfg(test)]
pub(crate) mod tests;

use std::sync::Arc;

pub use memory::memory;
pub use published::{
    ComparedSequence, Phase, ShownFrame, Start, State, Timeline, TrackTimeline, WorkProgress,
};
pub use requests::Request;
pub use session::{AnalysisOptions, Session};

/// Whether both point to the same allocation, or both are `None`.
fn is_same<T>(one: Option<&Arc<T>>, other: Option<&Arc<T>>) -> bool {
    one.map(Arc::as_ptr) == other.map(Arc::as_ptr)
}
