//! The first stage: the background model, which gives the mask of each frame.

use rayon::prelude::*;

use super::PipelineError;
use crate::frame::{Frame, Mask, Size};
use crate::mixture::opencv::OpencvModel;
use crate::mixture::{Mixture, Parameters};
use crate::registration::{Correction, CorrectionChoice, corrected};
use crate::settings::Settings;

/// The background model with the correction of frames before it.
pub(crate) struct BackgroundSubtractor {
    /// The correction of a frame before the model.
    registration: CorrectionChoice,
    model: Model,
}

enum Model {
    Mixture(Box<Mixture>),
    Opencv(OpencvModel),
}

impl BackgroundSubtractor {
    /// A model before the first frame. Fails only if OpenCV cannot create MOG2 or KNN.
    pub(crate) fn new(settings: &Settings, size: Size) -> Result<Self, PipelineError> {
        let opencv =
            OpencvModel::new(settings, size).map_err(|source| PipelineError::Opencv { frame: 0, source })?;
        let model = opencv.map_or_else(
            || Model::Mixture(Box::new(Mixture::new(size, Parameters::new(settings)))),
            Model::Opencv,
        );
        Ok(Self { registration: CorrectionChoice::new(settings), model })
    }

    /// Learns from frames before the first that is classified.
    pub(crate) fn learn(&mut self, frames: &[&Frame]) -> Result<(), PipelineError> {
        match &mut self.model {
            Model::Mixture(mixture) => {
                mixture.learn(frames);
                Ok(())
            }
            Model::Opencv(model) => frames.iter().try_for_each(|frame| {
                let corrected = corrected(frame, self.registration);
                let seen = corrected.as_ref().map_or(*frame, |corrected| &corrected.frame);
                model.learn(seen).map_err(|source| PipelineError::Opencv { frame: frame.number, source })
            }),
        }
    }

    /// Starts classification after the last frame to learn from.
    pub(super) fn begin(&mut self) {
        if let Model::Mixture(mixture) = &mut self.model {
            mixture.begin();
        }
    }

    /// Processes the next frames and returns the foreground mask of each, in the frame's own coordinates.
    pub(crate) fn masks(&mut self, frames: &[&Frame]) -> Result<Vec<Mask>, PipelineError> {
        let corrections: Vec<_> =
            frames.iter().map(|frame| self.registration.correction(&frame.alignment, frame.size)).collect();
        let masks = match &mut self.model {
            Model::Mixture(mixture) => {
                let mut masks = vec![Mask::empty(mixture.size()); frames.len()];
                mixture.step_many(frames, &mut masks);
                masks
            }
            Model::Opencv(model) => {
                let step = |(frame, correction): (&&Frame, &Option<Correction>)| {
                    let corrected = correction.as_ref().map(|correction| correction.apply(frame));
                    let seen = corrected.as_ref().map_or(*frame, |corrected| &corrected.frame);
                    let failed = |source| PipelineError::Opencv { frame: frame.number, source };
                    let mut mask = model.step(seen).map_err(failed)?;
                    if let Some(unknown) = corrected.and_then(|corrected| corrected.unknown) {
                        for (pixel, _) in mask.data.iter_mut().zip(unknown).filter(|(_, unknown)| *unknown) {
                            *pixel = Mask::BACKGROUND;
                        }
                    }
                    Ok(mask)
                };
                frames.iter().zip(&corrections).map(step).collect::<Result<_, PipelineError>>()?
            }
        };
        let masks = masks.into_par_iter().zip(&corrections);
        Ok(masks
            .map(|(mask, correction)| match correction {
                Some(correction) => correction.mask_of_frame(mask),
                None => mask,
            })
            .collect())
    }

    /// The mean of component 1, or the background image of MOG2 or KNN; RGB bytes in row order.
    pub(super) fn background_image(&self) -> Result<Vec<u8>, PipelineError> {
        match &self.model {
            Model::Mixture(mixture) => Ok(mixture.mean_image()),
            Model::Opencv(model) => {
                model.background_image().map_err(|source| PipelineError::Opencv { frame: 0, source })
            }
        }
    }

    /// The mixture; `None` with MOG2 or KNN.
    pub(super) const fn mixture(&self) -> Option<&Mixture> {
        match &self.model {
            Model::Mixture(mixture) => Some(mixture),
            Model::Opencv(_) => None,
        }
    }

    /// A copy of the current state; `None` for MOG2 and KNN, whose state cannot be copied.
    pub(super) fn try_clone(&self) -> Option<Self> {
        let model = Model::Mixture(Box::new(self.mixture()?.clone()));
        Some(Self { registration: self.registration, model })
    }
}
