//! The speed to command, for vehicles that take a speed in place of an acceleration.
//!
//! # Equations
//!
//! Such a vehicle has a servo of its own. It answers the command `u` with a first-order response and
//! a scale `k` that nobody knows exactly:
//!
//! ```text
//! v' = (k u(t - drive_delay) - v) / drive_lag
//! ```
//!
//! The integral `r` of the wanted acceleration, divided by the scale, makes of it a drive with the same
//! delay and lag that takes accelerations, for which the law is made. The integral is kept (anti-windup)
//! where the servo can be with the accelerations of the vehicle, and within the plan; the command never
//! exceeds the top speed:
//!
//! ```text
//! T  = drive_delay + drive_lag + SLACK
//! r  = clip(r + a dt,  v - b T,  v + a_max T)           b = max(b_max, -a)
//! r  = clip(r,  0,  plan where the command takes effect)
//! u  = min(r / k,  max_speed)
//! m' = (u - m) / (drive_delay + drive_lag)              what a servo of scale 1 does
//! k  = (1 + sum w m v) / (1 + sum w m²)                 least squares with forgetting, prior k = 1
//! ```
//!
//! So it goes as far below the measured speed as the lag needs in order to brake with `b`, and a
//! vehicle that does not move is not commanded ever more.

use crate::bounds::MAX_SPEED;
use crate::error::{InputError, input_in_range, input_within};
use crate::math::{decay, larger, saturate, smaller};
use crate::speed::defaults;
use crate::vehicle::Vehicle;

/// How much longer than the vehicle says its servo may take [s]. More: a vehicle that is stuck is
/// commanded to go faster. Less: one whose lag nobody knows is kept from its accelerations.
const SLACK: f64 = 0.5;
/// Time constant of the scale [s]. Less: a slope is taken for a scale.
const SCALE_TIME: f64 = 5.0;
/// How much less a command counts for the scale that the servo has still to answer.
const TRANSIENT: f64 = 5.0;
/// Bounds of the scale. Beyond it the speeds have another unit, which is a fault.
const SCALE: (f64, f64) = (0.6, 1.6);

/// What the speed command remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Servo {
    /// `r`: the integral of the wanted acceleration, along the path [m/s]; None before a first step.
    pub wanted: Option<f64>,
    /// The last command, along the path [m/s].
    pub command: f64,
    /// `m`: what a servo of scale 1 does with the commands [m/s].
    pub response: f64,
    /// Sums for the scale, `m v` and `m²`, in wheelbases.
    pub sums: (f64, f64),
}

/// What a step commands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// The acceleration [m/s²].
    pub acceleration: f64,
    /// The planned speed where the command takes effect [m/s].
    pub plan: f64,
    /// Whether the vehicle is to stand.
    pub standing: bool,
}

impl Servo {
    /// `k`: speed of the vehicle for one of the command.
    pub fn scale(&self) -> f64 {
        saturate((1.0 + self.sums.0) / (1.0 + self.sums.1), SCALE.0, SCALE.1)
    }

    /// The speed to command along the path [m/s], for a vehicle with the `speed` [m/s] along it.
    pub(super) fn step(&mut self, car: &Vehicle, speed: f64, wanted: Wanted, dt: f64) -> f64 {
        let lag = car.drive_delay + car.drive_lag;
        self.response = self.command + (self.response - self.command) * decay(dt, lag);
        self.learn(car, speed, dt);
        let forward = larger(speed, 0.0);
        let time = lag + SLACK;
        let driving = car.max_acceleration.unwrap_or(defaults::MAX_ACCELERATION);
        let braking = larger(car.comfort_braking(), -wanted.acceleration);
        let before = self.wanted.unwrap_or(forward);
        let kept = if before < 0.0 {
            smaller(before + braking * dt, 0.0)
        } else {
            let next = if wanted.standing {
                before - braking * dt
            } else {
                before + wanted.acceleration * dt
            };
            let (least, most) = (forward - braking * time, forward + driving * time);
            saturate(saturate(next, least, most), 0.0, wanted.plan)
        };
        let top = car.max_speed.unwrap_or(defaults::MAX_SPEED);
        self.wanted = Some(kept);
        self.command = saturate(kept / self.scale(), -top, top);
        self.command
    }

    /// The same where the direction of driving changes: it brakes to a standstill first.
    pub(super) fn turned(self) -> Self {
        Self {
            wanted: self.wanted.map(|wanted| -wanted),
            command: -self.command,
            response: -self.response,
            ..self
        }
    }

    /// Brings the scale up to date: the less, the farther the servo is from its command, as a lag
    /// that differs counts there.
    fn learn(&mut self, car: &Vehicle, speed: f64, dt: f64) {
        let unit = car.wheelbase;
        let (response, measured) = (self.response / unit, speed / unit);
        let changing = TRANSIENT * (self.command / unit - response);
        let kept = 1.0 - (1.0 - decay(dt, SCALE_TIME)) * smaller(response * response, 1.0);
        let square = response * response;
        let explained = SCALE.0 * response..=SCALE.1 * response;
        if response <= 0.0 || !explained.contains(&measured) {
            return;
        }
        let weight = dt * square / (square + changing * changing);
        self.sums.0 = kept * self.sums.0 + weight * response * measured;
        self.sums.1 = kept * self.sums.1 + weight * response * response;
    }

    /// Whether this is what a servo can have.
    ///
    /// # Errors
    ///
    /// [`InputError`] where a number is none.
    pub(super) fn checked(&self) -> Result<(), InputError> {
        const MOST: f64 = 1e20;
        input_within("servo.wanted", self.wanted.unwrap_or(0.0), MAX_SPEED)?;
        input_within("servo.command", self.command, MAX_SPEED)?;
        input_within("servo.response", self.response, MAX_SPEED)?;
        input_in_range("servo.sums", self.sums.0, -MOST, MOST)?;
        input_in_range("servo.sums", self.sums.1, 0.0, MOST).map(|_| ())
    }
}
