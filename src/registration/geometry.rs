//! Estimates camera motion: a coarse search, then least squares on points of strong contrast.

use nalgebra::{SMatrix, SVector};

use super::Motion;
use super::alignment::LevelChange;
use super::plane::{Plane, square};
use super::robust;
use crate::frame::Frame;

/// Range of the coarse search to each side, in pixels at a quarter of the size, and no more than a quarter of the
/// image.
const MAX_SEARCH_PX: usize = 8;
/// Relative improvement required per pixel of additional distance in the coarse search.
const SHARE_PER_PIXEL: f32 = 0.01;
/// Radius of the mean that is subtracted for the coarse search, in pixels.
const MEAN_RADIUS_PX: usize = 5;
/// Residual limit in levels: a point with a larger residual shows something else, and its size is irrelevant.
const MAX_RESIDUAL_LEVELS: f32 = 20.0;
/// Side of the squares with one point each, in pixels.
const POINT_CELL_PX: usize = 8;
/// Least contrast of a point, in levels per pixel.
const MIN_CONTRAST: f32 = 3.0;
/// Least number of points for an estimate.
const MIN_POINTS: usize = 24;
/// Largest rotation and scale change of a stationary camera, in radians and as a share.
const MAX_TURN_AND_ZOOM: f32 = 0.1;
/// Indices of the fit's parameters.
const DX: usize = 0;
const DY: usize = 1;
const TURN: usize = 2;
const ZOOM: usize = 3;
const GAIN: usize = 4;
const OFFSET: usize = 5;
/// Largest residual of a clear motion relative to that of no motion, in the whole image and in its quarters. Leaves
/// and water that move also affect the estimate, but explain little of the image, or only one side of it.
const MAX_UNEXPLAINED: f32 = 0.8;
const MAX_UNEXPLAINED_QUARTER: f32 = 0.95;
/// Least-squares steps on each pyramid level.
const LEAST_SQUARES_STEPS: usize = 6;
/// Largest ratio of a motion's residual to that of no motion, as long as the camera is not known to shake.
const MAX_RESIDUAL_RATIO: f32 = 0.93;
/// Largest ratio of the residual of no motion to the usual residual of a stationary camera.
const MAX_STILL_RATIO: f32 = 1.25;

/// A point of the reference on one pyramid level: position relative to the image's centre, value and gradient.
#[derive(Clone, Copy)]
struct ContrastPoint {
    x: f32,
    y: f32,
    value: f32,
    across: f32,
    down: f32,
}

/// The reference, with its points of strong contrast on each pyramid level.
pub(super) struct MotionReference {
    coarse: Plane,
    /// The points at a quarter, a half, and the full scale.
    points: [Vec<ContrastPoint>; 3],
    /// Column and row of the points at full scale.
    places: Vec<(usize, usize)>,
}

/// A frame as an image pyramid: a quarter, a half, and the full scale.
pub(super) struct Pyramid(pub(super) [Plane; 3]);

impl Pyramid {
    /// The pyramid of a plane, which becomes its largest level.
    pub(super) fn new(plane: Plane) -> Self {
        let half = plane.halved();
        Self([half.halved(), half, plane])
    }
}

/// The estimated motion of a frame against the reference, and its quality.
#[derive(Clone, Copy)]
pub(super) struct MotionEstimate {
    pub(super) motion: Motion,
    /// Correlation of the points of strong contrast, −1..=1.
    pub(super) correlation: f32,
    /// The residual: mean absolute difference in levels.
    pub(super) cost: f32,
    /// Whether the motion explains the image far better than no motion, in all quarters but one.
    pub(super) is_clear: bool,
    /// The change of the luma under this motion.
    pub(super) light: LevelChange,
}

impl MotionEstimate {
    /// The estimate where there is no usable contrast.
    pub(super) const NOTHING: Self = Self {
        motion: Motion::NONE,
        correlation: 1.0,
        cost: f32::MAX,
        is_clear: false,
        light: LevelChange::NONE,
    };
}

impl MotionReference {
    /// The reference of a plane.
    pub(super) fn new(plane: &Plane) -> Self {
        let half = plane.halved();
        let quarter = half.halved();
        let places = places(plane);
        let points =
            [(&quarter, 4), (&half, 2), (plane, 1)].map(|(plane, part)| points(plane, &places, part));
        Self { coarse: quarter.contrast(MEAN_RADIUS_PX), points, places }
    }

    /// Whether there are enough points of strong contrast.
    pub(super) fn is_usable(&self) -> bool {
        self.points.iter().all(|points| points.len() >= MIN_POINTS)
    }

