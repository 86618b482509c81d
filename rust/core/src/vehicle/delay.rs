//! The commands in flight: given, but not yet at the wheels.
//!
//! A controller that steers by the present vehicle, while its last commands are still in flight,
//! steers too late. [`InFlight::predict`] rolls the vehicle forward through them, so that the
//! controller steers by its state when the next command reaches the wheels.

use super::bicycle::Rollout;
use super::timed::{Timed, clipped};
use super::wheels::WheelIntegrals;
use super::{Estimate, Vehicle, VehicleState};
use crate::error::{InputError, input_in_range, input_within};
use crate::math::{from_count, tan};

/// The commands that are given but have not reached the wheels, oldest first, and the wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct InFlight {
    /// Angle [rad] and how long it was commanded [s].
    commands: Timed<{ InFlight::CAPACITY }>,
    /// Angle of the wheels by the vehicle's parameters, without an estimated offset [rad].
    wheel: f64,
}

impl InFlight {
    /// Commands are remembered apart down to this share of the dead time.
    const RESOLUTION: usize = 64;
    /// The most commands in flight; shorter ones are joined, see [`elapse`](Self::elapse).
    pub const CAPACITY: usize = 3 * Self::RESOLUTION + 4;

    /// Nothing in flight, and the wheels straight on.
    pub const fn empty() -> Self {
        Self {
            commands: Timed::EMPTY,
            wheel: 0.0,
        }
    }

    /// The wheels at rest under the command `steer` [rad], and that command in flight.
    pub fn settled(vehicle: &Vehicle, steer: f64) -> Self {
        let mut in_flight = Self {
            commands: Timed::EMPTY,
            wheel: vehicle.at_wheels(steer + vehicle.steer_offset),
        };
        if vehicle.dead_time > 0.0 {
            in_flight.commands.push(steer, vehicle.dead_time);
        }
        in_flight
    }

    /// The command `steer` [rad] in flight, and the wheels at the angle `wheel` [rad]; as
    /// [`settled`](Self::settled) where that is none.
    pub(crate) fn standing(vehicle: &Vehicle, steer: f64, wheel: Option<f64>) -> Self {
        let settled = Self::settled(vehicle, steer);
        Self {
            wheel: wheel.unwrap_or(settled.wheel),
            ..settled
        }
    }

    /// Commands in flight as they were, with this `dead_time` [s].
    ///
    /// # Errors
    ///
    /// [`InputError`] where there are too many commands, and as [`check`](Self::check).
    pub fn restore(
        commands: impl ExactSizeIterator<Item = (f64, f64)>,
        wheel: f64,
        dead_time: f64,
    ) -> Result<Self, InputError> {
        let in_flight = Self {
            commands: Timed::restore("in_flight.commands", commands)?,
            wheel,
        };
        in_flight.check(dead_time)?;
        Ok(in_flight)
    }

    /// Becomes what gave these [`commands`](Self::commands) and this angle of the wheels.
    #[inline]
    pub fn refill(&mut self, commands: &[(f64, f64)], wheel: f64) {
        self.commands.refill(commands);
        self.wheel = wheel;
    }

    /// Whether commands are ones that can be in flight with this `dead_time` [s].
    ///
    /// # Errors
    ///
    /// [`InputError`] where they cannot: an angle beyond a quarter turn, a duration that is none,
    /// durations that do not add up to the dead time.
    pub fn check(&self, dead_time: f64) -> Result<(), InputError> {
        let limit = core::f64::consts::FRAC_PI_2;
        input_within("in_flight.wheel", self.wheel, limit)?;
        let slack = 1e-9 * (1.0 + dead_time);
        let mut total = 0.0;
        for (steer, duration) in self.commands() {
            input_within("in_flight.commands", steer, limit)?;
            input_in_range("in_flight.commands", duration, 0.0, dead_time + slack)?;
            total += duration;
        }
        let (least, most) = (dead_time - slack, dead_time + slack);
        input_in_range("in_flight.commands", total, least, most).map(|_| ())
    }

    /// The commands in flight, oldest first: angle [rad] and duration [s].
    pub fn commands(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.commands.iter()
    }

    /// Angle of the wheels by the vehicle's parameters, without an estimated offset [rad].
    pub fn wheel(&self) -> f64 {
        self.wheel
    }

    /// What reaches the wheels in `dt` [s] after `last` was commanded.
    #[inline]
    pub fn wheel_integrals(&self, vehicle: &Vehicle, last: f64, dt: f64) -> WheelIntegrals {
        let (mut reached, mut wheel) = (WheelIntegrals::default(), self.wheel);
        for (steer, time) in clipped(self.commands().chain([(last, dt)]), dt) {
            let moved = vehicle.move_wheel(wheel, steer, time);
            reached.add(moved.mean, time);
            wheel = moved.wheel;
        }
        reached.change = tan(wheel) - tan(self.wheel);
        reached
    }

    /// Advances by `dt` [s] since `last` was commanded: `last` is then in flight, and the oldest
    /// commands reach the wheels. With a dead time that turns out `longer` by so much [s] they
    /// reach them later. Commands shorter than a 64th of the dead time are joined to their mean.
    pub fn elapse(&mut self, vehicle: &Vehicle, last: f64, dt: f64, longer: f64) {
        let mut gone = dt - longer;
        let joined = if self.commands.is_full() {
            f64::INFINITY
        } else {
            vehicle.dead_time / from_count(Self::RESOLUTION)
        };
        self.commands.push_or_join(last, dt, joined);
        while gone > 0.0
            && let Some((steer, time)) = self.commands.take(gone)
        {
            self.wheel = vehicle.move_wheel(self.wheel, steer, time).wheel;
            gone -= time;
        }
    }

    /// The vehicle and its wheels as they will be when a command given now reaches them: rolled
    /// forward through the commands in flight, from the wheels' angle `wheel` [rad]. The state is
    /// that of the no-slip point; the `estimate` corrects `vehicle`.
    pub fn predict(
        &self,
        vehicle: &Vehicle,
        state: VehicleState,
        wheel: f64,
        estimate: &Estimate,
    ) -> (VehicleState, f64) {
        let mut rollout = Rollout::new(vehicle, estimate, state);
        let wheel = rollout.drive(wheel, self.commands());
        (rollout.state(), wheel)
    }
}

#[cfg(test)]
mod tests;
