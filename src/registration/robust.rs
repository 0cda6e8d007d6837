//! Robust least squares: the median, and the scale of Tukey's biweight.

/// The median, the upper one of an even count; 0 if empty. Reorders the numbers.
pub(super) fn median(numbers: &mut [f32]) -> f32 {
    let middle = numbers.len() / 2;
    if numbers.is_empty() { 0.0 } else { *numbers.select_nth_unstable_by(middle, f32::total_cmp).1 }
}

/// The scale of Tukey's biweight: residuals beyond it have weight 0. Computed from the absolute residuals, assuming
/// Gaussian noise.
pub(super) fn reach(sizes: &mut [f32]) -> f32 {
    4.685 * 1.4826 * median(sizes)
}
