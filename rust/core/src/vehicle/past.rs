//! The recent angles of the wheels, to roll an old pose forward to the present.
//!
//! A localisation has a delay of its own, besides that of the steering. [`Past::advance`] rolls the
//! vehicle forward from where it was measured, through the angles of its wheels since.

use super::bicycle::Rollout;
use super::timed::{Timed, clipped};
use super::wheels::WheelIntegrals;
use super::{Estimate, Vehicle, VehicleState};
use crate::bounds::MIN_DT;
use crate::error::{InputError, input_in_range, input_within};
use crate::math::{from_count, saturate, tan};

/// The oldest pose that a step takes [s].
pub const MAX_POSE_AGE: f64 = 1.0;

/// `age` [s] where a step takes a pose of it; 0 for one that the rounding of two stamps makes negative.
///
/// # Errors
///
/// [`InputError`] for one that is not finite, negative or beyond [`MAX_POSE_AGE`].
#[inline]
pub fn checked_age(age: f64) -> Result<f64, InputError> {
    let is_rounded = age < 0.0 && age > -MIN_DT;
    input_in_range(
        "pose_age",
        if is_rounded { 0.0 } else { age },
        0.0,
        MAX_POSE_AGE,
    )
}

/// The angles of the wheels by the vehicle's parameters over the last second, oldest first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Past {
    /// Mean angle [rad] and for how long [s].
    angles: Timed<{ Past::CAPACITY }>,
    wheel: f64,
    since: f64,
}

impl Past {
    /// Angles are remembered apart down to this share of [`MAX_POSE_AGE`]. A 32nd would halve
    /// the memory, but preview POP at 100 Hz on poses 0.1 s old then keeps within 11 mm of its path
    /// instead of 3 mm (root mean square).
    const RESOLUTION: usize = 64;
    /// The most angles. Two neighbours are together longer than a share, so half as many shares
    /// are remembered as there are places.
    pub const CAPACITY: usize = 2 * Self::RESOLUTION + 2;
    /// Bound of the time since the last pose [s], which no valid input reaches.
    const MAX_SINCE: f64 = 1e6;

    /// The wheels as they have stood at the angle `wheel` [rad] for long.
    pub fn settled(wheel: f64) -> Self {
        let mut past = Self {
            angles: Timed::EMPTY,
            wheel,
            since: 0.0,
        };
        past.angles.push(wheel, MAX_POSE_AGE);
        past
    }

    /// Becomes what gave these [`angles`](Self::angles), this angle now and this time since a pose.
    #[inline]
    pub fn refill(&mut self, angles: &[(f64, f64)], wheel: f64, since: f64) {
        self.angles.refill(angles);
        (self.wheel, self.since) = (wheel, since);
    }

    /// Whether it is a past that wheels can have.
    ///
    /// # Errors
    ///
    /// [`InputError`] where it is not: an angle beyond a quarter turn, a duration that is negative.
    pub fn check(&self) -> Result<(), InputError> {
        let limit = core::f64::consts::FRAC_PI_2;
        input_within("past.wheel", self.wheel, limit)?;
        input_in_range("past.since", self.since, 0.0, Self::MAX_SINCE)?;
        for (angle, duration) in self.angles() {
            input_within("past.angles", angle, limit)?;
            input_in_range("past.angles", duration, 0.0, Self::MAX_SINCE)?;
        }
        Ok(())
    }

    /// Mean angles [rad] and for how long each [s], oldest first.
    pub fn angles(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.angles.iter()
    }

    /// Angle of the wheels now [rad].
    pub fn wheel(&self) -> f64 {
        self.wheel
    }

    /// Angle of the wheels when the last pose that was taken in was measured [rad].
    pub fn wheel_before(&self) -> f64 {
        let mut angles = self.between(self.since, 0.0);
        angles.next().map_or(self.wheel, |(angle, _)| angle)
    }

    /// How long ago the last pose that was taken in was measured [s].
    pub fn since(&self) -> f64 {
        self.since
    }

    /// A pose of `age` [s] was taken in.
    pub fn see(&mut self, age: f64) {
        self.since = age;
    }

    /// Lets `dt` [s] pass, in which `commands` reached the wheels from the angle `wheel` [rad] on:
    /// those in flight, and then the last one. Angles that last shorter than a 64th of
    /// [`MAX_POSE_AGE`] are joined to their mean.
    pub fn elapse(
        &mut self,
        vehicle: &Vehicle,
        commands: impl Iterator<Item = (f64, f64)>,
        wheel: f64,
        dt: f64,
    ) {
        let (mut wheel, joined) = (wheel, MAX_POSE_AGE / from_count(Self::RESOLUTION));
        for (steer, time) in clipped(commands, dt) {
            let moved = vehicle.move_wheel(wheel, steer, time);
            self.angles.push_or_join(moved.mean, time, joined);
            wheel = moved.wheel;
        }
        self.wheel = wheel;
        self.since = saturate(self.since + dt, 0.0, Self::MAX_SINCE);
    }

    /// What the wheels did from the last pose that was taken in until `age` [s] ago.
    pub fn wheel_integrals(&self, age: f64) -> WheelIntegrals {
        let mut reached = WheelIntegrals::default();
        // Angles are means of pieces: those at the ends are taken from the pieces there.
        let (mut first, mut last) = (None, 0.0);
        for (angle, time) in self.between(self.since, age) {
            reached.add(angle, time);
            first = first.or(Some(angle));
            last = angle;
        }
        reached.change = first.map_or(0.0, |first| tan(last) - tan(first));
        reached
    }

    /// A vehicle that was at `state` `age` [s] ago, as it is now. The state is that of the no-slip
    /// point; the `estimate` corrects `vehicle`.
    pub fn advance(
        &self,
        vehicle: &Vehicle,
        state: VehicleState,
        age: f64,
        estimate: &Estimate,
    ) -> VehicleState {
        let mut rollout = Rollout::new(vehicle, estimate, state);
        for (angle, time) in self.between(age, 0.0) {
            rollout.turn(angle, time);
        }
        rollout.state()
    }

    /// The angles from `start` [s] ago until `end` [s] ago, and for how long each [s].
    fn between(&self, start: f64, end: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        let mut ago = self
            .angles()
            .fold(0.0, |total, (_, duration)| total + duration);
        self.angles().filter_map(move |(angle, duration)| {
            let from = if ago < start { ago } else { start };
            ago -= duration;
            let until = if ago > end { ago } else { end };
            let time = from - until;
            (time > 0.0).then_some((angle, time))
        })
    }
}
