//! Numbers in tables: nine significant digits, from which every f32 is restored exactly, and times.

/// The number as in C's `%.9g`: at most nine significant digits, no trailing zeros, an exponent only below 10⁻⁴ and
/// from 10⁹ on.
pub fn significant(value: impl Into<f64>) -> String {
    const DIGITS: i32 = 9;
    let value = value.into();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return if value.is_nan() {
            "nan"
        } else if value > 0.0 {
            "inf"
        } else {
            "-inf"
        }
        .to_owned();
    }
    // Rounding to nine digits can carry into the next power of ten, so the exponent is read after it.
    let rounded = format!("{value:.8e}");
    let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..DIGITS).contains(&exponent) {
        let decimals = (DIGITS - 1 - exponent) as usize;
        return without_trailing_zeros(&format!("{value:.decimals$}")).to_owned();
    }
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{}e{sign}{:02}", without_trailing_zeros(mantissa), exponent.abs())
}

/// The number that is read back from the text of [`significant`].
pub fn rounded(value: f32) -> f64 {
    // What it writes is a number.
    significant(value).parse().unwrap_or_else(|_| f64::from(value))
}

/// Seconds rounded to microseconds, for JSON, which writes as many digits as there are.
pub fn microseconds(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e6
}

fn without_trailing_zeros(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::significant;

    #[test]
    fn numbers_are_written_as_in_c() {
        // The right side is the output of `printf("%.9g")`.
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (-2.5, "-2.5"),
            (0.1, "0.1"),
            (f64::from(0.1_f32), "0.100000001"),
            (123_456_789.0, "123456789"),
            (1_234_567_890.0, "1.23456789e+09"),
            (999_999_999.6, "1e+09"),
            (0.000_1, "0.0001"),
            (0.000_099_999_999_99, "0.0001"),
            (0.000_012_345_678_912, "1.23456789e-05"),
            (1.0 / 3.0, "0.333333333"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(significant(value), text);
        }
    }

    #[test]
    fn every_f32_is_restored_exactly() {
        let mut bits = 1_u32;
        for _ in 0..200_000 {
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let value = f32::from_bits(bits);
            if value.is_finite() {
                assert_eq!(significant(value).parse::<f32>().unwrap(), value);
            }
        }
    }
}
