//! Measured and predicted vehicle of a step, from the pose, its age and the applied angle.

use crate::bounds::MIN_DT;
use crate::laws::{Belief, LateralLaw};
use crate::math::{larger, saturate};
use crate::path::follow::Located;
use crate::tracker::reported::Reported;
use crate::tracker::state::{Model, Tracking};
use crate::tracker::step::Tracker;
use crate::vehicle::past::Past;
use crate::vehicle::wheels::Reached;
use crate::vehicle::{AdaptParams, Estimate, Estimator, InFlight, Motion, Vehicle, VehicleState};

/// The vehicle at a step: as it is measured, and as it is predicted for the controller.
pub(super) struct Perception {
    /// The vehicle now; an old pose is rolled forward to now.
    pub(super) here: VehicleState,
    /// The vehicle when the next command reaches the wheels.
    pub(super) predicted: VehicleState,
    pub(super) belief: Belief,
}

impl<L: LateralLaw> Tracker<L> {
    /// What the wheels did in the `dt` [s] since the last step, and from the last measured pose to this one,
    /// which is `age` [s] old.
    #[inline]
    pub(super) fn reach(
        &self,
        state: &Tracking<L::State>,
        model: &mut Model,
        dt: f64,
        age: f64,
    ) -> [Reached; 2] {
        let (told, steer) = (self.law.vehicle(), state.steer);
        let quicker = model.estimator.estimate.quicker(told);
        let car = quicker.as_ref().unwrap_or(told);
        // A tracker that models nothing ignores what a state of another vehicle holds.
        let in_flight = model.in_flight.as_ref().filter(|_| self.models);
        let standing = car.at_wheels(steer + car.steer_offset);
        let lately = Reached {
            wheels: in_flight.map(|line| line.wheel_integrals(car, steer, dt)),
            time: dt,
            first: in_flight.map_or(standing, InFlight::wheel),
        };
        let unseen = model.estimator.unseen.take();
        if age <= 0.0 && model.past.is_none() {
            return [lately, unseen.map_or(lately, |before| before.then(&lately))];
        }
        // Nothing is remembered before the first pose with an age: the wheels count as still.
        let past = model.past.get_or_insert_with(|| {
            let mut past = Past::settled(lately.first);
            if state.answer.is_none() {
                // The first pose is the newest.
                past.see(larger(age - dt, 0.0));
            } else if let Some(unseen) = unseen {
                past.see(unseen.time);
            }
            past
        });
        let wheel = in_flight.map_or(past.wheel(), InFlight::wheel);
        let commands = in_flight.into_iter().flat_map(InFlight::commands);
        past.elapse(car, commands.chain([(steer, dt)]), wheel, dt);
        let time = past.since() - age;
        if age <= 0.0 && time <= dt {
            return [lately; 2];
        }
        let is_new = time >= MIN_DT;
        let since = Reached {
            wheels: in_flight
                .filter(|_| is_new)
                .map(|_| past.wheel_integrals(age)),
            time,
            first: past.wheel_before(),
        };
        [lately, since]
    }

    /// Measured and predicted vehicle, after the last command `steer` [rad], the speed that was `told`
    /// [m/s] and all that is `reported`,
    /// which is checked: observes the motion since the last pose, in which the wheels did what they
    /// `reached`, puts the last command in flight, and predicts. Since an old pose the drive `moved` the
    /// vehicle; where that is not known, the acceleration does that was seen until then.
    #[inline]
    pub(super) fn perceive(
        &self,
        (steer, dt, told): (f64, f64, f64),
        model: &mut Model,
        vehicle: VehicleState,
        reached: &Reached,
        (reported, moved): (Reported, Option<Motion>),
    ) -> Perception {
        let (car, age) = (self.law.vehicle(), reported.pose_age);
        let mut in_flight = model.in_flight.as_mut().filter(|_| self.models);
        if in_flight.is_none() && age <= 0.0 {
            return Perception {
                here: vehicle,
                predicted: vehicle,
                belief: Belief {
                    wheel: steer,
                    estimate: Estimate::DEFAULT,
                },
            };
        }
        let estimator = &mut model.estimator;
        let old = vehicle.ahead(car.no_slip());
        let (before, quicker) = (
            estimator.estimate.longer_dead_time,
            estimator.estimate.quicker(car),
        );
        let dead_time = estimator.estimate.dead_time(car);
        // A pose that was given before carries no new information.
        if let (Some(adapt), Some(wheels)) = (self.adapt(), reached.wheels) {
            let as_told = VehicleState { speed: told, ..old };
            estimator.observe_turn(adapt, car, as_told, wheels, reached.time);
            // No command reaches the wheels before it is given: within a period the dead time
            // grows by at most that period.
            let longer = &mut estimator.estimate.longer_dead_time;
            *longer = saturate(*longer, before - dt, before + dt);
        }
        let estimate = match in_flight {
            Some(_) => estimator.estimate,
            None => Estimate::DEFAULT,
        };
        let (here, now) = match &model.past {
            Some(past) if age > 0.0 => {
                let now = rolled(past, car, old, (age, moved), &estimate).bounded();
                (now.ahead(-car.no_slip()).bounded(), now)
            }
            _ => (vehicle, old),
        };
        let (predicted, wheel) = match &mut in_flight {
            Some(in_flight) => {
                let car = quicker.as_ref().unwrap_or(car);
                let longer = estimate.dead_time(car) - dead_time;
                in_flight.elapse(car, steer, dt, longer);
                let measured = reported.measured_steer;
                arrival(car, in_flight, measured, [here, now], &estimate)
            }
            None => (here, steer),
        };
        Perception {
            here,
            predicted,
            belief: Belief { wheel, estimate },
        }
    }

    /// Updates the estimated slip, by the `vehicle` at a new pose, whose speed was `told` [m/s] and whose wheels
    /// did what they `reached` since the last. A change of the driving direction interrupts the estimation.
    #[inline]
    pub(super) fn observe_slip(
        &self,
        estimator: &mut Estimator,
        adapt: &AdaptParams,
        here: &Located,
        (vehicle, told): (VehicleState, f64),
        reached: &Reached,
        known: &Estimate,
    ) {
        if reached.wheels.is_none() {
            // A pose that was given before carries no new information.
            if here.direction_changed {
                estimator.last_measured = None;
            }
            return;
        }
        let car = self.law.vehicle();
        let as_told = VehicleState {
            speed: told,
            ..vehicle
        };
        let now = as_told.ahead(car.no_slip());
        if here.direction_changed || here.vehicle.speed <= 0.0 {
            estimator.last_measured = Some(now);
            return;
        }
        let bend = reached.first_bend(car, vehicle.speed, known);
        estimator.observe_slip(adapt, car, now, bend, reached.time);
        estimator.last_measured = Some(now);
    }
}

/// The no-slip point of a vehicle that was at `old` `age` [s] ago, since which the drive `moved` it, now.
#[inline]
fn rolled(
    past: &Past,
    car: &Vehicle,
    old: VehicleState,
    (age, moved): (f64, Option<Motion>),
    estimate: &Estimate,
) -> VehicleState {
    let Some(moved) = moved else {
        return past.advance(car, old, age, estimate);
    };
    // At its mean speed it goes as far.
    let speed = moved.travelled / age;
    let steady = Estimate {
        acceleration: 0.0,
        ..*estimate
    };
    let now = past.advance(car, VehicleState { speed, ..old }, age, &steady);
    VehicleState {
        speed: moved.speed,
        ..now
    }
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
