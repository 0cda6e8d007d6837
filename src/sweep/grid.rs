//! The combinations of a sweep: the values of some settings, each with each.

use std::collections::HashSet;

use crate::settings::{Kind, Setting, SettingError, Settings, Value};

/// Largest number of combinations.
const MAX_COMBINATIONS: usize = 100_000;

/// An error of a grid.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum GridError {
    /// A value that the setting cannot have, or an unknown setting.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A text that is not an axis.
    #[error("--grid cannot be `{text}`: {why}")]
    Axis {
        /// The text.
        text: String,
        /// The cause and a remedy.
        why: String,
    },
    /// More combinations than a sweep can have.
    #[error("the grid has more than {MAX_COMBINATIONS} combinations; use fewer values")]
    Size,
}

/// A setting and its values in the order in which they were given.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The setting.
    pub setting: &'static Setting,
    /// Its values, each once, at least one.
    pub values: Vec<Value>,
}

impl Axis {
    /// The axis of a text such as `k=3,4,5`, `t=0.5..0.9:5` (five values at equal steps) or `alpha=log:0.0005..0.05:9`
    /// (at equal ratios).
    pub fn of_text(text: &str) -> Result<Self, GridError> {
        let refused = |why: &str| GridError::Axis { text: text.to_owned(), why: why.to_owned() };
        let (name, values) =
            text.split_once('=').ok_or_else(|| refused("give a setting and its values, as in k=3,4,5"))?;
        let name = name.trim();
        let setting = Setting::named(name).ok_or_else(|| SettingError::Unknown(name.to_owned()))?;
        let texts = match values.split_once("..") {
            Some((first, rest)) => range(first, rest, setting).map_err(refused)?,
            None => values.split(',').map(|value| value.trim().to_owned()).collect(),
        };
        let mut values: Vec<Value> = Vec::new();
        let mut distinct = HashSet::new();
        for text in &texts {
            let mut settings = Settings::default();
            setting.set_text(&mut settings, text)?;
            let value = setting.get(&settings);
            if !distinct.insert(value.to_string()) {
                return Err(refused(&format!("it has the value {value} twice; use fewer values")));
            }
            values.push(value);
        }
        Ok(Self { setting, values })
    }
}

/// The texts of the values from `first` to the end of `rest`, which is `LAST:COUNT`.
fn range(first: &str, rest: &str, setting: &Setting) -> Result<Vec<String>, &'static str> {
    const FORM: &str = "a range is FIRST..LAST:COUNT, as in 0.5..0.9:5, or log:FIRST..LAST:COUNT";
    let whole = match setting.kind {
        Kind::Integer { .. } | Kind::OddSize { .. } => true,
        Kind::Real { .. } => false,
        Kind::Choice(_) | Kind::Span { .. } => {
            return Err("this setting has no ranges; list its values with commas");
        }
    };
    let (logarithmic, first) = match first.trim().strip_prefix("log:") {
        Some(first) => (true, first),
        None => (false, first),
    };
    let (last, count) = rest.split_once(':').ok_or(FORM)?;
    let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite()).ok_or(FORM);
    let (first, last) = (number(first)?, number(last)?);
    let count: usize = count.trim().parse().map_err(|_| FORM)?;
    if count < 2 {
        return Err("a range has at least 2 values");
    }
    if count > MAX_COMBINATIONS {
        return Err("it has more values than a sweep can have; use fewer");
    }
    if logarithmic && (first <= 0.0 || last <= 0.0) {
        return Err("the ends of a logarithmic range are greater than 0");
    }
    let value = |at: usize| {
        let share = at as f64 / (count - 1) as f64;
        // The ends are exact.
        match at {
            0 => first,
            _ if at == count - 1 => last,
            _ if logarithmic => first * (last / first).powf(share),
            _ => first + (last - first) * share,
        }
    };
    // Values between the ends have four digits, unless the range is so narrow that they need more.
    let is_narrow = (last - first).abs() < 0.01 * count as f64 * first.abs().max(last.abs());
    let text = |at: usize| match value(at) {
        value if whole => value.round().to_string(),
        value if at == 0 || at == count - 1 || is_narrow => (value as f32).to_string(),
        value => format!("{value:.3e}")
            .parse::<f32>()
            .map_or_else(|_| value.to_string(), |value| value.to_string()),
    };
    Ok((0..count).map(text).collect())
}

/// All combinations of the values of some settings, the values of the last axis changing fastest. Without axes it has
/// one combination, the settings as they are.
#[derive(Clone, Debug, Default)]
pub struct Grid {
    axes: Vec<Axis>,
}

impl Grid {
    /// The grid of these axes. Fails if a setting has two, or if there are more than 100 000 combinations.
    pub fn new(axes: Vec<Axis>) -> Result<Self, GridError> {
        for (at, axis) in axes.iter().enumerate() {
            let name = axis.setting.name;
            if axes[..at].iter().any(|other| other.setting.name == name) {
                let why = "the setting has two lists of values; join them".to_owned();
                return Err(GridError::Axis { text: name.to_owned(), why });
            }
        }
        let combinations = axes.iter().try_fold(1_usize, |count, axis| count.checked_mul(axis.values.len()));
        combinations.filter(|&count| count <= MAX_COMBINATIONS).ok_or(GridError::Size)?;
        Ok(Self { axes })
    }

