//! A Kalman model of a moving region: position and size, constant velocity (§VIII).

use nalgebra::{Matrix3, Matrix3x6, Matrix6, Vector3, Vector6};

use crate::regions::Rect;

/// The noise of the process and of the measurements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of position and size relative to constant velocity, in pixels per frame period.
    pub process: f32,
    /// Standard deviation of a measured position and size, in pixels.
    pub measurement: f32,
}

/// The measurement of a region: (x, y, s), the centre of its box and s = √area, in pixels.
pub type Measurement = Vector3<f32>;

/// The difference of a measurement from a model's prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// Squared Mahalanobis length of the difference.
    pub distance_squared: f32,
    /// ln of the innovation covariance's determinant over that of the noise of one frame alone.
    pub log_spread: f32,
}

impl Innovation {
    /// Log-likelihood of the measurement, up to a constant that is common to all models of one noise.
    pub fn log_likelihood(self) -> f32 {
        -0.5 * (self.distance_squared + self.log_spread)
    }
}

/// A Kalman filter of a moving region; a frame period is the time from frame to frame at the average rate. It has the state (x, y, s, vx, vy, vs), in pixels and pixels per frame period, and its covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct KalmanModel {
    state: Vector6<f32>,
    covariance: Matrix6<f32>,
    noise: Noise,
}

impl KalmanModel {
    /// A model that starts at a measurement with a velocity (vx, vy, vs) of standard deviation `velocity_sigma`, in
    /// pixels per frame period.
    pub fn new(at: Measurement, velocity: Vector3<f32>, velocity_sigma: f32, noise: Noise) -> Self {
        let scale = noise_scale(at.z);
        let position = (scale * noise.measurement).powi(2);
        let speed = (scale * velocity_sigma).powi(2);
        Self {
            state: Vector6::new(at.x, at.y, at.z, velocity.x, velocity.y, velocity.z),
            covariance: Matrix6::from_diagonal(&Vector6::new(
                position, position, position, speed, speed, speed,
            )),
            noise,
        }
    }

    /// The model through two measurements that are `periods` frame periods apart, with the state at the second.
    pub fn through(first: Measurement, second: Measurement, periods: f32, noise: Noise) -> Self {
        let velocity_sigma = noise.measurement * std::f32::consts::SQRT_2 / periods;
        Self::new(second, (second - first) / periods, velocity_sigma, noise)
    }

    /// Predicts the state by a number of frame periods, 1 from one frame to the next of a constant rate. A whole number n
    /// has the same effect as n predictions by one period.
    pub fn predict(&mut self, periods: f32) {
        let n = periods;
        let mut transition = Matrix6::identity();
        transition.fixed_view_mut::<3, 3>(0, 3).fill_diagonal(n);
        // White acceleration within a period: the position has standard deviation q, the velocity q/2. The errors of
        // the velocity after each of n periods add to the position.
        let process = noise_scale(self.state.z) * self.noise.process;
        let (q, v) = (process.powi(2), (process / 2.0).powi(2));
        let position = n * q + n * (n - 1.0) * (2.0 * n - 1.0) / 6.0 * v;
        let mut noise =
            Matrix6::from_diagonal(&Vector6::new(position, position, position, n * v, n * v, n * v));
        for (row, column) in [(0, 3), (3, 0)] {
            noise.fixed_view_mut::<3, 3>(row, column).fill_diagonal(n * (n - 1.0) / 2.0 * v);
        }
        self.state = transition * self.state;
        self.covariance = transition * self.covariance * transition.transpose() + noise;
    }

