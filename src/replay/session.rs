//! The window's side of a session: requests, and the last published state.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use super::worker::Worker;
use super::{Phase, Start, State, Timeline, memory};
use crate::explain::tuning::TunableSetting;
use crate::mixture::Quantity;
use crate::occlusion::Event;
use crate::regions::Roi;
use crate::settings::Settings;
use crate::source::cache::FrameCache;
use crate::source::{Options, SourceError};
use crate::truth::Truth;

/// A video under analysis. Dropping it ends its worker.
///
/// Requests do not block; a newer one replaces an older one of its kind.
pub struct Session {
    shared: Arc<Shared>,
    /// Disconnected when the worker has ended.
    ended: Receiver<()>,
}

/// Requests of the window that are not processed yet.
#[derive(Default)]
pub(super) struct Requests {
    pub(super) show: Option<u32>,
    pub(super) settings: Option<Settings>,
    pub(super) compared: Option<CompareRequest>,
    pub(super) truth: Option<TruthRequest>,
    pub(super) explain: Option<ExplainRequest>,
    pub(super) roi: Option<RoiRequest>,
    pub(super) inspect: Option<PixelRequest>,
    pub(super) tune: Option<TuneRequest>,
    pub(super) analyse_ahead: Option<bool>,
    pub(super) map: Option<MapRequest>,
    pub(super) pins: Option<Vec<(u32, u32)>>,
    pub(super) region: Option<RegionRequest>,
    pub(super) tune_region: Option<RegionRequest>,
    stop: bool,
}

/// Request: the pixel to follow, `None` for none.
pub(super) struct PixelRequest(pub(super) Option<(u32, u32)>);

/// Request: the two settings of a map, `None` for no map.
pub(super) struct TuneRequest(pub(super) Option<[TunableSetting; 2]>);

/// Request: the settings to compare with those in view, `None` for none.
pub(super) struct CompareRequest(pub(super) Option<Settings>);

/// Request: the ground truth, `None` for none.
pub(super) struct TruthRequest(pub(super) Option<Arc<Truth>>);

/// Request: the event to explain, `None` for none.
pub(super) struct ExplainRequest(pub(super) Option<Event>);

/// Request: the centre and side of a region to count or to score, `None` for none.
pub(super) struct RegionRequest(pub(super) Option<((u32, u32), u32)>);

/// Request: the quantity to map, `None` for none.
pub(super) struct MapRequest(pub(super) Option<Quantity>);

/// Request: the region of interest, `None` for the whole image.
pub(super) struct RoiRequest(pub(super) Option<Arc<Roi>>);

/// The state shared by both threads.
pub(super) struct Shared {
    requests: Mutex<Requests>,
    asked: Condvar,
    state: Mutex<State>,
    wake: Box<dyn Fn() + Send + Sync>,
}

impl Session {
    /// Starts a worker on `video` (a name as in [`crate::source::open`]) and returns at once.
    ///
    /// `roi` is the region of interest, `None` the whole image; the session fails if its size is not that of the
    /// frames. The worker calls `wake`, from its own thread, after every change of [`Self::state`]. It caches up to
    /// `memory` bytes of frames and models, or a quarter of the machine's memory.
    pub fn open(
        video: &str,
        options: Options,
        (settings, roi): (Settings, Option<Arc<Roi>>),
        start: Start,
        memory: Option<usize>,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let (name, options) = (video.to_owned(), options);
        // An evicted frame needs decoding from the start, a dropped checkpoint replaying from the previous one: each
        // has half.
        let budget = memory.unwrap_or_else(memory::quarter) / 2;
        let open = move || FrameCache::open(&name, options, budget);
        Self::start(video, open, budget, (settings, roi), start, wake)
    }

