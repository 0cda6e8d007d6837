//! Areas to analyse or to ignore: those that were drawn, the one that is being drawn, and a mask under them.

use std::sync::Arc;

use crate::frame::Size;
use crate::regions::roi::{self, Area, Purpose, Roi};

/// Least number of corners of an area.
const MIN_CORNERS: usize = 3;
/// Least distance of two corners in pixels: a double click sets none beside the last.
const MIN_CORNER_DISTANCE_PX: f32 = 0.75;

/// An edit of the areas.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum AreaEdit {
    /// Begin to draw one.
    Begin(Purpose),
    /// Its next corner, in pixels.
    Corner([f32; 2]),
    /// It is the rectangle between two corners.
    Rectangle([f32; 2], [f32; 2]),
    /// It is whole.
    Close,
    /// Take back its last corner, or choose none.
    Back,
    /// Cancel drawing.
    Cancel,
    /// Choose one by its place, or none.
    Choose(Option<usize>),
    /// Take one away.
    Delete(usize),
    /// Take the mask away that lies under them.
    DeleteMask,
    /// Take this mask in place of all that is there.
    Load(Arc<Roi>),
    /// Take everything away.
    Clear,
}

/// Why an edit was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum AreaError {
    /// It has no inside.
    #[error("An area needs at least three corners; add corners, or cancel with Esc")]
    Corners,
    /// Nothing would be left to analyse.
    #[error("No pixels would be left to analyse; draw a smaller ignore area, or delete another first")]
    Nothing,
}

/// The areas over a video.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Areas {
    /// A mask from a file, which lies under all that is drawn.
    pub(crate) mask: Option<Arc<Roi>>,
    /// Those that were drawn, in order.
    pub(crate) drawn: Vec<Area>,
    /// The place of the one that is chosen.
    pub(crate) chosen: Option<usize>,
    /// The one that is being drawn.
    pub(crate) draft: Option<Area>,
    /// All of it together; none where the whole image is analysed.
    pub(crate) roi: Option<Arc<Roi>>,
}

impl Areas {
    /// A mask alone.
    pub(crate) fn of_mask(mask: Option<Arc<Roi>>) -> Self {
        Self { roi: mask.clone(), mask, ..Self::default() }
    }

    /// Whether there is nothing.
    pub(crate) const fn is_empty(&self) -> bool {
        self.mask.is_none() && self.drawn.is_empty()
    }

    /// Makes a change over frames of `size`; whether other pixels are analysed from then on.
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

    /// Puts together what is analysed; what leaves nothing is taken back.
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

    /// The place of the area whose outline passes nearest to a point, within `reach` pixels.
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

/// How far a point is from the line between two others.
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
    fn areas_are_drawn_chosen_and_taken_away() {
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
    fn what_has_no_inside_or_leaves_nothing_is_refused() {
        let mut areas = Areas::default();
        assert_eq!(draw(&mut areas, Purpose::Analyse, &TRIANGLE[..2]), Err(AreaError::Corners));
        areas.change(AreaEdit::Corner([0.0, 20.0]), SIZE).unwrap();
        assert_eq!(areas.change(AreaEdit::Close, SIZE), Ok(true), "drawing went on");
        let all = [[-1.0, -1.0], [50.0, -1.0], [50.0, 50.0], [-1.0, 50.0]];
        let before = areas.roi.clone();
        assert_eq!(draw(&mut areas, Purpose::Ignore, &all), Err(AreaError::Nothing));
        assert_eq!((areas.drawn.len(), &areas.roi), (1, &before));
        // A double click sets its last corner once.
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
