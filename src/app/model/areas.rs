//! Areas to analyse or to ignore: the drawn areas, the draft, and a mask from a file.

use std::sync::Arc;

use crate::frame::Size;
use crate::regions::roi::{self, Area, Purpose, Roi};

/// Minimum number of corners of an area.
const MIN_CORNERS: usize = 3;
/// Minimum distance of two corners in pixels, so that a double click adds only one corner.
const MIN_CORNER_DISTANCE_PX: f32 = 0.75;

/// An edit of the areas.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum AreaEdit {
    /// Start drawing an area.
    Begin(Purpose),
    /// Add a corner, in pixels.
    Corner([f32; 2]),
    /// Make the draft the rectangle between two corners.
    Rectangle([f32; 2], [f32; 2]),
    /// Complete the draft.
    Close,
    /// Remove the draft's last corner; without a draft, clear the selection.
    Back,
    /// Cancel drawing.
    Cancel,
    /// Select an area by its index, or none.
    Choose(Option<usize>),
    /// Delete the area of this index.
    Delete(usize),
    /// Delete the mask.
    DeleteMask,
    /// Replace mask and areas by this mask.
    Load(Arc<Roi>),
    /// Delete all areas and the mask.
    Clear,
}

/// Why an edit was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum AreaError {
    /// The area has too few distinct corners or no interior.
    #[error("An area needs at least three corners; add corners, or cancel with Esc")]
    Corners,
    /// No pixel would be left to analyse.
    #[error("No pixels would be left to analyse; draw a smaller ignore area, or delete another first")]
    Nothing,
}

/// The areas of a video.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Areas {
    /// A mask from a file, to which the drawn areas are applied.
    pub(crate) mask: Option<Arc<Roi>>,
    /// The drawn areas, in order of creation.
    pub(crate) drawn: Vec<Area>,
    /// The index of the selected area.
    pub(crate) chosen: Option<usize>,
    /// The area that is being drawn.
    pub(crate) draft: Option<Area>,
    /// The region of interest, composed of mask and areas; `None` where the whole image is analysed.
    pub(crate) roi: Option<Arc<Roi>>,
}

impl Areas {
    /// Areas with a mask only.
    pub(crate) fn of_mask(mask: Option<Arc<Roi>>) -> Self {
        Self { roi: mask.clone(), mask, ..Self::default() }
    }

    /// Whether there is neither a mask nor an area.
    pub(crate) const fn is_empty(&self) -> bool {
        self.mask.is_none() && self.drawn.is_empty()
    }

    /// Applies an edit to areas over frames of `size`. Returns whether the region of interest changed.
    pub(crate) fn change(&mut self, change: AreaEdit, size: Size) -> Result<bool, AreaError> {
        let before = (self.mask.clone(), self.drawn.clone());
        match change {
            AreaEdit::Begin(purpose) => {
                self.chosen = None;
                self.draft = Some(Area { purpose, corners: Vec::new() });
            }
            AreaEdit::Corner(at) => {
                if let Some(draft) = &mut self.draft
                    && draft.corners.last().is_none_or(|last| !is_same(*last, at))
                {
                    draft.corners.push(at);
                }
            }
            AreaEdit::Rectangle(a, b) => {
                if let Some(draft) = &mut self.draft {
                    draft.corners = vec![a, [b[0], a[1]], b, [a[0], b[1]]];
                    return self.close(size);
                }
            }
            AreaEdit::Close => return self.close(size),
            AreaEdit::Back => match &mut self.draft {
                Some(draft) => drop(draft.corners.pop()),
                None => self.chosen = None,
            },
            AreaEdit::Cancel => self.draft = None,
            AreaEdit::Choose(place) => self.chosen = place.filter(|&place| place < self.drawn.len()),
            AreaEdit::Delete(place) => {
                if place < self.drawn.len() {
                    self.drawn.remove(place);
                    self.chosen = None;
                }
            }
            AreaEdit::DeleteMask => self.mask = None,
            AreaEdit::Load(mask) => *self = Self { mask: Some(mask), ..Self::default() },
            AreaEdit::Clear => {
                (self.mask, self.drawn, self.chosen, self.draft) = (None, Vec::new(), None, None);
            }
        }
        self.compose(before, size)
    }

    fn close(&mut self, size: Size) -> Result<bool, AreaError> {
        let before = (self.mask.clone(), self.drawn.clone());
        let Some(mut draft) = self.draft.take() else { return Ok(false) };
        while draft.corners.len() > 1 && is_same(draft.corners[0], draft.corners[draft.corners.len() - 1]) {
            draft.corners.pop();
        }
        if draft.corners.len() < MIN_CORNERS || draft.pixels(size) == 0 {
            self.draft = Some(draft);
            return Err(AreaError::Corners);
        }
        self.chosen = Some(self.drawn.len());
        self.drawn.push(draft);
        self.compose(before, size)
    }

