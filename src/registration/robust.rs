//! What robust least squares need.

/// The median, the upper one of an even count; 0 of nothing. The numbers are left in another order.
pub(super) fn median(numbers: &mut [f32]) -> f32 {
    let middle = numbers.len() / 2;
    if numbers.is_empty() { 0.0 } else { *numbers.select_nth_unstable_by(middle, f32::total_cmp).1 }
}

/// The residual from which on Tukey's biweight is 0, for Gaussian noise, from the sizes of all residuals.
pub(super) fn reach(sizes: &mut [f32]) -> f32 {
    4.685 * 1.4826 * median(sizes)
}
