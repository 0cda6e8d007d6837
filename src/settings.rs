//! All parameters: name, symbol, range, default and meaning.
//!
//! Flags, the TOML file, the sliders of the window and the docs all read [`SETTINGS`], which is the only definition
//! of a parameter.

pub mod file;

use std::fmt::{self, Write as _};
use std::path::Path;

use serde::{Deserialize, Serialize};

/// The first stage of the analysis that a setting affects: this stage and all later ones must run again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Correction of the frame before the mixture, for camera shake and changes of light.
    Registration,
    /// The pixel process and the selection of background components (§V–VI).
    Mixture,
    /// Cleaning of the mask before regions are found in it.
    Cleaning,
    /// Connected components and their colours (§VII, Algorithm 1).
    Regions,
    /// Kalman models and their hypotheses (§VIII).
    Tracking,
    /// Merging, disappearing, demerging, reappearing (Algorithms 1–3).
    Occlusion,
}

impl Stage {
    /// All stages in processing order.
    pub const ALL: [Self; 6] =
        [Self::Registration, Self::Mixture, Self::Cleaning, Self::Regions, Self::Tracking, Self::Occlusion];

    /// The stage's name in headings.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Registration => "Registration",
            Self::Mixture => "Mixture",
            Self::Cleaning => "Post-processing",
            Self::Regions => "Regions",
            Self::Tracking => "Tracking",
            Self::Occlusion => "Occlusion",
        }
    }
}

/// A duration: in frames, or in seconds of the video.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Span {
    /// A number of frames.
    Frames(u32),
    /// A number of seconds, converted by the video's frame rate.
    Seconds(f32),
}

impl Span {
    /// The span in frames of a video with `fps` frames per second, rounded, at least 1 unless it is zero.
    pub fn frames(self, fps: f32) -> u32 {
        match self {
            Self::Frames(frames) => frames,
            Self::Seconds(seconds) if seconds <= 0.0 => 0,
            Self::Seconds(seconds) => ((seconds * fps).round() as u32).max(1),
        }
    }

    /// The duration in seconds for a video with `fps` frames per second.
    pub fn seconds(self, fps: f32) -> f32 {
        match self {
            Self::Frames(frames) => frames as f32 / fps.max(f32::MIN_POSITIVE),
            Self::Seconds(seconds) => seconds,
        }
    }

    fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        if let Some(seconds) = text.strip_suffix('s') {
            let seconds: f32 = seconds.trim().parse().ok()?;
            return seconds.is_finite().then_some(Self::Seconds(seconds));
        }
        let frames = text.strip_suffix("frames").or_else(|| text.strip_suffix('f')).unwrap_or(text);
        frames.trim().parse().ok().map(Self::Frames)
    }
}

impl fmt::Display for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frames(frames) => write!(f, "{frames}"),
            Self::Seconds(seconds) => write!(f, "{seconds}s"),
        }
    }
}

/// The value of any setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// An integer.
    Integer(u32),
    /// A floating-point number.
    Real(f32),
    /// One of several words.
    Choice(&'static str),
    /// A duration.
    Span(Span),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(value) => write!(f, "{value}"),
            Self::Real(value) => write!(f, "{value}"),
            Self::Choice(value) => write!(f, "{value}"),
            Self::Span(value) => write!(f, "{value}"),
        }
    }
}

/// The range of a setting's values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// An integer, in an inclusive range.
    Integer {
        /// The least value.
        min: u32,
        /// The greatest value.
        max: u32,
    },
    /// An odd number of pixels from 3 to `max`, or 0 for off.
    OddSize {
        /// The largest size.
        max: u32,
    },
    /// A number.
    Real {
        /// The lower end.
        min: f32,
        /// The upper end.
        max: f32,
        /// Whether the ends are excluded (`0 < α < 1`).
        open: bool,
        /// Whether a slider should be logarithmic.
        logarithmic: bool,
    },
    /// One of these words.
    Choice(&'static [&'static str]),
    /// Frames (`25`) or seconds (`"10s"`), up to a maximum of either.
    Span {
        /// The greatest number of frames.
        max_frames: u32,
        /// The greatest number of seconds.
        max_seconds: f32,
    },
}

impl Kind {
    /// The range in words: `0 < value < 1`, `1–8`, `density | weight | constant`. `symbol` stands for the value.
    pub fn range(&self, symbol: &str) -> String {
        match *self {
            Self::Integer { min, max } => format!("{min}–{max}"),
            Self::OddSize { max } => format!("0 (off) or an odd number 3–{max}"),
            Self::Real { min, max, open: true, .. } => {
                let name = if symbol.is_empty() { "value" } else { symbol };
                format!("{min} < {name} < {max}")
            }
            Self::Real { min, max, .. } => format!("{min}–{max}"),
            Self::Choice(words) => words.join(" | "),
            Self::Span { max_frames, max_seconds } => {
                format!("0–{max_frames} frames, or \"0s\"–\"{max_seconds}s\"")
            }
        }
    }