    /// The estimate of no motion, where its residual is close to the usual one.
    pub(super) fn find_still(&self, frame: &Frame, factor: usize, usual: f32) -> Option<MotionEstimate> {
        let values: Vec<_> = self.places.iter().map(|&(x, y)| square(frame, factor, x, y)).collect();
        let seen = || self.points[2].iter().copied().zip(values.iter().copied());
        let mut still = MotionFit::of(Motion::NONE);
        still.relight(seen());
        let cost = still.cost(seen());
        (cost <= MAX_STILL_RATIO * usual).then(|| MotionEstimate {
            motion: Motion::NONE,
            correlation: correlation(seen()),
            cost,
            is_clear: false,
            light: LevelChange { gain: still.gain, offset: still.offset },
        })
    }

    /// Estimates the motion of a frame against the reference; `shakes` lowers the required improvement over no
    /// motion.
    pub(super) fn find(&self, frame: &Pyramid, shakes: bool) -> MotionEstimate {
        let (dx, dy) = self.search(&frame.0[0].contrast(MEAN_RADIUS_PX));
        let mut fit = MotionFit::of(Motion { dx: dx as f32, dy: dy as f32, ..Motion::NONE });
        for (level, (plane, points)) in frame.0.iter().zip(&self.points).enumerate() {
            if level > 0 {
                fit.motion.dx *= 2.0;
                fit.motion.dy *= 2.0;
            }
            fit.improve(plane, points, &[DX, DY, GAIN, OFFSET]);
        }
        let mut turned = fit;
        turned.improve(&frame.0[2], &self.points[2], &[DX, DY, TURN, ZOOM, GAIN, OFFSET]);
        let (plane, points) = (&frame.0[2], &self.points[2]);
        let mut still = MotionFit::of(Motion::NONE);
        still.relight(still.seen(plane, points));
        let cost_still = still.cost(still.seen(plane, points));
        let (mut best, mut cost) = (still, cost_still);
        let better = if shakes { 1.0 } else { MAX_RESIDUAL_RATIO };
        for mut fit in [fit, turned] {
            fit.relight(fit.seen(plane, points));
            let left = fit.cost(fit.seen(plane, points));
            if left < cost.min(better * cost_still) {
                (best, cost) = (fit, left);
            }
        }
        let fit = best;
        let is_clear = cost < MAX_UNEXPLAINED * cost_still && self.is_clear(&fit, &still, plane);
        let correlation = correlation(fit.seen(plane, points));
        let light = LevelChange { gain: fit.gain, offset: fit.offset };
        MotionEstimate { motion: fit.motion, correlation, cost, is_clear, light }
    }

    /// Whether `fit` explains the quarters of the image better than `still`, all but one.
    fn is_clear(&self, fit: &MotionFit, still: &MotionFit, plane: &Plane) -> bool {
        let (mut judged, mut better) = (0, 0);
        for quarter in [(true, true), (true, false), (false, true), (false, false)] {
            let points: Vec<_> = self.points[2]
                .iter()
                .copied()
                .filter(|point| (point.x < 0.0, point.y < 0.0) == quarter)
                .collect();
            let [with, without] = [fit, still].map(|fit| fit.cost(fit.seen(plane, &points)));
            if with < f32::MAX && without < f32::MAX {
                judged += 1;
                better += usize::from(with < MAX_UNEXPLAINED_QUARTER * without);
            }
        }
        better + 1 >= judged.max(2)
    }

    /// The shift in pixels, at a quarter of the scale, with the least difference of contrast.
    fn search(&self, frame: &Plane) -> (i32, i32) {
        let (width, height) = (self.coarse.width, self.coarse.height);
        let (reach_x, reach_y) = (MAX_SEARCH_PX.min(width / 4), MAX_SEARCH_PX.min(height / 4));
        let columns = reach_x..width - reach_x;
        let cost = |dx: usize, dy: usize| {
            let mut sum = 0.0;
            for y in (reach_y..height - reach_y).step_by(2) {
                let reference = &self.coarse.data[y * width + columns.start..y * width + columns.end];
                let start = (y + dy - reach_y) * width + dx;
                let row = &frame.data[start..start + columns.len()];
                sum += row_cost(reference, row);
            }
            sum
        };
        // Among similar positions, as along a fence, the nearest one is preferred.
        let cost = |dx: usize, dy: usize| {
            let away = dx.abs_diff(reach_x) + dy.abs_diff(reach_y);
            cost(dx, dy) * (1.0 + SHARE_PER_PIXEL * away as f32)
        };
        let mut best = (cost(reach_x, reach_y), (reach_x, reach_y));
        let try_at = |best: &mut (f32, (usize, usize)), dx: usize, dy: usize| {
            let cost = cost(dx, dy);
            if cost < best.0 {
                *best = (cost, (dx, dy));
            }
        };
        // Every second shift, then the neighbours of the best one.
        for dy in (0..=2 * reach_y).step_by(2) {
            for dx in (0..=2 * reach_x).step_by(2) {
                try_at(&mut best, dx, dy);
            }
        }
        let (near_x, near_y) = best.1;
        for dy in near_y.saturating_sub(1)..=(near_y + 1).min(2 * reach_y) {
            for dx in near_x.saturating_sub(1)..=(near_x + 1).min(2 * reach_x) {
                try_at(&mut best, dx, dy);
            }
        }
        let (dx, dy) = best.1;
        (dx as i32 - reach_x as i32, dy as i32 - reach_y as i32)
    }
}