    /// What it expects to measure, if the object may have deviated from constant velocity by `manoeuvre` pixels (standard
    /// deviation of position and of size); 0 is constant velocity.
    pub fn expected_measurement(&self, manoeuvre: f32) -> ExpectedMeasurement {
        let spread = self.innovation_covariance() + Matrix3::from_diagonal_element(manoeuvre.powi(2));
        let nominal =
            noise_scale(self.state.z).powi(2) * (self.noise.process.powi(2) + self.noise.measurement.powi(2));
        let log_spread = (spread.determinant().max(f32::MIN_POSITIVE) / nominal.powi(3)).ln();
        ExpectedMeasurement {
            mean: self.measurement(),
            variances: spread.diagonal(),
            inverse: spread.try_inverse(),
            log_spread,
        }
    }

    /// Updates it with a measurement after a manoeuvre of `manoeuvre` pixels (standard deviation).
    pub fn update_after_manoeuvre(&mut self, measured: &Measurement, manoeuvre: f32) {
        let position = manoeuvre.powi(2);
        // The course changed within the last frame: the change of place is one of velocity, too.
        self.covariance +=
            Matrix6::from_diagonal(&Vector6::new(position, position, position, position, position, position));
        for (place, velocity) in [(0, 3), (3, 0)] {
            let mut both = self.covariance.fixed_view_mut::<3, 3>(place, velocity);
            both += Matrix3::from_diagonal_element(0.7 * position);
        }
        self.update(measured, 1.0);
    }

    /// Updates it with a measurement; `trust` multiplies the standard deviation of the measurement.
    pub fn update(&mut self, measured: &Measurement, trust: f32) {
        let observe = Matrix3x6::<f32>::identity();
        let noise = Matrix3::from_diagonal_element((self.measurement_sigma() * trust).powi(2));
        let spread = self.covariance.fixed_view::<3, 3>(0, 0) + noise;
        // Sums of positive definite matrices always have an inverse; should rounding say otherwise,
        // the prediction stands.
        let Some(inverse) = spread.try_inverse() else { return };
        let gain = self.covariance * observe.transpose() * inverse;
        self.state += gain * (measured - self.measurement());
        self.covariance = (Matrix6::identity() - gain * observe) * self.covariance;
        // Rounding must not let the covariance drift from symmetry.
        self.covariance = (self.covariance + self.covariance.transpose()) * 0.5;
    }

    /// Restarts at a measurement with the same velocity and the covariance of a new model.
    pub fn restart_at(&mut self, measured: &Measurement) {
        *self = Self::new(*measured, self.velocity(), self.noise.measurement, self.noise);
    }

    /// Sets the velocity (vx, vy, vs), in pixels per frame period; the covariance stays.
    pub fn set_velocity(&mut self, velocity: Vector3<f32>) {
        self.state.fixed_rows_mut::<3>(3).copy_from(&velocity);
    }

    /// Sets the centre, in pixels; the covariance stays.
    pub fn set_centre(&mut self, centre: [f32; 2]) {
        [self.state.x, self.state.y] = centre;
    }

    /// The estimated (x, y, s), in pixels.
    pub fn measurement(&self) -> Measurement {
        self.state.fixed_rows::<3>(0).into_owned()
    }

    /// The estimated velocity (vx, vy, vs), in pixels per frame period.
    pub fn velocity(&self) -> Vector3<f32> {
        self.state.fixed_rows::<3>(3).into_owned()
    }

    /// The estimated centre (x, y), in pixels.
    pub fn centre(&self) -> [f32; 2] {
        [self.state.x, self.state.y]
    }

    /// The estimated s = √area, in pixels.
    pub fn scale(&self) -> f32 {
        self.state.z
    }

    /// Half axes (pixels) and angle (radians) of the ellipse around the centre in which the next measured position
    /// has a χ² of at most `chi_squared`.
    pub fn gate_ellipse(&self, chi_squared: f32) -> [f32; 3] {
        let spread = self.innovation_covariance();
        let (a, b, c) = (spread.m11, spread.m12, spread.m22);
        let root = ((a - c).powi(2) / 4.0 + b * b).sqrt();
        let middle = f32::midpoint(a, c);
        let half = |eigenvalue: f32| (chi_squared * eigenvalue.max(0.0)).sqrt();
        [half(middle + root), half(middle - root), 0.5 * (2.0 * b).atan2(a - c)]
    }

