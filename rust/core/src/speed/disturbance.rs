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
//! `k = 1 / (1 + ((b - a) / (AMBIGUOUS b))²)`: a part of it counts for `d`, and the speed takes the rest.
//! A drive that gives less than is asked to speed up is at its end, and will not be while the vehicle
//! brakes: that is not learnt, unless the vehicle rolls back. The estimate rests while the brakes hold the
//! vehicle: how much of their force that takes is not known. Where they hold it short of its stop by
//! themselves, the estimate fades within `time`: `d' = -d / time`. What brakes that give less than they are
//! told have of the estimate is found by [`bias`](super::bias), and taken out of it.
//!
//! In noise of the speed, with the variance `r`, the law does not act on what is measured. It believes the mean of
//! the measured `z` and the expected `v'` with the least variance,
//!
//! ```text
//! v = z + r / (r + m²) (v' - z),     v' = v + dt (a + known + d), 0 where brakes hold
//! ```
//!
//! where the model leaves open `m`, that is `NOISE` planned decelerations. Its standard deviation is `sqrt(r)` times
//! `m² / (r + m²) + r / (r + m²) sqrt(1 - p)`; slower than [`REST`] and three of these is at rest.
//!
//! Assumed: noise of the speed that is white.

use crate::bounds::MAX_SPEED;
use crate::error::{InputError, input_within};
use crate::math::{decay, larger, saturate, smaller, sqrt};
use crate::speed::bias::{Bias, Corrected, NOISE};
use crate::speed::law::REST;
use crate::vehicle::{Answer, Motion};

/// Bound of the estimate [m/s²]: a slope of three tenths. More is a fault of the drive or of the speed.
pub const MAX_DISTURBANCE: f64 = 3.0;
/// How much more slowly than the vehicle says its drive may respond [s].
const UNTOLD_LAG: f64 = 0.3;
/// By how much the answers of the two drives differ where half of an error counts, as a share of the
/// planned deceleration.
const AMBIGUOUS: f64 = 0.5;
/// A speed within so many standard deviations of what is left of its noise is at rest. More: its gear changes
/// while it rolls. Less: noise moves one that stands.
const DEVIATIONS: f64 = 3.0;

/// What the observer remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Observer {
    /// The speed along the path that the model expects [m/s]; None before the first step.
    pub speed: Option<f64>,
    /// What a slower drive would give [m/s^2].
    pub slow_drive: f64,
    /// Acceleration that neither the commands nor the path's grade explain [m/s^2].
    pub disturbance: f64,
    /// What the drive gave at the last step [m/s^2].
    pub pull: f64,
    /// What the drive is not as told.
    pub bias: Option<Bias>,
}

/// What is heard of the speed in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Heard {
    /// As measured, and as the model expects it [m/s]; None before the first step.
    pub measured: f64,
    pub expected: Option<f64>,
    /// As it is believed, and how slow is at rest in what noise leaves of that [m/s].
    pub believed: f64,
    pub rest: f64,
}

impl Observer {
    /// How the vehicle answers its drive, with the acceleration `known` [m/s²] beside it.
    pub(super) fn answer(&self, known: f64) -> Answer {
        let brakes = self.bias.map_or(1.0, |bias| bias.brakes());
        let due = self.bias.map_or(0.0, |bias| bias.push.x * (brakes - 1.0));
        let disturbance = saturate(self.disturbance + due, -MAX_DISTURBANCE, MAX_DISTURBANCE);
        Answer {
            push: known + disturbance,
            brakes,
        }
    }

    /// What is heard of a `measured` speed [m/s], `dt` [s] after the last, whose noise has a standard deviation;
    /// by an observer with the time constant `time` [s].
    pub(super) fn hear(
        &self,
        measured: f64,
        known: f64,
        given: Motion,
        (noise, time, braking): (f64, f64, f64),
        dt: f64,
    ) -> Heard {
        let Some(before) = self.speed else {
            return Heard {
                measured,
                expected: None,
                believed: measured,
                rest: REST,
            };
        };
        let expected = self.expected(before, known, given, dt);
        let (square, model) = (noise * noise, NOISE * braking);
        let share = square / (square + model * model);
        let left = noise * (1.0 - share + share * sqrt(1.0 - decay(dt, time)));
        Heard {
            measured,
            expected: Some(expected),
            believed: measured + share * (expected - measured),
            rest: REST + DEVIATIONS * left,
        }
    }

