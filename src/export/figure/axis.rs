//! Axes: the mapping from values to positions, and tick values.

use super::super::number::significant;

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Its name and unit, as written next to it.
    pub name: String,
    /// The values at its ends.
    pub ends: (f64, f64),
    /// Whether the scale is logarithmic.
    pub logarithmic: bool,
    /// The tick values and their labels.
    pub ticks: Vec<(f64, String)>,
}

impl Axis {
    /// An axis with about `most` round numbers.
    pub fn new(name: impl Into<String>, ends: (f64, f64), most: usize) -> Self {
        let round = ticks(ends.0, ends.1, most).into_iter();
        let ticks = round.map(|value| (value, written(value))).collect();
        Self { name: name.into(), ends, logarithmic: false, ticks }
    }

    /// A logarithmic axis between two positive values, with a tick at each power of ten and a label at every `nth`.
    pub fn logarithmic(name: impl Into<String>, ends: (f64, f64), nth: i32) -> Self {
        let (from, to) = (ends.0.log10() - 1e-9, ends.1.log10() + 1e-9);
        let powers = (from.ceil() as i32)..=(to.floor() as i32);
        let ticks = powers
            .map(|power| {
                (
                    10_f64.powi(power),
                    if power % nth.max(1) == 0 { power_of_ten(power) } else { String::new() },
                )
            })
            .collect();
        Self { name: name.into(), ends, logarithmic: true, ticks }
    }

    /// The same axis with these ticks.
    pub fn with_ticks(self, ticks: Vec<(f64, String)>) -> Self {
        Self { ticks, ..self }
    }

    /// The position of a value, 0 at the first end and 1 at the other.
    pub fn share(&self, value: f64) -> f64 {
        let scaled = |value: f64| if self.logarithmic { value.max(f64::MIN_POSITIVE).ln() } else { value };
        let (from, to) = (scaled(self.ends.0), scaled(self.ends.1));
        if to > from { (scaled(value) - from) / (to - from) } else { 0.5 }
    }
}

/// Round values within `min..=max`, at most about `most` of them.
pub fn ticks(min: f64, max: f64, most: usize) -> Vec<f64> {
    let span = max - min;
    if !(span > 0.0 && span.is_finite()) {
        return vec![min];
    }
    let raw = span / most.max(1) as f64;
    let power = 10_f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|&step| step >= raw).unwrap_or(raw);
    let (first, last) = ((min / step - 1e-9).ceil() as i64, (max / step + 1e-9).floor() as i64);
    (first..=last).map(|n| n as f64 * step).collect()
}

/// A round number without rounding errors, with a true minus sign.
pub fn written(value: f64) -> String {
    let rounded = format!("{value:.6}").parse().unwrap_or(value);
    significant(rounded).replace('-', "−")
}

/// `0.001`, `1e−7`. The typeface has no superscript minus.
pub fn power_of_ten(power: i32) -> String {
    if power >= -4 { written(10_f64.powi(power)) } else { format!("1e−{}", -power) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks(0.0, 795.0, 5), [0.0, 200.0, 400.0, 600.0]);
        assert_eq!(ticks(3.2, 9.1, 6), [4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
        assert_eq!(ticks(5.0, 5.0, 4), [5.0]);
        let labels: Vec<_> = Axis::new("w", (0.0, 0.3), 3).ticks.into_iter().map(|tick| tick.1).collect();
        assert_eq!(labels, ["0", "0.1", "0.2", "0.3"]);
    }

    #[test]
    fn positions_are_between_the_ends_on_either_scale() {
        let linear = Axis::new("X", (0.0, 255.0), 5);
        assert_eq!((linear.share(0.0), linear.share(51.0), linear.share(255.0)), (0.0, 0.2, 1.0));
        let decades = Axis::logarithmic("ρ", (1e-4, 1.0), 1);
        assert!((decades.share(1e-2) - 0.5).abs() < 1e-12);
        let labels: Vec<_> = decades.ticks.iter().map(|tick| tick.1.as_str()).collect();
        assert_eq!(labels, ["0.0001", "0.001", "0.01", "0.1", "1"]);
        assert_eq!(Axis::logarithmic("ρ", (1e-6, 1e-5), 1).ticks[0].1, "1e−6");
        assert_eq!(Axis::new("X", (3.0, 3.0), 5).share(3.0), 0.5);
    }
}
