//! Measured and predicted vehicle of a step, from the pose, its age and the applied angle.

use crate::bounds::MIN_DT;
use crate::laws::{Belief, LateralLaw};
use crate::math::{rough_tangent, saturate, tan};
use crate::path::follow::Located;
use crate::tracker::reported::Reported;
use crate::tracker::state::Model;
use crate::tracker::step::Tracker;
use crate::vehicle::past::Past;
use crate::vehicle::{AdaptParams, Estimate, Estimator, InFlight, Vehicle, VehicleState};

/// The vehicle at a step: as it is measured, and as it is predicted for the controller.
pub(super) struct Perception {
    /// The vehicle now; an old pose is rolled forward to now.
    pub(super) here: VehicleState,
    /// The vehicle when the next command reaches the wheels.
    pub(super) predicted: VehicleState,
    pub(super) belief: Belief,
    /// Time between the last pose and this one [s]; 0 or less for a pose that was given before.
    pub(super) observed: f64,
    /// Curvature [1/m] by the wheels when the period began that ends with the pose.
    pub(super) bend: f64,
}

impl<L: LateralLaw> Tracker<L> {
    /// Measured and predicted vehicle, after the last command `steer` [rad] and all that is `reported`,
    /// which is checked.
    #[inline]
    pub(super) fn perceive(
        &self,
        steer: f64,
        model: &mut Model,
        vehicle: VehicleState,
        bend: f64,
        dt: f64,
        reported: Reported,
    ) -> Perception {
        if reported.pose_age > 0.0 || model.past.is_some() {
            return self.perceive_aged(steer, model, vehicle, dt, reported);
        }
        let measured = reported.measured_steer;
        let (predicted, belief) = self.predict_now(steer, model, vehicle, dt, measured);
        Perception {
            here: vehicle,
            predicted,
            belief,
            observed: dt,
            bend,
        }
    }

    /// [`perceive`](Self::perceive) for a pose that was measured some time ago: observes the motion
    /// between the poses, puts the last command in flight, and predicts.
    #[cold]
    fn perceive_aged(
        &self,
        steer: f64,
        model: &mut Model,
        vehicle: VehicleState,
        dt: f64,
        reported: Reported,
    ) -> Perception {
        let (car, age) = (self.vehicle(), reported.pose_age);
        let estimator = &mut model.estimator;
        let mut in_flight = model.in_flight.as_mut().filter(|_| self.models);
        // Nothing is remembered before the first pose with an age: the wheels count as still.
        let past = model.past.get_or_insert_with(|| {
            let standing = car.at_wheels(steer + car.steer_offset);
            Past::settled(in_flight.as_ref().map_or(standing, |line| line.wheel()))
        });
        remember(car, past, in_flight.as_deref(), steer, dt);
        let bend = curvature(car, past.wheel_before(), vehicle.speed, &estimator.estimate);
        let observed = past.since() - age;
        let old = vehicle.ahead(car.no_slip());
        let before = estimator.estimate.longer_dead_time;
        // A pose that was given before carries no new information.
        if observed >= MIN_DT {
            if let (Some(adapt), Some(_)) = (self.adapt(), &in_flight) {
                let wheels = past.wheel_integrals(age);
                estimator.observe_turn(adapt, car, old, wheels, observed);
                // No command reaches the wheels before it is given: within a period the dead time
                // grows by at most that period.
                let longer = &mut estimator.estimate.longer_dead_time;
                *longer = saturate(*longer, before - dt, before + dt);
            }
            past.see(age);
        }
        let estimate = match in_flight {
            Some(_) => estimator.estimate,
            None => Estimate::DEFAULT,
        };
        let (here, now) = if age > 0.0 {
            let now = past.advance(car, old, age, &estimate).bounded();
            (now.ahead(-car.no_slip()).bounded(), now)
        } else {
            (vehicle, old)
        };
        let (predicted, wheel) = match &mut in_flight {
            Some(in_flight) => {
                in_flight.elapse(car, steer, dt, estimate.longer_dead_time - before);
                let measured = reported.measured_steer;
                arrival(car, in_flight, measured, [here, now], &estimate)
            }
            None => (here, steer),
        };
        Perception {
            here,
            predicted,
            belief: Belief { wheel, estimate },
            observed,
            bend,
        }
    }

