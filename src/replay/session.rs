//! The window's side of a session: requests, and the state published last.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use super::worker::Worker;
use super::{Phase, Start, State, Timeline, memory};
use crate::mixture::Quantity;
use crate::mixture::tuning::TunableSetting;
use crate::occlusion::Event;
use crate::regions::Roi;
use crate::settings::Settings;
use crate::source::cache::FrameCache;
use crate::source::{Options, SourceError};
use crate::truth::Truth;

/// A video under analysis. Dropping it ends its worker.
///
/// Requests never wait; a newer one takes the place of an older one of its kind.
pub struct Session {
    shared: Arc<Shared>,
    /// Disconnected when the worker has ended.
    ended: Receiver<()>,
}

/// Requests of the window that are not applied yet.
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

/// Request: the two settings along the sides of a map, `None` for no map.
pub(super) struct TuneRequest(pub(super) Option<[TunableSetting; 2]>);

/// Request: the settings to compare with those in view, `None` for none.
pub(super) struct CompareRequest(pub(super) Option<Settings>);

/// Request: the ground truth, `None` for none.
pub(super) struct TruthRequest(pub(super) Option<Arc<Truth>>);

/// Request: the event to explain, `None` for none.
pub(super) struct ExplainRequest(pub(super) Option<Event>);

/// Request: the middle and side of a region to count or to score, `None` for none.
pub(super) struct RegionRequest(pub(super) Option<((u32, u32), u32)>);

/// Request: the quantity to map, `None` for none.
pub(super) struct MapRequest(pub(super) Option<Quantity>);

/// Request: the area of interest, `None` for the whole image.
pub(super) struct RoiRequest(pub(super) Option<Arc<Roi>>);

/// The state shared by both threads.
pub(super) struct Shared {
    requests: Mutex<Requests>,
    asked: Condvar,
    state: Mutex<State>,
    wake: Box<dyn Fn() + Send + Sync>,
}

impl Session {
    /// Starts a worker on `video` (a name as [`crate::source::open`] takes it) and returns at once.
    ///
    /// `roi` is what is analysed, the whole image without one; where it is not as large as the frames, the session
    /// fails. It calls `wake` after every change of [`Self::state`], from its own thread. It keeps up to `memory` bytes of frames and models, or a quarter of the machine's memory.
    pub fn open(
        video: &str,
        options: Options,
        (settings, roi): (Settings, Option<Arc<Roi>>),
        start: Start,
        memory: Option<usize>,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let (name, options) = (video.to_owned(), options);
        // A frame that was dropped costs decoding from the start, a checkpoint replaying from the
        // one before: half for each.
        let budget = memory.unwrap_or_else(memory::quarter) / 2;
        let open = move || FrameCache::open(&name, options, budget);
        Self::start(video, open, budget, (settings, roi), start, wake)
    }

    /// As [`Self::open`], on frames that `open` gives; `model_budget` is the memory for checkpoints.
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

    /// The state published last.
    pub fn state(&self) -> State {
        self.shared.state()
    }

    /// Asks for a frame by its position from 0; one beyond the end gives the last. What lies beyond
    /// the frames that are analysed is analysed first.
    pub fn show(&self, position: u32) {
        self.shared.ask(|requests| requests.show = Some(position));
    }

    /// Asks for other settings: what they touch is run again. What is shown stays until the frame
    /// in view is there under the new ones.
    pub fn set_settings(&self, settings: Settings) {
        self.shared.ask(|requests| requests.settings = Some(settings));
    }

    /// Asks for settings in view and, beside them, for others to compare them with; `None` for none. Settings that were
    /// one of the two before are not run again.
    pub fn compare(&self, settings: Settings, beside: Option<Settings>) {
        self.shared.ask(|requests| {
            requests.settings = Some(settings);
            requests.compared = Some(CompareRequest(beside));
        });
    }

