//! The trajectory that a controller intends: its answers to its own vehicle, step after step.

use super::LateralLaw;
use super::tracker::Tracker;
use super::tracker_state::TrackerState;
use crate::error::InputError;
use crate::math::{ceil_to_count, from_count, tan};
use crate::path::view::PathView;
use crate::vehicle::bicycle::advance;
use crate::vehicle::state::checked_dt;
use crate::vehicle::{Estimate, InFlight, Vehicle, VehicleState};

/// One instant of a predicted trajectory.
// The order is told: arrays of these come from C.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// Time since the last step [s].
    pub time: f64,
    /// Pose of the vehicle's point, and speed.
    pub vehicle: VehicleState,
    /// Angle commanded then [rad].
    pub steer: f64,
}

impl Predicted {
    /// The origin at the last step.
    pub const DEFAULT: Self = Self {
        time: 0.0,
        vehicle: VehicleState {
            x: 0.0,
            y: 0.0,
            yaw: 0.0,
            speed: 0.0,
        },
        steer: 0.0,
    };
}

/// The longest step of the motion [s].
const STEP: f64 = 0.05;

impl<L: LateralLaw> Tracker<L> {
    /// Writes the trajectory from the last step of `state` on into `out`, an instant each `dt` [s],
    /// the last step first. Tells how many were written: none before the first step.
    ///
    /// A copy of the controller drives the vehicle as it is known by now, at its present
    /// acceleration, and to the next stop at most. `state` stays as it is.
    ///
    /// # Errors
    ///
    /// [`InputError`] where `dt` is no control period.
    pub fn predict(
        &self,
        path: &PathView<'_>,
        state: &TrackerState<L::State>,
        dt: f64,
        out: &mut [Predicted],
    ) -> Result<usize, InputError> {
        let dt = checked_dt(dt)?;
        let Some(answer) = state.answer else {
            return Ok(0);
        };
        let car = self.vehicle();
        let mut state = state.clone();
        // The poses to come have no age, and what is predicted shows nothing of the vehicle.
        let wheel = state.past.map(|past| past.wheel());
        state.past = None;
        state.held_time = 0.0;
        state.estimator.seen = None;
        let (estimate, mut plant) = match state.in_flight {
            Some(in_flight) if self.models => (state.estimator.estimate, in_flight),
            _ => (
                Estimate::DEFAULT,
                InFlight::standing(car, state.steer, wheel),
            ),
        };
        let mut vehicle = answer.vehicle;
        let mut remaining = answer.ahead.distance_to_stop;
        let count = out.len();
        for (k, instant) in out.iter_mut().enumerate() {
            *instant = Predicted {
                time: from_count(k) * dt,
                vehicle,
                steer: state.steer,
            };
            if k + 1 == count {
                break;
            }
            if (vehicle.speed < 0.0) == answer.reverse {
                let most = if remaining > 0.0 { remaining / dt } else { 0.0 };
                if vehicle.speed.abs() > most {
                    vehicle.speed = most.copysign(vehicle.speed);
                }
            }
            remaining -= vehicle.speed.abs() * dt;
            let start = vehicle.ahead(car.no_slip());
            let end = drive(car, &plant, state.steer, &estimate, start, dt);
            plant.elapse(car, state.steer, dt, 0.0);
            vehicle = end.bounded().ahead(-car.no_slip()).bounded();
            if self.step(path, &mut state, vehicle, dt).is_err() {
                return Ok(k + 1);
            }
        }
        Ok(count)
    }
}

/// The point that does not slip `dt` [s] on from `state`, with `last` commanded [rad] and the
/// commands before it in flight.
fn drive(
    car: &Vehicle,
    in_flight: &InFlight,
    last: f64,
    estimate: &Estimate,
    state: VehicleState,
    dt: f64,
) -> VehicleState {
    let (begin, mut time) = (state.speed, 0.0);
    let length = car.turning_length(state.speed) / estimate.gain;
    let (mut state, mut wheel, mut gone) = (state, in_flight.wheel(), dt);
    for (steer, duration) in in_flight.commands().chain([(last, dt)]) {
        if gone <= 0.0 {
            break;
        }
        let part = if duration < gone { duration } else { gone };
        let steps = from_count(ceil_to_count(part / STEP));
        let step = part / steps;
        let mut done = 0.0;
        while done < steps {
            let moved = car.move_wheel(wheel, steer, step);
            time += step;
            let speed = estimate.speed_after(begin, time);
            let travel = 0.5 * (state.speed + speed) * step;
            let angle = car.at_wheels(moved.mean + estimate.steer_offset);
            let curvature = tan(angle) / length;
            let slip = estimate.slip + estimate.slip_length * curvature;
            state = advance(state, travel, curvature, slip);
            state.speed = speed;
            wheel = moved.wheel;
            done += 1.0;
        }
        gone -= part;
    }
    state
}
