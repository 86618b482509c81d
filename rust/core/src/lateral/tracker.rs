//! A control step whole: estimate, predict, locate, decide, limit.
//!
//! A [`Tracker`] is a law as a vehicle takes it. It shows the law the vehicle as it will be when
//! the next command reaches the wheels, keeps the commands within what the vehicle does, goes on
//! from a driver's angle without a jump, and answers every input.

use super::monitor::Monitor;
use super::reported::Reported;
use super::tracker_state::{Answer, Handover, Place, Seen, TrackerState, check_waypoint};
use super::{Belief, Command, LateralLaw, LateralState, Status, check_steer};
use crate::error::{ConfigError, InputError, Requirement, input_in_range};
use crate::geometry::Point;
use crate::limits::{MAX_COORDINATE, MAX_DT, MIN_DT};
use crate::math::{atan, saturate};
use crate::path::follow::{Follow, Located};
use crate::path::preview::Preview;
use crate::path::relocalise::relocalise;
use crate::path::stop::Ahead;
use crate::path::view::PathView;
use crate::vehicle::state::checked_dt;
use crate::vehicle::{AdaptParams, Estimate, Estimator, InFlight, Vehicle, VehicleState};

/// How long the difference to a driver's angle takes to fade [s].
pub const HANDOVER_TIME: f64 = 1.0;

/// A law, and how it adapts to its vehicle.
///
/// With a dead time the law is shown the vehicle as it will be when its command reaches the
/// wheels. Commands keep the vehicle's angle, rate and lateral acceleration. A law that starts from
/// a driver's angle, or on another path, goes on from the present angle: the difference to what the
/// law itself wants fades evenly over [`HANDOVER_TIME`]; POP, whose next angle lies in the
/// neighbourhood of the last, needs no fading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracker<L> {
    pub(super) law: L,
    adapt: Option<AdaptParams>,
    pub(super) monitor: Option<Monitor>,
    /// Whether wheels and motion of the vehicle are modelled.
    pub(super) models: bool,
    /// Whether the law's angle is the command as it is.
    bare: bool,
}