    /// Parses a value of this kind and checks its range.
    fn parse(&self, text: &str) -> Option<Value> {
        let text = text.trim();
        let value = match *self {
            Self::Integer { .. } | Self::OddSize { .. } => Value::Integer(text.parse().ok()?),
            Self::Real { .. } => Value::Real(text.parse().ok()?),
            Self::Choice(words) => Value::Choice(words.iter().copied().find(|&word| word == text)?),
            Self::Span { .. } => Value::Span(Span::parse(text)?),
        };
        self.contains(value).then_some(value)
    }

    /// Whether `value` is of this kind and within its range.
    pub fn contains(&self, value: Value) -> bool {
        match (*self, value) {
            (Self::Integer { min, max }, Value::Integer(value)) => (min..=max).contains(&value),
            (Self::OddSize { max }, Value::Integer(value)) => {
                value == 0 || (value % 2 == 1 && (3..=max).contains(&value))
            }
            (Self::Real { min, max, open: true, .. }, Value::Real(value)) => value > min && value < max,
            (Self::Real { min, max, .. }, Value::Real(value)) => (min..=max).contains(&value),
            (Self::Choice(words), Value::Choice(value)) => words.contains(&value),
            (Self::Span { max_frames, .. }, Value::Span(Span::Frames(frames))) => frames <= max_frames,
            (Self::Span { max_seconds, .. }, Value::Span(Span::Seconds(seconds))) => {
                (0.0..=max_seconds).contains(&seconds)
            }
            _ => false,
        }
    }
}

/// The definition of a parameter.
#[derive(Debug)]
pub struct Setting {
    /// Its key in a settings file; with dashes in place of underscores, its flag.
    pub name: &'static str,
    /// Its symbol in the paper; empty if it has none.
    pub symbol: &'static str,
    /// Its unit; empty if it is dimensionless.
    pub unit: &'static str,
    /// The first stage that it affects.
    pub stage: Stage,
    /// The range of its values.
    pub kind: Kind,
    /// Its meaning, one sentence.
    pub meaning: &'static str,
    get: fn(&Settings) -> Value,
    set: fn(&mut Settings, Value),
}

impl Setting {
    /// The setting of this name (underscores or dashes).
    pub fn named(name: &str) -> Option<&'static Self> {
        SETTINGS.iter().find(|setting| setting.name == name || setting.flag() == name)
    }

    /// Its name on the screen: the standard term if that differs from the key.
    pub fn label(&self) -> String {
        let term = match self.name {
            "k" => "components",
            "alpha" => "learning rate",
            "t" => "background ratio",
            "match_sigmas" => "match threshold",
            "shadow_floor" => "shadow threshold",
            "light_ceiling" => "light threshold",
            "unrest_memory" => "flicker memory",
            "unrest_full" => "flicker limit",
            "restless_learning" => "flicker learning",
            "restless_t" => "flicker T",
            "same_episode" => "episode gap",
            "same_colour" => "colour threshold",
            "placing" => "localisation",
            "find_again" => "re-identification",
            "count_heads" => "head count",
            "predict_for" => "prediction time",
            name => return name.replace('_', " "),
        };
        term.to_owned()
    }

    /// Its command-line flag without the leading dashes.
    pub fn flag(&self) -> String {
        self.name.replace('_', "-")
    }

    /// Its value in `settings`.
    pub fn get(&self, settings: &Settings) -> Value {
        (self.get)(settings)
    }

    /// Sets its value in `settings`. Fails if the value is of another kind or out of range.
    pub fn set(&self, settings: &mut Settings, value: Value) -> Result<(), SettingError> {
        if !self.kind.contains(value) {
            return Err(self.refusal(&value.to_string()));
        }
        (self.set)(settings, value);
        Ok(())
    }

    /// Parses its value from text and sets it in `settings`. Fails if the text is not a value of its kind within its
    /// range.
    pub fn set_text(&self, settings: &mut Settings, text: &str) -> Result<(), SettingError> {
        let value = self.kind.parse(text).ok_or_else(|| self.refusal(text))?;
        (self.set)(settings, value);
        Ok(())
    }

    fn refusal(&self, text: &str) -> SettingError {
        SettingError::Refused { name: self.name, given: text.to_owned(), range: self.kind.range(self.symbol) }
    }
}

