//! Shares of counts, for the two conventions of an empty whole.

/// part / whole for `part <= whole`, 0..=1; 0 if there is nothing to count.
pub(super) fn share_or_zero(part: u64, whole: u64) -> f64 {
    share(part, whole).unwrap_or(0.0)
}

/// part / whole for `part <= whole`, 0..=1; 1 if there is nothing to count.
pub(super) fn share_or_one(part: u64, whole: u64) -> f64 {
    share(part, whole).unwrap_or(1.0)
}

fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_quotients() {
        for (part, whole, expected) in [(0, 4, 0.0), (1, 4, 0.25), (4, 4, 1.0)] {
            assert_eq!(share_or_zero(part, whole), expected, "{part} of {whole}");
            assert_eq!(share_or_one(part, whole), expected, "{part} of {whole}");
        }
    }

    #[test]
    fn the_share_of_nothing_is_the_one_in_the_name() {
        assert_eq!((share_or_zero(0, 0), share_or_one(0, 0)), (0.0, 1.0));
    }
}
