//! A step put together from the parts that it is made of, against the step itself.

use super::State;
use crate::subject::Subject;
use popsteer_core::bounds::{MAX_DT, MAX_SPEED};
use popsteer_core::laws::{Belief, Decision};
use popsteer_core::path::Located;
use popsteer_core::path::preview::wheel_at_rest;
use popsteer_core::tracker::hold::ESTIMATION_GAP;
use popsteer_core::tracker::state::HANDOVER_TIME;
use popsteer_core::tracker::{Handover, TrackerState};
use popsteer_core::vehicle::past::MAX_POSE_AGE;
use popsteer_core::vehicle::wheels::Reached;
use popsteer_core::vehicle::{Estimate, Estimator, InFlight, Vehicle};
use popsteer_core::{Command, LateralState, PathView, Status, Tracker, VehicleState};

/// The time since the last step: that of this input and of those that were held.
fn elapsed<S>(before: &TrackerState<S>, dt: f64) -> f64 {
    (before.held_time + dt).min(MAX_DT)
}

/// What the step went by.
struct Plain {
    measured: Located,
    predicted: Located,
    decision: Decision,
    estimate: Estimate,
}

/// The step of a good input, from the state `before` it to the one `after` it.
pub(super) fn check_step<L: Subject>(
    tracker: &Tracker<L>,
    path: &PathView<'_>,
    before: &State<L>,
    after: &State<L>,
    command: &Command,
    vehicle: VehicleState,
    dt: f64,
) {
    let period = dt;
    let dt = elapsed(before, dt);
    let held = [Status::OUTLIER, Status::POSE_STALE];
    if held.iter().any(|&held| command.status.contains(held)) {
        // The gate went on with another pose; tests of the core hold which.
        return;
    }
    let vehicle = vehicle.left(-tracker.vehicle().antenna_offset(0.0));
    let plain = decide(tracker, path, before, after, vehicle, dt);
    let bits = |values: [f64; 4]| values.map(f64::to_bits);
    assert_eq!(
        bits([
            command.cross_track_error,
            command.predicted_cross_track_error,
            command.target.x,
            command.target.y,
        ]),
        bits([
            plain.measured.closest.cross_track_error(),
            plain.predicted.closest.cross_track_error(),
            plain.decision.target.x,
            plain.decision.target.y,
        ])
    );
    // The gear is the measured vehicle's, and the prediction stays on its leg.
    assert_eq!(command.reverse, plain.measured.reverse);
    assert_eq!(plain.predicted.reverse, plain.measured.reverse);
    let seen = plain.decision.status
        | Status::END_OF_PATH.when(plain.measured.past_end)
        | Status::OFF_PATH.when(plain.measured.off_path);
    let watched = Status::SATURATED
        | Status::STEER_LIMIT
        | Status::RATE_LIMIT
        | Status::LATERAL_LIMIT
        | Status::TOO_FAST
        | Status::DEVIATING
        | Status::IMPLAUSIBLE;
    assert!(command.status.contains(seen) && (seen | watched).contains(command.status));
    check_limits(tracker, (before, after), command, &plain, period);
}

