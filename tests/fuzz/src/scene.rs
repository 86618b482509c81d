//! Paths and vehicles out of bytes.

use crate::bytes::Bytes;
use popsteer_core::bounds::{MAX_COORDINATE, MAX_DT, MAX_SPEED, MAX_YAW, MIN_DT};
use popsteer_core::vehicle::kalman::Walk;
use popsteer_core::vehicle::wheels::{Reached, WheelIntegrals};
use popsteer_core::vehicle::{AdaptParams, Estimate, Estimator};
use popsteer_core::{Path, PathError, PathView, Vehicle, VehicleState};
use std::f64::consts::FRAC_PI_4;

/// Waypoints that may or may not make a path.
#[derive(Clone, Debug, Default)]
pub struct Waypoints {
    /// Abscissas [m].
    pub x: Vec<f64>,
    /// Ordinates [m].
    pub y: Vec<f64>,
    /// Reference speeds [m/s], whose signs say where the path is driven backwards.
    pub speed: Option<Vec<f64>>,
    /// Where the path is driven backwards, said outright.
    pub reverse: Option<Vec<bool>>,
    /// Whether the last leads back to the first.
    pub closed: bool,
}

impl Waypoints {
    /// A walk of at most 20 steps, or twice as many: straight, bent, back on itself, crossing itself, along a
    /// lattice where many places are as near as others, far from the origin; now and then with a
    /// waypoint twice, there and back, or with numbers that no path can have.
    pub fn draw(bytes: &mut Bytes) -> Self {
        let form = bytes.byte();
        let place = usize::from(bytes.byte());
        let (count, out_and_back) = (place % 21, place >= 168);
        let (signed, lattice) = (form & 8 == 8, form & 16 == 16);
        let spacing = [1.0, 1.0, 0.01, 100.0, 0.2, 5.0, 1e-9, 1e7][bytes.below(8)];
        let origin = [0.0, 0.0, 0.0, 50.0, -1e3, 1e7, -1e9, 1e9][usize::from(form >> 5)];
        let mut waypoints = Self {
            closed: form & 1 == 1,
            speed: (form & 2 == 2).then(Vec::new),
            reverse: (form & 4 == 4).then(Vec::new),
            ..Self::default()
        };
        let (mut x, mut y, mut yaw) = (origin, -origin, 0.0_f64);
        for _ in 0..count {
            waypoints.push(x, y, signed, bytes);
            match bytes.byte() {
                // The same place again, an earlier one, any.
                255 => {}
                254 if !waypoints.x.is_empty() => {
                    let earlier = bytes.below(waypoints.x.len());
                    (x, y) = (waypoints.x[earlier], waypoints.y[earlier]);
                }
                253 => {
                    let whole = [-MAX_COORDINATE, MAX_COORDINATE];
                    x = bytes.number([-10.0, 10.0], whole);
                    y = bytes.number([-10.0, 10.0], whole);
                }
                steps if lattice => {
                    let length = spacing * f64::from(1 + steps / 4 % 4);
                    let (along_x, along_y) =
                        [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][usize::from(steps % 4)];
                    x += length * along_x;
                    y += length * along_y;
                }
                length => {
                    yaw += f64::from(bytes.byte().cast_signed()) / 40.0;
                    let length = spacing * f64::from(length.saturating_add(1)) / 64.0;
                    x += length * yaw.cos();
                    y += length * yaw.sin();
                }
            }
        }
        if out_and_back {
            waypoints.come_back(bytes);
        }
        waypoints
    }

    /// Back again the same way, or a little beside it.
    fn come_back(&mut self, bytes: &mut Bytes) {
        let aside = [0.0, 0.5, 1.0, 3.0][bytes.below(4)];
        for k in (0..self.x.len()).rev() {
            self.x.push(self.x[k] - aside);
            self.y.push(self.y[k] + aside);
            if let Some(speed) = &mut self.speed {
                speed.push(speed[k]);
            }
            if let Some(reverse) = &mut self.reverse {
                reverse.push(reverse[k]);
            }
        }
    }

    fn push(&mut self, x: f64, y: f64, signed: bool, bytes: &mut Bytes) {
        self.x.push(x);
        self.y.push(y);
        if let Some(speed) = &mut self.speed {
            let usual = [if signed { -10.0 } else { 0.0 }, 30.0];
            let drawn = bytes.number(usual, [-MAX_SPEED, MAX_SPEED]);
            speed.push(if signed && drawn.abs() < 1.0 {
                0.0
            } else {
                drawn
            });
        }
        if let Some(reverse) = &mut self.reverse {
            // Mostly as the segment before.
            let before = reverse.last().copied().unwrap_or(false);
            reverse.push(before ^ (bytes.byte() < 64));
        }
    }