    /// Composes the region of interest. Restores `before` if no pixel would be left.
    fn compose(&mut self, before: (Option<Arc<Roi>>, Vec<Area>), size: Size) -> Result<bool, AreaError> {
        if before == (self.mask.clone(), self.drawn.clone()) {
            return Ok(false);
        }
        let composed = match (&self.mask, self.drawn.is_empty()) {
            (None, true) => None,
            (Some(mask), true) => Some(Arc::clone(mask)),
            (mask, false) => {
                let composed = roi::of_areas(size, mask.as_deref(), &self.drawn);
                if composed.is_none() {
                    (self.mask, self.drawn) = before;
                    self.chosen = None;
                    return Err(AreaError::Nothing);
                }
                composed.map(Arc::new)
            }
        };
        let changed = composed != self.roi;
        if changed {
            self.roi = composed;
        }
        Ok(changed)
    }

    /// The index of the area whose outline is nearest to a point, within `reach` pixels.
    pub(crate) fn at(&self, point: [f32; 2], reach: f32) -> Option<usize> {
        let near = |area: &Area| {
            let next = area.corners.iter().cycle().skip(1);
            area.corners.iter().zip(next).map(|(&a, &b)| distance(point, a, b)).fold(f32::INFINITY, f32::min)
        };
        let nearest = self.drawn.iter().map(near).enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.filter(|(_, distance)| *distance <= reach).map(|(place, _)| place)
    }
}

fn is_same(a: [f32; 2], b: [f32; 2]) -> bool {
    (a[0] - b[0]).hypot(a[1] - b[1]) < MIN_CORNER_DISTANCE_PX
}

/// The distance of a point from the line segment between `a` and `b`.
fn distance(point: [f32; 2], a: [f32; 2], b: [f32; 2]) -> f32 {
    let (along, to) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
    let length = along[0] * along[0] + along[1] * along[1];
    let share = ((to[0] * along[0] + to[1] * along[1]) / length.max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    (to[0] - share * along[0]).hypot(to[1] - share * along[1])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    const SIZE: Size = Size::new(40, 30);

    fn draw(areas: &mut Areas, purpose: Purpose, corners: &[[f32; 2]]) -> Result<bool, AreaError> {
        areas.change(AreaEdit::Begin(purpose), SIZE)?;
        for &corner in corners {
            areas.change(AreaEdit::Corner(corner), SIZE)?;
        }
        areas.change(AreaEdit::Close, SIZE)
    }

    const TRIANGLE: [[f32; 2]; 3] = [[0.0, 0.0], [20.0, 0.0], [0.0, 20.0]];

    #[test]
    fn areas_are_drawn_selected_and_deleted() {
        let mut areas = Areas::default();
        assert_eq!(draw(&mut areas, Purpose::Ignore, &TRIANGLE), Ok(true));
        assert_eq!((areas.chosen, areas.draft.is_none()), (Some(0), true));
        assert!(!areas.roi.as_ref().unwrap().contains(3, 3));
        areas.change(AreaEdit::Begin(Purpose::Ignore), SIZE).unwrap();
        assert_eq!(areas.change(AreaEdit::Rectangle([30.0, 20.0], [40.0, 30.0]), SIZE), Ok(true));
        assert!(!areas.roi.as_ref().unwrap().contains(35, 25));
        assert_eq!(areas.at([30.5, 24.0], 2.0), Some(1));
        assert_eq!(areas.at([10.0, 1.0], 2.0), Some(0));
        assert_eq!(areas.at([25.0, 12.0], 2.0), None);
        assert_eq!(areas.change(AreaEdit::Choose(Some(0)), SIZE), Ok(false));
        assert_eq!(areas.change(AreaEdit::Delete(0), SIZE), Ok(true));
        assert!(areas.roi.as_ref().unwrap().contains(3, 3) && areas.chosen.is_none());
        assert_eq!(areas.change(AreaEdit::Clear, SIZE), Ok(true));
        assert!(areas.is_empty() && areas.roi.is_none());
    }

    #[test]
    fn an_area_without_interior_or_without_remaining_pixels_is_rejected() {
        let mut areas = Areas::default();
        assert_eq!(draw(&mut areas, Purpose::Analyse, &TRIANGLE[..2]), Err(AreaError::Corners));
        areas.change(AreaEdit::Corner([0.0, 20.0]), SIZE).unwrap();
        assert_eq!(areas.change(AreaEdit::Close, SIZE), Ok(true), "the area is completed");
        let all = [[-1.0, -1.0], [50.0, -1.0], [50.0, 50.0], [-1.0, 50.0]];
        let before = areas.roi.clone();
        assert_eq!(draw(&mut areas, Purpose::Ignore, &all), Err(AreaError::Nothing));
        assert_eq!((areas.drawn.len(), &areas.roi), (1, &before));
        // A double click adds its corner once.
        areas.change(AreaEdit::Begin(Purpose::Ignore), SIZE).unwrap();
        for corner in [[1.0, 1.0], [8.0, 1.0], [8.0, 1.0], [8.0, 8.0]] {
            areas.change(AreaEdit::Corner(corner), SIZE).unwrap();
        }
        assert_eq!(areas.draft.as_ref().unwrap().corners.len(), 3);
        areas.change(AreaEdit::Back, SIZE).unwrap();
        assert_eq!(areas.draft.as_ref().unwrap().corners.len(), 2);
        assert_eq!(areas.change(AreaEdit::Cancel, SIZE), Ok(false));
        assert!(areas.draft.is_none());
    }
}
