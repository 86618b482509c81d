//! Monitors two things: the deviation from the path, and whether the vehicle answers as modelled.
//!
//! The turn measured in a period is compared with the turns that the commands explain. These follow
//! from the vehicle's parameters, for every gain that the turns so far allow, the steering offsets
//! that they allow, with play, and a somewhat faster or slower response. What is beyond them adds up
//! in a [`Cusum`](crate::vehicle::cusum::Cusum); a sum beyond the noise of the yaw is a fault: a wrong
//! sign of the steering, stuck wheels, or a dead time longer than the vehicle's. What is not known yet
//! may be anything that the vehicle can drive with.

pub mod course;
pub mod state;

use course::Course;
use state::Expected;
pub use state::MonitorState;

use crate::math::{rough_tangent, saturate, wrap};
use crate::params;
use crate::path::follow::Located;
use crate::status::Status;
use crate::vehicle::wheels::Reached;
use crate::vehicle::{Estimate, Estimator, Vehicle, VehicleState};

params! {
    /// Thresholds of the monitor's faults: by default 1.5 m for a car that is 2 m wide, which is then half
    /// in the next lane, and twice the turn that the plants' own dynamics need.
    pub struct MonitorParams<Scaled> of Vehicle(width, wheelbase) {
        /// Cross-track error from which a vehicle that was within it is deviating [m], besides the noise
        /// that is seen; 1e9 switches it off.
        deviation_limit: Scaled = 0.75 * width.unwrap_or(wheelbase / 1.5), in [0.0, 1e9];
        /// Cross-track error beyond which a vehicle that was never within `deviation_limit` is
        /// deviating too [m]: a path that jumps away. Less than that it may join a path from.
        /// Before the start of a path neither limit counts. 1e9 switches it off.
        join_limit: Scaled = 4.5 * width.unwrap_or(wheelbase / 1.5), in [0.0, 1e9];
        /// How far the turns may add up beyond those that the commands explain, besides noise [rad];
        /// 1e9 switches it off. Smaller: faults are found sooner, false alarms are likelier.
        turn_tolerance: f64 = 0.01, in [0.0, 1e9];
    }
}

/// What is measured at a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured<'a> {
    /// Where the tracked point of the measured vehicle is.
    pub(super) here: &'a Located,
    /// The vehicle by the last pose of its own point.
    pub(super) vehicle: VehicleState,
    /// Its speed at the pose before [m/s].
    pub(super) last_speed: f64,
    /// What the modelled wheels did since the last measured pose, without wheels where this step has none;
    /// None if they are not modelled.
    pub(super) reached: Option<Reached>,
    /// Which gains the turns have shown; None if none are estimated.
    pub(super) estimator: Option<&'a Estimator>,
    /// How far it moved aside of its heading since the last measured pose [m].
    pub(super) aside: f64,
    /// Standard deviation of the position's noise [m]; 0 where none is known.
    pub(super) noise: f64,
    /// Control period [s].
    pub(super) dt: f64,
}

/// The parameters as they are given, and with their defaults for a vehicle filled in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Monitor {
    given: MonitorParams,
    params: MonitorParams<f64>,
}

impl Monitor {
    /// An error beyond a limit by less than so many standard deviations may be noise of the position.
    const DEVIATIONS: f64 = 5.0;

    /// With `params` that are within their ranges.
    pub(super) fn new(params: MonitorParams, vehicle: &Vehicle) -> Self {
        Self {
            given: params,
            params: params.resolved(vehicle),
        }
    }

    pub(super) fn params(&self) -> &MonitorParams {
        &self.given
    }

    /// Compares a step with the angle `steer` [rad] that was commanded before it, and says what is
    /// wrong; `last` is the cross-track error then [m].
    #[inline]
    pub(super) fn check(
        &self,
        car: &Vehicle,
        monitored: &mut Option<MonitorState>,
        steer: f64,
        last: Option<f64>,
        now: &Measured<'_>,
    ) -> Status {
        let at_rest = || MonitorState::settled(car.at_wheels(steer + car.steer_offset));
        let monitored = monitored.get_or_insert_with(at_rest);
        let is_deviating = self.check_path(monitored, now, last);
        let is_implausible = self.check_turn(monitored, car, steer, now);
        Status::DEVIATING.when(is_deviating)
            | Status::IMPLAUSIBLE.when(is_implausible)
            | Status::TOO_FAST.when(monitored.is_too_fast(car, now.vehicle.speed))
    }