    fn innovation_covariance(&self) -> Matrix3<f32> {
        self.covariance.fixed_view::<3, 3>(0, 0)
            + Matrix3::from_diagonal_element(self.measurement_sigma().powi(2))
    }

    /// Standard deviation of a measured position and size, in pixels.
    fn measurement_sigma(&self) -> f32 {
        noise_scale(self.state.z) * self.noise.measurement
    }
}

/// What a model expects to measure in a frame, prepared to be compared with many measurements.
#[derive(Clone, Copy, Debug)]
pub struct ExpectedMeasurement {
    mean: Measurement,
    /// Of each component of a measurement.
    variances: Vector3<f32>,
    /// Of the covariance of a measurement.
    inverse: Option<Matrix3<f32>>,
    log_spread: f32,
}

impl ExpectedMeasurement {
    /// The box that holds the position of every measurement within the gate, `gate` in squared Mahalanobis lengths: no
    /// component of such a measurement is farther away than the whole.
    pub fn reach(&self, gate: f32) -> Rect {
        // More than a rounded length differs from an exact one.
        let [x, y] = [self.variances.x, self.variances.y].map(|variance| 1.01 * (gate * variance).sqrt());
        Rect::around([self.mean.x, self.mean.y], 2.0 * x, 2.0 * y)
    }

    /// The squared Mahalanobis length of the difference of a measurement; infinite where the covariance has no inverse.
    pub fn distance_squared(&self, measured: &Measurement) -> f32 {
        let difference = measured - self.mean;
        self.inverse.map_or(f32::INFINITY, |inverse| (difference.transpose() * inverse * difference).x)
    }

    /// The difference of a measurement.
    pub fn innovation(&self, measured: &Measurement) -> Innovation {
        Innovation { distance_squared: self.distance_squared(measured), log_spread: self.log_spread }
    }
}

/// From this √area on, in pixels, the noise grows with the object's size. Tried from 40 to 100 on people from 30 to 300
/// pixels tall.
const LARGE_OBJECT_PX: f32 = 80.0;

/// The noise of a region of this √area relative to that of a small one: errors of mask and motion are proportional to
/// the size of a large object.
fn noise_scale(size: f32) -> f32 {
    (size / LARGE_OBJECT_PX).clamp(1.0, 10.0)
}

/// The χ² quantile with 3 degrees of freedom, by bisection of the distribution function
/// 2Φ(√x) − 1 − √(2x/π)·e^(−x/2).
pub fn chi_squared_3(probability: f32) -> f32 {
    let distribution = |x: f64| {
        2.0 * normal_distribution(x.sqrt()) - 1.0 - (2.0 * x / std::f64::consts::PI).sqrt() * (-x / 2.0).exp()
    };
    let (mut low, mut high) = (0.0, 100.0);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if distribution(middle) < f64::from(probability) { low = middle } else { high = middle }
    }
    f64::midpoint(low, high) as f32
}