    /// Says what is known to be right, so that what was analysed is scored; `None` for no scores. Masks of another size
    /// than the frames' are left out, with a warning.
    pub fn set_truth(&self, truth: Option<Arc<Truth>>) {
        self.shared.ask(|requests| requests.truth = Some(TruthRequest(truth)));
    }

    /// Asks what would have kept an event from happening under the settings in view; `None` to ask no more.
    pub fn explain(&self, event: Option<Event>) {
        self.shared.ask(|requests| requests.explain = Some(ExplainRequest(event)));
    }

    /// Asks for another part of the image to be analysed, the whole without one; it must be as large as the frames.
    /// The model is not run again, whose masks are kept.
    pub fn set_roi(&self, roi: Option<Arc<Roi>>) {
        self.shared.ask(|requests| requests.roi = Some(RoiRequest(roi)));
    }

    /// Chooses the pixel whose history is shown; `None`, or one outside the image, chooses none.
    pub fn inspect(&self, at: Option<(u32, u32)>) {
        self.shared.ask(|requests| requests.inspect = Some(PixelRequest(at)));
    }

    /// Asks what the chosen pixel would be in the frame in view under other values of these two
    /// settings, and of each alone; `None` to ask no more.
    pub fn tune(&self, knobs: Option<[TunableSetting; 2]>) {
        self.shared.ask(|requests| requests.tune = Some(TuneRequest(knobs)));
    }

    /// Goes on analysing beyond the frame in view, as it does from the start, or stops that and gives up a frame that
    /// is still on its way. What is asked for after that is analysed nevertheless.
    pub fn analyse_ahead(&self, ahead: bool) {
        self.shared.ask(|requests| {
            requests.analyse_ahead = Some(ahead);
            if !ahead {
                requests.show = None;
            }
        });
    }

    /// Pins these pixels, in place of those before: their histories are gathered after that of the chosen pixel.
    pub fn pin(&self, pixels: Vec<(u32, u32)>) {
        self.shared.ask(|requests| requests.pins = Some(pixels));
    }

    /// Asks which share of the pixels around one is foreground in each frame, `side` of them along each side; `None` to
    /// ask no more.
    pub fn region(&self, region: Option<((u32, u32), u32)>) {
        self.shared.ask(|requests| requests.region = Some(RegionRequest(region)));
    }

    /// Asks how right the mixture would be about the pixels around one, `side` of them along each side, over the same
    /// grid as [`Self::tune`]; `None` to ask no more. It takes true masks, and is worked out when all else is done.
    pub fn tune_region(&self, region: Option<((u32, u32), u32)>) {
        self.shared.ask(|requests| requests.tune_region = Some(RegionRequest(region)));
    }

    /// Asks for a map of a number of each pixel with every frame that is shown; `None` to ask no more.
    pub fn map(&self, quantity: Option<Quantity>) {
        self.shared.ask(|requests| requests.map = Some(MapRequest(quantity)));
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.shared.ask(|requests| requests.stop = true);
        // A worker inside a decoder must not meet the end of the process; one that hangs in a
        // dead disk or camera must not hold up the window.
        let waited = self.ended.recv_timeout(Duration::from_secs(2));
        debug_assert!(matches!(waited, Err(RecvTimeoutError::Disconnected | RecvTimeoutError::Timeout)));
    }
}

impl Shared {
    /// Without requests and state; `wake` is called after every change of the state.
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

    /// The state published last.
    pub(super) fn state(&self) -> State {
        lock(&self.state).clone()
    }

    fn ask(&self, change: impl FnOnce(&mut Requests)) {
        change(&mut lock(&self.requests));
        self.asked.notify_one();
    }

    /// Takes the requests since the previous call; `None` when the session is over. With `wait`, it sleeps until
    /// there is a request.
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

/// A thread that panicked with the lock held left whole values behind: every change under it is one assignment.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn words(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied();
    let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    text.unwrap_or("of an unknown kind").split_whitespace().collect::<Vec<_>>().join(" ")
}