impl<L: LateralLaw> Tracker<L> {
    /// `law` with its vehicle, adapting so; not at all where that is none.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn new(law: L, adapt: Option<AdaptParams>) -> Result<Self, ConfigError> {
        let adapt = match adapt {
            Some(adapt) => Some(adapt.checked()?),
            None => None,
        };
        Ok(Self::unchecked(law, adapt))
    }

    /// `law` with its vehicle, adapting as laws of its kind do.
    pub fn of(law: L) -> Self {
        let adapt = law.default_adapt();
        Self::unchecked(law, adapt)
    }

    fn unchecked(law: L, adapt: Option<AdaptParams>) -> Self {
        let vehicle = *law.vehicle();
        let models = law.predicts() || vehicle.dead_time > 0.0 || adapt.is_some();
        let bare = !models
            && vehicle.max_steer_rate.is_none()
            && vehicle.max_lateral_acceleration.is_none()
            && vehicle.steer_offset.to_bits() == 0;
        Self {
            law,
            adapt,
            monitor: Some(Monitor::usual(&vehicle)),
            models,
            bare,
        }
    }

    /// The law.
    pub fn law(&self) -> &L {
        &self.law
    }

    /// The vehicle that is steered.
    pub fn vehicle(&self) -> &Vehicle {
        self.law.vehicle()
    }

    /// How it adapts; none where it does not.
    pub fn adapt(&self) -> Option<&AdaptParams> {
        self.adapt.as_ref()
    }

    /// Which point of the vehicle is followed along the path, and how.
    pub fn follow(&self) -> &Follow {
        self.law.follow()
    }

    /// How far ahead of the pose's point the tracked point lies [m], driving forward.
    pub fn tracked_point(&self) -> f64 {
        self.follow().base + self.follow().reference_offset
    }

    /// The same with the law made into another by `change`.
    pub fn map<M: LateralLaw>(self, change: impl FnOnce(L) -> M) -> Tracker<M> {
        let (models, bare) = (self.models, self.bare);
        Tracker {
            law: change(self.law),
            adapt: self.adapt,
            monitor: self.monitor,
            models,
            bare,
        }
    }

    /// The state before the first step, with straight wheels.
    pub fn initial_state(&self) -> TrackerState<L::State> {
        TrackerState {
            law: self.law.initial_state(),
            waypoint: None,
            measured_waypoint: None,
            place: None,
            steer: 0.0,
            handover: None,
            held: 0,
            held_time: 0.0,
            period: 0.0,
            answer: None,
            in_flight: self
                .models
                .then(|| InFlight::settled(self.law.vehicle(), 0.0)),
            past: None,
            estimator: Estimator::default(),
            monitor: None,
        }
    }

    /// The state before the first step of a vehicle that a driver leaves to the law, steering at
    /// the angle `steer` [rad].
    ///
    /// # Errors
    ///
    /// [`InputError`] where `steer` is not within `max_steer`.
    pub fn state_from(&self, steer: f64) -> Result<TrackerState<L::State>, InputError> {
        check_steer("steer", steer, self.law.vehicle().max_steer)?;
        let mut state = self.initial_state();
        state.take_over(steer);
        state.in_flight = self
            .models
            .then(|| InFlight::settled(self.law.vehicle(), steer));
        Ok(state)
    }

    /// After a jump of the vehicle, of its localisation or along the path: finds the place that
    /// the next step goes on from, by [`relocalise`](crate::path::relocalise::relocalise). The rest
    /// of `state` stays. Unlike a step it is exact wherever the vehicle is, and visits every segment
    /// at worst.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the first of them that is not finite or beyond its bound; `state` is
    /// then unchanged.
    pub fn relocalise(
        &self,
        path: &PathView<'_>,
        state: &mut TrackerState<L::State>,
        x: f64,
        y: f64,
        yaw: f64,
    ) -> Result<(), InputError> {
        let speed = 0.0;
        let vehicle = VehicleState { x, y, yaw, speed }.checked()?;
        let follow = self.follow();
        let base = vehicle.ahead(follow.base);
        let position = Point::new(base.x, base.y);
        let segment = relocalise(path, position, yaw, follow.opposite_distance);
        state.set_waypoint(segment);
        Ok(())
    }

    /// Whether `state` is one that this tracker could have on `path`.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the field that is not.
    pub fn check_state(
        &self,
        path: &PathView<'_>,
        state: &TrackerState<L::State>,
    ) -> Result<(), InputError> {
        let vehicle = self.law.vehicle();
        self.law.check_state(&state.law)?;
        check_waypoint("waypoint", path, state.waypoint)?;
        check_waypoint("measured_waypoint", path, state.measured_waypoint)?;
        check_steer("steer", state.steer, vehicle.max_steer)?;
        if let Some(Handover { offset, left }) = state.handover {
            let widest = widest_offset(vehicle);
            check_steer("handover_offset", offset.unwrap_or(0.0), widest)?;
            input_in_range("handover_left", left, 0.0, HANDOVER_TIME)?;
        }
        if let Some(place) = state.place {
            place.checked()?;
        }
        input_in_range("held_time", state.held_time, 0.0, MAX_DT)?;
        input_in_range("period", state.period, 0.0, MAX_DT)?;
        if let Some(answer) = state.answer {
            answer.measured.checked()?;
            answer.predicted.checked()?;
            let most = 4.0 * MAX_COORDINATE;
            input_in_range("answer", answer.target.x, -most, most)?;
            input_in_range("answer", answer.target.y, -most, most)?;
            answer.checked_ahead()?;
        }
        if let Some(past) = &state.past {
            past.check()?;
        }
        state.estimator.checked(vehicle)?;
        if let Some(monitor) = state.monitor {
            monitor.checked()?;
        }
        match (self.models, &state.in_flight) {
            (false, _) => Ok(()),
            (true, Some(in_flight)) => {
                in_flight.check(vehicle, state.estimator.estimate.longer_dead_time)
            }
            // With no command in flight known nothing could be predicted.
            (true, None) => Err(InputError {
                field: "commands_in_flight",
                value: 0.0,
                requirement: Requirement::CountInRange(1, InFlight::CAPACITY),
            }),
        }
    }

    /// What is known of the vehicle beyond its own figures, its gain also where it is not used.
    pub fn estimate(&self, state: &TrackerState<L::State>) -> Estimate {
        state.estimator.known()
    }

    #[inline]
    pub(super) fn advance(
        &self,
        path: &PathView<'_>,
        state: &mut TrackerState<L::State>,
        vehicle: VehicleState,
        dt: f64,
        reported: Reported,
    ) -> Result<Status, InputError> {
        let vehicle = vehicle.checked()?;
        let dt = checked_dt(dt)?;
        let reported = reported.checked(self.law.vehicle())?;
        let dt = state.elapse(dt);
        let sight = self.sight(state, vehicle, dt, reported);
        let mut belief = sight.belief;

        let follow = self.law.follow();
        let is_anew = state.waypoint.is_none();
        let at = follow.locate(path, state.waypoint, sight.seen, dt);
        state.waypoint = Some(at.foot.segment);
        let measured = if self.law.vehicle().dead_time > 0.0 {
            let measured = follow.locate(path, state.measured_waypoint, sight.here, dt);
            state.measured_waypoint = Some(measured.foot.segment);
            Some(measured)
        } else {
            // One that a state of another vehicle brought along may be none of this path.
            state.measured_waypoint = None;
            None
        };
        if let Some(adapt) = &self.adapt {
            let place = measured.as_ref().unwrap_or(&at);
            // A pose that was given before shows nothing new.
            if sight.observed >= MIN_DT {
                let since = (sight.observed, sight.travel);
                self.observe_slip(path, state, adapt, place, vehicle, since);
            }
            belief.estimate = state.estimator.estimate;
        }

        let here = measured.as_ref().unwrap_or(&at);
        let fault = self.watch(state, here, sight.here, is_anew, dt);

        if !self.bare {
            // The angle of the last command by the offset as it is known now.
            let offset = self.law.vehicle().steer_offset + belief.estimate.steer_offset;
            let last = self.law.vehicle().at_wheels(state.steer + offset);
            state.law.set_steer(last);
        }
        let decision = self.law.decide(path, &mut state.law, &at, &belief);
        let steer = at.turn(decision.steer);
        state.held = 0;
        let limited = if self.bare && state.handover.is_none() {
            state.steer = steer;
            false
        } else {
            self.limit(state, steer, at.vehicle.speed, dt, &belief.estimate)
        };
        let predicted = Seen::of(&at);
        let ahead = Ahead::of(path, follow, measured.as_ref().unwrap_or(&at));
        let answer = Answer {
            measured: measured.as_ref().map_or(predicted, Seen::of),
            predicted,
            target: decision.target,
            reverse: at.reverse,
            ahead,
            vehicle: sight.here,
        };
        state.answer = Some(answer);
        state.place = Some(Place {
            predicted: at.foot.point,
            measured: measured.as_ref().map_or(at.foot.point, |at| at.foot.point),
        });
        let status = decision.status
            | fault
            | Status::SATURATED.when(limited)
            | Status::END_OF_PATH.when(at.past_end)
            | Status::OFF_PATH.when(at.off_path);
        Ok(status)
    }

    /// The vehicle as the law is to see it, after its motion since the last step was observed and
    /// the last command took flight.
    #[inline]
    pub(super) fn predict_now(
        &self,
        state: &mut TrackerState<L::State>,
        vehicle: VehicleState,
        dt: f64,
    ) -> (VehicleState, Belief) {
        let car = self.law.vehicle();
        // Where nothing is modelled, what a state of another vehicle brings along does not count.
        let (true, Some(in_flight)) = (self.models, &mut state.in_flight) else {
            let belief = Belief {
                wheel: state.steer,
                estimate: Estimate::DEFAULT,
            };
            return (vehicle, belief);
        };
        let estimator = &mut state.estimator;
        let now = vehicle.ahead(car.no_slip());
        let before = estimator.estimate.longer_dead_time;
        if let Some(adapt) = &self.adapt {
            let reached = in_flight.reaching(car, state.steer, dt);
            estimator.observe_turn(adapt, car, now, reached, dt);
        }
        let estimate = estimator.estimate;
        in_flight.elapse(car, state.steer, dt, estimate.longer_dead_time - before);
        if car.dead_time > 0.0 {
            let (predicted, wheel) = in_flight.predict(car, now, &estimate);
            // What was given is good, so what comes of it is not refused.
            let seen = predicted.bounded().ahead(-car.no_slip()).bounded();
            (seen, Belief { wheel, estimate })
        } else {
            let wheel = in_flight.wheel();
            (vehicle, Belief { wheel, estimate })
        }
    }

    /// Observes the slip of a vehicle that is at `here`, and was seen at `vehicle` so long [s] after
    /// the last time, and since then has come so far [m]. Nothing is learnt across a change of the
    /// direction.
    #[inline]
    fn observe_slip(
        &self,
        path: &PathView<'_>,
        state: &mut TrackerState<L::State>,
        adapt: &AdaptParams,
        here: &Located,
        vehicle: VehicleState,
        (dt, since): (f64, f64),
    ) {
        let car = self.law.vehicle();
        let now = vehicle.ahead(car.no_slip());
        if here.turned || here.vehicle.speed <= 0.0 {
            state.estimator.seen = Some(now);
            return;
        }
        let curvature = |travel: f64| {
            let travel = travel.abs();
            let mut turn = [0.0];
            // The tracked point lies ahead of the one that slips by about this much.
            let start = here.foot.arc_length(path) - self.follow().reference_offset - travel;
            let start = start - since.abs();
            let smoothing = 2.0 / 3.0 * car.wheelbase;
            Preview::new(path, smoothing, here.foot.segment, start, travel)
                .turns(start, travel, &mut turn);
            let [turn] = turn;
            here.turn(turn / travel)
        };
        state.estimator.observe_slip(adapt, car, now, curvature, dt);
        state.estimator.seen = Some(now);
    }

    /// Commands the angle `wanted` of the wheels [rad] as far as the vehicle allows, and tells
    /// whether it had to be limited.
    fn limit(
        &self,
        state: &mut TrackerState<L::State>,
        wanted: f64,
        speed: f64,
        dt: f64,
        estimate: &Estimate,
    ) -> bool {
        let car = self.law.vehicle();
        let offset = car.steer_offset + estimate.steer_offset;
        let widest = widest_offset(car);
        let wanted = fade(
            &mut state.handover,
            state.steer,
            wanted - offset,
            dt,
            widest,
        );
        let wheel = car.at_wheels(wanted + offset);
        let wheel = car.limit_lateral_acceleration(wheel, speed, estimate.gain);
        let command = saturate(wheel - offset, -car.max_steer, car.max_steer);
        let steer = match car.max_steer_rate {
            None => command,
            Some(rate) => saturate(command, state.steer - rate * dt, state.steer + rate * dt),
        };
        state.steer = steer;
        state.law.set_steer(car.at_wheels(steer + offset));
        // The offset is put off and on again, which rounds.
        (steer - wanted).abs() > 1e-12
    }
}