    /// As [`Self::open`], on the frames of `open`; `model_budget` is the memory for checkpoints.
    pub(super) fn start(
        video: &str,
        open: impl FnOnce() -> Result<FrameCache, SourceError> + Send + 'static,
        model_budget: usize,
        under: (Settings, Option<Arc<Roi>>),
        start: Start,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let shared = Arc::new(Shared::new(wake));
        let (alive, ended) = channel();
        let (theirs, video) = (Arc::clone(&shared), video.to_owned());
        let started = thread::Builder::new().name("analysis".into()).spawn(move || {
            let work = AssertUnwindSafe(|| Worker::open_and_run(&theirs, open, under, start, model_budget));
            if let Err(payload) = catch_unwind(work) {
                theirs.fail(format!(
                    "{video} cannot be analysed further: internal error ({}); open it again",
                    words(&*payload)
                ));
            }
            drop(alive);
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

    /// Requests a frame by its position from 0; a position beyond the end requests the last frame. The analysis
    /// continues up to the requested frame.
    pub fn show(&self, position: u32) {
        self.shared.ask(|requests| requests.show = Some(position));
    }

    /// Requests other settings: the affected stages run again. The frame in view stays until it is available under
    /// the new settings.
    pub fn set_settings(&self, settings: Settings) {
        self.shared.ask(|requests| requests.settings = Some(settings));
    }

    /// Requests settings in view (A) and settings to compare them with (B); `None` for none. Settings that were
    /// already one of the two are not run again.
    pub fn compare(&self, settings: Settings, beside: Option<Settings>) {
        self.shared.ask(|requests| {
            requests.settings = Some(settings);
            requests.compared = Some(CompareRequest(beside));
        });
    }

    /// Sets the ground truth for scores; `None` for no scores. Masks of another size than the frames are ignored with
    /// a warning.
    pub fn set_truth(&self, truth: Option<Arc<Truth>>) {
        self.shared.ask(|requests| requests.truth = Some(TruthRequest(truth)));
    }

    /// Requests the counterfactuals of an event under the settings in view; `None` to stop.
    pub fn explain(&self, event: Option<Event>) {
        self.shared.ask(|requests| requests.explain = Some(ExplainRequest(event)));
    }

    /// Sets the region of interest, `None` for the whole image; it must have the frames' size. The model does not run
    /// again, because its masks are recorded.
    pub fn set_roi(&self, roi: Option<Arc<Roi>>) {
        self.shared.ask(|requests| requests.roi = Some(RoiRequest(roi)));
    }

    /// Chooses the pixel whose history is shown; `None`, or a pixel outside the image, chooses none.
    pub fn inspect(&self, at: Option<(u32, u32)>) {
        self.shared.ask(|requests| requests.inspect = Some(PixelRequest(at)));
    }

    /// Requests the verdict on the chosen pixel in the frame in view over a grid of these two settings, and for each
    /// alone; `None` to stop.
    pub fn tune(&self, knobs: Option<[TunableSetting; 2]>) {
        self.shared.ask(|requests| requests.tune = Some(TuneRequest(knobs)));
    }

    /// Continues the analysis beyond the frame in view, which is the default, or stops it and drops the pending
    /// frame. Later requests are processed in either case.
    pub fn analyse_ahead(&self, ahead: bool) {
        self.shared.ask(|requests| {
            requests.analyse_ahead = Some(ahead);
            if !ahead {
                requests.show = None;
            }
        });
    }

    /// Pins these pixels, in place of the previous ones. Their histories are computed after that of the chosen pixel.
    pub fn pin(&self, pixels: Vec<(u32, u32)>) {
        self.shared.ask(|requests| requests.pins = Some(pixels));
    }

    /// Requests the share of foreground among the `side`×`side` pixels around one in each frame; `None` to stop.
    pub fn region(&self, region: Option<((u32, u32), u32)>) {
        self.shared.ask(|requests| requests.region = Some(RegionRequest(region)));
    }

    /// Requests the accuracy of the mixture in the `side`×`side` pixels around one, over the grid of [`Self::tune`];
    /// `None` to stop. It needs true masks, and is computed after all other work.
    pub fn tune_region(&self, region: Option<((u32, u32), u32)>) {
        self.shared.ask(|requests| requests.tune_region = Some(RegionRequest(region)));
    }

    /// Requests a map of a quantity with every shown frame; `None` to stop.
    pub fn map(&self, quantity: Option<Quantity>) {
        self.shared.ask(|requests| requests.map = Some(MapRequest(quantity)));
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.shared.ask(|requests| requests.stop = true);
        // The process must not end while a worker is inside a decoder; a worker that hangs on a failed disk or camera
        // must not block the window.
        let waited = self.ended.recv_timeout(Duration::from_secs(2));
        debug_assert!(matches!(waited, Err(RecvTimeoutError::Disconnected | RecvTimeoutError::Timeout)));
    }
}

impl Shared {
    /// Without requests and state. `wake` is called after every change of the state.
    pub(super) fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        let state = State {
            phase: Phase::Opening,
            info: None,
            warnings: Arc::default(),
            shown: None,
            pixel: None,
            pins: Arc::default(),
            lost: Vec::new(),
            region: None,
            region_tuning: None,
            tuning: None,
            timeline: Arc::new(Timeline::default()),
            compared: None,
            counterfactual: None,
            busy: None,
            analysis_fps: 0.0,
        };
        Self {
            requests: Mutex::default(),
            asked: Condvar::new(),
            state: Mutex::new(state),
            wake: Box::new(wake),
        }
    }

    /// The last published state.
    pub(super) fn state(&self) -> State {
        lock(&self.state).clone()
    }

    fn ask(&self, change: impl FnOnce(&mut Requests)) {
        change(&mut lock(&self.requests));
        self.asked.notify_one();
    }

    /// Takes the requests since the previous call; `None` when the session has ended. With `wait`, blocks until there
    /// is a request.
    pub(super) fn take_requests(&self, wait: bool) -> Option<Requests> {
        let mut requests = lock(&self.requests);
        if wait {
            requests = self
                .asked
                .wait_while(requests, |requests| !requests.is_anything())
                .unwrap_or_else(PoisonError::into_inner);
        }
        if requests.stop { None } else { Some(std::mem::take(&mut *requests)) }
    }

    /// Publishes a change of the state.
    pub(super) fn publish(&self, change: impl FnOnce(&mut State)) {
        change(&mut lock(&self.state));
        (self.wake)();
    }

    pub(super) fn fail(&self, why: String) {
        self.publish(|state| {
            state.phase = Phase::Failed(why);
            state.busy = None;
        });
    }
}

impl Requests {
    const fn is_anything(&self) -> bool {
        self.show.is_some()
            || self.settings.is_some()
            || self.compared.is_some()
            || self.truth.is_some()
            || self.explain.is_some()
            || self.roi.is_some()
            || self.inspect.is_some()
            || self.tune.is_some()
            || self.analyse_ahead.is_some()
            || self.map.is_some()
            || self.pins.is_some()
            || self.region.is_some()
            || self.tune_region.is_some()
            || self.stop
    }
}

/// Ignores poisoning: every change under the lock is one assignment, so that a panic leaves no partial value.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn words(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied();
    let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    text.unwrap_or("of an unknown kind").split_whitespace().collect::<Vec<_>>().join(" ")
}
