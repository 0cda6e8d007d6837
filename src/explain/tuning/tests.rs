#![allow(clippy::unwrap_used)]

use super::*;
use crate::explain::pixel::PixelHistory;
use crate::settings::{Preset, Space};

/// A wall with a swaying branch in front, and from frame 300 on a person in dark clothes.
fn values(frames: u32, parameters: &Parameters) -> Vec<PixelValue> {
    let mut seed = 99_u32;
    let mut noise = move || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((seed >> 16) % 11) as u8
    };
    let colour = |n: u32| match n {
        300..340 => [50, 44, 70],
        _ if (n / 9).is_multiple_of(3) => [92, 128, 64],
        _ => [168, 160, 150],
    };
    (0..frames)
        .map(|n| {
            let wobble = noise();
            parameters.value(colour(n).map(|level| level + wobble))
        })
        .collect()
}

fn parameters() -> Parameters {
    Parameters { warm_up: 20, ..Parameters::new(&Settings::preset(Preset::Plain)) }
}

/// The verdict by the reference implementation: `Pixel::update` through all values.
fn reference_verdict(values: &[PixelValue], parameters: &Parameters) -> bool {
    let mut pixel = Pixel::unseen(parameters.k);
    (1..).zip(values).map(|(t, &value)| pixel.update(value, t, parameters).foreground).last().unwrap()
}

#[test]
fn every_cell_of_every_map_equals_a_run_of_the_reference() {
    let gray = Parameters { space: Space::Gray, ..parameters() };
    let feedback =
        Parameters::new(&Settings { hold: 0.2, restless_t: 0.9, ..Settings::preset(Preset::Plain) });
    let (mut foreground, mut background) = (0, 0);
    for (parameters, frames) in [(parameters(), 312), (gray, 204), (feedback, 204)] {
        let values = values(frames, &parameters);
        for (at, x) in TunableSetting::ALL.into_iter().enumerate() {
            for y in TunableSetting::ALL
                .into_iter()
                .skip(at + 1)
                .chain(TunableSetting::ALL.into_iter().take(at.min(1)))
            {
                let map = map(&values, &parameters, [x, y]);
                // Every seventh cell: a run for each would take long.
                for cell in (0..map.foreground.len()).step_by(7) {
                    let (column, row) = (cell % map.axes[0].values.len(), cell / map.axes[0].values.len());
                    let there = x.with(&parameters, map.axes[0].values[column]);
                    let there = y.with(&there, map.axes[1].values[row]);
                    let expected = reference_verdict(&values, &there);
                    assert_eq!(map.is_foreground(column, row), expected, "{x:?} {y:?} {column} {row}");
                    foreground += usize::from(expected);
                    background += usize::from(!expected);
                }
            }
        }
    }
    assert!(foreground > 200 && background > 200, "both occur: {foreground}, {background}");
}

#[test]
fn the_first_frame_is_background_everywhere() {
    let values = values(1, &parameters());
    let map = map(&values, &parameters(), [TunableSetting::Alpha, TunableSetting::T]);
    assert_eq!(map.foreground_share(), 0.0);
    for setting in TunableSetting::ALL {
        assert_eq!(flip(&values, &parameters(), setting).value, None, "{setting:?}");
    }
}

#[test]
fn a_flip_changes_the_verdict_and_nothing_nearer_does() {
    let parameters = parameters();
    let mut found = 0;
    for frames in [40, 150, 301, 310, 325, 339, 345, 400] {
        let values = values(frames, &parameters);
        let now = reference_verdict(&values, &parameters);
        for setting in TunableSetting::ALL {
            let flip = flip(&values, &parameters, setting);
            let from = setting.get(&parameters);
            let Some(value) = flip.value else {
                // None of the map's values flips either.
                for value in SettingAxis::new(setting, from).values {
                    let there = setting.with(&parameters, value);
                    assert!(
                        value != value.clamp(setting.range().0, setting.range().1)
                            || reference_verdict(&values, &there) == now
                    );
                }
                continue;
            };
            found += 1;
            assert_eq!(flip.above, value > from);
            assert_ne!(
                reference_verdict(&values, &setting.with(&parameters, value)),
                now,
                "{setting:?} {value}"
            );
            // Up to the value, apart from rounding to three digits, the verdict does not flip.
            let reach = setting.scaled(value) - setting.scaled(from);
            for step in 0..=20 {
                let near = setting.unscaled(setting.scaled(from) + reach * f64::from(step) / 20.0);
                let near = if setting == TunableSetting::K { from } else { near };
                if (near / value - 1.0).abs() < 0.01 {
                    continue;
                }
                assert_eq!(
                    reference_verdict(&values, &setting.with(&parameters, near)),
                    now,
                    "{setting:?} {value} {near}"
                );
            }
        }
    }
    assert!(found > 12, "{found}");
}