/// An error of a setting.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum SettingError {
    /// No setting has this name.
    #[error("there is no setting `{0}`; `occluscope settings` lists them all")]
    Unknown(String),
    /// The value is of another kind or out of range.
    #[error("the setting `{name}` cannot be `{given}`; allowed: {range}")]
    Refused {
        /// The setting.
        name: &'static str,
        /// The given value.
        given: String,
        /// The accepted values.
        range: String,
    },
    /// No preset has this name.
    #[error("there is no preset `{0}`; choose plain, paper, opencv-mog or default")]
    UnknownPreset(String),
    /// A settings file that is not TOML, or not a flat list of keys.
    #[error("the settings file {path} cannot be used: {why}")]
    File {
        /// The file.
        path: String,
        /// The cause.
        why: String,
    },
}

/// Converts a field of [`Settings`] to a [`Value`] and back.
trait Parameter: Sized {
    fn to_value(&self) -> Value;
    fn from_value(value: Value) -> Option<Self>;
}

impl Parameter for u32 {
    fn to_value(&self) -> Value {
        Value::Integer(*self)
    }
    fn from_value(value: Value) -> Option<Self> {
        if let Value::Integer(value) = value { Some(value) } else { None }
    }
}

impl Parameter for f32 {
    fn to_value(&self) -> Value {
        Value::Real(*self)
    }
    fn from_value(value: Value) -> Option<Self> {
        if let Value::Real(value) = value { Some(value) } else { None }
    }
}

impl Parameter for Span {
    fn to_value(&self) -> Value {
        Value::Span(*self)
    }
    fn from_value(value: Value) -> Option<Self> {
        if let Value::Span(value) = value { Some(value) } else { None }
    }
}

/// An enumeration whose variants each have a word.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $word:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name { $($(#[$variant_doc])* $variant),+ }

        impl $name {
            /// The words of all choices.
            pub const WORDS: &'static [&'static str] = &[$($word),+];

            /// The word of this choice.
            pub const fn word(self) -> &'static str {
                match self { $(Self::$variant => $word),+ }
            }

            /// The choice of this word.
            pub fn from_word(word: &str) -> Option<Self> {
                match word { $($word => Some(Self::$variant),)+ _ => None }
            }
        }

        impl Parameter for $name {
            fn to_value(&self) -> Value {
                Value::Choice(self.word())
            }
            fn from_value(value: Value) -> Option<Self> {
                if let Value::Choice(word) = value { Self::from_word(word) } else { None }
            }
        }
    };
}

words! {
    /// The background model.
    BackgroundModel {
        /// The adaptive mixture of Gaussians of §V–VI.
        Mixture = "mixture",
        /// OpenCV's `BackgroundSubtractorMOG2`, for comparison.
        Mog2 = "mog2",
        /// OpenCV's `BackgroundSubtractorKNN`, for comparison.
        Knn = "knn",
    }
}

words! {
    /// The camera motion that is compensated in each frame.
    Stabilise {
        /// None.
        Off = "off",
        /// Shift, rotation and zoom, once the camera shakes.
        Auto = "auto",
        /// The shift.
        Shift = "shift",
        /// Shift, rotation and zoom.
        Similarity = "similarity",
    }
}

words! {
    /// The change of light that is compensated in each frame.
    LightCorrection {
        /// None.
        Off = "off",
        /// A gain and an offset of each channel, the same for the whole image.
        Gain = "gain",
    }
}

words! {
    /// The update rate of the matched component: ρ of §V.
    Rate {
        /// ρ = α·η(X; μ, σ²I), the paper's equation.
        Density = "density",
        /// ρ = α / w (Power & Schoonees 2002).
        Weight = "weight",
        /// ρ = α.
        Constant = "constant",
    }
}

words! {
    /// The value X of a pixel.
    Space {
        /// Three channels: red, green, blue.
        Rgb = "rgb",
        /// One channel: BT.601 luma in 8 bits.
        Gray = "gray",
    }
}

words! {
    /// The source of an object's dominant colours (Algorithm 1).
    ColourMemory {
        /// The single frame before the occlusion, as in Algorithm 1.
        Frame = "frame",
        /// The histogram averaged over the object's unoccluded frames.
        Clear = "clear",
    }
}

words! {
    /// Localisation of the members of an occlusion group within its region.
    Placing {
        /// By predicted motion, limited to the region.
        Predicted = "predicted",
        /// By appearance: where the members' templates explain the region's pixels best.
        Looks = "looks",
    }
}

words! {
    /// Whether a part of the method is used.
    Switch {
        /// Not used.
        Off = "off",
        /// Used.
        On = "on",
    }
}