    /// The speed [m/s] that the model expects of one that had the speed `before`.
    fn expected(&self, before: f64, known: f64, given: Motion, dt: f64) -> f64 {
        let push = known + self.disturbance;
        let moved = before + given.speed + push * dt;
        if given.pull <= -push.abs() {
            // Brakes hold one that they have brought to rest.
            saturate(0.0, smaller(before, moved), larger(before, moved))
        } else {
            moved
        }
    }

    /// Moves the model on by `dt` [s] to the speed that was `heard`. Of the drive, the mean of the commands that
    /// acted, what it gives, and the last command. `held`: the vehicle stands on its brakes; `at_full_drive`: its
    /// drive may be at its end.
    pub(super) fn step(
        &mut self,
        heard: &Heard,
        (mean, given, command): (f64, Motion, f64),
        (held, at_full_drive): (bool, bool),
        (lag, time, braking, response): (f64, f64, f64, f64),
        dt: f64,
    ) {
        let slower = self.slow_drive;
        let pull = core::mem::replace(&mut self.pull, given.pull);
        self.slow_drive = mean + (self.slow_drive - mean) * decay(dt, lag + UNTOLD_LAG);
        let mut bias = self.bias.unwrap_or_else(|| Bias::new(response, braking));
        let (speed, believed) = (heard.measured, heard.believed);
        let pole = decay(dt, time);
        let Some(predicted) = heard.expected.filter(|_| !held) else {
            let found = believed + (1.0 - pole * pole) * (speed - believed);
            self.speed = Some(saturate(found, -MAX_SPEED, MAX_SPEED));
            self.bias = Some(bias.rest());
            return;
        };
        let error = speed - predicted;
        let (late, early) = (self.slow_drive - given.pull, command - given.pull);
        let other = if late * error > 0.0 {
            late
        } else if early * error > 0.0 {
            early
        } else {
            0.0
        };
        let ratio = other / (AMBIGUOUS * braking);
        // One that rolls back has a drive that gives less than the slope takes, and has to give more.
        let trust = if at_full_drive && error < 0.0 && speed >= 0.0 {
            0.0
        } else {
            1.0 / (1.0 + ratio * ratio)
        };
        let (k, l) = (
            1.0 - trust * pole * pole,
            trust * (1.0 - pole) * (1.0 - pole) / dt,
        );
        let done = Corrected {
            error,
            braked: smaller(given.speed, 0.0),
            changed: (given.pull - pull, self.slow_drive - slower),
            gains: (k, l),
            dt,
        };
        bias.observe(&done, (response, braking, time));
        self.bias = Some(bias);
        let corrected = predicted + k * error;
        self.speed = Some(saturate(corrected, -MAX_SPEED, MAX_SPEED));
        let estimate = self.disturbance + l * error;
        self.disturbance = saturate(estimate, -MAX_DISTURBANCE, MAX_DISTURBANCE);
    }

    /// The same `dt` [s] later, of which nothing was seen: less and less of it is believed.
    pub(super) fn fade(&mut self, time: f64, dt: f64) {
        self.disturbance *= decay(dt, time);
        if let Some(bias) = &mut self.bias {
            bias.push *= decay(dt, time);
        }
    }

    /// The same where the direction of driving changes: a slope then pushes the other way.
    pub(super) fn turned(self) -> Self {
        Self {
            disturbance: -self.answer(0.0).push,
            bias: self.bias.map(Bias::rest),
            ..Self::default()
        }
    }

    /// Whether this is what an observer can have.
    ///
    /// # Errors
    ///
    /// [`InputError`] where a number is not.
    pub(super) fn check(&self, most: f64) -> Result<(), InputError> {
        input_within("observer.speed", self.speed.unwrap_or(0.0), MAX_SPEED)?;
        input_within("observer.slow_drive", self.slow_drive, most)?;
        input_within("observer.pull", self.pull, most)?;
        input_within("observer.disturbance", self.disturbance, MAX_DISTURBANCE)?;
        self.bias.map_or(Ok(()), |bias| bias.check())
    }
}