/// The nearest flip on one side, by linear search.
fn linear_search(
    values: &[PixelValue],
    parameters: &Parameters,
    setting: TunableSetting,
    above: bool,
) -> Option<f32> {
    let now = reference_verdict(values, parameters);
    let flips = |value: f32| reference_verdict(values, &setting.with(parameters, value)) != now;
    let (from, (low, high)) = (setting.get(parameters), setting.range());
    let end = if above { high } else { low };
    if setting == TunableSetting::K {
        let one = if above { 1.0 } else { -1.0 };
        let mut all = (1..=(end - from).abs() as usize).map(|step| from + one * step as f32);
        return all.find(|&k| flips(k)).filter(|_| above == (end > from));
    }
    if above == (from >= end) {
        return None;
    }
    let (start, width) = (setting.scaled(from), setting.scaled(end) - setting.scaled(from));
    let steps = (0..=24).map(|step| match step {
        0 => from,
        24 => end,
        _ => setting.unscaled(start + width * f64::from(step) / 24.0),
    });
    let steps: Vec<f32> = steps.collect();
    let step = (1..=24).find(|&step| flips(steps[step]))?;
    let (mut inner, mut outer) = (steps[step - 1], steps[step]);
    for _ in 0..14 {
        let middle = setting.unscaled(f64::midpoint(setting.scaled(inner), setting.scaled(outer)));
        *(if flips(middle) { &mut outer } else { &mut inner }) = middle;
    }
    let how = if above { Rounding::Up } else { Rounding::Down };
    let mut short = (3..=5).map(|digits| rounded(outer, digits, how));
    short.find(|&value| (low..=high).contains(&value) && flips(value)).or(Some(outer))
}

#[test]
fn a_flip_equals_the_result_of_a_linear_search() {
    let gray = Parameters { space: Space::Gray, ..parameters() };
    let at_the_end = Parameters { t: 0.999, k: 1, ..parameters() };
    let mut found = 0;
    for (parameters, frames) in
        [(parameters(), 301), (parameters(), 325), (parameters(), 345), (gray, 204), (at_the_end, 310)]
    {
        let values = values(frames, &parameters);
        for setting in TunableSetting::ALL {
            let flip = flip(&values, &parameters, setting);
            let [below, above] =
                [false, true].map(|above| linear_search(&values, &parameters, setting, above));
            let from = setting.scaled(setting.get(&parameters));
            let distance = |value: f32| (setting.scaled(value) - from).abs();
            let expected = match (below, above) {
                (Some(below), Some(above)) if distance(above) < distance(below) => Some(above),
                (below, above) => below.or(above),
            };
            assert_eq!(flip.value.map(f32::to_bits), expected.map(f32::to_bits), "{setting:?} {frames}");
            found += usize::from(expected.is_some());
        }
    }
    assert!(found > 6, "{found}");
}

#[test]
fn the_flip_of_lambda_is_the_distance_of_the_nearest_background_component() {
    // Forty steady frames, then one step: λ has to reach the distance of the value.
    let parameters = parameters();
    let mut colours = vec![[100_u8; 3]; 40];
    colours.push([118; 3]);
    let history = PixelHistory::of_colours((0, 0), parameters, (1..).zip(colours));
    let values: Vec<_> = history.states.iter().map(|state| state.value).collect();
    let sigma = history.before(40).unwrap().components()[0].sigma();
    let distance = 18.0 * 3_f32.sqrt() / sigma;
    assert!(history.states[40].outcome.foreground && distance > parameters.lambda);
    let flip = flip(&values, &parameters, TunableSetting::Lambda);
    let value = flip.value.unwrap();
    assert!(flip.above && value >= distance && value < distance * 1.01, "{value} {distance}");
    assert_eq!(flip.words(), format!("λ ≥ {value}"));
    let no = super::flip(&values, &parameters, TunableSetting::T);
    assert_eq!(no.words(), "no value of T");
}

#[test]
fn an_axis_includes_the_present_value_and_only_valid_values() {
    for (setting, present) in [
        (TunableSetting::Alpha, 0.01),
        (TunableSetting::Alpha, 0.9),
        (TunableSetting::Alpha, 0.000_01),
        (TunableSetting::T, 0.999),
        (TunableSetting::K, 5.0),
        (TunableSetting::Lambda, 0.5),
        (TunableSetting::InitialSigma, 128.0),
    ] {
        let axis = SettingAxis::new(setting, present);
        assert!((-0.001..=1.001).contains(&axis.share_of(present)), "{setting:?}");
        assert!(axis.values.is_sorted_by(|a, b| a < b));
        for (cell, &value) in axis.values.iter().enumerate() {
            let mut settings = Settings::preset(Preset::Plain);
            setting.set(&mut settings, value).unwrap();
            assert_eq!(setting.get(&Parameters::new(&settings)), value);
            assert_eq!(axis.cell_at(axis.share_of(value)), cell, "{setting:?} {value}");
        }
    }
    assert!(TunableSetting::T.set(&mut Settings::default(), 1.5).is_err());
}

#[test]
fn rounding_follows_its_direction() {
    assert_eq!(rounded(0.012_345, 3, Rounding::Up), 0.0124);
    assert_eq!(rounded(0.012_345, 3, Rounding::Down), 0.0123);
    assert_eq!(rounded(3.0, 3, Rounding::Up), 3.0);
    assert_eq!(rounded(12_345.0, 3, Rounding::Nearest), 12_300.0);
}
