//! What the wheels did of late: for poses that are older than the step they are given to.
//!
//! A localisation takes its time, which is none of the steering's. [`Past::advance`] rolls the
//! vehicle forward from where it was seen, through the angles that its wheels have had since.

use super::bicycle::advance;
use super::delay::Reached;
use super::{Estimate, Vehicle, VehicleState};
use crate::error::{InputError, Requirement, input_in_range};
use crate::math::{from_count, saturate, tan};

/// The oldest pose that a step takes [s].
pub const MAX_POSE_AGE: f64 = 1.0;

/// The angles of the wheels by the vehicle's own figures over the last second, oldest first.
#[derive(Clone, Copy, Debug)]
pub struct Past {
    /// Mean angle [rad] and for how long [s].
    angles: [(f64, f64); Self::CAPACITY],
    first: usize,
    count: usize,
    wheel: f64,
    since: f64,
}

/// Places of the ring that hold no angle do not count.
impl PartialEq for Past {
    fn eq(&self, other: &Self) -> bool {
        self.wheel == other.wheel && self.since == other.since && self.angles().eq(other.angles())
    }
}

impl Past {
    /// Angles are remembered apart down to this share of [`MAX_POSE_AGE`].
    const RESOLUTION: usize = 64;
    /// The most angles. Two neighbours are together longer than a share, so half as many shares
    /// are remembered as there are places.
    pub const CAPACITY: usize = 2 * Self::RESOLUTION + 2;
    /// More than the time since the last pose can come to [s].
    const MAX_SINCE: f64 = 1e6;

    /// The wheels as they have stood at the angle `wheel` [rad] for long.
    pub fn settled(wheel: f64) -> Self {
        let mut past = Self {
            angles: [(0.0, 0.0); Self::CAPACITY],
            first: 0,
            count: 0,
            wheel,
            since: 0.0,
        };
        past.push(wheel, MAX_POSE_AGE);
        past
    }

    /// A past as it was: mean angles [rad] with their durations [s], oldest first, the angle now
    /// [rad], and how long ago the last pose was taken [s].
    ///
    /// # Errors
    ///
    /// [`InputError`] where there are too many angles, and as [`check`](Self::check).
    pub fn restore(
        angles: impl ExactSizeIterator<Item = (f64, f64)>,
        wheel: f64,
        since: f64,
    ) -> Result<Self, InputError> {
        let count = angles.len();
        if count > Self::CAPACITY {
            return Err(InputError {
                field: "past_angles",
                value: from_count(count),
                requirement: Requirement::CountInRange(0, Self::CAPACITY),
            });
        }
        let mut past = Self::settled(wheel);
        past.count = 0;
        past.since = since;
        for (place, angle) in past.angles.iter_mut().zip(angles) {
            *place = angle;
            past.count += 1;
        }
        past.check()?;
        Ok(past)
    }

    /// Whether it is a past that wheels can have.
    ///
    /// # Errors
    ///
    /// [`InputError`] where it is not: an angle beyond a quarter turn, a duration that is negative.
    pub fn check(&self) -> Result<(), InputError> {
        let limit = core::f64::consts::FRAC_PI_2;
        input_in_range("past_wheel", self.wheel, -limit, limit)?;
        input_in_range("past_since", self.since, 0.0, Self::MAX_SINCE)?;
        for (angle, duration) in self.angles() {
            input_in_range("past_angles", angle, -limit, limit)?;
            input_in_range("past_angles", duration, 0.0, Self::MAX_SINCE)?;
        }
        Ok(())
    }

    /// Mean angles [rad] and for how long each [s], oldest first.
    pub fn angles(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        (0..self.count).map(|k| self.get(k))
    }

    /// Angle of the wheels now [rad].
    pub fn wheel(&self) -> f64 {
        self.wheel
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
        let (mut wheel, mut gone) = (wheel, dt);
        for (steer, duration) in commands {
            if gone <= 0.0 {
                break;
            }
            let part = if duration < gone { duration } else { gone };
            let moved = vehicle.move_wheel(wheel, steer, part);
            self.push(moved.mean, part);
            wheel = moved.wheel;
            gone -= part;
        }
        self.wheel = wheel;
        self.since = saturate(self.since + dt, 0.0, Self::MAX_SINCE);
    }

    /// What the wheels did from the last pose that was taken in until `age` [s] ago.
    pub fn reached(&self, age: f64) -> Reached {
        let mut reached = Reached::default();
        let mut ago = self.total();
        for (angle, duration) in self.angles() {
            let start = if ago < self.since { ago } else { self.since };
            ago -= duration;
            let end = if ago > age { ago } else { age };
            let part = start - end;
            if part > 0.0 {
                let tangent = tan(angle);
                reached.turn += part * tangent;
                reached.slope += part * (1.0 + tangent * tangent);
            }
        }
        reached
    }

    /// A vehicle that was at `state` `age` [s] ago, as it is now. The state is that of the point
    /// that does not slip; what the `estimate` knows better than `vehicle` counts.
    pub fn advance(
        &self,
        vehicle: &Vehicle,
        state: VehicleState,
        age: f64,
        estimate: &Estimate,
    ) -> VehicleState {
        let (begin, mut time) = (state.speed, 0.0);
        let mut state = state;
        let length = vehicle.turning_length(state.speed) / estimate.gain;
        let mut ago = self.total();
        for (angle, duration) in self.angles() {
            let start = if ago < age { ago } else { age };
            ago -= duration;
            let end = if ago > 0.0 { ago } else { 0.0 };
            let part = start - end;
            if part > 0.0 {
                time += part;
                let speed = estimate.speed_after(begin, time);
                let travel = 0.5 * (state.speed + speed) * part;
                let angle = vehicle.at_wheels(angle + estimate.steer_offset);
                let curvature = tan(angle) / length;
                let slip = estimate.slip + estimate.slip_length * curvature;
                state = advance(state, travel, curvature, slip);
                state.speed = speed;
            }
        }
        state
    }

    /// How long all that is remembered lasted [s].
    fn total(&self) -> f64 {
        self.angles()
            .fold(0.0, |total, (_, duration)| total + duration)
    }

    fn push(&mut self, angle: f64, duration: f64) {
        let share = MAX_POSE_AGE / from_count(Self::RESOLUTION);
        if let Some(newest) = self.count.checked_sub(1) {
            let (mean, lasted) = self.get(newest);
            let total = lasted + duration;
            if total <= share {
                let mean = (mean * lasted + angle * duration) / total;
                self.set(newest, (mean, total));
                return;
            }
        }
        if self.count == Self::CAPACITY {
            self.first = self.place(1);
        } else {
            self.count += 1;
        }
        self.set(self.count - 1, (angle, duration));
    }

    fn place(&self, k: usize) -> usize {
        let place = self.first + k;
        if place < Self::CAPACITY {
            place
        } else {
            place - Self::CAPACITY
        }
    }

    fn get(&self, k: usize) -> (f64, f64) {
        self.angles
            .get(self.place(k))
            .copied()
            .unwrap_or((self.wheel, 0.0))
    }

    fn set(&mut self, k: usize, angle: (f64, f64)) {
        let place = self.place(k);
        if let Some(entry) = self.angles.get_mut(place) {
            *entry = angle;
        }
    }
}
