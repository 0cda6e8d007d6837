//! Numbers of pixels in which two foreground masks agree and differ.

use crate::frame::Mask;
use crate::truth::decisions::Decisions;

/// Numbers of foreground pixels in two masks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct MaskAgreement {
    /// In the first mask only.
    pub(crate) first: usize,
    /// In the second mask only.
    pub(crate) second: usize,
    /// In both masks.
    pub(crate) both: usize,
}

/// The agreement of a mask with another one, from its decisions against that.
impl From<Decisions> for MaskAgreement {
    fn from(Decisions { tp, fp, fn_, .. }: Decisions) -> Self {
        let [first, second, both] = [fp, fn_, tp].map(|count| count as usize);
        Self { first, second, both }
    }
}

impl MaskAgreement {
    /// Counts the pixels of two masks of equal size.
    pub(crate) fn of(first: &Mask, second: &Mask) -> Self {
        let mut counts = Self::default();
        // Chunks small enough for byte sums, which the compiler vectorises.
        for (a, b) in first.data.chunks(128).zip(second.data.chunks(128)) {
            let count = |of: fn(u8, u8) -> u8| {
                a.iter().zip(b).map(|(&a, &b)| of(a, b) & 1).fold(0_u8, u8::wrapping_add)
            };
            counts.first += usize::from(count(|a, b| a & !b));
            counts.second += usize::from(count(|a, b| b & !a));
            counts.both += usize::from(count(|a, b| a & b));
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Size;

    #[test]
    fn every_pixel_counts_once() {
        let size = Size::new(37, 29);
        let mask = |step: usize| Mask {
            size,
            data: (0..size.pixels()).map(|at| if at % step < 2 { 255 } else { 0 }).collect(),
        };
        let (a, b) = (mask(3), mask(5));
        let count = |of: fn(bool, bool) -> bool| {
            (0..size.pixels()).filter(|&at| of(a.data[at] > 0, b.data[at] > 0)).count()
        };
        let expected = MaskAgreement {
            first: count(|a, b| a && !b),
            second: count(|a, b| b && !a),
            both: count(|a, b| a && b),
        };
        assert_eq!(MaskAgreement::of(&a, &b), expected);
        let all = Mask { size, data: vec![255; size.pixels()] };
        assert_eq!(
            MaskAgreement::of(&all, &all),
            MaskAgreement { both: size.pixels(), ..MaskAgreement::default() }
        );
    }
}
