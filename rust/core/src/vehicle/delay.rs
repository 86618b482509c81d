//! The commands in flight: what lies between a command and the wheels.
//!
//! A controller that steers by the vehicle of now while its last commands are still in flight
//! steers too late. [`InFlight::predict`] rolls the vehicle forward through them, so that the
//! controller sees it as it will be when its next command reaches the wheels.

use super::bicycle::advance;
use super::{Estimate, Vehicle, VehicleState};
use crate::error::{InputError, Requirement, input_in_range};
use crate::math::{ceil_to_count, decay, from_count, saturate, tan};

/// Where the wheels come to, and their mean angle on the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// Angle at the end [rad].
    pub wheel: f64,
    /// Mean angle [rad].
    pub mean: f64,
}

impl Vehicle {
    /// The wheels from the angle `wheel` [rad] after `time` [s] of a `command` [rad] that reaches
    /// them: a first-order response whose rate is limited, solved exactly.
    ///
    /// Farther from the commanded angle than `max_steer_rate steer_lag` the wheels turn at their
    /// rate, nearer they approach it exponentially.
    #[inline]
    pub fn move_wheel(&self, wheel: f64, command: f64, time: f64) -> Moved {
        let target = saturate(command + self.steer_offset, -self.max_steer, self.max_steer);
        if time <= 0.0 {
            return Moved { wheel, mean: wheel };
        }
        let gap = target - wheel;
        match self.max_steer_rate {
            Some(rate) if gap.abs() > rate * self.steer_lag => {
                let knee = (rate * self.steer_lag).copysign(gap);
                let ramp = (gap - knee).abs() / rate;
                if ramp >= time {
                    let turned = (rate * time).copysign(gap);
                    return Moved {
                        wheel: wheel + turned,
                        mean: wheel + 0.5 * turned,
                    };
                }
                let start = target - knee;
                let rest = self.approach(start, target, time - ramp);
                let share = ramp / time;
                Moved {
                    wheel: rest.wheel,
                    mean: share * (0.5 * (wheel + start)) + (1.0 - share) * rest.mean,
                }
            }
            _ => self.approach(wheel, target, time),
        }
    }

    /// The exponential part of the response.
    #[inline]
    fn approach(&self, wheel: f64, target: f64, time: f64) -> Moved {
        let kept = decay(time, self.steer_lag);
        let excess = wheel - target;
        Moved {
            wheel: target + excess * kept,
            mean: target + excess * (self.steer_lag * (1.0 - kept) / time),
        }
    }
}

/// What reached the wheels in a period: integrals over the time, for the speed 1 m/s and the
/// turning length 1 m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reached {
    /// Of `tan(wheel)` [s].
    pub turn: f64,
    /// Of its derivative by the angle [s].
    pub slope: f64,
}

/// The commands that are given but have not reached the wheels, oldest first, and the wheels.
#[derive(Clone, Copy, Debug)]
pub struct InFlight {
    /// Angle [rad] and how long it was commanded [s].
    commands: [(f64, f64); Self::CAPACITY],
    first: usize,
    count: usize,
    /// Angle of the wheels by the vehicle's own figures, without an estimated offset [rad].
    wheel: f64,
}

/// Places of the ring that hold no command do not count.
impl PartialEq for InFlight {
    fn eq(&self, other: &Self) -> bool {
        self.wheel == other.wheel && self.commands().eq(other.commands())
    }
}

impl InFlight {
    /// Commands are remembered apart down to this share of the dead time.
    const RESOLUTION: usize = 64;
    /// The most commands in flight; shorter ones are joined, see [`elapse`](Self::elapse).
    pub const CAPACITY: usize = 3 * Self::RESOLUTION + 4;
    /// The longest step of the prediction [s].
    const STEP: f64 = 0.05;

