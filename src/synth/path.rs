//! Paths on the ground.

use serde::{Deserialize, Serialize};

/// Number of frames of deceleration and of acceleration around a stop.
const EASE: i32 = 6;

/// A path on the ground: piecewise straight, with constant speed on each piece.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// The frame in which the first piece, extended if necessary, passes `at`; may be fractional and outside the scene.
    pub frame: f32,
    /// The point on the ground below the object's middle, in pixels.
    pub at: [f32; 2],
    /// Pixels per frame, to the right and down.
    pub velocity: [f32; 2],
    /// Changes of velocity, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub turns: Vec<VelocityChange>,
}

/// A change of velocity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VelocityChange {
    /// The frame of the change.
    pub frame: f32,
    /// Pixels per frame, to the right and down; zero is a stop.
    pub velocity: [f32; 2],
}

/// A straight piece of a path.
#[derive(Clone, Copy)]
struct PathSegment {
    /// A frame, and the position in it.
    frame: f32,
    at: [f32; 2],
    velocity: [f32; 2],
    /// The start of the next piece.
    end: f32,
}

impl PathSegment {
    fn position(&self, frame: f32) -> [f32; 2] {
        let passed = frame - self.frame;
        [self.at[0] + self.velocity[0] * passed, self.at[1] + self.velocity[1] * passed]
    }

    fn speed(&self) -> f32 {
        self.velocity[0].hypot(self.velocity[1])
    }
}

impl Path {
    /// A straight path.
    pub const fn straight(frame: f32, at: [f32; 2], velocity: [f32; 2]) -> Self {
        Self { frame, at, velocity, turns: Vec::new() }
    }

    /// Adds a change of velocity at `frame`, which must be later than all previous ones.
    #[must_use]
    pub fn then(mut self, frame: f32, velocity: [f32; 2]) -> Self {
        self.turns.push(VelocityChange { frame, velocity });
        self
    }

    fn segments(&self) -> impl Iterator<Item = PathSegment> {
        let end = |index: usize| self.turns.get(index).map_or(f32::INFINITY, |turn| turn.frame);
        let first = PathSegment { frame: self.frame, at: self.at, velocity: self.velocity, end: end(0) };
        let turns = self.turns.iter().zip(1..).scan(first, move |before, (turn, next)| {
            let at = before.position(turn.frame);
            *before = PathSegment { frame: turn.frame, at, velocity: turn.velocity, end: end(next) };
            Some(*before)
        });
        std::iter::once(first).chain(turns)
    }

    /// The piece that contains a frame.
    fn segment(&self, frame: f32) -> PathSegment {
        let first =
            PathSegment { frame: self.frame, at: self.at, velocity: self.velocity, end: f32::INFINITY };
        self.segments().find(|segment| frame < segment.end).unwrap_or(first)
    }

    /// The point on the ground in a frame.
    pub fn position(&self, frame: f32) -> [f32; 2] {
        self.segment(frame).position(frame)
    }

    /// Pixels per frame, to the right and down.
    pub fn velocity(&self, frame: f32) -> [f32; 2] {
        self.segment(frame).velocity
    }

    /// Whether the object stands still in a frame.
    pub fn stands(&self, frame: f32) -> bool {
        self.velocity(frame) == [0.0; 2]
    }

    /// The signed distance along the path from `at` to the position in a frame, in pixels.
    pub fn walked(&self, frame: f32) -> f32 {
        let before = self.segments().take_while(|segment| segment.end <= frame);
        let before: f32 = before.map(|segment| (segment.end - segment.frame) * segment.speed()).sum();
        let segment = self.segment(frame);
        before + (frame - segment.frame) * segment.speed()
    }

    /// 1 while walking, 0 while standing, with smooth transitions.
    pub fn stride(&self, frame: f32) -> f32 {
        let walks = (-EASE..=EASE).filter(|&away| !self.stands(frame + away as f32)).count();
        walks as f32 / (2 * EASE + 1) as f32
    }

    /// 1 to the right, −1 to the left; while standing or moving vertically, the last horizontal direction.
    pub fn facing(&self, frame: f32) -> f32 {
        let until_now =
            self.segments().take_while(|segment| segment.frame <= frame || segment.frame == self.frame);
        let sideways = until_now.map(|segment| segment.velocity[0]).filter(|&speed| speed != 0.0);
        if sideways.last().is_some_and(|speed| speed < 0.0) { -1.0 } else { 1.0 }
    }

    /// The last frame, on the way out, in which the object is `reach` pixels to the right or left of column `middle`;
    /// `None` if it does not move horizontally at the end.
    pub fn last_within(&self, middle: f32, reach: f32) -> Option<f32> {
        let last = self.segments().last()?;
        let [across, _] = last.velocity;
        let way = reach - (last.at[0] - middle) * across.signum();
        (across != 0.0).then(|| last.frame + way / across.abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// To the right until frame 10, a stop until 20, back until 30, then down.
    fn path() -> Path {
        Path::straight(0.0, [100.0, 50.0], [3.0, 4.0])
            .then(10.0, [0.0, 0.0])
            .then(20.0, [-3.0, -4.0])
            .then(30.0, [0.0, 1.0])
    }

    #[test]
    fn a_path_is_continuous_over_its_turns() {
        let expected = [
            (-2.0, [94.0, 42.0], -10.0),
            (0.0, [100.0, 50.0], 0.0),
            (10.0, [130.0, 90.0], 50.0),
            (15.0, [130.0, 90.0], 50.0),
            (25.0, [115.0, 70.0], 75.0),
            (30.0, [100.0, 50.0], 100.0),
            (37.0, [100.0, 57.0], 107.0),
        ];
        for (frame, at, walked) in expected {
            assert_eq!((path().position(frame), path().walked(frame)), (at, walked), "frame {frame}");
        }
    }

    #[test]
    fn a_standing_person_keeps_the_last_direction() {
        let facing = [-5.0, 15.0, 25.0, 40.0].map(|frame| path().facing(frame));
        assert_eq!(facing, [1.0, 1.0, -1.0, -1.0]);
        assert_eq!([5.0, 10.0, 19.0, 20.0].map(|frame| path().stands(frame)), [false, true, true, false]);
    }

    #[test]
    fn strides_end_smoothly() {
        let long = Path::straight(0.0, [0.0; 2], [1.0, 0.0]).then(50.0, [0.0; 2]).then(90.0, [1.0, 0.0]);
        assert_eq!([0.0, 43.0, 60.0, 80.0, 100.0].map(|frame| long.stride(frame)), [1.0, 1.0, 0.0, 0.0, 1.0]);
        assert!((0.4..0.6).contains(&long.stride(50.0)));
    }

    #[test]
    fn the_last_way_out_is_used() {
        let back = Path::straight(50.0, [100.0, 0.0], [2.0, 0.0]).then(60.0, [-2.0, 0.0]);
        assert_eq!(back.last_within(100.0, 40.0), Some(60.0 + 30.0));
        assert_eq!(path().last_within(100.0, 40.0), None);
    }
}