    /// Whether the vehicle is beyond the limit after it was within. A change of direction that
    /// begins farther off is a new task, as a new path is: see `set_path` and `set_waypoint`.
    #[inline]
    fn check_path(
        &self,
        monitored: &mut MonitorState,
        now: &Measured<'_>,
        last: Option<f64>,
    ) -> bool {
        let error = now.here.closest.cross_track_error();
        // The path turns round at a cusp: there the same place has an error of the other sign.
        if let (true, Some(last)) = (now.here.direction_changed, last)
            && (error + last).abs() > self.params.deviation_limit
        {
            monitored.within = false;
        }
        if now.here.before_start {
            return false;
        }
        let is_within = error.abs() <= self.params.deviation_limit;
        monitored.within |= is_within;
        let limit = if monitored.within {
            self.params.deviation_limit
        } else {
            self.params.join_limit
        };
        error.abs() > limit + Self::DEVIATIONS * now.noise
    }

    /// Whether the vehicle turns otherwise than the commands explain, now or within the alarm time.
    #[inline]
    fn check_turn(
        &self,
        monitored: &mut MonitorState,
        car: &Vehicle,
        last: f64,
        now: &Measured<'_>,
    ) -> bool {
        let (mut dt, speed) = (now.dt, 0.5 * (now.last_speed + now.vehicle.speed));
        monitored.alarm = saturate(monitored.alarm - dt, 0.0, MonitorState::ALARM_TIME);
        if now.here.direction_changed {
            monitored.interrupt();
        }
        let tangent = match now.reached {
            Some(Reached {
                wheels: Some(wheels),
                time,
                ..
            }) => {
                dt = time;
                wheels.turn / dt
            }
            Some(_) => return monitored.alarm > 0.0,
            None => {
                let (wheel, mean) = respond(car, monitored.wheel, last, dt);
                monitored.wheel = wheel;
                rough_tangent(mean)
            }
        };
        let share = speed / car.turning_length(speed);
        let rate = share * tangent;
        let expected = Expected { rate, share, dt };

        if dt > MonitorState::MAX_PERIOD {
            monitored.interrupt();
        }
        if let Some(yaw) = monitored.yaw {
            let turn = wrap(now.vehicle.yaw - yaw);
            let tolerance = self.params.turn_tolerance;
            let alarms = monitored.observe(turn, expected, tolerance, now.estimator);
            if alarms {
                monitored.alarm = MonitorState::ALARM_TIME;
            }
            if alarms || monitored.turned.most() > 0.0 {
                let travel = speed * dt;
                let known = now
                    .estimator
                    .map_or(Estimate::DEFAULT, |known| known.estimate);
                let way = (travel, now.aside - known.slip * travel);
                let commanded = known.gain * (rate + known.steer_offset * share) * dt;
                monitored.blame((turn, commanded), way, now.noise, alarms);
            } else {
                monitored.course = Course::default();
            }
            if now.estimator.is_none() && car.max_lateral_acceleration.is_some() {
                monitored.observe_gain(turn, expected);
            }
        } else {
            monitored.rates = (rate, rate);
        }
        monitored.yaw = Some(now.vehicle.yaw);
        monitored.alarm > 0.0
    }
}

/// The wheels at the angle `wheel` [rad] `dt` [s] later under the angle `command`, and their mean:
/// the vehicle's response with a Pade approximant in place of the exponential. At most 3.3 % of a
/// move is off up to a `dt` of the lag.
#[inline]
fn respond(car: &Vehicle, wheel: f64, command: f64, dt: f64) -> (f64, f64) {
    let gap = car.at_wheels(command + car.steer_offset) - wheel;
    let lag = car.steer_lag;
    let turned = gap * (1.0 - lag * lag / (lag * lag + dt * (lag + 0.5 * dt)));
    if let Some(rate) = car.max_steer_rate
        && turned.abs() > rate * dt
    {
        let turned = (rate * dt).copysign(gap);
        return (wheel + turned, wheel + 0.5 * turned);
    }
    (wheel + turned, wheel + gap - turned * (lag / dt))
}

#[cfg(test)]
mod tests;