/// Φ(z) (Abramowitz & Stegun 26.2.17, error below 7.5e-8).
fn normal_distribution(z: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * z.abs());
    let series = t
        * (0.319_381_53
            + t * (-0.356_563_782 + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    let tail = (-z * z / 2.0).exp() / (2.0 * std::f64::consts::PI).sqrt() * series;
    if z >= 0.0 { 1.0 - tail } else { tail }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing)]
    use proptest::prelude::*;

    use super::*;

    const NOISE: Noise = Noise { process: 1.0, measurement: 2.0 };

    #[test]
    fn the_quantiles_agree_with_published_tables() {
        for (probability, quantile) in [(0.5, 2.366), (0.95, 7.815), (0.99, 11.345), (0.999, 16.266)] {
            assert!((chi_squared_3(probability) / quantile - 1.0).abs() < 0.001, "{probability}");
        }
    }

    #[test]
    fn a_model_through_two_measurements_predicts_the_third_on_their_line() {
        let mut model =
            KalmanModel::through(Vector3::new(10.0, 5.0, 8.0), Vector3::new(13.0, 4.0, 8.0), 1.0, NOISE);
        model.predict(1.0);
        assert_eq!(model.measurement(), Vector3::new(16.0, 3.0, 8.0));
        assert_eq!(model.expected_measurement(0.0).distance_squared(&Vector3::new(16.0, 3.0, 8.0)), 0.0);
    }

    #[test]
    fn a_prediction_over_several_periods_equals_that_many_of_one_period() {
        let mut once = KalmanModel::through(at_x(10.0), at_x(19.0), 3.0, NOISE);
        assert_eq!(once.velocity().x, 3.0, "nine pixels in three periods");
        let mut often = once.clone();
        once.predict(7.0);
        (0..7).for_each(|_| often.predict(1.0));
        assert_eq!(once.measurement(), often.measurement());
        assert!((once.covariance - often.covariance).abs().max() < 1e-3 * once.covariance.max());
        let mut halves = often.clone();
        often.predict(1.0);
        (0..2).for_each(|_| halves.predict(0.5));
        assert_eq!(halves.measurement(), often.measurement());
        assert!((halves.covariance - often.covariance).abs().max() < 0.01 * often.covariance.max());
    }

    fn at_x(x: f32) -> Measurement {
        Vector3::new(x, 5.0, 8.0)
    }

    #[test]
    fn of_two_equal_predictions_the_one_with_the_smaller_covariance_is_likelier() {
        let at = Vector3::new(100.0, 50.0, 20.0);
        let sure = KalmanModel::new(at, Vector3::zeros(), 1.0, NOISE);
        let mut vague = sure.clone();
        (0..5).for_each(|_| vague.predict(1.0));
        let near = Vector3::new(101.0, 50.0, 20.0);
        let likelihood =
            |model: &KalmanModel| model.expected_measurement(0.0).innovation(&near).log_likelihood();
        assert!(likelihood(&sure) > likelihood(&vague) + 1.0);
        let far = Vector3::new(112.0, 50.0, 20.0);
        let of = |manoeuvre: f32| sure.expected_measurement(manoeuvre).innovation(&far).log_likelihood();
        assert!(of(8.0) > of(0.0), "a jump is likelier where manoeuvres are expected");
    }

    #[test]
    fn an_update_after_a_manoeuvre_changes_the_velocity_at_once() {
        let mut model =
            KalmanModel::new(Vector3::new(100.0, 50.0, 20.0), Vector3::new(3.0, 0.0, 0.0), 0.5, NOISE);
        let mut steady = model.clone();
        let jumped = Vector3::new(96.0, 60.0, 20.0);
        for each in [&mut model, &mut steady] {
            each.predict(1.0);
        }
        model.update_after_manoeuvre(&jumped, 8.0);
        steady.update(&jumped, 1.0);
        assert!((model.centre()[0] - 96.0).abs() < 1.0 && (model.centre()[1] - 60.0).abs() < 1.0);
        assert!(
            model.velocity().y > 5.0 && steady.velocity().y < 2.0,
            "{} {}",
            model.velocity(),
            steady.velocity()
        );
    }

    #[test]
    fn the_gate_of_a_large_object_grows_with_its_size() {
        let gate = |size: f32| {
            KalmanModel::new(Vector3::new(0.0, 0.0, size), Vector3::zeros(), 1.0, NOISE).gate_ellipse(11.3)[0]
        };
        assert_eq!(gate(20.0), gate(60.0));
        assert!((gate(240.0) / gate(60.0) - 3.0).abs() < 0.01);
    }

    #[test]
    fn it_converges_to_a_constant_velocity_and_its_covariance_shrinks() {
        let at = |frame: f32| Vector3::new(2.5 * frame, 100.0 - frame, 20.0);
        let mut model = KalmanModel::through(at(0.0), at(1.0) + Vector3::new(2.0, -1.0, 0.0), 1.0, NOISE);
        let unsure = {
            model.predict(1.0);
            model.gate_ellipse(11.3)[0]
        };
        for frame in 2..40 {
            if frame > 2 {
                model.predict(1.0);
            }
            model.update(&at(frame as f32), 1.0);
        }
        assert!((model.velocity() - Vector3::new(2.5, -1.0, 0.0)).norm() < 0.1);
        model.predict(1.0);
        assert!(model.gate_ellipse(11.3)[0] < unsure);
        for _ in 0..10 {
            model.predict(1.0);
        }
        assert!((model.centre()[0] - 2.5 * 50.0).abs() < 3.0, "{:?}", model.centre());
    }

    proptest! {
        #[test]
        fn no_measurement_within_the_gate_is_out_of_reach(
            path in prop::array::uniform2(prop::array::uniform3(1.0_f32..60.0)),
            offset in prop::array::uniform3(-15.0_f32..15.0),
            periods in 1_u8..4,
        ) {
            let [first, second] = path.map(Vector3::from);
            let mut model = KalmanModel::through(first, second, 1.0, NOISE);
            model.predict(f32::from(periods));
            let (expected, gate) = (model.expected_measurement(0.0), chi_squared_3(0.99));
            let measured = model.measurement() + Vector3::from(offset);
            let is_within = expected.distance_squared(&measured) <= gate;
            let holds = |measured: Measurement| {
                let [dx, dy] = expected.reach(gate).gap(&Rect::new(measured.x, measured.y, 0.0, 0.0));
                dx == 0.0 && dy == 0.0
            };
            prop_assert!(!is_within || holds(measured));
            prop_assert!(!holds(measured.map(|value| value + 1000.0)));
        }
    }

    /// One coordinate of the filter: position, velocity and their covariances. The coordinates do not depend on each
    /// other, and have the same covariances.
    #[derive(Clone, Copy)]
    struct Coordinate {
        position: f32,
        velocity: f32,
        pp: f32,
        pv: f32,
        vv: f32,
    }

    impl Coordinate {
        /// A step of one period with the process noise q of the position, q/2 of the velocity.
        fn predict(&mut self, q: f32) {
            self.position += self.velocity;
            self.pp += 2.0 * self.pv + self.vv + q * q;
            self.pv += self.vv;
            self.vv += q * q / 4.0;
        }

        fn update(&mut self, measured: f32, sigma: f32) {
            let spread = self.pp + sigma * sigma;
            let (gain_p, gain_v) = (self.pp / spread, self.pv / spread);
            let difference = measured - self.position;
            self.position += gain_p * difference;
            self.velocity += gain_v * difference;
            self.vv -= gain_v * self.pv;
            self.pv -= gain_p * self.pv;
            self.pp -= gain_p * self.pp;
        }
    }

    fn close(found: f32, expected: f32) -> bool {
        (found - expected).abs() <= 2e-4 * expected.abs().max(1.0)
    }

    /// A small object, whose noise is that of the settings, and one three times as large as from which the noise grows.
    #[test]
    fn every_coordinate_is_filtered_as_one_alone() {
        let noise = Noise { process: 1.5, measurement: 2.0 };
        for (size, times) in [(20.0, 1.0), (240.0, 3.0)] {
            let (q, r) = (times * noise.process, times * noise.measurement);
            let at = |x: f32, y: f32| Vector3::new(x, y, size);
            let mut model = KalmanModel::through(at(70.0, 60.0), at(100.0, 50.0), 2.0, noise);
            // Two measurements, two periods apart.
            let vv = 2.0 * r * r / 4.0;
            let mut x = Coordinate { position: 100.0, velocity: 15.0, pp: r * r, pv: 0.0, vv };
            let mut y = Coordinate { position: 50.0, velocity: -5.0, ..x };
            let agree = |model: &KalmanModel, x: &Coordinate, y: &Coordinate| {
                let covariance = &model.covariance;
                for (index, of) in [x, y].into_iter().enumerate() {
                    assert!(close(model.state[index], of.position), "{} {}", model.state, of.position);
                    assert!(close(model.state[index + 3], of.velocity), "{} {}", model.state, of.velocity);
                }
                for index in 0..3 {
                    assert!(close(covariance[(index, index)], x.pp), "{covariance} {}", x.pp);
                    assert!(close(covariance[(index, index + 3)], x.pv), "{covariance} {}", x.pv);
                    assert!(close(covariance[(index + 3, index)], x.pv), "{covariance} {}", x.pv);
                    assert!(close(covariance[(index + 3, index + 3)], x.vv), "{covariance} {}", x.vv);
                }
                assert_eq!((covariance[(0, 1)], covariance[(2, 3)], model.state[5]), (0.0, 0.0, 0.0));
            };
            agree(&model, &x, &y);
            for (measured_x, measured_y, trust) in
                [(118.0, 47.0, 1.0), (127.0, 35.0, 3.0), (150.0, 33.0, 0.5)]
            {
                model.predict(1.0);
                x.predict(q);
                y.predict(q);
                agree(&model, &x, &y);

                let measured = at(measured_x, measured_y);
                let squared = (measured_x - x.position).powi(2) + (measured_y - y.position).powi(2);
                assert!(close(
                    model.expected_measurement(0.0).distance_squared(&measured),
                    squared / (x.pp + r * r)
                ));
                for manoeuvre in [0.0, 7.0_f32] {
                    let spread = x.pp + r * r + manoeuvre * manoeuvre;
                    let innovation = model.expected_measurement(manoeuvre).innovation(&measured);
                    assert!(close(innovation.distance_squared, squared / spread));
                    assert!(close(innovation.log_spread, 3.0 * (spread / (q * q + r * r)).ln()));
                }
                let radius = (2.0 * (x.pp + r * r)).sqrt();
                let [long, short, angle] = model.gate_ellipse(2.0);
                assert!(close(long, radius) && close(short, radius) && angle == 0.0);

                model.update(&measured, trust);
                x.update(measured_x, trust * r);
                y.update(measured_y, trust * r);
                agree(&model, &x, &y);
            }
            model.update_after_manoeuvre(&at(160.0, 60.0), 8.0);
            for (of, measured) in [(&mut x, 160.0), (&mut y, 60.0)] {
                of.pp += 64.0;
                of.vv += 64.0;
                of.pv += 0.7 * 64.0;
                of.update(measured, r);
            }
            agree(&model, &x, &y);
            model.restart_at(&at(10.0, 20.0));
            x = Coordinate { position: 10.0, pp: r * r, pv: 0.0, vv: r * r, ..x };
            agree(&model, &x, &Coordinate { position: 20.0, velocity: y.velocity, ..x });
        }
    }

    /// The covariance of the place and of its measurement has the eigenvalues 28 and 8.
    #[test]
    fn the_gate_is_an_ellipse_along_the_larger_spread() {
        let mut model = KalmanModel::new(Vector3::new(0.0, 0.0, 20.0), Vector3::zeros(), 1.0, NOISE);
        let [xx, xy, yy] = [20.0, 8.0, 8.0];
        (model.covariance[(0, 0)], model.covariance[(1, 1)]) = (xx, yy);
        (model.covariance[(0, 1)], model.covariance[(1, 0)]) = (xy, xy);
        let [long, short, angle] = model.gate_ellipse(2.0);
        assert!(close(long, 56.0_f32.sqrt()) && close(short, 4.0), "{long} {short}");
        assert!(close(angle, 0.5 * (16.0_f32 / 12.0).atan()), "{angle}");
    }
}
