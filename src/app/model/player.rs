//! The window's interface of the worker.

use std::sync::Arc;

use crate::explain::tuning::TunableSetting;
use crate::mixture::Quantity;
use crate::occlusion::Event;
use crate::regions::Roi;
use crate::replay::{Session, State};
use crate::settings::Settings;
use crate::truth::Truth;

/// The interface of the worker.
pub(crate) trait Player {
    /// The latest published state.
    fn state(&self) -> State;
    /// Requests a frame.
    fn show(&self, position: u32);
    /// Sets the settings in view, and the settings to compare with them.
    fn set_settings(&self, settings: Settings, beside: Option<Settings>);
    /// Requests the counterfactuals of an event.
    fn explain(&self, event: Option<Event>);
    /// Sets the ground truth.
    fn set_truth(&self, truth: Option<Arc<Truth>>);
    /// Sets the region of interest; `None` for the whole image.
    fn set_roi(&self, roi: Option<Arc<Roi>>);
    /// Chooses a pixel.
    fn inspect(&self, at: Option<(u32, u32)>);
    /// Requests the chosen pixel's verdict under other values of these two settings.
    fn tune(&self, knobs: Option<[TunableSetting; 2]>);
    /// Resumes or pauses the analysis beyond the frame in view.
    fn analyse_ahead(&self, ahead: bool);
    /// Ends the worker without waiting for it.
    fn leave(self: Box<Self>);
    /// Requests the map of a per-pixel quantity with every frame.
    fn map(&self, quantity: Option<Quantity>);
    /// Requests the histories of these pixels.
    fn pin(&self, pixels: Vec<(u32, u32)>);
    /// Requests the foreground ratio around a pixel, in a region of this side in pixels.
    fn region(&self, region: Option<((u32, u32), u32)>);
    /// Requests the accuracy of the mixture around a pixel under other settings, in a region of this side in pixels.
    fn tune_region(&self, region: Option<((u32, u32), u32)>);
}

impl Player for Session {
    fn state(&self) -> State {
        Session::state(self)
    }

    fn show(&self, position: u32) {
        Session::show(self, position);
    }

    fn set_settings(&self, settings: Settings, beside: Option<Settings>) {
        self.compare(settings, beside);
    }

    fn explain(&self, event: Option<Event>) {
        Session::explain(self, event);
    }

    fn set_truth(&self, truth: Option<Arc<Truth>>) {
        Session::set_truth(self, truth);
    }

    fn set_roi(&self, roi: Option<Arc<Roi>>) {
        Session::set_roi(self, roi);
    }

    fn inspect(&self, at: Option<(u32, u32)>) {
        Session::inspect(self, at);
    }

    fn tune(&self, knobs: Option<[TunableSetting; 2]>) {
        Session::tune(self, knobs);
    }

    fn analyse_ahead(&self, ahead: bool) {
        Session::analyse_ahead(self, ahead);
    }

    fn leave(self: Box<Self>) {
        // The worker may be inside a decoder, and frees gigabytes. If no thread can be started, this thread waits for
        // it.
        let left = std::thread::Builder::new().name("leaving".into()).spawn(move || drop(self));
        drop(left);
    }

    fn map(&self, quantity: Option<Quantity>) {
        Session::map(self, quantity);
    }

    fn pin(&self, pixels: Vec<(u32, u32)>) {
        Session::pin(self, pixels);
    }

    fn region(&self, region: Option<((u32, u32), u32)>) {
        Session::region(self, region);
    }

    fn tune_region(&self, region: Option<((u32, u32), u32)>) {
        Session::tune_region(self, region);
    }
}