/// The command of a hand-over: the difference to the last one, at most `widest` [rad], fades.
fn fade(handover: &mut Option<Handover>, last: f64, wanted: f64, dt: f64, widest: f64) -> f64 {
    let Some(fading) = handover else {
        return wanted;
    };
    let before = fading.left;
    let offset = match fading.offset {
        None if before >= HANDOVER_TIME => last - wanted,
        None => {
            // The path changed again on the way: the difference fades in the time that is left.
            fading.left -= dt;
            let share = before / HANDOVER_TIME;
            if fading.left > 0.0 {
                saturate((last - wanted) / share, -widest, widest)
            } else {
                0.0
            }
        }
        Some(offset) => {
            fading.left -= dt;
            offset
        }
    };
    fading.offset = Some(offset);
    let share = saturate(fading.left / HANDOVER_TIME, 0.0, 1.0);
    if fading.left <= 0.0 {
        *handover = None;
    }
    wanted + share * offset
}

/// The widest offset of a hand-over: from one end of the wheels to the other [rad].
fn widest_offset(vehicle: &Vehicle) -> f64 {
    let offsets = vehicle.steer_offset.abs() + Estimator::MAX_STEER_OFFSET;
    2.0 * vehicle.max_steer + offsets
}

impl Vehicle {
    /// An angle that the wheels can stand at [rad].
    #[inline]
    pub fn at_wheels(&self, angle: f64) -> f64 {
        saturate(angle, -self.max_steer, self.max_steer)
    }