words! {
    /// The criterion of re-identification after an occlusion by the scene (Algorithm 3).
    ReappearBy {
        /// The predicted position alone, as in Algorithm 3.
        Position = "position",
        /// The predicted position, with colours to choose between several candidates; elsewhere on the predicted path
        /// the colours.
        Colour = "colour",
    }
}

macro_rules! settings {
    ($($(#[doc = $doc:literal])+ $field:ident : $ty:ty = $plain:expr, $symbol:literal, $unit:literal, $stage:ident, $kind:expr;)+) => {
        /// The value of every parameter. Equal settings and equal frames give equal results.
        #[derive(Clone, Debug, PartialEq)]
        pub struct Settings {
            $($(#[doc = $doc])+ pub $field: $ty,)+
        }

        impl Settings {
            /// The published method, all additions off.
            fn plain() -> Self {
                Self { $($field: $plain,)+ }
            }
        }

        /// Every setting, in the order in which files and panels list them.
        pub static SETTINGS: &[Setting] = &[$(
            Setting {
                name: stringify!($field),
                symbol: $symbol,
                unit: $unit,
                stage: Stage::$stage,
                kind: $kind,
                meaning: concat!($($doc),+),
                get: |settings| settings.$field.to_value(),
                set: |settings, value| {
                    if let Some(value) = Parameter::from_value(value) {
                        settings.$field = value;
                    }
                },
            },
        )+];
    };
}

const fn real(min: f32, max: f32) -> Kind {
    Kind::Real { min, max, open: false, logarithmic: false }
}

const fn open(min: f32, max: f32) -> Kind {
    Kind::Real { min, max, open: true, logarithmic: false }
}

const fn log(min: f32, max: f32) -> Kind {
    Kind::Real { min, max, open: false, logarithmic: true }
}

const fn span(max_frames: u32, max_seconds: f32) -> Kind {
    Kind::Span { max_frames, max_seconds }
}

settings! {
    /// Camera motion that is compensated in each frame before the mixture: none, a shift, or shift, rotation and zoom (`similarity`); `auto` uses the latter once the camera shakes.
    stabilise: Stabilise = Stabilise::Off, "", "", Registration, Kind::Choice(Stabilise::WORDS);
    /// Change of illumination that is compensated in each frame before the mixture: none, or a gain and an offset of the whole image relative to the recent past.
    light: LightCorrection = LightCorrection::Off, "", "", Registration, Kind::Choice(LightCorrection::WORDS);

    /// Background model: the mixture, or OpenCV's MOG2 or KNN in its place.
    background_model: BackgroundModel = BackgroundModel::Mixture, "", "", Mixture, Kind::Choice(BackgroundModel::WORDS);
    /// Number of components per pixel.
    k: u32 = 4, "K", "", Mixture, Kind::Integer { min: 1, max: 8 };
    /// Learning rate of the weights; 1/α is their time constant in frames.
    alpha: f32 = 0.01, "α", "", Mixture, Kind::Real { min: 0.0, max: 1.0, open: true, logarithmic: true };
    /// Minimum share of the recent past that the background components account for; a higher value includes more components.
    t: f32 = 0.7, "T", "", Mixture, open(0.0, 1.0);
    /// Match threshold: maximum distance of a value from a component's mean, in standard deviations.
    match_sigmas: f32 = 2.5, "λ", "σ", Mixture, real(0.5, 10.0);
    /// Standard deviation of a new component.
    initial_sigma: f32 = 20.0, "σ₀", "levels", Mixture, real(1.0, 128.0);
    /// Weight of a new component before normalisation.
    initial_weight: f32 = 0.05, "w₀", "", Mixture, open(0.0, 1.0);
    /// Minimum standard deviation of a component; a higher value suppresses noise and soft shadows.
    min_sigma: f32 = 4.0, "σ_min", "levels", Mixture, log(0.1, 64.0);
    /// Update rate of the matched component's mean and variance: `density` is the paper's α·η, `weight` is α/w, `constant` is α.
    rate: Rate = Rate::Weight, "ρ", "", Mixture, Kind::Choice(Rate::WORDS);
    /// Pixel value: three colour channels, or BT.601 luma.
    space: Space = Space::Rgb, "", "", Mixture, Kind::Choice(Space::WORDS);
    /// For this number of frames α is at least 1/t, so that the first frame does not dominate; 0 is off.
    warm_up: u32 = 0, "", "frames", Mixture, Kind::Integer { min: 0, max: 10_000 };
    /// Length of the beginning of a file from which the model is trained before the first frame is evaluated; a shorter file is used in full; 0 is off.
    bootstrap: Span = Span::Frames(0), "", "time", Mixture, span(100_000, 3600.0);

    /// Factor on α for persistent foreground, so that stationary people stay foreground; 1 is off.
    hold: f32 = 1.0, "", "", Mixture, log(0.001, 1.0);
    /// Number of consecutive foreground frames after which foreground is persistent.
    hold_after: u32 = 8, "", "frames", Mixture, Kind::Integer { min: 1, max: 1000 };
    /// Factor on α for short foreground of flickering pixels; 1 is off.
    restless_learning: f32 = 1.0, "", "", Mixture, log(1.0, 50.0);
    /// Background ratio T of flickering pixels, if greater than T; 0 is off.
    restless_t: f32 = 0.0, "", "", Mixture, real(0.0, 0.99);
    /// Number of frames over which the verdict changes of a pixel are averaged.
    unrest_memory: u32 = 300, "", "frames", Mixture, Kind::Integer { min: 1, max: 10_000 };
    /// Share of frames with a verdict change from which a pixel counts fully as flickering.
    unrest_full: f32 = 0.15, "", "", Mixture, log(0.01, 1.0);

    /// Shadow threshold: foreground is shadow if it has the colour of component 1 at no less than this share of its brightness; 1 is off.
    shadow_floor: f32 = 1.0, "τ", "", Mixture, real(0.2, 1.0);
    /// Light threshold: foreground is a light patch if it has the colour of component 1 at no more than this multiple of its brightness; 1 is off.
    light_ceiling: f32 = 1.0, "", "", Mixture, real(1.0, 4.0);
    /// Side of the square in which even shadow or light pixels must be at least as many as other foreground pixels; 0 is off.
    shadow_window: u32 = 0, "", "pixels", Mixture, Kind::OddSize { max: 31 };
    /// Shadow is even if the standard deviation of its relative brightness over 3 × 3 pixels is at most this; used with `shadow_window`.
    shadow_spread: f32 = 0.07, "", "", Mixture, real(0.0, 1.0);
    /// Maximum colour distance of a shadow or light pixel from the darkened or brightened colour.
    shadow_colour: f32 = 12.0, "", "levels", Mixture, real(0.0, 100.0);

    /// A pixel that matches the background at more than this distance from the mean is foreground if enough of its neighbourhood is; 0 is off.
    hysteresis: f32 = 0.0, "", "levels", Mixture, real(0.0, 200.0);
    /// Side of the neighbourhood in which foreground is counted for hysteresis.
    hysteresis_window: u32 = 11, "", "pixels", Mixture, Kind::OddSize { max: 31 };
    /// Minimum foreground ratio in that neighbourhood.
    hysteresis_share: f32 = 0.35, "", "", Mixture, real(0.0, 1.0);

    /// Side of the median filter on the mask, which removes specks and closes gaps; 0 is off.
    median: u32 = 0, "", "pixels", Cleaning, Kind::OddSize { max: 31 };
    /// Side of the morphological opening (erosion, then dilation), which removes thin structures; 0 is off.
    opening: u32 = 0, "", "pixels", Cleaning, Kind::OddSize { max: 31 };
    /// Side of the morphological closing (dilation, then erosion), which joins close regions; 0 is off.
    closing: u32 = 0, "", "pixels", Cleaning, Kind::OddSize { max: 31 };
    /// Maximum area of holes in the mask that are filled; 0 is off.
    fill_holes: u32 = 0, "", "pixels", Cleaning, Kind::Integer { min: 0, max: 1_000_000 };

    /// Minimum area of a region; smaller regions are removed.
    min_area: u32 = 3, "", "pixels", Regions, Kind::Integer { min: 1, max: 1_000_000 };

    /// Minimum area of a tracked region, as a share of the image area.
    track_min_area: f32 = 0.03, "", "% of image", Tracking, log(0.001, 10.0);
    /// Maximum gap between fragments of one object, relative to the longer side: regions one above the other, or a small region near a large one; 0 is off.
    fragment_gap: f32 = 0.0, "", "", Tracking, real(0.0, 1.0);
    /// Probability of the χ² gate (3 degrees of freedom) for the association of a region with a hypothesis.
    gate: f32 = 0.99, "", "", Tracking, Kind::Real { min: 0.5, max: 0.9999, open: false, logarithmic: false };
    /// Standard deviation of position and size relative to constant velocity, per frame.
    process_noise: f32 = 1.0, "", "pixels", Tracking, log(0.01, 50.0);
    /// Standard deviation of measured position and size.
    measurement_noise: f32 = 2.0, "", "pixels", Tracking, log(0.1, 50.0);
    /// Number of frames over which the prediction error is averaged for the fitness.
    fitness_memory: u32 = 10, "", "frames", Tracking, Kind::Integer { min: 1, max: 1000 };
    /// Factor on the fitness per frame without an associated region, at 25 frames per second.
    null_factor: f32 = 0.8, "", "", Tracking, open(0.0, 1.0);
    /// Minimum fitness of a hypothesis; below it the hypothesis is removed.
    min_fitness: f32 = 0.11, "", "", Tracking, log(0.0001, 0.3);
    /// Maximum number of hypotheses; the least probable ones are removed first.
    max_hypotheses: u32 = 200, "", "models", Tracking, Kind::Integer { min: 1, max: 10_000 };
    /// Minimum number of detections of a confirmed track; shorter tracks get no identity and are not exported.
    min_track: Span = Span::Frames(5), "", "frames", Tracking, span(10_000, 600.0);

    /// Maximum duration of an occlusion; after it the object is removed.
    max_hidden: Span = Span::Seconds(10.0), "", "time", Occlusion, span(100_000, 3600.0);
    /// Objects separated for less than this stay in the same occlusion episode.
    same_episode: Span = Span::Seconds(0.5), "", "time", Occlusion, span(10_000, 60.0);
    /// Maximum distance of a box from the image edge at which an object can enter or exit.
    border: f32 = 2.0, "", "% of shorter side", Occlusion, real(0.0, 25.0);
    /// Minimum relative change of a region's area that indicates a merge or a split.
    size_step: f32 = 0.2, "", "", Occlusion, real(0.01, 2.0);
    /// Maximum CIE76 ΔE of two colours that count as the same.
    same_colour: f32 = 25.0, "ΔE", "Lab units", Occlusion, real(0.0, 100.0);
    /// Source of an object's appearance model: the last single frame before the occlusion, or its unoccluded frames.
    colour_memory: ColourMemory = ColourMemory::Frame, "", "", Occlusion, Kind::Choice(ColourMemory::WORDS);
    /// Criterion of re-identification after occlusion: predicted position, or colour among candidates.
    reappear_by: ReappearBy = ReappearBy::Position, "", "", Occlusion, Kind::Choice(ReappearBy::WORDS);
    /// Localisation within an occlusion group: by predicted motion, or by appearance.
    placing: Placing = Placing::Predicted, "", "", Occlusion, Kind::Choice(Placing::WORDS);
    /// Re-identification of occluded objects in regions that other objects do not fully explain; requires `placing = looks`.
    find_again: Switch = Switch::Off, "", "", Occlusion, Kind::Choice(Switch::WORDS);
    /// Detection of several heads side by side in one region, so that people who enter together are separate objects.
    count_heads: Switch = Switch::Off, "", "", Occlusion, Kind::Choice(Switch::WORDS);
    /// Learns how object size depends on position, so that occluded objects change size with their predicted position.
    perspective: Switch = Switch::Off, "", "", Occlusion, Kind::Choice(Switch::WORDS);
    /// Duration for which an undetected object is shown and exported at its predicted position; `max_hidden` limits how long it is kept.
    predict_for: Span = Span::Seconds(10.0), "", "time", Occlusion, span(100_000, 3600.0);
}

words! {
    /// A named set of values to start from.
    Preset {
        /// The published method, all additions off.
        Plain = "plain",
        /// `plain` with the paper's own learning rate, ρ = α·η.
        Paper = "paper",
        /// Imitates OpenCV's `bgsegm::BackgroundSubtractorMOG`.
        OpencvMog = "opencv-mog",
        /// The additions on, with values that were measured on many kinds of footage (`docs/occlusion.md`).
        Default = "default",
    }
}

impl Preset {
    /// All presets.
    pub const ALL: [Self; 4] = [Self::Default, Self::Plain, Self::Paper, Self::OpencvMog];

    /// A description of the preset, one sentence.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Plain => "the published method, all additions off",
            Self::Paper => "`plain` with the paper's own learning rate ρ = α·η",
            Self::OpencvMog => "imitates OpenCV's bgsegm MOG",
            Self::Default => "the additions on, with values for many kinds of footage",
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::preset(Preset::Default)
    }
}

impl Settings {
    /// The values of a preset.
    pub fn preset(preset: Preset) -> Self {
        let plain = Self::plain();
        match preset {
            Preset::Plain => plain,
            Preset::Paper => Self { rate: Rate::Density, ..plain },
            // bgsegm MOG has one variance per channel and compares their sum. This implementation stores that sum,
            // hence the factor √3 on its σ of 30 (new) and 15 (minimum).
            Preset::OpencvMog => Self {
                k: 5,
                alpha: 0.005,
                warm_up: 200,
                rate: Rate::Constant,
                initial_sigma: 51.96,
                min_sigma: 25.98,
                ..plain
            },
            Preset::Default => Self {
                stabilise: Stabilise::Auto,
                light: LightCorrection::Gain,
                k: 3,
                alpha: 0.002,
                warm_up: 25,
                // 5, 10, 20 and 60 seconds were tried: with the shorter ones, people who stood in the street for ten
                // seconds became background.
                bootstrap: Span::Seconds(20.0),
                min_sigma: 16.0,
                hold: 0.05,
                restless_learning: 2.0,
                restless_t: 0.85,
                // These, and a spread of .07, were tried on people, fish and vehicles, on roads, indoors and on water.
                shadow_floor: 0.6,
                light_ceiling: 1.3,
                shadow_window: 11,
                shadow_colour: 10.0,
                // 16 to 30 levels, squares of 5 to 11 pixels and shares of .3 to .5 were tried on people, fish and vehicles.
                hysteresis: 24.0,
                median: 5,
                min_area: 20,
                fragment_gap: 0.15,
                colour_memory: ColourMemory::Clear,
                reappear_by: ReappearBy::Colour,
                placing: Placing::Looks,
                find_again: Switch::On,
                count_heads: Switch::On,
                perspective: Switch::On,
                predict_for: Span::Seconds(0.5),
                ..plain
            },
        }
    }

    /// Sets one parameter, named as in a settings file or as a flag, from text. Fails if there is no such parameter,
    /// or if the text is not a value within its range.
    pub fn set(&mut self, name: &str, text: &str) -> Result<(), SettingError> {
        Setting::named(name).ok_or_else(|| SettingError::Unknown(name.to_owned()))?.set_text(self, text)
    }

    /// Overrides these settings by the keys of a TOML file, given as text; settings without a key keep their value.
    /// `path` is used in messages only.
    ///
    /// Fails if the text is not TOML, or at the first key that is no setting or has a value out of range; other keys may
    /// then already be set.
    ///
    /// # Examples
    /// ```
    /// use std::path::Path;
    ///
    /// use occluscope::settings::{Settings, Span, Stage};
    ///
    /// let path = Path::new("my.toml");
    /// let mut settings = Settings::default();
    /// settings.apply_toml("k = 5\nalpha = 0.01\nmax_hidden = \"2.5s\"\n", path)?;
    /// assert_eq!((settings.k, settings.alpha, settings.max_hidden), (5, 0.01, Span::Seconds(2.5)));
    /// assert_eq!(settings.first_difference(&Settings::default()), Some(Stage::Mixture));
    ///
    /// let error = settings.apply_toml("k = 9", path).unwrap_err();
    /// let why = "the setting `k` cannot be `9`; allowed: 1–8";
    /// assert_eq!(error.to_string(), format!("the settings file my.toml cannot be used: {why}"));
    /// # Ok::<(), occluscope::settings::SettingError>(())
    /// ```
    pub fn apply_toml(&mut self, text: &str, path: &Path) -> Result<(), SettingError> {
        // A message repeats values, which may contain line breaks.
        let fail = |why: String| {
            let why = why.split_whitespace().collect::<Vec<_>>().join(" ");
            SettingError::File { path: path.display().to_string(), why }
        };
        let table: toml::Table = text.parse().map_err(|error: toml::de::Error| fail(error.to_string()))?;
        for (name, value) in &table {
            let text = match value {
                toml::Value::String(text) => text.clone(),
                toml::Value::Integer(number) => number.to_string(),
                toml::Value::Float(number) => number.to_string(),
                other => return Err(fail(format!("`{name}` is {}, not a value", other.type_str()))),
            };
            self.set(name, &text).map_err(|error| fail(error.to_string()))?;
        }
        Ok(())
    }

    /// All settings as TOML, each with its symbol, range, default and meaning in comments.
    pub fn to_toml(&self) -> String {
        let defaults = Self::default();
        let mut text = String::new();
        for stage in Stage::ALL {
            let heading = format!("# {} ", stage.name());
            let _ = write!(text, "{heading:-<78}\n\n");
            for setting in SETTINGS.iter().filter(|setting| setting.stage == stage) {
                let symbol =
                    if setting.symbol.is_empty() { String::new() } else { format!("{}: ", setting.symbol) };
                let unit = if setting.unit.is_empty() { String::new() } else { format!(" {}", setting.unit) };
                // Writing to a string cannot fail.
                let _ = write!(
                    text,
                    "# {symbol}{}\n# range: {}{unit}; default: {}\n{} = {}\n\n",
                    setting.meaning.trim(),
                    setting.kind.range(setting.symbol),
                    setting.get(&defaults),
                    setting.name,
                    toml_value(setting.get(self)),
                );
            }
        }
        text
    }

    /// The first stage at which the two differ; `None` if they are equal.
    pub fn first_difference(&self, other: &Self) -> Option<Stage> {
        SETTINGS
            .iter()
            .filter(|setting| setting.get(self) != setting.get(other))
            .map(|setting| setting.stage)
            .min()
    }
}

fn toml_value(value: Value) -> String {
    match value {
        Value::Choice(word) => format!("\"{word}\""),
        Value::Span(span @ Span::Seconds(_)) => format!("\"{span}\""),
        // TOML distinguishes `1.0` from `1`, and a real number should have a decimal point.
        Value::Real(number) => format!("{number:?}"),
        other => other.to_string(),
    }
}

impl Serialize for Settings {
    /// A map from name to value, in the order of [`SETTINGS`].
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeMap;
        let mut map = serializer.serialize_map(Some(SETTINGS.len()))?;
        for setting in SETTINGS {
            match setting.get(self) {
                Value::Integer(value) => map.serialize_entry(setting.name, &value)?,
                // The shortest decimal of the f32, not the digits of its f64 value.
                Value::Real(value) => map.serialize_entry(
                    setting.name,
                    &value.to_string().parse::<f64>().unwrap_or(f64::from(value)),
                )?,
                Value::Choice(word) => map.serialize_entry(setting.name, word)?,
                Value::Span(span @ Span::Seconds(_)) => {
                    map.serialize_entry(setting.name, &span.to_string())?;
                }
                Value::Span(Span::Frames(frames)) => map.serialize_entry(setting.name, &frames)?,
            }
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Settings {
    /// The inverse of serialisation: missing keys keep their default, unknown ones are refused.
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        use serde::de::Error;
        let map = std::collections::BTreeMap::<String, serde_json::Value>::deserialize(deserializer)?;
        let mut settings = Self::default();
        for (name, value) in map {
            let text = match value {
                serde_json::Value::String(text) => text,
                other => other.to_string(),
            };
            settings.set(&name, &text).map_err(D::Error::custom)?;
        }
        Ok(settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_within_its_own_ranges() {
        for preset in Preset::ALL {
            let settings = Settings::preset(preset);
            for setting in SETTINGS {
                assert!(setting.kind.contains(setting.get(&settings)), "{} in {preset:?}", setting.name);
            }
        }
    }

    #[test]
    fn toml_and_json_read_back_as_the_same() {
        for preset in Preset::ALL {
            let settings = Settings::preset(preset);
            let mut read = Settings::preset(Preset::Plain);
            read.apply_toml(&settings.to_toml(), Path::new("settings.toml")).unwrap();
            assert_eq!(read, settings);
            let json = serde_json::to_string(&settings).unwrap();
            assert_eq!(serde_json::from_str::<Settings>(&json).unwrap(), settings);
        }
    }

    #[test]
    fn errors_name_the_setting_the_value_and_the_range() {
        let mut settings = Settings::default();
        let refused = settings.set("alpha", "1").unwrap_err().to_string();
        assert!(
            refused.contains("alpha") && refused.contains("`1`") && refused.contains("0 < α < 1"),
            "{refused}"
        );
        for (name, text) in [
            ("k", "0"),
            ("k", "9"),
            ("k", "3.5"),
            ("alpha", "NaN"),
            ("rate", "fast"),
            ("median", "4"),
            ("max_hidden", "-1s"),
        ] {
            assert!(settings.set(name, text).is_err(), "{name} = {text}");
        }
        assert_eq!(settings.set("alfa", "1"), Err(SettingError::Unknown("alfa".into())));
        assert_eq!(settings, Settings::default());
    }

    #[test]
    fn spans_are_parsed_from_frames_and_seconds() {
        let mut settings = Settings::default();
        settings.set("max_hidden", "25").unwrap();
        assert_eq!(settings.max_hidden.frames(10.0), 25);
        settings.set("max-hidden", "2.5s").unwrap();
        assert_eq!(settings.max_hidden.frames(10.0), 25);
        assert_eq!(settings.max_hidden.seconds(10.0), 2.5);
    }

    #[test]
    fn a_difference_is_at_the_first_affected_stage() {
        let base = Settings::default();
        assert_eq!(base.first_difference(&base), None);
        let tracking = Settings { gate: 0.95, same_colour: 1.0, ..base.clone() };
        assert_eq!(base.first_difference(&tracking), Some(Stage::Tracking));
        let mixture = Settings { k: 5, ..tracking };
        assert_eq!(base.first_difference(&mixture), Some(Stage::Mixture));
    }
}