    /// The wheels at rest under the command `steer` [rad], and that command in flight.
    pub fn settled(vehicle: &Vehicle, steer: f64) -> Self {
        let most = vehicle.max_steer;
        let mut in_flight = Self {
            commands: [(0.0, 0.0); Self::CAPACITY],
            first: 0,
            count: 0,
            wheel: saturate(steer + vehicle.steer_offset, -most, most),
        };
        if vehicle.dead_time > 0.0 {
            in_flight.push((steer, vehicle.dead_time));
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

    /// Commands in flight as they were, with a dead time that is `longer` than the vehicle's by so
    /// much [s].
    ///
    /// # Errors
    ///
    /// [`InputError`] where there are too many commands, and as [`check`](Self::check).
    pub fn restore(
        vehicle: &Vehicle,
        commands: impl ExactSizeIterator<Item = (f64, f64)>,
        wheel: f64,
        longer: f64,
    ) -> Result<Self, InputError> {
        let count = commands.len();
        if count > Self::CAPACITY {
            return Err(InputError {
                field: "commands_in_flight",
                value: from_count(count),
                requirement: Requirement::CountInRange(0, Self::CAPACITY),
            });
        }
        let mut in_flight = Self::settled(vehicle, 0.0);
        in_flight.count = 0;
        in_flight.wheel = wheel;
        for command in commands {
            in_flight.push(command);
        }
        in_flight.check(vehicle, longer)?;
        Ok(in_flight)
    }

    /// Whether commands are ones that can be in flight to the wheels of this vehicle.
    ///
    /// # Errors
    ///
    /// [`InputError`] where they cannot: an angle beyond a quarter turn, a duration that is none,
    /// durations that do not add up to the dead time.
    pub fn check(&self, vehicle: &Vehicle, longer: f64) -> Result<(), InputError> {
        let limit = core::f64::consts::FRAC_PI_2;
        input_in_range("wheel", self.wheel, -limit, limit)?;
        let dead_time = vehicle.dead_time + longer;
        let slack = 1e-9 * (1.0 + dead_time);
        let mut total = 0.0;
        for (steer, duration) in self.commands() {
            input_in_range("commands_in_flight", steer, -limit, limit)?;
            input_in_range("commands_in_flight", duration, 0.0, dead_time + slack)?;
            total += duration;
        }
        input_in_range(
            "commands_in_flight",
            total,
            dead_time - slack,
            dead_time + slack,
        )?;
        Ok(())
    }

    /// The commands in flight, oldest first: angle [rad] and duration [s].
    pub fn commands(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        (0..self.count).map(|k| self.get(k))
    }

    /// Angle of the wheels by the vehicle's own figures, without an estimated offset [rad].
    pub fn wheel(&self) -> f64 {
        self.wheel
    }

    /// What reaches the wheels in `dt` [s] after `last` was commanded.
    #[inline]
    pub fn reaching(&self, vehicle: &Vehicle, last: f64, dt: f64) -> Reached {
        let mut reached = Reached::default();
        let (mut wheel, mut gone) = (self.wheel, dt);
        for (steer, duration) in self.commands().chain([(last, dt)]) {
            if gone <= 0.0 {
                break;
            }
            let part = if duration < gone { duration } else { gone };
            let moved = vehicle.move_wheel(wheel, steer, part);
            let tangent = tan(moved.mean);
            reached.turn += part * tangent;
            reached.slope += part * (1.0 + tangent * tangent);
            wheel = moved.wheel;
            gone -= part;
        }
        reached
    }

    /// Lets `dt` [s] pass since `last` was commanded: it takes flight, and the oldest commands
    /// reach the wheels. With a dead time that turns out `longer` by so much [s] they reach them
    /// later. Commands shorter than a 64th of the dead time are joined to their mean.
    pub fn elapse(&mut self, vehicle: &Vehicle, last: f64, dt: f64, longer: f64) {
        let mut gone = dt - longer;
        let joined = vehicle.dead_time / from_count(Self::RESOLUTION);
        let newest = self.count.checked_sub(1);
        match newest.map(|k| (k, self.get(k))) {
            Some((k, (steer, duration))) if duration + dt <= joined => {
                let total = duration + dt;
                let mean = (steer * duration + last * dt) / total;
                self.set(k, (mean, total));
            }
            _ => self.push((last, dt)),
        }
        while gone > 0.0 && self.count > 0 {
            let (steer, duration) = self.get(0);
            if duration > gone {
                self.wheel = vehicle.move_wheel(self.wheel, steer, gone).wheel;
                self.set(0, (steer, duration - gone));
                break;
            }
            self.wheel = vehicle.move_wheel(self.wheel, steer, duration).wheel;
            self.pop();
            gone -= duration;
        }
    }

    /// The vehicle and its wheels as they will be when a command given now reaches them: rolled
    /// forward through the commands in flight. The state is that of the point that does not slip;
    /// what the `estimate` knows better than `vehicle` counts.
    pub fn predict(
        &self,
        vehicle: &Vehicle,
        state: VehicleState,
        estimate: &Estimate,
    ) -> (VehicleState, f64) {
        let (start, mut time) = (state.speed, 0.0);
        let (mut state, mut wheel) = (state, self.wheel);
        let length = vehicle.turning_length(state.speed) / estimate.gain;
        for (steer, duration) in self.commands() {
            let steps = from_count(ceil_to_count(duration / Self::STEP));
            let step = duration / steps;
            let mut done = 0.0;
            while done < steps {
                let moved = vehicle.move_wheel(wheel, steer, step);
                time += step;
                let speed = estimate.speed_after(start, time);
                let travel = 0.5 * (state.speed + speed) * step;
                let angle = vehicle.at_wheels(moved.mean + estimate.steer_offset);
                let curvature = tan(angle) / length;
                let slip = estimate.slip + estimate.slip_length * curvature;
                state = advance(state, travel, curvature, slip);
                state.speed = speed;
                wheel = moved.wheel;
                done += 1.0;
            }
        }
        (state, wheel)
    }

    #[inline]
    fn place(&self, k: usize) -> usize {
        let place = self.first + k;
        if place < Self::CAPACITY {
            place
        } else {
            place - Self::CAPACITY
        }
    }

    #[inline]
    fn get(&self, k: usize) -> (f64, f64) {
        self.commands
            .get(self.place(k))
            .copied()
            .unwrap_or((self.wheel, 0.0))
    }

    #[inline]
    fn set(&mut self, k: usize, command: (f64, f64)) {
        let place = self.place(k);
        if let Some(entry) = self.commands.get_mut(place) {
            *entry = command;
        }
    }

    #[inline]
    fn push(&mut self, command: (f64, f64)) {
        self.set(self.count, command);
        self.count += 1;
    }

    #[inline]
    fn pop(&mut self) {
        self.first = self.place(1);
        self.count -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::exp;
    use alloc::vec::Vec;

    fn car(dead_time: f64, steer_lag: f64, max_steer_rate: Option<f64>) -> Vehicle {
        Vehicle {
            steer_lag,
            dead_time,
            max_steer_rate,
            ..Vehicle::DEFAULT
        }
    }

    #[test]
    fn test_elapse_brings_a_command_after_the_dead_time() {
        let car = car(0.2, 0.0, None);
        let mut in_flight = InFlight::settled(&car, 0.0);
        let wheels: Vec<f64> = (1..8)
            .map(|k| {
                in_flight.elapse(&car, 0.1 * f64::from(k), 0.05, 0.0);
                in_flight.wheel()
            })
            .collect();
        let expected = [0.0, 0.0, 0.0, 0.0, 0.1, 0.2, 0.3];
        for (wheel, expected) in wheels.iter().zip(expected) {
            assert!((wheel - expected).abs() < 1e-12, "{wheels:?}");
        }
    }

    #[test]
    fn test_elapse_durations_always_add_up_to_the_dead_time() {
        let car = car(0.3, 0.1, None);
        let mut in_flight = InFlight::settled(&car, 0.2);
        let mut dt = 1e-6;
        for k in 0..100_000_u32 {
            dt = if k % 1000 == 0 {
                0.7
            } else {
                1e-6 + (dt * 7.3) % 0.004
            };
            in_flight.elapse(&car, 0.001 * f64::from(k % 300), dt, 0.0);
            let total: f64 = in_flight.commands().map(|(_, duration)| duration).sum();
            assert!((total - 0.3).abs() < 1e-9, "{k} {total}");
        }
        let commands = in_flight.commands().collect::<Vec<_>>().into_iter();
        let restored = InFlight::restore(&car, commands, in_flight.wheel(), 0.0).unwrap();
        assert!(restored.commands().eq(in_flight.commands()));
    }

    #[test]
    fn test_settled_wheels_stand_at_the_command_and_its_offset() {
        let car = Vehicle {
            steer_offset: 0.02,
            ..car(0.2, 0.1, None)
        };
        let mut in_flight = InFlight::settled(&car, 0.3);
        assert_eq!(in_flight.wheel(), 0.32);
        in_flight.elapse(&car, 0.3, 0.05, 0.0);
        assert_eq!(in_flight.wheel(), 0.32);
    }

    #[test]
    fn test_move_wheel_is_a_first_order_response_with_a_limited_rate() {
        let lagging = car(0.0, 0.1, None).move_wheel(0.0, 1.0, 0.1);
        assert!((lagging.wheel - (1.0 - exp(-1.0))).abs() < 1e-15);
        let slow = car(0.0, 0.0, Some(0.5));
        assert_eq!(slow.move_wheel(0.0, 1.0, 0.1).wheel, 0.05);
        assert_eq!(slow.move_wheel(0.0, 0.01, 0.1).wheel, 0.01);
        // Against the differential equation in small steps.
        let both = car(0.0, 0.2, Some(0.4));
        for (start, command, time) in [(0.0, 0.3, 0.5), (0.1, -0.6, 2.5), (0.2, 0.25, 0.3)] {
            let (mut wheel, mut sum) = (start, 0.0);
            let step = time / 1e5;
            for _ in 0..100_000 {
                let rate = saturate((command - wheel) / 0.2, -0.4, 0.4);
                sum += (wheel + 0.5 * rate * step) * step;
                wheel += rate * step;
            }
            let moved = both.move_wheel(start, command, time);
            assert!((moved.wheel - wheel).abs() < 1e-5, "{moved:?} {wheel}");
            assert!((moved.mean - sum / time).abs() < 1e-5, "{moved:?}");
        }
    }

    #[test]
    fn test_predict_braking_stops_and_does_not_turn_round() {
        let car = car(0.6, 0.1, None);
        let in_flight = InFlight::settled(&car, 0.0);
        for speed in [1.0, -1.0] {
            let state = VehicleState {
                x: 0.0,
                y: 0.0,
                yaw: 0.0,
                speed,
            };
            let estimate = Estimate {
                acceleration: -5.0 * speed,
                ..Estimate::DEFAULT
            };
            let (seen, _) = in_flight.predict(&car, state, &estimate);
            assert_eq!(seen.speed, 0.0);
            assert!((seen.x - 0.1 * speed).abs() < 1e-12, "{seen:?}");
        }
    }

    #[test]
    fn test_predict_is_where_the_vehicle_comes_to_be() {
        let car = car(0.25, 0.1, None);
        // One line of commands as the controller keeps it, and one as the vehicle has it.
        let (mut kept, mut real) = (InFlight::settled(&car, 0.0), InFlight::settled(&car, 0.0));
        let mut vehicle = VehicleState {
            x: 1.0,
            y: 2.0,
            yaw: 0.3,
            speed: 8.0,
        };
        let (mut last, mut predicted, mut driven) = (0.0, Vec::new(), Vec::new());
        for command in [0.1, -0.2, 0.3, 0.05, 0.1, 0.0, 0.1, 0.0, 0.2, 0.0] {
            if !driven.is_empty() {
                kept.elapse(&car, last, 0.05, 0.0);
                predicted.push(kept.predict(&car, vehicle, &Estimate::DEFAULT).0);
            }
            driven.push(vehicle);
            last = command;
            for _ in 0..50 {
                real.elapse(&car, last, 0.001, 0.0);
                vehicle = advance(vehicle, 0.008, tan(real.wheel()) / 3.0, 0.0);
            }
        }
        for (there, predicted) in driven.iter().skip(6).zip(&predicted) {
            for (a, b) in [
                (predicted.x, there.x),
                (predicted.y, there.y),
                (predicted.yaw, there.yaw),
            ] {
                assert!((a - b).abs() < 2e-3, "{predicted:?} {there:?}");
            }
        }
    }
}
