//! Dominant colour: the most frequent colour of a region's own pixels (Algorithm 1), from a histogram of 16 × 16 × 16
//! bins.

use palette::color_difference::EuclideanDistance;
use palette::{IntoColor, Lab, Srgb};
use std::collections::BTreeMap;

/// An 8-bit RGB colour.
pub type Rgb = [u8; 3];

/// CIE76 ΔE: the Euclidean distance of two colours in Lab (D65), about 100 between black and white.
pub fn delta_e(a: Rgb, b: Rgb) -> f32 {
    let lab = |colour: Rgb| -> Lab { Srgb::from(colour).into_linear::<f32>().into_color() };
    lab(a).distance(lab(b))
}

/// The number of pixels in one bin, and the sum of their colours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bin {
    /// Pixels, or an average of pixels over frames.
    pub count: f32,
    /// Sum of red, green and blue over them.
    pub sum: [f32; 3],
}

impl Bin {
    /// The mean of its colours.
    pub fn mean(&self) -> Rgb {
        self.sum.map(|sum| (sum / self.count).round().clamp(0.0, 255.0) as u8)
    }
}

/// A colour histogram of 16 levels per channel (4096 bins), sparse.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Histogram {
    bins: BTreeMap<u16, Bin>,
}

impl Histogram {
    /// Adds pixels of one colour.
    pub(super) fn add_many(&mut self, colour: Rgb, pixels: u32) {
        let bin = self.bins.entry(index(colour)).or_default();
        bin.count += pixels as f32;
        for (sum, channel) in bin.sum.iter_mut().zip(colour) {
            *sum += pixels as f32 * f32::from(channel);
        }
    }

    /// Adds another histogram, scaled by `share`.
    pub fn add_scaled(&mut self, other: &Self, share: f32) {
        for (&index, bin) in &other.bins {
            let mine = self.bins.entry(index).or_default();
            mine.count += share * bin.count;
            for (sum, other) in mine.sum.iter_mut().zip(bin.sum) {
                *sum += share * other;
            }
        }
    }

    /// Drops the bins below this share of the total.
    pub fn forget_below(&mut self, share: f32) {
        let least = share * self.total();
        self.bins.retain(|_, bin| bin.count >= least);
    }

    /// Number of pixels.
    pub fn total(&self) -> f32 {
        self.bins.values().map(|bin| bin.count).sum()
    }

    /// The bins by ascending index, `r·256 + g·16 + b` of the quantised levels.
    pub fn bins(&self) -> impl Iterator<Item = (u16, &Bin)> {
        self.bins.iter().map(|(&index, bin)| (index, bin))
    }

    /// The mean colour of the fullest bin, the lower index on a tie; `None` if empty.
    pub fn dominant(&self) -> Option<Rgb> {
        self.dominant_at_least(1.0).first().copied()
    }

    /// The mean colours of all bins at least `share` times as full as the fullest, fullest first.
    pub fn dominant_at_least(&self, share: f32) -> Vec<Rgb> {
        let fullest = self.bins.values().map(|bin| bin.count).fold(0.0, f32::max);
        let mut full: Vec<_> =
            self.bins.iter().filter(|(_, bin)| bin.count > 0.0 && bin.count >= share * fullest).collect();
        full.sort_by(|(i, a), (j, b)| b.count.total_cmp(&a.count).then(i.cmp(j)));
        full.into_iter().map(|(_, bin)| bin.mean()).collect()
    }

    /// The share of `area` pixels with the colours of `other` that this histogram can contain: 0..=1.
    pub fn holds(&self, other: &Self, area: f32) -> f32 {
        let scale = area / other.total().max(f32::MIN_POSITIVE);
        let due = other.bins.iter().map(|(index, bin)| (scale * bin.count, self.bins.get(index)));
        let held: f32 = due.map(|(due, mine)| mine.map_or(0.0, |mine| mine.count.min(due))).sum();
        (held / area.max(f32::MIN_POSITIVE)).min(1.0)
    }

    /// The histogram as it is compared with others; making it takes longer than comparing.
    pub fn smoothed(&self) -> SmoothedHistogram {
        let total = self.total().max(f32::MIN_POSITIVE);
        let mut shares = Vec::with_capacity(8 * self.bins.len());
        for (&index, bin) in &self.bins {
            let level = |shift: u16| (index >> shift) & 15;
            for (dr, dg, db) in (0..8).map(|bits: u16| (bits & 1, bits >> 1 & 1, bits >> 2)) {
                let cell = ((level(8) + dr) >> 1) * 81 + ((level(4) + dg) >> 1) * 9 + ((level(0) + db) >> 1);
                shares.push((cell | (dr | dg << 1 | db << 2) << 10, bin.count / total / 8.0));
            }
        }
        // Stable, so that the shares of a cell are added in the order of the bins.
        shares.sort_by_key(|&(cell, _)| cell);
        shares.dedup_by(|(cell, share), (kept, sum)| {
            let is_same = cell == kept;
            if is_same {
                *sum += *share;
            }
            is_same
        });
        SmoothedHistogram { shares }
    }
}

