//! One implementation of the exponential for scalar and vector code, so that results do not depend on the machine.

// x = n·ln 2 + r with |r| ≤ ln 2 / 2; ln 2 is split in two parts so that r is exact.
pub(super) const LN_2_HIGH: f32 = 0.693_359_4;
pub(super) const LN_2_LOW: f32 = -2.121_944_4e-4;
/// Adding and subtracting 1.5·2²³ rounds to the nearest integer without a branch.
pub(super) const ROUND: f32 = 12_582_912.0;
/// The exponential of a smaller number is subnormal or 0 in f32.
pub(super) const LEAST: f32 = -87.0;
/// Minimax polynomial of (eʳ − 1 − r) / r² (Cephes, S. Moshier), from the highest power down.
pub(super) const COEFFICIENTS: [f32; 6] =
    [1.987_569_1e-4, 1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 5e-1];

/// eˣ for x ≤ 0 in f32, within 2 units in the last place; 0 below −87, the limit of the range of f32.
///
/// It uses only additions, multiplications and bit shifts, each rounded once and in this order, so that any processor
/// and any vector width gives the same bits.
#[inline(always)]
pub fn exp_of_negative(x: f32) -> f32 {
    let clamped = if x >= LEAST { x } else { LEAST };
    let n = (clamped * std::f32::consts::LOG2_E + ROUND) - ROUND;
    let r = (clamped - n * LN_2_HIGH) - n * LN_2_LOW;
    let p = COEFFICIENTS[1..].iter().fold(COEFFICIENTS[0], |p, coefficient| p * r + coefficient);
    let e_to_r = p * (r * r) + r + 1.0;
    let two_to_n = f32::from_bits(((n as i32 + 127) as u32) << 23);
    if x >= LEAST { e_to_r * two_to_n } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::exp_of_negative;

    #[test]
    fn agrees_with_f64_to_two_units_in_the_last_place() {
        for step in 0..870_000 {
            let x = -(step as f32) / 10_000.0;
            let truth = f64::from(x).exp();
            let error = (f64::from(exp_of_negative(x)) - truth).abs() / truth;
            assert!(error < 2.0 * f64::from(f32::EPSILON), "e^{x}: relative error {error:e}");
        }
    }

    #[test]
    fn ends_are_exact() {
        assert_eq!(exp_of_negative(0.0), 1.0);
        assert_eq!(exp_of_negative(-87.1), 0.0);
        assert_eq!(exp_of_negative(f32::NEG_INFINITY), 0.0);
    }
}
