//! The trajectory that a controller intends: it drives its own vehicle ahead, step by step.

use crate::error::InputError;
use crate::laws::LateralLaw;
use crate::math::{from_count, larger, saturate};
use crate::path::Place;
use crate::path::view::PathView;
use crate::tracker::reported::Reported;
use crate::tracker::seen::Seen;
use crate::tracker::state::TrackerState;
use crate::tracker::step::Tracker;
use crate::vehicle::bicycle::Rollout;
use crate::vehicle::state::checked_dt;
use crate::vehicle::timed::clipped;
use crate::vehicle::{Estimate, InFlight, VehicleState};

/// One instant of a predicted trajectory.
// The order of the fields is fixed: arrays of these come from C.
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
        vehicle: VehicleState::ORIGIN,
        steer: 0.0,
    };
}

/// How a predicted vehicle goes on: its acceleration [m/s²], signed as its speed, and the segment behind a
/// cusp at which it stands.
pub(crate) type Pace = (f64, Option<usize>);

impl<L: LateralLaw> Tracker<L> {
    /// Writes the trajectory from the last step of `state` on into `out`, an instant each `dt` [s],
    /// the last step first. Returns how many were written: 0 before the first step.
    ///
    /// A copy of the controller drives the estimated vehicle at its present acceleration, and to
    /// the next stop at most. `state` is unchanged.
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
        self.predict_driven(path, state, dt, out, false, |_, _| None)
    }

    /// [`predict`](Self::predict) of a vehicle that `drive`s by what was seen of it, nothing at first, with
    /// `straight` wheels or not; at its present acceleration, and to the next stop at most, where that is none.
    pub(crate) fn predict_driven(
        &self,
        path: &PathView<'_>,
        state: &TrackerState<L::State>,
        dt: f64,
        out: &mut [Predicted],
        straight: bool,
        mut drive: impl FnMut(VehicleState, Option<&Seen>) -> Option<Pace>,
    ) -> Result<usize, InputError> {
        let dt = checked_dt(dt)?;
        let Some(answer) = state.answer else {
            return Ok(0);
        };
        let (mut state, mut estimate, mut plant) = self.estimated(state);
        let quicker = estimate.quicker(self.vehicle());
        let car = quicker.as_ref().unwrap_or(self.vehicle());
        let mut vehicle = answer.vehicle;
        let mut remaining = answer.ahead.distance_to_stop;
        let count = out.len();
        let mut pace = drive(vehicle, None);
        for (k, instant) in out.iter_mut().enumerate() {
            *instant = Predicted {
                time: from_count(k) * dt,
                vehicle,
                steer: state.steer,
            };
            if k + 1 == count {
                break;
            }
            if let Some((acceleration, _)) = pace {
                estimate.acceleration = acceleration;
                state.model.estimator.estimate.acceleration = acceleration;
                if acceleration < 0.0 && vehicle.speed.abs() <= 0.0 {
                    // From rest, backwards: a speed of 0 counts as one forwards, which brakes.
                    vehicle.speed = -f64::MIN_POSITIVE;
                }
            } else if (vehicle.speed < 0.0) == answer.reverse {
                let most = larger(remaining / dt, 0.0);
                vehicle.speed = saturate(vehicle.speed, -most, most);
            }
            remaining -= vehicle.speed.abs() * dt;
            let start = vehicle.ahead(car.no_slip());
            let mut rollout = Rollout::new(car, &estimate, start);
            let commands = plant.commands().chain([(state.steer, dt)]);
            rollout.drive(plant.wheel(), clipped(commands, dt));
            plant.elapse(car, state.steer, dt, 0.0);
            let braked = vehicle.speed * estimate.acceleration < 0.0;
            vehicle = rollout.state().bounded().ahead(-car.no_slip()).bounded();
            if braked && vehicle.speed.abs() <= 0.0 {
                // Brakes that have stopped it do not drive it on the other way.
                estimate.acceleration = 0.0;
                state.model.estimator.estimate.acceleration = 0.0;
            }
            // The speed signal says what it says of a vehicle that is so fast.
            let told = state.model.estimator.estimate.told(vehicle);
            let TrackerState { tracking, model } = &mut state;
            let seen = self.see(
                path,
                tracking,
                model,
                told.bounded(),
                dt,
                (Reported::NOTHING, true, |_| None),
            );
            self.turn(path, tracking, &seen, straight);
            pace = drive(vehicle, Some(&seen));
            if let Some((_, Some(segment))) = pace {
                tracking.place = Place::at(path, segment);
            }
        }
        Ok(count)
    }

    /// A copy of the controller, and the vehicle that it drives ahead: the estimated one. Predicted poses have
    /// no age, and carry no information on the vehicle.
    fn estimated(
        &self,
        state: &TrackerState<L::State>,
    ) -> (TrackerState<L::State>, Estimate, InFlight) {
        let mut state = state.clone();
        let model = &mut state.model;
        let wheel = model.past.take().map(|past| past.wheel());
        (model.estimator.last_measured, model.estimator.unseen) = (None, None);
        let (estimate, plant) = match model.in_flight {
            Some(in_flight) if self.models => (model.estimator.estimate, in_flight),
            _ => (
                Estimate::DEFAULT,
                InFlight::standing(self.vehicle(), state.steer, wheel),
            ),
        };
        state.held_time = 0.0;
        (state, estimate, plant)
    }
}
