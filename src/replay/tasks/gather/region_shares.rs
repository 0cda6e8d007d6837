//! The share of foreground in a small region over time, from the recorded masks.

use std::ops::Range;
use std::sync::Arc;

use crate::explain::pixel::region_shares::{PixelRegion, RegionShares, region_bounds};
use crate::frame::Size;
use crate::replay::store::analysis_record::AnalysisRecord;

/// Number of frames of one step.
const FRAMES_PER_STEP: u32 = 256;

/// Computes [`RegionShares`].
#[derive(Default)]
pub(crate) struct RegionShareCounter(Option<Arc<RegionShares>>);

impl RegionShareCounter {
    /// Chooses a region of an image of `size`, or none.
    pub(crate) fn choose(&mut self, region: Option<PixelRegion>, size: Size) {
        let region = region.filter(|region| region.is_centred_in(size));
        let known = self.0.as_ref().map(|shares| PixelRegion { centre: shares.at, side: shares.side });
        if known != region {
            self.0 = region.map(|PixelRegion { centre: at, side }| {
                let (columns, rows) = region_bounds(at, side, size);
                let pixels = (columns.len() * rows.len()) as u32;
                Arc::new(RegionShares { at, side, pixels, model: Vec::new(), cleaned: Vec::new() })
            });
        }
    }

    /// Drops the counts, because the masks are computed again.
    pub(crate) fn forget(&mut self) {
        if let Some(shares) = &mut self.0 {
            let shares = Arc::make_mut(shares);
            shares.model.clear();
            shares.cleaned.clear();
        }
    }

    /// Counts in some of the `front` analysed frames; returns whether there was work to do.
    pub(crate) fn count(&mut self, record: &AnalysisRecord, front: u32, size: Size) -> bool {
        let Some(shares) = self.0.as_mut().filter(|shares| (shares.model.len() as u32) < front) else {
            return false;
        };
        let shares = Arc::make_mut(shares);
        let (columns, rows) = region_bounds(shares.at, shares.side, size);
        let start = shares.model.len() as u32;
        for position in start..front.min(start + FRAMES_PER_STEP) {
            let [mut model, mut cleaned] = [0, 0];
            record.for_each_raw_run(position, |run| model += inside(&run, &columns, &rows, size));
            record.for_each_run(position, |run| cleaned += inside(&run, &columns, &rows, size));
            let share = |count: usize| count as f32 / shares.pixels.max(1) as f32;
            shares.model.push(share(model));
            shares.cleaned.push(share(cleaned));
        }
        true
    }

    /// The current shares.
    pub(crate) fn latest(&self) -> Option<Arc<RegionShares>> {
        self.0.clone()
    }
}

/// Number of pixels of a run, which may span several rows, inside a rectangle.
fn inside(run: &Range<usize>, columns: &Range<u32>, rows: &Range<u32>, size: Size) -> usize {
    let width = size.width.max(1) as usize;
    let (first, last) = (run.start / width, run.end.saturating_sub(1) / width);
    let of_row = |row: usize| {
        let start = run.start.max(row * width + columns.start as usize);
        run.end.min(row * width + columns.end as usize).saturating_sub(start)
    };
    (first.max(rows.start as usize)..(last + 1).min(rows.end as usize)).map(of_row).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pixels_of_a_run_inside_the_region_are_counted() {
        let size = Size::new(10, 6);
        let (columns, rows) = region_bounds((4, 2), 3, size);
        assert_eq!((columns.clone(), rows.clone()), (3..6, 1..4));
        for start in 0..60 {
            for end in start + 1..=60 {
                let expected = (start..end)
                    .filter(|at| columns.contains(&(*at as u32 % 10)) && rows.contains(&(*at as u32 / 10)));
                assert_eq!(inside(&(start..end), &columns, &rows, size), expected.count(), "{start}..{end}");
            }
        }
    }
}
