//! The camera of the views, and the pixel under the pointer.

use crate::app::model::view::View;

/// Minimum and maximum magnification by keys and menu.
const MAGNIFICATION_RANGE: (f32, f32) = (0.5, 400.0);

/// The camera of all views, independent of their sizes, so that the views stay linked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ViewCamera {
    /// The magnification relative to the fitted image.
    pub(crate) magnification: f32,
    /// The image point at the centre of each view, as fractions of width and height.
    pub(crate) centre: [f32; 2],
}

impl ViewCamera {
    /// The whole image.
    pub(crate) const FIT: Self = Self { magnification: 1.0, centre: [0.5, 0.5] };

    /// The camera after zooming by `factor` around an image point given in fractions of width and height, or around
    /// the centre.
    pub(crate) fn zoomed(self, factor: f32, around: Option<[f32; 2]>) -> Self {
        let (least, greatest) = MAGNIFICATION_RANGE;
        let magnification = (self.magnification * factor).clamp(least, greatest);
        let mut centre = self.centre;
        if let Some(around) = around {
            let part = 1.0 - self.magnification / magnification;
            for (centre, around) in centre.iter_mut().zip(around) {
                *centre = (*centre + (around - *centre) * part).clamp(0.0, 1.0);
            }
        }
        Self { magnification, centre }
    }
}

/// The pixel under the pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hover {
    /// The view.
    pub(crate) view: View,
    /// The pixel, as column and row.
    pub(crate) pixel: (u32, u32),
    /// Points per image pixel in that view.
    pub(crate) scale: f32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zooming_approaches_the_given_point_and_stays_within_bounds() {
        let camera = ViewCamera::FIT.zoomed(2.0, Some([1.0, 0.5]));
        assert_eq!(camera, ViewCamera { magnification: 2.0, centre: [0.75, 0.5] });
        assert_eq!(ViewCamera::FIT.zoomed(4.0, None), ViewCamera { magnification: 4.0, centre: [0.5, 0.5] });
        assert_eq!(ViewCamera::FIT.zoomed(1e4, None).magnification, 400.0);
        assert_eq!(ViewCamera::FIT.zoomed(1e-4, None).magnification, 0.5);
    }
}
