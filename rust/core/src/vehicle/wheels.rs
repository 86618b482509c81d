//! The wheels: their response to a command, and the turn of the vehicle by them.

use super::{Estimate, Vehicle};
use crate::error::{InputError, input_in_range, input_within};
use crate::math::{decay, rough_tangent, tan};

/// The wheels' angle after a move, and their mean angle during it.
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
        self.turn_wheel(wheel, self.at_wheels(command + self.steer_offset), time)
    }

    /// The same towards an angle `target` [rad] of the wheels, however far it is.
    #[inline]
    pub fn turn_wheel(&self, wheel: f64, target: f64, time: f64) -> Moved {
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
        let deviation = wheel - target;
        Moved {
            wheel: target + deviation * kept,
            mean: target + deviation * (self.steer_lag * (1.0 - kept) / time),
        }
    }
}

/// What the wheels did in a period. Times `speed / turning length`, the integrals are the turn of
/// the vehicle and its derivative by a steering offset, and `change` that of the yaw rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WheelIntegrals {
    /// Integral of `tan(wheel)` over the time [s].
    pub turn: f64,
    /// Integral of its derivative by the angle, `1 + tan(wheel)^2`, over the time [s].
    pub slope: f64,
    /// `tan(wheel)` at the end less that at the beginning. Wheels that move `t` [s] later turn the
    /// vehicle by `t change` less in this period.
    pub change: f64,
}

impl WheelIntegrals {
    /// Adds wheels that stand at the angle `wheel` [rad] for `time` [s].
    #[inline]
    pub fn add(&mut self, wheel: f64, time: f64) {
        let tangent = tan(wheel);
        self.turn += time * tangent;
        self.slope += time * (1.0 + tangent * tangent);
    }
}

/// What the wheels did in the period that a pose ends.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reached {
    /// None if they are not modelled, or the period ends with a pose that was given before.
    pub wheels: Option<WheelIntegrals>,
    /// Length of the period [s].
    pub time: f64,
    /// Angle of the wheels when it began [rad].
    pub first: f64,
}

impl Reached {
    /// Bound that no valid input reaches.
    const MOST: f64 = 1e30;

    /// The same with the period that follows.
    #[inline]
    pub fn then(&self, next: &Self) -> Self {
        let both = |(before, after): (WheelIntegrals, WheelIntegrals)| WheelIntegrals {
            turn: before.turn + after.turn,
            slope: before.slope + after.slope,
            change: before.change + after.change,
        };
        Self {
            wheels: self.wheels.zip(next.wheels).map(both),
            time: self.time + next.time,
            first: self.first,
        }
    }

    /// Itself, where wheels can have done that.
    ///
    /// # Errors
    ///
    /// [`InputError`] where they cannot.
    pub fn checked(self) -> Result<Self, InputError> {
        let WheelIntegrals {
            turn,
            slope,
            change,
        } = self.wheels.unwrap_or_default();
        for number in [turn, slope, change, self.first] {
            input_within("unseen", number, Self::MOST)?;
        }
        input_in_range("unseen", self.time, 0.0, Self::MOST)?;
        Ok(self)
    }

    /// Mean curvature [1/m] of the vehicle.
    #[inline]
    pub fn bend(&self, car: &Vehicle, speed: f64, estimate: &Estimate) -> f64 {
        let tangent = match self.wheels {
            Some(wheels) => {
                estimate.gain * (wheels.turn + estimate.steer_offset * wheels.slope) / self.time
            }
            None => rough_tangent(self.first),
        };
        tangent / car.turning_length(speed)
    }

    /// Curvature [1/m] of the vehicle when the period began.
    #[inline]
    pub fn first_bend(&self, car: &Vehicle, speed: f64, estimate: &Estimate) -> f64 {
        let angle = car.at_wheels(self.first + estimate.steer_offset);
        estimate.gain * tan(angle) / car.turning_length(speed)
    }
}
