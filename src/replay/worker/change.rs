//! Other settings, another part of the image, other truth: what they leave as it is, and what is run again.

use std::sync::Arc;

use super::{Aim, Stopped, Worker};
use crate::regions::Roi;
use crate::replay::lane::Lane;
use crate::replay::rival::Rival;
use crate::replay::{Phase, Shown};
use crate::settings::{Settings, Stage};
use crate::truth::Truth;

impl Worker<'_> {
    /// Takes what is known to be right, as far as it is about frames of this size.
    pub(super) fn take_truth(&mut self, truth: Option<Arc<Truth>>) {
        let size = self.info.size;
        let (truth, masks) = match truth {
            Some(truth) if truth.masks.as_ref().is_some_and(|masks| masks.size() != size) => {
                let masks = truth.masks.as_ref().map_or(size, |masks| masks.size());
                self.outbox.warnings.push(format!(
                    "the ground-truth masks are {masks}, the frames of {} are {size}: the masks are \
                     ignored; load those of this video",
                    self.info.name
                ));
                (Some(Arc::new(Truth { boxes: truth.boxes.clone(), masks: None })), None)
            }
            truth => {
                let masks = truth.as_ref().and_then(|truth| truth.masks.clone());
                (truth, masks)
            }
        };
        self.truth = truth;
        self.region_tuner.set_truth(masks);
        self.publish_region_tuning();
        (self.outbox.timeline_grew, self.outbox.beside_grew) = (true, true);
        if let Some(shown) = self.shown.clone() {
            self.show(Shown::clone(&shown));
        }
    }

    /// Gives up going anywhere: the frame in view stays, or the last that is analysed under new settings.
    pub(super) fn stay(&mut self) {
        self.aim = None;
        if let Some(shown) = &self.shown {
            self.wanted = shown.position.min(self.lane.run.front().saturating_sub(1));
        }
    }

    /// Takes other settings in view and beside it, or another part of the image, and runs again what they touch.
    pub(super) fn change(
        &mut self,
        settings: Settings,
        roi: Option<Arc<Roi>>,
        beside: Option<Settings>,
    ) -> Result<(), Stopped> {
        let beside = self.comparable(beside);
        let differs = self.lane.first_difference(&settings, roi.as_ref()).is_some();
        if !differs && !self.stopped && beside == self.rival.settings {
            return Ok(());
        }
        if self.stopped {
            self.rival = Rival::default();
        }
        if differs {
            // Under other settings it may never have happened.
            self.asker.ask(None);
            self.publish_what_if();
        }
        self.rival.settings = beside;
        if differs || self.stopped {
            self.change_view(settings, roi.clone())?;
        }
        self.change_rival(roi)
    }

    /// A live source's frames come once, and only some are kept: two runs cannot both have them.
    pub(super) fn comparable(&mut self, beside: Option<Settings>) -> Option<Settings> {
        let refused = beside.is_some() && self.info.live;
        if refused && !std::mem::replace(&mut self.outbox.told_of.live, true) {
            self.outbox.warnings.push(format!(
                "two settings cannot be compared on the live source {}; record it first",
                self.info.name
            ));
        }
        beside.filter(|_| !refused)
    }

    /// Brings other settings into view.
    pub(super) fn change_view(&mut self, settings: Settings, roi: Option<Arc<Roi>>) -> Result<(), Stopped> {
        // Before anything else: one pixel through all frames is a matter of a millisecond.
        self.lane.inspector.choose(self.pixel, &settings, &self.info);
        self.publish_pixel();
        self.pins.run_again(&settings, &self.info);
        self.region_tuner.register(&settings);
        self.region.forget();
        self.outbox.pixel_grew = true;
        let budget = self.budget();
        let settings = Arc::new(settings);
        match self.lane.first_difference(&settings, roi.as_ref()) {
            _ if self.take_from_rival(&settings, roi.as_ref()) => self.show_pixel(),
            Some(stage) if stage > Stage::Mixture && !self.stopped => {
                if self.rival.is(self.lane.settings())
                    && settings != *self.lane.settings()
                    && let Some(fork) = self.lane.fork(budget)
                {
                    let given_up = self.rival.lane.replace(fork);
                    rayon::spawn(move || drop(given_up));
                }
                self.lane.restart_at(stage, settings, roi)?;
            }
            _ => {
                let mut lane = Lane::new(settings, roi, &self.info, budget)?;
                lane.inspector = std::mem::take(&mut self.lane.inspector);
                let old = std::mem::replace(&mut self.lane, lane);
                if self.rival.is(old.settings()) && !self.stopped {
                    let given_up = self.rival.lane.replace(old);
                    rayon::spawn(move || drop(given_up));
                    if let Some(old) = &mut self.rival.lane {
                        old.inspect(self.pixel);
                    }
                } else {
                    // To give gigabytes back takes longer than the first frames.
                    rayon::spawn(move || drop(old));
                }
                if self.info.live && !self.frames.numbers().is_empty() && self.frames.kept(0).is_none() {
                    self.start_over_live()?;
                }
            }
        }
        self.stopped = false;
        if let Some(Aim::Occlusion(found)) = &mut self.aim {
            *found = None;
        }
        // The timeline changes together with the view.
        self.outbox.analysed = 0;
        self.outbox.timeline_grew = true;
        self.shared.publish(|state| state.phase = Phase::Ready);
        Ok(())
    }

    /// Changes places with the rival, if what is asked for is its run; whether it was.
    pub(super) fn take_from_rival(&mut self, settings: &Settings, roi: Option<&Arc<Roi>>) -> bool {
        let Some(lane) = &mut self.rival.lane else { return false };
        let same = lane.first_difference(settings, roi).is_none() && !self.stopped;
        if same {
            std::mem::swap(lane, &mut self.lane);
            lane.inspect(self.pixel);
            self.rival.shown = None;
        }
        same
    }

    /// Gives the rival the settings that it is to have.
    pub(super) fn change_rival(&mut self, roi: Option<Arc<Roi>>) -> Result<(), Stopped> {
        let budget = self.budget();
        self.lane.run.set_budget(budget);
        self.outbox.beside_grew = true;
        let settings = self.rival.settings.clone().filter(|settings| settings != &**self.lane.settings());
        let Some(settings) = settings else {
            // Equal settings have one run; without settings there is none.
            let given_up = self.rival.give_up();
            rayon::spawn(move || drop(given_up));
            return Ok(());
        };
        let settings = Arc::new(settings);
        match &mut self.rival.lane {
            Some(lane) => match lane.first_difference(&settings, roi.as_ref()) {
                None => {}
                Some(stage) if stage > Stage::Mixture => lane.restart_at(stage, settings, roi)?,
                Some(_) => {
                    let other = self.lane.beside(settings, roi, &self.info, budget)?;
                    let old = std::mem::replace(lane, other);
                    rayon::spawn(move || drop(old));
                }
            },
            none => *none = Some(self.lane.beside(settings, roi, &self.info, budget)?),
        }
        if let Some(lane) = &mut self.rival.lane {
            lane.run.set_budget(budget);
            lane.inspect(self.pixel);
        }
        Ok(())
    }

    /// The memory for going back in time that one run may take.
    pub(super) const fn budget(&self) -> usize {
        if self.rival.settings.is_some() { self.model_budget / 2 } else { self.model_budget }
    }

    /// A live source whose first frames are no longer kept cannot be run again from the start: the
    /// sequence begins with the next frame.
    pub(super) fn start_over_live(&mut self) -> Result<(), Stopped> {
        let name = &self.info.name;
        if self.frames.is_complete() {
            return Err(Stopped(format!(
                "{name} has no more frames, and its first frames are no longer kept for a new analysis; \
                 open it again"
            )));
        }
        self.outbox.warnings.push(format!(
            "the first frames of {name} are no longer kept: the new settings apply from the next frame on"
        ));
        self.frames.forget();
        let (settings, roi) = (Arc::clone(self.lane.settings()), self.lane.run.roi().cloned());
        self.lane = Lane::new(settings, roi, &self.info, self.model_budget)?;
        self.lane.inspect(self.pixel);
        self.pins.forget(self.lane.settings(), &self.info);
        self.region.forget();
        self.tuner.forget();
        self.region_tuner.forget();
        self.follow = true;
        Ok(())
    }
}
