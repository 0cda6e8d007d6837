//! The window's side of a session.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use super::memory;
use super::published::{Start, State};
use super::requests::Request;
use super::shared::Shared;
use super::worker::Worker;
use crate::panic_message::message;
use crate::regions::Roi;
use crate::settings::Settings;
use crate::source::cache::FrameCache;
use crate::source::{Options, SourceError};

/// What decides the results of an analysis, apart from the video.
#[derive(Clone, Debug, Default)]
pub struct AnalysisOptions {
    /// The settings.
    pub settings: Settings,
    /// The region of interest, which has the size of the frames; `None` for the whole image.
    pub roi: Option<Arc<Roi>>,
}

/// A video under analysis. Dropping it ends its worker.
pub struct Session {
    shared: Arc<Shared>,
    /// Disconnected when the worker has ended.
    ended: Receiver<()>,
}

impl Session {
    /// Starts a worker on `video` (a name as in [`crate::source::open`]) and returns at once.
    ///
    /// The session fails if the size of the region of interest is not that of the frames. The worker calls `wake`, from its own thread, after every change of [`Self::state`]. It caches up to
    /// `memory` bytes of frames and models, or a quarter of the machine's memory.
    pub fn open(
        video: &str,
        options: Options,
        analysis: AnalysisOptions,
        start: Start,
        memory: Option<usize>,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let (name, options) = (video.to_owned(), options);
        // An evicted frame needs decoding from the start, a dropped checkpoint replaying from the previous one: each
        // has half.
        let budget = memory.unwrap_or_else(memory::quarter) / 2;
        let open = move || FrameCache::open(&name, options, budget);
        Self::start(video, open, budget, analysis, start, wake)
    }

    /// As [`Self::open`], on the frames of `open`; `model_budget` is the memory for checkpoints.
    pub(super) fn start(
        video: &str,
        open: impl FnOnce() -> Result<FrameCache, SourceError> + Send + 'static,
        model_budget: usize,
        analysis: AnalysisOptions,
        start: Start,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let shared = Arc::new(Shared::new(wake));
        let (running, ended) = channel();
        let (of_worker, video) = (Arc::clone(&shared), video.to_owned());
        let started = thread::Builder::new().name("analysis".into()).spawn(move || {
            let work =
                AssertUnwindSafe(|| Worker::open_and_run(&of_worker, open, analysis, start, model_budget));
            if let Err(payload) = catch_unwind(work) {
                of_worker.fail(format!(
                    "{video} cannot be analysed further: internal error ({}); open it again",
                    message(&*payload)
                ));
            }
            drop(running);
        });
        if let Err(error) = started {
            shared.fail(format!("the analysis cannot start: {error}; close other programs and try again"));
        }
        Self { shared, ended }
    }

    /// The last published state.
    pub fn state(&self) -> State {
        self.shared.state()
    }

    /// Sends a request to the worker and returns at once; it replaces an older one of its kind.
    pub fn request(&self, request: Request) {
        self.shared.request(request);
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.shared.close();
        // The process must not end while a worker is inside a decoder; a worker that hangs on a failed disk or camera
        // must not block the window.
        let waited = self.ended.recv_timeout(Duration::from_secs(2));
        debug_assert!(matches!(waited, Err(RecvTimeoutError::Disconnected | RecvTimeoutError::Timeout)));
    }
}