    /// The path of these waypoints.
    pub fn path(&self) -> Result<Path, PathError> {
        let path = Path::new(&self.x, &self.y, self.speed.as_deref(), self.closed)?;
        match &self.reverse {
            Some(reverse) => path.with_reverse(reverse),
            None => Ok(path),
        }
    }
}

/// A vehicle somewhere by the path, far from it, or nowhere at all.
pub fn vehicle(bytes: &mut Bytes, path: &PathView<'_>) -> VehicleState {
    let coordinates = [-MAX_COORDINATE, MAX_COORDINATE];
    let yaws = [-MAX_YAW, MAX_YAW];
    let speeds = [-MAX_SPEED, MAX_SPEED];
    match bytes.byte() {
        0..=169 => {
            let k = bytes.below(path.len());
            VehicleState {
                x: path.x()[k] + bytes.within(-8.0, 8.0),
                y: path.y()[k] + bytes.within(-8.0, 8.0),
                yaw: bytes.within(-3.2, 3.2),
                speed: bytes.number([-2.0, 30.0], speeds),
            }
        }
        // Half way between waypoints, along an axis or half way between two.
        170..=199 => {
            let k = bytes.below(path.len());
            let mut half_steps = || f64::from(bytes.byte() % 9) - 4.0;
            VehicleState {
                x: path.x()[k] + 0.5 * half_steps(),
                y: path.y()[k] + 0.5 * half_steps(),
                yaw: FRAC_PI_4 * half_steps(),
                speed: half_steps(),
            }
        }
        200..=219 => {
            let k = bytes.below(path.len());
            VehicleState {
                x: path.x()[k],
                y: path.y()[k],
                yaw: bytes.number([-7.0, 7.0], yaws),
                speed: bytes.number([0.0, 1e-3], speeds),
            }
        }
        _ => VehicleState {
            x: bytes.number([-100.0, 100.0], coordinates),
            y: bytes.number([-100.0, 100.0], coordinates),
            yaw: bytes.number([-7.0, 7.0], yaws),
            speed: bytes.number([0.0, 30.0], speeds),
        },
    }
}

/// A control period [s].
pub fn dt(bytes: &mut Bytes) -> f64 {
    if bytes.byte() < 160 {
        0.05
    } else {
        bytes.number([0.001, 0.5], [MIN_DT, MAX_DT])
    }
}

/// A vehicle that may or may not be one.
pub fn car(bytes: &mut Bytes) -> Vehicle {
    let standard = Vehicle::DEFAULT;
    Vehicle {
        wheelbase: bytes.parameter(standard.wheelbase, [1.0, 4.0], [1e-3, 1e3]),
        rear_axle: bytes.parameter(0.0, [-3.0, 1.0], [-1e3, 1e3]),
        no_slip_point: bytes.optional([-3.0, 1.0], [-1e3, 1e3]),
        turning_wheelbase: bytes.optional([1.0, 4.0], [1e-3, 1e3]),
        understeer: bytes.parameter(0.0, [0.0, 0.01], [0.0, 1e3]),
        steer_offset: bytes.parameter(0.0, [-0.1, 0.1], [-0.5, 0.5]),
        steer_lag: bytes.parameter(standard.steer_lag, [0.0, 0.5], [0.0, 10.0]),
        dead_time: bytes.parameter(0.0, [0.0, 0.5], [0.0, 10.0]),
        max_steer: bytes.parameter(standard.max_steer, [0.3, 1.3], [1e-3, 1.57]),
        max_steer_rate: bytes.optional([0.1, 2.0], [1e-3, 1e6]),
        max_lateral_acceleration: bytes.optional([1.0, 15.0], [1e-3, 1e6]),
        // No controller asks for what follows: it need not be drawn each by itself.
        ..match bytes.byte() {
            0..=199 => standard,
            _ => Vehicle {
                width: bytes.optional([0.2, 3.0], [1e-3, 1e2]),
                antenna_left: bytes.parameter(0.0, [-1.0, 1.0], [-1e2, 1e2]),
                antenna_height: bytes.parameter(0.0, [0.0, 3.0], [0.0, 1e2]),
                steer_play: bytes.parameter(0.0, [0.0, 0.03], [0.0, 0.5]),
                max_speed: bytes.optional([1.0, 40.0], [1e-3, 1e4]),
                max_acceleration: bytes.optional([0.1, 5.0], [1e-3, 1e3]),
                max_deceleration: bytes.optional([0.1, 9.0], [1e-3, 1e3]),
                brake_deceleration: bytes.optional([0.1, 9.0], [1e-3, 1e3]),
                drive_delay: bytes.parameter(standard.drive_delay, [0.0, 0.5], [0.0, 10.0]),
                drive_lag: bytes.parameter(0.0, [0.0, 1.0], [0.0, 10.0]),
                stop_point: bytes.optional([-3.0, 6.0], [-1e3, 1e3]),
                steers_at_rest: bytes.byte() & 1 == 0,
                ..standard
            },
        }
    }
}