/// Normalised counts of a histogram over coarser, overlapping bins, so that noise that moves a colour across a bin's edge
/// has little effect.
#[derive(Clone, Debug, Default)]
pub struct SmoothedHistogram {
    /// The coarser bins that are not empty, ascending, and their shares.
    shares: Vec<(u16, f32)>,
}

impl SmoothedHistogram {
    /// Appearance similarity: the intersection of the two, 0..=1.
    pub fn likeness(&self, other: &Self) -> f32 {
        let mut theirs = other.shares.iter().peekable();
        let common = self.shares.iter().filter_map(|&(cell, mine)| {
            while theirs.next_if(|(other, _)| *other < cell).is_some() {}
            theirs.next_if(|(other, _)| *other == cell).map(|&(_, theirs)| mine.min(theirs))
        });
        common.sum()
    }
}

/// The bin of a colour.
fn index(colour: Rgb) -> u16 {
    let [r, g, b] = colour.map(|channel| u16::from(channel >> 4));
    r << 8 | g << 4 | b
}

/// Accumulates the histogram of one region at a time.
pub(super) struct Tally {
    /// Number of pixels and sums of red, green and blue of each bin.
    bins: Vec<[u64; 4]>,
    /// The bins that are not empty.
    touched: Vec<u16>,
}

impl Default for Tally {
    fn default() -> Self {
        Self { bins: vec![[0; 4]; 1 << 12], touched: Vec::new() }
    }
}

impl Tally {
    /// Adds pixels, three bytes each.
    pub(super) fn add(&mut self, rgb: &[u8]) {
        for pixel in rgb.chunks_exact(3) {
            let index = index([pixel[0], pixel[1], pixel[2]]);
            let bin = &mut self.bins[usize::from(index)];
            if bin[0] == 0 {
                self.touched.push(index);
            }
            bin[0] += 1;
            for (sum, &channel) in bin[1..].iter_mut().zip(pixel) {
                *sum += u64::from(channel);
            }
        }
    }

