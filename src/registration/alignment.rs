//! The alignment of a frame: camera motion and change of light against the reference.

/// Camera motion: maps points of the reference to the frame.
///
/// A point at (x, y) from the image's centre is at ((1 + zoom)·x − turn·y + dx, turn·x + (1 + zoom)·y + dy).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// To the right, in pixels.
    pub dx: f32,
    /// Downwards, in pixels.
    pub dy: f32,
    /// Rotation, clockwise on the screen, in radians (small angles).
    pub turn: f32,
    /// Scale minus 1.
    pub zoom: f32,
}

impl Motion {
    /// No motion.
    pub const NONE: Self = Self { dx: 0.0, dy: 0.0, turn: 0.0, zoom: 0.0 };

    /// The shift of the image's centre, in pixels.
    pub fn length(&self) -> f32 {
        (self.dx * self.dx + self.dy * self.dy).sqrt()
    }

    /// The motion without turn and zoom.
    pub const fn shift(&self) -> Self {
        Self { dx: self.dx, dy: self.dy, ..Self::NONE }
    }

    /// Maps a point of the reference to the frame; coordinates are relative to the image's centre.
    #[inline(always)]
    pub fn apply(&self, x: f32, y: f32) -> (f32, f32) {
        let scale = 1.0 + self.zoom;
        ((scale * x - self.turn * y) + self.dx, (self.turn * x + scale * y) + self.dy)
    }

    /// The motion from the frame back to the reference.
    pub fn inverse(&self) -> Self {
        let scale = 1.0 + self.zoom;
        let determinant = scale * scale + self.turn * self.turn;
        let (cos, sin) = (scale / determinant, -self.turn / determinant);
        Self {
            dx: -(cos * self.dx - sin * self.dy),
            dy: -(sin * self.dx + cos * self.dy),
            turn: sin,
            zoom: cos - 1.0,
        }
    }

    /// The composition of motions: first `first`, then this one.
    pub fn after(&self, first: &Self) -> Self {
        let (scale, other) = (1.0 + self.zoom, 1.0 + first.zoom);
        let (dx, dy) = self.apply(first.dx, first.dy);
        Self {
            dx,
            dy,
            turn: scale * first.turn + self.turn * other,
            zoom: scale * other - self.turn * first.turn - 1.0,
        }
    }
}

/// Change of the levels of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LevelChange {
    pub(super) gain: f32,
    pub(super) offset: f32,
}

impl LevelChange {
    /// No change.
    pub(super) const NONE: Self = Self { gain: 1.0, offset: 0.0 };

    /// gain·level + offset.
    pub(super) fn apply(self, level: f32) -> f32 {
        self.gain * level + self.offset
    }
}

/// Change of light: a level v of the reference, 0..=255, is gain·v + offset in the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Gain of red, green and blue.
    pub gain: [f32; 3],
    /// Offset of red, green and blue, in levels.
    pub offset: [f32; 3],
}

impl Light {
    /// No change.
    pub const SAME: Self = Self { gain: [1.0; 3], offset: [0.0; 3] };

    /// The gain of the luma.
    pub fn luma_gain(&self) -> f32 {
        self.luma().gain
    }

    /// The change of the luma.
    pub(super) fn luma(&self) -> LevelChange {
        LevelChange { gain: luma(self.gain), offset: luma(self.offset) }
    }

    /// This change of light relative to `usual`.
    pub(super) fn against(&self, usual: &Self) -> Self {
        let gain: [f32; 3] = std::array::from_fn(|channel| self.gain[channel] / usual.gain[channel]);
        let offset =
            std::array::from_fn(|channel| self.offset[channel] - gain[channel] * usual.offset[channel]);
        Self { gain, offset }
    }
}

impl Default for Light {
    fn default() -> Self {
        Self::SAME
    }
}

/// The alignment of a frame to the reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Alignment {
    /// The camera motion relative to the reference.
    pub motion: Motion,
    /// The change of light relative to the recent past.
    pub light: Light,
    /// The rest motion around which the camera shakes, once a shake is detected.
    pub rest: Option<Motion>,
    /// The number of the frame in which the camera moved for good, given once, in the frame in which this is certain.
    pub moved_since: Option<u32>,
}

impl Alignment {
    /// A warning about the frame for the user, one sentence.
    pub fn warning(&self) -> Option<String> {
        self.moved_since.map(|frame| {
            format!(
                "the camera moved permanently at about frame {frame}: the background is learnt again where \
                 the view changed; analyse the frames from there on separately"
            )
        })
    }
}

/// BT.601 luma of levels, gains or offsets of red, green and blue.
pub(super) fn luma([r, g, b]: [f32; 3]) -> f32 {
    (0.299 * r + 0.587 * g) + 0.114 * b
}
