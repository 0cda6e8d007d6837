//! The window's interface of the worker.

use crate::replay::{Request, Session, State};

/// The interface of the worker.
pub(crate) trait Player {
    /// The latest published state.
    fn state(&self) -> State;
    /// Sends a request.
    fn request(&self, request: Request);
    /// Ends the worker without waiting for it.
    fn leave(self: Box<Self>);
}

impl Player for Session {
    fn state(&self) -> State {
        Session::state(self)
    }

    fn request(&self, request: Request) {
        Session::request(self, request);
    }

    fn leave(self: Box<Self>) {
        // The worker may be inside a decoder, and frees gigabytes. If no thread can be started, this thread waits for
        // it.
        let left = std::thread::Builder::new().name("leaving".into()).spawn(move || drop(self));
        drop(left);
    }
}