    /// Takes the histogram and resets the sums for the next region.
    pub(super) fn take(&mut self) -> Histogram {
        let bins = self.touched.drain(..).map(|index| {
            let [count, r, g, b] = std::mem::take(&mut self.bins[usize::from(index)]);
            (index, Bin { count: count as f32, sum: [r, g, b].map(|sum| sum as f32) })
        });
        Histogram { bins: bins.collect() }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use proptest::prelude::*;

    use super::*;

    pub(crate) fn histogram(colours: &[(Rgb, u32)]) -> Histogram {
        let mut histogram = Histogram::default();
        for &(colour, count) in colours {
            histogram.add_many(colour, count);
        }
        histogram
    }

    fn likeness(a: &Histogram, b: &Histogram) -> f32 {
        a.smoothed().likeness(&b.smoothed())
    }

    proptest! {
        #[test]
        fn the_likeness_is_the_common_share_of_the_eight_coarser_grids(
            one in prop::collection::vec((prop::array::uniform3(0_u8..90), 1_u32..20), 1..30),
            other in prop::collection::vec((prop::array::uniform3(0_u8..90), 1_u32..20), 1..30),
        ) {
            // Each grid has cells of two bins per channel, and is moved by a bin along some of the channels.
            let shares = |histogram: &Histogram, moved: [u16; 3]| {
                let mut shares = BTreeMap::new();
                for (index, bin) in histogram.bins() {
                    let levels = [index >> 8, index >> 4 & 15, index & 15];
                    let cell = [0, 1, 2].map(|channel| (levels[channel] + moved[channel]) >> 1);
                    *shares.entry(cell).or_insert(0.0) += bin.count / histogram.total() / 8.0;
                }
                shares
            };
            let (one, other) = (histogram(&one), histogram(&other));
            let mut expected = 0.0;
            for moved in (0..8).map(|bits: u16| [bits & 1, bits >> 1 & 1, bits >> 2]) {
                let theirs = shares(&other, moved);
                let common = |(cell, mine): (&[u16; 3], &f32)| theirs.get(cell).map(|theirs| mine.min(*theirs));
                expected += shares(&one, moved).iter().filter_map(common).sum::<f32>();
            }
            prop_assert!((likeness(&one, &other) - expected).abs() < 1e-5, "{expected}");
        }
    }

    #[test]
    fn the_dominant_colour_is_the_mean_of_the_fullest_bin() {
        let mut colours = histogram(&[([200, 10, 10], 5), ([202, 12, 14], 5), ([10, 10, 200], 9)]);
        assert_eq!(colours.dominant(), Some([201, 11, 12]));
        colours.add_scaled(&histogram(&[([10, 10, 200], 1)]), 1.0);
        assert_eq!(colours.dominant(), Some([10, 10, 200]), "a tie goes to the lower index");
        assert_eq!(Histogram::default().dominant(), None);
    }

    #[test]
    fn dominant_colours_are_the_bins_at_least_half_as_full() {
        let colours = histogram(&[([0, 0, 0], 10), ([100, 0, 0], 5), ([0, 100, 0], 4)]);
        assert_eq!(colours.dominant_at_least(0.5), vec![[0, 0, 0], [100, 0, 0]]);
    }

    #[test]
    fn delta_e_agrees_with_known_lab_values() {
        // sRGB red and green in Lab (D65): (53.24, 80.09, 67.20) and (87.73, −86.18, 83.18).
        assert!((delta_e([255, 0, 0], [0, 255, 0]) - 170.6).abs() < 0.2);
        assert!((delta_e([0, 0, 0], [255, 255, 255]) - 100.0).abs() < 0.1);
        assert_eq!(delta_e([12, 34, 56], [12, 34, 56]), 0.0);
    }

    #[test]
    fn likeness_is_one_for_equal_and_zero_for_disjoint_histograms() {
        let red = histogram(&[([200, 0, 0], 10)]);
        assert!((likeness(&red, &histogram(&[([200, 0, 0], 3)])) - 1.0).abs() < 1e-5);
        assert_eq!(likeness(&red, &histogram(&[([0, 0, 200], 3)])), 0.0);
        let across_the_edge = likeness(&red, &histogram(&[([207, 0, 0], 5), ([208, 0, 0], 5)]));
        assert!(across_the_edge > 0.7, "{across_the_edge}");
    }

    #[test]
    fn a_scaled_histogram_adds_its_share_of_pixels_and_colours() {
        let mut colours = histogram(&[([200, 10, 20], 4)]);
        colours.add_scaled(&histogram(&[([202, 12, 24], 8), ([0, 0, 100], 2)]), 0.25);
        let bins: Vec<(u16, Bin)> = colours.bins().map(|(index, bin)| (index, *bin)).collect();
        let blue = Bin { count: 0.5, sum: [0.0, 0.0, 50.0] };
        let red = Bin { count: 6.0, sum: [1204.0, 64.0, 128.0] };
        assert_eq!(bins, [(6, blue), (12 << 8 | 1, red)]);
        assert_eq!(colours.total(), 6.5);
    }

    #[test]
    fn rare_colours_are_forgotten() {
        let mut colours = histogram(&[([0, 0, 0], 75), ([100, 0, 0], 20), ([0, 100, 0], 5)]);
        let all = colours.clone();
        colours.forget_below(0.05);
        assert_eq!(colours, all);
        colours.forget_below(0.06);
        assert_eq!(colours, histogram(&[([0, 0, 0], 75), ([100, 0, 0], 20)]));
    }

    #[test]
    fn a_histogram_holds_the_pixels_of_an_object_as_far_as_it_has_their_colours() {
        let group = histogram(&[([0, 0, 0], 60), ([100, 0, 0], 10), ([0, 0, 200], 500)]);
        // Of 100 pixels 50 are black, 30 red and 20 green; of the red ones there are 10.
        let object = histogram(&[([0, 0, 0], 5), ([100, 0, 0], 3), ([0, 100, 0], 2)]);
        assert_eq!(group.holds(&object, 100.0), 0.6);
        assert_eq!(group.holds(&object, 20.0), 0.8);
        assert_eq!(group.holds(&object, 400.0), 70.0 / 400.0);
        assert_eq!(group.holds(&Histogram::default(), 100.0), 0.0);
    }

    /// A histogram counts a colour in eight grids of cells two levels wide, offset by a level per channel: colours a
    /// level apart in a channel share half of them.
    #[test]
    fn likeness_halves_with_each_channel_a_level_apart() {
        let colour = |levels: [u8; 3]| histogram(&[(levels.map(|level| 16 * level), 7)]);
        for one in [[7, 8, 3], [0, 15, 4], [2, 1, 9]] {
            let histogram = colour(one);
            for index in 0..1 << 12 {
                let other = [(index >> 8) as u8, (index >> 4 & 15) as u8, (index & 15) as u8];
                let share =
                    |(a, b): (u8, u8)| [1.0, 0.5].get(usize::from(a.abs_diff(b))).copied().unwrap_or(0.0);
                let expected: f32 = one.into_iter().zip(other).map(share).product();
                assert_eq!(likeness(&histogram, &colour(other)), expected, "{one:?} {other:?}");
            }
        }
    }
}