/// What the law decides for the vehicle that it is shown.
fn decide<L: Subject>(
    tracker: &Tracker<L>,
    path: &PathView<'_>,
    before: &State<L>,
    after: &State<L>,
    vehicle: VehicleState,
    dt: f64,
) -> Plain {
    let (car, law) = (tracker.vehicle(), tracker.law());
    // The speed is what the signal says by its scale so far.
    let scale = before.model.estimator.estimate.speed_scale;
    let speed = (scale * vehicle.speed).clamp(-MAX_SPEED, MAX_SPEED);
    let mut gate = before.gate;
    let speed = gate
        .as_mut()
        .map_or(speed, |gate| gate.hear(car, speed, dt));
    let doubted = after.gate.as_ref().filter(|gate| gate.doubted);
    let speed = doubted.map_or(speed, |gate| gate.believed.speed);
    let vehicle = VehicleState { speed, ..vehicle };
    let mut shown = vehicle;
    let mut belief = Belief {
        wheel: before.steer,
        estimate: Estimate::DEFAULT,
    };
    let modelled = before.model.in_flight.filter(|_| is_modelled(tracker));
    if let Some(mut in_flight) = modelled {
        let now = vehicle.ahead(car.no_slip());
        let mut estimator = before.model.estimator;
        let known = estimator.estimate;
        // Its wheels lag no more than they were seen to.
        let wheeled = Vehicle {
            steer_lag: known.steer_lag(car),
            ..*car
        };
        if dt > ESTIMATION_GAP {
            estimator.last_measured = None;
            estimator.estimate.acceleration = 0.0;
        }
        let lately = Reached {
            wheels: Some(in_flight.wheel_integrals(&wheeled, before.steer, dt)),
            time: dt,
            first: in_flight.wheel(),
        };
        // What is learnt is learnt from the last measured pose on.
        let unseen = estimator.unseen.take();
        let reached = unseen.map_or(lately, |unseen| unseen.then(&lately));
        if reached.time > MAX_POSE_AGE {
            estimator.last_measured = None;
        }
        if let (Some(adapt), Some(wheels)) = (tracker.adapt(), reached.wheels) {
            let told = VehicleState {
                speed: now.speed / scale,
                ..now
            };
            estimator.observe_turn(adapt, car, told, wheels, reached.time);
            // Within a period the dead time changes by at most that period.
            let (longer, known) = (
                &mut estimator.estimate.longer_dead_time,
                before.model.estimator,
            );
            let known = known.estimate.longer_dead_time;
            *longer = longer.clamp(known - dt, known + dt);
        }
        let dead_time = estimator.estimate.dead_time(car);
        let longer = dead_time - known.dead_time(car);
        in_flight.elapse(&wheeled, before.steer, dt, longer);
        assert_eq!(Some(in_flight), after.model.in_flight);
        check_line(&in_flight, dead_time);
        belief.wheel = in_flight.wheel();
        // The slip is observed after this, and changes nothing that counts here.
        if estimator.estimate.delays(car) {
            let (predicted, wheel) =
                in_flight.predict(&wheeled, now, in_flight.wheel(), &estimator.estimate);
            shown = predicted.bounded().ahead(-car.no_slip()).bounded();
            belief.wheel = wheel;
        }
        belief.estimate = after.model.estimator.estimate;
    }
    let follow = law.follow();
    // Since the last step it may have driven faster than now.
    let faster = before.answer.map_or(0.0, |last| last.vehicle.speed.abs());
    let travelled = vehicle.speed.abs().max(faster) * dt;
    let measured = follow.find(path, &before.place, vehicle, dt, travelled);
    let predicted = if modelled.is_some() && belief.estimate.delays(car) {
        follow.offset(path, &measured, shown, travelled)
    } else {
        measured
    };
    let mut remembered = before.law.clone();
    let is_limited = car.max_steer_rate.is_some() || car.max_lateral_acceleration.is_some();
    let is_bare = !is_modelled(tracker) && !is_limited && car.steer_offset.abs().to_bits() == 0;
    if !is_bare {
        // The angle of the last command by the offset as it is known now.
        let offset = car.steer_offset + belief.estimate.steer_offset;
        remembered.set_steer(car.at_wheels(before.steer + offset));
    }
    let rests = predicted.vehicle.speed.abs() < 0.02 * car.wheelbase;
    let decision = if rests && (car.steers_at_rest || !is_bare) {
        // At rest wheels that can turn to the path's angle, and others keep theirs.
        let closest = &predicted.closest;
        let offset = car.steer_offset + belief.estimate.steer_offset;
        Decision {
            steer: if car.steers_at_rest {
                wheel_at_rest(car, path, closest.segment, closest.arc_length(path))
            } else {
                predicted.mirror(car.at_wheels(before.steer + offset))
            },
            target: closest.point,
            status: Status::OK,
        }
    } else {
        law.decide(path, &mut remembered, &predicted, &belief)
    };
    assert!(decision.steer.abs() <= car.max_steer, "{decision:?}");
    Plain {
        measured,
        predicted,
        decision,
        estimate: belief.estimate,
    }
}

/// Whether commands in flight count: a state of another vehicle may bring some along.
pub(super) fn is_modelled<L: Subject>(tracker: &Tracker<L>) -> bool {
    tracker.initial_state().model.in_flight.is_some()
}

/// Commands in flight last the dead time.
fn check_line(in_flight: &InFlight, dead_time: f64) {
    let total: f64 = in_flight.commands().map(|(_, duration)| duration).sum();
    assert!((total - dead_time).abs() <= 1e-9 * (1.0 + dead_time));
}

/// Offset, hand-over, lateral acceleration, largest angle and rate, one after the other: the command
/// changes in the present period. While inputs were missing it stood.
fn check_limits<L: Subject>(
    tracker: &Tracker<L>,
    (before, after): (&State<L>, &State<L>),
    command: &Command,
    plain: &Plain,
    period: f64,
) {
    let (car, estimate) = (tracker.vehicle(), &plain.estimate);
    let offset = car.steer_offset + estimate.steer_offset;
    let mut wanted = plain.predicted.mirror(plain.decision.steer) - offset;
    if let Some(Handover { offset, remaining }) = before.handover {
        let (difference, remaining) = match offset {
            None if remaining >= HANDOVER_TIME => (before.steer - wanted, remaining),
            None if remaining <= period => (0.0, 0.0),
            None => {
                let widest =
                    2.0 * car.max_steer + car.steer_offset.abs() + Estimator::MAX_STEER_OFFSET;
                let whole = (before.steer - wanted) * HANDOVER_TIME / remaining;
                (whole.clamp(-widest, widest), remaining - period)
            }
            Some(difference) => (difference, remaining - period),
        };
        wanted += (remaining / HANDOVER_TIME).clamp(0.0, 1.0) * difference;
    }
    let mut wheel = (wanted + offset).clamp(-car.max_steer, car.max_steer);
    if let Some(most) = car.max_lateral_acceleration {
        let speed = plain.predicted.vehicle.speed;
        let length = car.turning_length(speed);
        // By the gain that is measured: the monitor's, where nothing else is estimated.
        let gain = match &after.monitor {
            Some(monitor) if tracker.adapt().is_none() => monitor.gain.get(0),
            _ => estimate.gain,
        };
        let widest = (most * length / (speed * speed * gain)).atan();
        wheel = wheel.clamp(-widest, widest);
    }
    let mut steer = (wheel - offset).clamp(-car.max_steer, car.max_steer);
    if let Some(rate) = car.max_steer_rate {
        steer = steer.clamp(before.steer - rate * period, before.steer + rate * period);
    }
    assert!(
        (command.steer - steer).abs() <= 1e-12,
        "{command:?} {steer}"
    );
    let limited = (steer - wanted).abs();
    let said = command.status.contains(Status::SATURATED);
    assert!(said || limited <= 1.1e-12, "{command:?} {wanted}");
}