    /// The settings of the grid and their values.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Number of combinations, at least 1.
    pub fn combinations(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// The index of each axis's value in a combination.
    pub fn indices(&self, combination: usize) -> Vec<usize> {
        let mut rest = combination;
        let mut indices: Vec<usize> = self
            .axes
            .iter()
            .rev()
            .map(|axis| {
                let at = rest % axis.values.len();
                rest /= axis.values.len();
                at
            })
            .collect();
        indices.reverse();
        indices
    }

    /// The value of each axis in a combination.
    pub fn values(&self, combination: usize) -> Vec<Value> {
        self.axes.iter().zip(self.indices(combination)).map(|(axis, at)| axis.values[at]).collect()
    }

    /// The combination whose values some settings have, if there is one.
    pub fn combination_of(&self, settings: &Settings) -> Option<usize> {
        self.axes.iter().try_fold(0, |combination, axis| {
            let value = axis.setting.get(settings);
            let at = axis.values.iter().position(|other| *other == value)?;
            Some(combination * axis.values.len() + at)
        })
    }

    /// A combination in words: `k=3 t=0.6`; empty without axes.
    pub fn name(&self, combination: usize) -> String {
        let values = self.axes.iter().zip(self.values(combination));
        values.map(|(axis, value)| format!("{}={value}", axis.setting.name)).collect::<Vec<_>>().join(" ")
    }

    /// `base` with the values of a combination.
    pub fn settings(&self, base: &Settings, combination: usize) -> Result<Settings, SettingError> {
        let mut settings = base.clone();
        for (axis, value) in self.axes.iter().zip(self.values(combination)) {
            axis.setting.set(&mut settings, value)?;
        }
        Ok(settings)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn texts(text: &str) -> Vec<String> {
        Axis::of_text(text).unwrap().values.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn values_are_listed_or_a_range() {
        assert_eq!(texts("k=3,4, 5"), ["3", "4", "5"]);
        assert_eq!(texts("t=0.5..0.9:5"), ["0.5", "0.6", "0.7", "0.8", "0.9"]);
        assert_eq!(texts("alpha=log:0.0005..0.05:3"), ["0.0005", "0.005", "0.05"]);
        assert_eq!(texts("alpha=log:0.001..0.1:5"), ["0.001", "0.003162", "0.01", "0.03162", "0.1"]);
        assert_eq!(texts("t=0.5..0.9:8")[1..3], ["0.5571", "0.6143"]);
        assert_eq!(texts("t=0.5..0.5002:3"), ["0.5", "0.5001", "0.5002"]);
        assert_eq!(texts("k=3..7:3"), ["3", "5", "7"]);
        assert_eq!(texts("match-sigmas=3..2:2"), ["3", "2"]);
        assert_eq!(texts("bootstrap=50,2s"), ["50", "2s"]);
        assert_eq!(texts("rate=density,constant"), ["density", "constant"]);
    }

    #[test]
    fn what_is_no_axis_is_told() {
        for (text, why) in [
            ("k", "k=3,4,5"),
            ("kk=3", "no setting `kk`"),
            ("k=3,99", "`99`"),
            ("k=", "cannot be ``"),
            ("k=3,3", "3 twice"),
            ("k=3..5:9", "twice"),
            ("t=0.5..0.9", "FIRST..LAST:COUNT"),
            ("t=0.5..:3", "FIRST..LAST:COUNT"),
            ("t=0.5..0.9:1", "at least 2"),
            ("alpha=log:0..0.1:3", "greater than 0"),
            ("rate=density..constant:2", "no ranges"),
        ] {
            let error = Axis::of_text(text).unwrap_err().to_string();
            assert!(error.contains(why), "{text}: {error}");
        }
        let grid = |texts: &[&str]| {
            Grid::new(texts.iter().map(|text| Axis::of_text(text).unwrap()).collect()).map(|_| ())
        };
        assert!(grid(&["k=3,4", "k=5"]).unwrap_err().to_string().contains("two lists"));
        let many = ["alpha=0.001..0.9:800", "t=0.1..0.9:800"];
        assert_eq!(grid(&many), Err(GridError::Size));
    }

    #[test]
    fn the_last_axis_changes_fastest() {
        let axes = ["k=3,4", "t=0.6,0.7,0.8"].map(|text| Axis::of_text(text).unwrap());
        let grid = Grid::new(axes.to_vec()).unwrap();
        let names: Vec<_> = (0..grid.combinations()).map(|at| grid.name(at)).collect();
        let expected = ["k=3 t=0.6", "k=3 t=0.7", "k=3 t=0.8", "k=4 t=0.6", "k=4 t=0.7", "k=4 t=0.8"];
        assert_eq!(names, expected);
        let settings = grid.settings(&Settings::default(), 4).unwrap();
        assert_eq!((settings.k, settings.t), (4, 0.7));
        assert_eq!(grid.combination_of(&settings), Some(4));
        assert_eq!(grid.combination_of(&Settings { k: 5, ..settings }), None);
        let none = Grid::default();
        assert_eq!((none.combinations(), none.name(0)), (1, String::new()));
        assert_eq!(none.settings(&Settings::default(), 0).unwrap(), Settings::default());
    }
}
