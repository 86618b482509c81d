//! What else accelerates the vehicle: an estimate of all that the commands do not explain.
//!
//! # Equations
//!
//! The drive answers a command with a first-order response, and whatever the model does not know
//! (a slope, drag, a drive that gives less than asked) is a slowly changing acceleration `d`:
//!
//! ```text
//! a' = (command - a) / lag
//! v' = a + known + d              known: gravity along a path that has a grade
//! d' = 0
//! ```
//!
//! A Luenberger observer finds `d` from the measured speed. With the mean `a` of the period,
//! `p = exp(-dt / time)` and a share `k` of 1,
//!
//! ```text
//! [v]   [1  dt] [v]   [dt]                          r = measured speed - v
//! [d] = [0   1] [d] + [ 0] (a + known)
//!
//! [v]   [v]   [1 - k p²       ]
//! [d] = [d] + [k (1 - p)² / dt] r,    |d| <= MAX_DISTURBANCE
//! ```
//!
//! where `k = 1` places both poles at `p`, that is at `-1 / time`. A drive may respond later or
//! earlier than the vehicle says: with `b`, the answer of one that is slower by `UNTOLD_LAG`, or the
//! command itself, an error of the sign of `b - a` may be due to that alone. Then
//! `k = 1 / (1 + ((b - a) / (AMBIGUOUS L))²)`: a part of it counts for `d`, and the speed takes the rest.
//! A drive that gives less than is asked to speed up is at its end, and will not be while the vehicle
//! brakes: that is not learnt, unless the vehicle rolls back. The estimate rests while the brakes hold the vehicle: how much of
//! their force that takes is not known.

use crate::bounds::MAX_SPEED;
use crate::math::{decay, larger, saturate, smaller};
use crate::speed::servo::Servo;
use crate::vehicle::Gate;

/// Bound of the estimate [m/s²]: a slope of a fifth. More is a fault of the drive or of the speed.
pub const MAX_DISTURBANCE: f64 = 2.0;
/// How much more slowly than the vehicle says its drive may respond [s].
const UNTOLD_LAG: f64 = 0.3;
/// By how much the answers of the two drives differ where half of an error counts, in wheelbases a
/// second squared.
const AMBIGUOUS: f64 = 0.5;

/// What [`SpeedTracker`](super::SpeedTracker) remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SpeedTrackerState {
    /// Where the segment beside the rear axle starts; None before the first step.
    pub waypoint: Option<usize>,
    /// The last command [m/s^2].
    pub acceleration: f64,
    /// What the drive gives, by its lag [m/s^2].
    pub drive: f64,
    /// What a slower drive would give [m/s^2].
    pub slow_drive: f64,
    /// The speed along the path that the model expects [m/s]; None before the first step.
    pub model_speed: Option<f64>,
    /// Acceleration that neither the commands nor the path's grade explain [m/s^2].
    pub disturbance: f64,
    /// Whether the vehicle is held where it stands.
    pub standing: bool,
    /// Distance to the next stop [m], as steady as the speed; None where it is not known.
    pub to_stop: Option<f64>,
    /// How long the vehicle stands until its wheels are turned [s].
    pub turning: f64,
    /// The poses that are believed; None before the first step.
    pub gate: Option<Gate>,
    /// Curvature of the vehicle's way by its last poses [1/m].
    pub bend: f64,
    /// Whether the vehicle overruns its stop by the last step.
    pub overruns: bool,
    /// The last speed signal [m/s], believed or not; None before the first step.
    pub heard: Option<f64>,
    /// The speed command, for a vehicle that takes one.
    pub servo: Servo,
}

impl SpeedTrackerState {
    /// What is believed of a `speed` signal [m/s] `dt` [s] after the last: at most what accelerations of
    /// `most` [m/s²] make of the expected speed or of the last signal. So two messages can say
    /// anything, and one alone can not.
    pub(super) fn hear(&mut self, speed: f64, most: f64, dt: f64) -> f64 {
        let Some(last) = self.heard.replace(speed) else {
            return speed;
        };
        let gained = (self.drive + self.disturbance) * dt;
        let believed = self.gate.map_or(last, |gate| gate.believed.speed);
        let expected = believed + if believed < 0.0 { -gained } else { gained };
        let (low, high) = (smaller(last, expected), larger(last, expected));
        saturate(speed, low - most * dt, high + most * dt)
    }

    /// Moves the model on by `dt` [s] under the last command, with the acceleration `known` [m/s²]
    /// beside it, to the measured `speed` [m/s]. `held`: the vehicle stands on its brakes;
    /// `at_full_drive`: its drive may be at its end.
    pub(super) fn observe(
        &mut self,
        speed: f64,
        known: f64,
        (held, at_full_drive): (bool, bool),
        (lag, time, wheelbase): (f64, f64, f64),
        dt: f64,
    ) {
        let (command, kept) = (self.acceleration, decay(dt, lag));
        let mean = command + (self.drive - command) * lag * (1.0 - kept) / dt;
        self.drive = command + (self.drive - command) * kept;
        self.slow_drive = command + (self.slow_drive - command) * decay(dt, lag + UNTOLD_LAG);
        let Some(before) = self.model_speed.filter(|_| !held) else {
            self.model_speed = Some(speed);
            return;
        };
        let predicted = before + (mean + known + self.disturbance) * dt;
        let error = speed - predicted;
        let (late, early) = (self.slow_drive - self.drive, command - self.drive);
        let other = if late * error > 0.0 {
            late
        } else if early * error > 0.0 {
            early
        } else {
            0.0
        };
        let ratio = other / (AMBIGUOUS * wheelbase);
        // One that rolls back has a drive that gives less than the slope takes, and has to give more.
        let trust = if at_full_drive && error < 0.0 && speed >= 0.0 {
            0.0
        } else {
            1.0 / (1.0 + ratio * ratio)
        };
        let pole = decay(dt, time);
        let corrected = predicted + (1.0 - trust * pole * pole) * error;
        self.model_speed = Some(saturate(corrected, -MAX_SPEED, MAX_SPEED));
        let estimate = self.disturbance + trust * (1.0 - pole) * (1.0 - pole) / dt * error;
        self.disturbance = saturate(estimate, -MAX_DISTURBANCE, MAX_DISTURBANCE);
    }
}