    /// The predicted vehicle of a pose that is not old: observes the motion since the last step,
    /// puts the last command in flight, and predicts.
    #[inline]
    fn predict_now(
        &self,
        steer: f64,
        model: &mut Model,
        vehicle: VehicleState,
        dt: f64,
        measured: Option<f64>,
    ) -> (VehicleState, Belief) {
        let car = self.law.vehicle();
        // A tracker that models nothing ignores what a state of another vehicle holds.
        let (true, Some(in_flight)) = (self.models, &mut model.in_flight) else {
            let belief = Belief {
                wheel: steer,
                estimate: Estimate::DEFAULT,
            };
            return (vehicle, belief);
        };
        let estimator = &mut model.estimator;
        let now = vehicle.ahead(car.no_slip());
        let before = estimator.estimate.longer_dead_time;
        if let Some(adapt) = self.adapt() {
            let reached = in_flight.wheel_integrals(car, steer, dt);
            estimator.observe_turn(adapt, car, now, reached, dt);
        }
        let estimate = estimator.estimate;
        in_flight.elapse(car, steer, dt, estimate.longer_dead_time - before);
        let (predicted, wheel) = arrival(car, in_flight, measured, [vehicle, now], &estimate);
        (predicted, Belief { wheel, estimate })
    }

    /// Curvature [1/m] by the wheels as they are before the last command, `steer` [rad], is put in
    /// flight.
    #[inline]
    pub(super) fn bend(&self, steer: f64, model: &Model, speed: f64) -> f64 {
        let car = self.law.vehicle();
        match &model.in_flight {
            Some(in_flight) if self.models => {
                curvature(car, in_flight.wheel(), speed, &model.estimator.estimate)
            }
            _ => rough_tangent(car.at_wheels(steer + car.steer_offset)) / car.turning_length(speed),
        }
    }

    /// Updates the estimated slip. `vehicle` is the measured pose, `dt` [s] after the last one, and
    /// `bend` its curvature [1/m] before. A change of the driving direction interrupts the
    /// estimation.
    #[inline]
    pub(super) fn observe_slip(
        &self,
        estimator: &mut Estimator,
        adapt: &AdaptParams,
        here: &Located,
        vehicle: VehicleState,
        (dt, bend): (f64, f64),
    ) {
        let car = self.law.vehicle();
        let now = vehicle.ahead(car.no_slip());
        if here.direction_changed || here.vehicle.speed <= 0.0 {
            estimator.last_measured = Some(now);
            return;
        }
        estimator.observe_slip(adapt, car, now, bend, dt);
        estimator.last_measured = Some(now);
    }
}

/// Curvature [1/m] of a vehicle whose wheels are at the angle `wheel` [rad].
#[inline]
fn curvature(car: &Vehicle, wheel: f64, speed: f64, estimate: &Estimate) -> f64 {
    let angle = car.at_wheels(wheel + estimate.steer_offset);
    estimate.gain * tan(angle) / car.turning_length(speed)
}

/// The vehicle when the next command reaches the wheels, and the angle of these then [rad]. They
/// start from the `measured` angle, or the modelled one. `here` is the vehicle's point now, `now` its
/// no-slip point.
#[inline]
fn arrival(
    car: &Vehicle,
    in_flight: &InFlight,
    measured: Option<f64>,
    [here, now]: [VehicleState; 2],
    estimate: &Estimate,
) -> (VehicleState, f64) {
    let wheel = match measured {
        Some(angle) => car.at_wheels(angle + car.steer_offset),
        None => in_flight.wheel(),
    };
    if estimate.delays(car) {
        let (predicted, wheel) = in_flight.predict(car, now, wheel, estimate);
        // The input was valid, so its prediction is put within the bounds and not refused.
        let predicted = predicted.bounded().ahead(-car.no_slip()).bounded();
        (predicted, wheel)
    } else {
        (here, wheel)
    }
}

/// Records `dt` [s] of the commanded angle `last` [rad]; it is in flight first if commands are.
fn remember(car: &Vehicle, past: &mut Past, in_flight: Option<&InFlight>, last: f64, dt: f64) {
    let last = core::iter::once((last, dt));
    match in_flight {
        Some(line) => past.elapse(car, line.commands().chain(last), line.wheel(), dt),
        None => past.elapse(car, last, past.wheel(), dt),
    }
}