    /// The angle `wheel` [rad], brought within `max_lateral_acceleration` at `speed` [m/s] for a
    /// vehicle that turns `gain` times more than its figures say.
    #[inline]
    fn limit_lateral_acceleration(&self, wheel: f64, speed: f64, gain: f64) -> f64 {
        let Some(most) = self.max_lateral_acceleration else {
            return wheel;
        };
        let (square, length) = (speed * speed * gain, self.turning_length(speed));
        // tan(x) < x + x^3 up to 1.1, by more than rounds: within the limit no arc is needed.
        let tangent = wheel.abs() * (1.0 + 1e-9 + wheel * wheel);
        if wheel.abs() < 1.1 && tangent * square <= most * length {
            return wheel;
        }
        let widest = atan(most * length / square);
        saturate(wheel, -widest, widest)
    }
}

#[inline]
pub(super) fn command<S>(state: &TrackerState<S>, status: Status) -> Command {
    let answer = state.answer.as_ref().unwrap_or(&Answer::NOWHERE);
    let (measured, predicted) = (&answer.measured, &answer.predicted);
    let heading_error = measured.heading_error();
    Command {
        steer: state.steer,
        cross_track_error: measured.cross_track_error,
        heading_error,
        predicted_cross_track_error: predicted.cross_track_error,
        predicted_heading_error: if predicted.heads_as(measured) {
            heading_error
        } else {
            predicted.heading_error()
        },
        target: answer.target,
        reverse: answer.reverse,
        reference_speed: answer.ahead.reference_speed,
        distance_to_stop: answer.ahead.distance_to_stop,
        status,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

        #[test]
        fn test_lateral_limit_without_the_arc_is_that_of_the_arc(
            wheel in prop_oneof![-1.57..1.57, -1e-7..1e-7, Just(0.0)],
            near in prop_oneof![Just(0.0), -3e-16..3e-16, -2e-9..2e-9, -0.1..0.1],
            at_limit: bool,
            speed in prop_oneof![Just(0.0), -40.0..40.0, -1e4..1e4],
            gain in 0.4..2.5,
            most in prop_oneof![Just(4.0), (-3.0..6.0).prop_map(|e| f64::powf(10.0, e))],
            understeer in prop_oneof![Just(0.0), 0.0..0.01],
        ) {
            let vehicle = Vehicle {
                understeer,
                max_lateral_acceleration: Some(most),
                ..Vehicle::DEFAULT
            };
            let widest = atan(most * vehicle.turning_length(speed) / (speed * speed * gain));
            let wheel = if at_limit {
                (widest * (1.0 + near)).copysign(wheel)
            } else {
                wheel
            };
            let limited = vehicle.limit_lateral_acceleration(wheel, speed, gain);
            prop_assert_eq!(limited.to_bits(), saturate(wheel, -widest, widest).to_bits());
        }
    }
}
