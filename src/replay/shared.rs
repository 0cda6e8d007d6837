//! The state shared by the session and its worker.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use super::published::{Phase, State};
use super::requests::{Request, RequestQueue};

/// The requests of the session and the state published by its worker.
pub(super) struct Shared {
    requests: Mutex<RequestQueue>,
    requested: Condvar,
    state: Mutex<State>,
    wake: Box<dyn Fn() + Send + Sync>,
}

impl Shared {
    /// Without requests and results. `wake` is called after every change of the state.
    pub(super) fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self {
            requests: Mutex::default(),
            requested: Condvar::new(),
            state: Mutex::new(State::default()),
            wake: Box::new(wake),
        }
    }

    /// The last published state.
    pub(super) fn state(&self) -> State {
        lock(&self.state).clone()
    }

    /// Adds a request for the worker.
    pub(super) fn request(&self, request: Request) {
        lock(&self.requests).push(request);
        self.requested.notify_one();
    }

    /// Ends the worker after its present step.
    pub(super) fn close(&self) {
        lock(&self.requests).close();
        self.requested.notify_one();
    }

    /// Takes the requests since the previous call; `None` when the session has ended. With `wait`, blocks until there
    /// is a request.
    pub(super) fn take_requests(&self, wait: bool) -> Option<Vec<Request>> {
        let mut requests = lock(&self.requests);
        if wait {
            requests = self
                .requested
                .wait_while(requests, |requests| !requests.is_ready())
                .unwrap_or_else(PoisonError::into_inner);
        }
        requests.take()
    }

    /// Publishes a change of the state.
    pub(super) fn publish(&self, change: impl FnOnce(&mut State)) {
        change(&mut lock(&self.state));
        (self.wake)();
    }

    /// Publishes that the work has failed, with the cause and a remedy as a sentence.
    pub(super) fn fail(&self, why: String) {
        self.publish(|state| {
            state.phase = Phase::Failed(why);
            state.busy = None;
        });
    }
}

/// Ignores poisoning: every change under the lock is one assignment, so that a panic leaves no partial value.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