/// Sum of absolute differences, in eight partial sums so that the result does not depend on the machine.
fn row_cost(one: &[f32], other: &[f32]) -> f32 {
    let mut sums = [0.0_f32; 8];
    let (one, one_rest) = one.as_chunks::<8>();
    let (other, other_rest) = other.as_chunks::<8>();
    for (a, b) in one.iter().zip(other) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += (a - b).abs().min(MAX_RESIDUAL_LEVELS);
        }
    }
    for ((sum, a), b) in sums.iter_mut().zip(one_rest).zip(other_rest) {
        *sum += (a - b).abs().min(MAX_RESIDUAL_LEVELS);
    }
    sums.iter().sum()
}

/// The pixel of strongest contrast in each cell.
fn places(plane: &Plane) -> Vec<(usize, usize)> {
    let mut places = Vec::new();
    for top in (2..plane.height.saturating_sub(POINT_CELL_PX + 2)).step_by(POINT_CELL_PX) {
        for left in (2..plane.width.saturating_sub(POINT_CELL_PX + 2)).step_by(POINT_CELL_PX) {
            let mut best = (MIN_CONTRAST * MIN_CONTRAST, None);
            for y in top..top + POINT_CELL_PX {
                for x in left..left + POINT_CELL_PX {
                    let (across, down) = gradient(plane, x, y);
                    let strength = across * across + down * down;
                    if strength > best.0 {
                        best = (strength, Some((x, y)));
                    }
                }
            }
            places.extend(best.1);
        }
    }
    places
}

fn gradient(plane: &Plane, x: usize, y: usize) -> (f32, f32) {
    let at = y * plane.width + x;
    let data = &plane.data;
    (0.5 * (data[at + 1] - data[at - 1]), 0.5 * (data[at + plane.width] - data[at - plane.width]))
}

/// The points at these positions, on a plane of the full, half or quarter scale (`part` 1, 2 or 4).
fn points(plane: &Plane, places: &[(usize, usize)], part: usize) -> Vec<ContrastPoint> {
    let (centre_x, centre_y) = centre(plane);
    let inside = |x: usize, y: usize| x > 0 && y > 0 && x + 1 < plane.width && y + 1 < plane.height;
    let all = places.iter().map(|&(x, y)| (x / part, y / part)).filter(|&(x, y)| inside(x, y));
    all.map(|(x, y)| {
        let (across, down) = gradient(plane, x, y);
        let value = plane.data[y * plane.width + x];
        ContrastPoint { x: x as f32 - centre_x, y: y as f32 - centre_y, value, across, down }
    })
    .collect()
}

fn centre(plane: &Plane) -> (f32, f32) {
    (0.5 * (plane.width as f32 - 1.0), 0.5 * (plane.height as f32 - 1.0))
}

/// A motion and the change of light fitted with it.
#[derive(Clone, Copy)]
struct MotionFit {
    motion: Motion,
    gain: f32,
    offset: f32,
}

impl MotionFit {
    const fn of(motion: Motion) -> Self {
        Self { motion, gain: 1.0, offset: 0.0 }
    }

