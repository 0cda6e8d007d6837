//! OpenCV's MOG2 and KNN background subtractors, as alternatives to the mixture.

use opencv::boxed_ref::BoxedRef;
use opencv::core::{Mat, Ptr, Vec3b, set_rng_seed};
use opencv::prelude::*;
use opencv::video::{
    BackgroundSubtractorKNN, BackgroundSubtractorMOG2, create_background_subtractor_knn,
    create_background_subtractor_mog2,
};

use crate::frame::{Frame, Mask, Size};
use crate::settings::{BackgroundModel, Settings};

enum Subtractor {
    Mog2(Ptr<BackgroundSubtractorMOG2>),
    Knn(Ptr<BackgroundSubtractorKNN>),
}

/// One of OpenCV's background subtractors, with the mixture's α (and K, T where it has them),
/// shadow detection off, and otherwise OpenCV's defaults. Its state cannot be read or copied.
pub struct OpencvModel {
    subtractor: Subtractor,
    size: Size,
    alpha: f64,
    t: u64,
}

impl OpencvModel {
    /// The subtractor in `settings`; `None` if they name the mixture.
    pub fn new(settings: &Settings, size: Size) -> opencv::Result<Option<Self>> {
        let history = (1.0 / settings.alpha).round() as i32;
        let subtractor = match settings.background_model {
            BackgroundModel::Mixture => return Ok(None),
            BackgroundModel::Mog2 => {
                let mut mog2 = create_background_subtractor_mog2(history, 16.0, false)?;
                mog2.set_n_mixtures(settings.k as i32)?;
                mog2.set_background_ratio(f64::from(settings.t))?;
                Subtractor::Mog2(mog2)
            }
            BackgroundModel::Knn => Subtractor::Knn(create_background_subtractor_knn(history, 400.0, false)?),
        };
        Ok(Some(Self { subtractor, size, alpha: f64::from(settings.alpha), t: 0 }))
    }

    /// Learns from a frame before the first classified one, with the mixture's learning rate for that frame.
    pub fn learn(&mut self, frame: &Frame) -> opencv::Result<()> {
        self.take(frame, self.alpha.max(1.0 / (self.t + 1) as f64)).map(drop)
    }

    /// Processes the next frame and returns its foreground mask.
    pub fn step(&mut self, frame: &Frame) -> opencv::Result<Mask> {
        self.take(frame, self.alpha)
    }

    fn take(&mut self, frame: &Frame, alpha: f64) -> opencv::Result<Mask> {
        self.t += 1;
        // The first frame initialises OpenCV's model at any learning rate.
        let rgb = rgb_mat(frame)?;
        let mut mask = Mat::default();
        match &mut self.subtractor {
            Subtractor::Mog2(mog2) => {
                BackgroundSubtractorMOG2Trait::apply(mog2, &rgb, &mut mask, alpha)?;
            }
            Subtractor::Knn(knn) => {
                // KNN replaces random samples: the frame number as seed makes runs reproducible.
                set_rng_seed(self.t as i32)?;
                BackgroundSubtractorTrait::apply(knn, &rgb, &mut mask, alpha)?;
            }
        }
        Ok(Mask { size: self.size, data: mask.data_bytes()?.to_vec() })
    }

    /// The model's background: RGB bytes in row order.
    pub fn background_image(&self) -> opencv::Result<Vec<u8>> {
        let mut background = Mat::default();
        match &self.subtractor {
            Subtractor::Mog2(mog2) => mog2.get_background_image(&mut background)?,
            Subtractor::Knn(knn) => knn.get_background_image(&mut background)?,
        }
        Ok(background.data_bytes()?.to_vec())
    }
}

fn rgb_mat(frame: &Frame) -> opencv::Result<BoxedRef<'_, Mat>> {
    Mat::new_rows_cols_with_bytes::<Vec3b>(frame.size.height as i32, frame.size.width as i32, &frame.rgb)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const SIZE: Size = Size::new(8, 6);

    fn grey(number: u32, level: u8) -> Frame {
        Frame::new(number, SIZE, vec![level; 3 * SIZE.pixels()])
    }

    fn model(background_model: BackgroundModel) -> Option<OpencvModel> {
        let settings = Settings { background_model, alpha: 0.01, ..Settings::default() };
        OpencvModel::new(&settings, SIZE).unwrap()
    }

    #[test]
    fn frames_that_are_learned_from_count_alike() {
        assert!(model(BackgroundModel::Mixture).is_none());
        let mut mog2 = model(BackgroundModel::Mog2).unwrap();
        for number in 1..=20 {
            mog2.learn(&grey(number, if number % 2 == 0 { 104 } else { 96 })).unwrap();
        }
        let background = mog2.background_image().unwrap();
        assert_eq!(background.len(), 3 * SIZE.pixels());
        assert!(background.iter().all(|level| level.abs_diff(100) <= 1), "{background:?}");
        // After it the learning rate is α: a hundredth of the difference.
        mog2.step(&grey(21, 108)).unwrap();
        assert!(mog2.background_image().unwrap().iter().all(|level| level.abs_diff(100) <= 1));
    }

    #[test]
    fn both_models_show_what_differs_from_what_they_learned() {
        for kind in [BackgroundModel::Mog2, BackgroundModel::Knn] {
            let mut model = model(kind).unwrap();
            (1..=30).for_each(|number| model.learn(&grey(number, 100)).unwrap());
            let mut frame = grey(31, 100);
            frame.rgb[3 * 10..3 * 13].fill(220);
            let mask = model.step(&frame).unwrap();
            let found: Vec<usize> =
                (0..SIZE.pixels()).filter(|&at| mask.data[at] == Mask::FOREGROUND).collect();
            assert_eq!(found, [10, 11, 12], "{kind:?}");
            assert!(model.background_image().unwrap().iter().all(|level| level.abs_diff(100) <= 1));
        }
    }
}