/// How fast a controller adapts, which may or may not be possible.
pub fn adapt(bytes: &mut Bytes) -> AdaptParams {
    AdaptParams {
        turn_time: bytes.parameter(10.0, [0.0, 20.0], [0.0, 1e6]),
        slip_time: bytes.parameter(5.0, [0.0, 20.0], [0.0, 1e6]),
        speed_time: bytes.parameter(20.0, [0.0, 20.0], [0.0, 1e6]),
    }
}

/// What the motion may or may not have shown of a vehicle with this wheelbase and dead time.
pub fn estimate(bytes: &mut Bytes, wheelbase: f64, dead_time: f64) -> Estimate {
    if bytes.byte() < 100 {
        return Estimate::DEFAULT;
    }
    let longer = 0.5 * dead_time;
    let most = 20.0 * wheelbase;
    Estimate {
        gain: bytes.number([0.5, 1.5], [Estimator::MIN_GAIN, Estimator::MAX_GAIN]),
        steer_offset: symmetric(bytes, 0.05, Estimator::MAX_STEER_OFFSET),
        longer_dead_time: symmetric(bytes, longer, longer),
        slip: symmetric(bytes, 0.05, Estimator::MAX_SLIP),
        slip_length: symmetric(bytes, 1.0, wheelbase),
        acceleration: symmetric(bytes, 5.0, most),
        speed_scale: bytes.number([0.7, 1.5], Estimator::SCALES.into()),
    }
}

/// What an estimate may or may not rest on.
pub fn estimator(bytes: &mut Bytes, wheelbase: f64, dead_time: f64) -> Estimator {
    let coordinates = [-2.0 * MAX_COORDINATE, 2.0 * MAX_COORDINATE];
    Estimator {
        last_measured: (bytes.byte() & 1 == 1).then(|| VehicleState {
            x: bytes.number([-50.0, 50.0], coordinates),
            y: bytes.number([-50.0, 50.0], coordinates),
            yaw: bytes.number([-4.0, 4.0], [-MAX_YAW, MAX_YAW]),
            speed: bytes.number([-5.0, 30.0], [-MAX_SPEED, MAX_SPEED]),
        }),
        unseen: (bytes.byte() & 1 == 1).then(|| Reached {
            wheels: (bytes.byte() & 1 == 1).then(|| WheelIntegrals {
                turn: symmetric(bytes, 1.0, 1e30),
                slope: symmetric(bytes, 1.0, 1e30),
                change: symmetric(bytes, 1.0, 1e30),
            }),
            time: bytes.number([0.0, 1.0], [0.0, 1e30]),
            first: symmetric(bytes, 0.5, 1e30),
        }),
        turning: walk(bytes),
        sliding: walk(bytes),
        pace: walk(bytes),
        driving: walk(bytes),
        wheel_rate: symmetric(bytes, 2.0, 1e40),
        gain_deviation: bytes.number([0.0, 1.0], [0.0, 1e40]),
        estimate: estimate(bytes, wheelbase, dead_time),
    }
}

/// A filter whose covariance may or may not be one.
pub fn walk<const N: usize>(bytes: &mut Bytes) -> Walk<N> {
    let noise = bytes.number([0.0, 1e-3], [0.0, 1e40]);
    let mut drawn = Walk::new([0.0; N], &[1.0; N], noise);
    for row in 0..N {
        drawn.mean[row] = symmetric(bytes, 1.0, 1e40);
        drawn.cross[row] = symmetric(bytes, 0.01, 1e40);
        for column in 0..row {
            let both = symmetric(bytes, 0.1, 1e40);
            drawn.covariance[(row, column)] = both;
            drawn.covariance[(column, row)] = both;
        }
        drawn.covariance[(row, row)] = bytes.number([0.0, 10.0], [0.0, 1e40]);
    }
    drawn.level = symmetric(bytes, 0.1, 1e40);
    drawn.variance = bytes.number([0.0, 1e-3], [0.0, 1e40]);
    drawn.noise.variance = bytes.number([0.0, 1e-3], [0.0, 1e40]);
    drawn.noise.last = (bytes.byte() & 1 == 1).then(|| symmetric(bytes, 0.1, 1e40));
    drawn.noise.count = bytes.number([1.0, 40.0], [1.0, 1e3]);
    drawn
}

/// A number of `[-most, most]`, mostly of `[-usual, usual]`.
pub fn symmetric(bytes: &mut Bytes, usual: f64, most: f64) -> f64 {
    bytes.number([-usual, usual], [-most, most])
}