    /// The frame's value at each point inside it.
    fn seen<'a>(
        &self,
        plane: &'a Plane,
        points: &'a [ContrastPoint],
    ) -> impl Iterator<Item = (ContrastPoint, f32)> + 'a {
        let (centre_x, centre_y) = centre(plane);
        let motion = self.motion;
        points.iter().filter_map(move |point| {
            let (x, y) = motion.apply(point.x, point.y);
            Some((*point, plane.at(x + centre_x, y + centre_y)?))
        })
    }

    fn residual(&self, point: &ContrastPoint, value: f32) -> f32 {
        value - (self.gain * point.value + self.offset)
    }

    /// Iterates robust least squares over the given parameters until the step is short.
    fn improve<const N: usize>(&mut self, plane: &Plane, points: &[ContrastPoint], numbers: &[usize; N]) {
        for _ in 0..LEAST_SQUARES_STEPS {
            match self.improved(plane, points, numbers) {
                Some((better, length)) => {
                    *self = better;
                    if length < 0.01 {
                        break;
                    }
                }
                None => break,
            }
        }
    }

    /// One step of robust least squares; returns the step's length in pixels.
    fn improved<const N: usize>(
        &self,
        plane: &Plane,
        points: &[ContrastPoint],
        numbers: &[usize; N],
    ) -> Option<(Self, f32)> {
        let seen: Vec<_> = self.seen(plane, points).collect();
        if seen.len() < MIN_POINTS {
            return None;
        }
        let mut sizes: Vec<f32> =
            seen.iter().map(|(point, value)| self.residual(point, *value).abs()).collect();
        let reach = robust::reach(&mut sizes).clamp(8.0, 40.0);
        let mut normal = SMatrix::<f64, N, N>::zeros();
        let mut right = SVector::<f64, N>::zeros();
        for (point, value) in &seen {
            let residual = self.residual(point, *value);
            let share = residual / reach;
            if share.abs() >= 1.0 {
                continue;
            }
            let weight = f64::from((1.0 - share * share) * (1.0 - share * share));
            let (across, down) = (self.gain * point.across, self.gain * point.down);
            let all = [
                across,
                down,
                down * point.x - across * point.y,
                across * point.x + down * point.y,
                -point.value,
                -1.0,
            ];
            let row = SVector::from(numbers.map(|number| f64::from(all[number])));
            // Only the lower triangle is read.
            normal.syger(weight, &row, &row, 1.0);
            right.axpy(-weight * f64::from(residual), &row, 1.0);
        }
        let step = normal.cholesky()?.solve(&right);
        let mut steps = [0.0; 6];
        for (number, step) in numbers.iter().zip(step.iter()) {
            steps[*number] = *step as f32;
        }
        let [dx, dy, turn, zoom, gain, offset] = steps;
        let better = Self {
            motion: Motion {
                dx: self.motion.dx + dx,
                dy: self.motion.dy + dy,
                turn: self.motion.turn + turn,
                zoom: self.motion.zoom + zoom,
            },
            gain: (self.gain + gain).clamp(0.2, 5.0),
            offset: self.offset + offset,
        };
        let corner = 0.5 * plane.width as f32;
        let length = dx.abs() + dy.abs() + corner * (turn.abs() + zoom.abs());
        let tilt = better.motion.turn.abs().max(better.motion.zoom.abs());
        let sound =
            steps.iter().all(|number| number.is_finite()) && tilt < MAX_TURN_AND_ZOOM && length < corner;
        sound.then_some((better, length))
    }

    /// Fits the gain to these points.
    fn relight(&mut self, seen: impl Iterator<Item = (ContrastPoint, f32)>) {
        let mut ratios: Vec<f32> =
            seen.filter(|(point, _)| point.value > 8.0).map(|(point, value)| value / point.value).collect();
        if !ratios.is_empty() {
            self.gain = robust::median(&mut ratios).clamp(0.2, 5.0);
            self.offset = 0.0;
        }
    }

    /// The mean of the limited absolute differences.
    fn cost(&self, seen: impl Iterator<Item = (ContrastPoint, f32)>) -> f32 {
        let (mut sum, mut count) = (0.0, 0.0);
        for (point, value) in seen {
            sum += self.residual(&point, value).abs().min(MAX_RESIDUAL_LEVELS);
            count += 1.0;
        }
        if count < MIN_POINTS as f32 { f32::MAX } else { sum / count }
    }
}

fn correlation(seen: impl Iterator<Item = (ContrastPoint, f32)>) -> f32 {
    let mut sums = [0.0_f64; 6];
    for (point, value) in seen {
        let (a, b) = (f64::from(point.value), f64::from(value));
        for (sum, term) in sums.iter_mut().zip([1.0, a, b, a * a, b * b, a * b]) {
            *sum += term;
        }
    }
    let [n, a, b, aa, bb, ab] = sums;
    let spread = (aa - a * a / n.max(1.0)).max(0.0) * (bb - b * b / n.max(1.0)).max(0.0);
    if spread > 0.0 { ((ab - a * b / n) / spread.sqrt()) as f32 } else { 0.0 }
}
