//! A whole control step: estimate, predict, locate, decide, limit.
//!
//! A [`Tracker`] runs a controller on a vehicle. It predicts the vehicle to the time when the next
//! command reaches the wheels, keeps the commands within the vehicle's limits, takes over from a
//! driver without a jump of the angle, and never fails.

use crate::bounds::MAX_DT;
use crate::error::{ConfigError, InputError, input_in_range};
use crate::geometry::Point;
use crate::laws::law::check_steer;
use crate::laws::{Belief, Decision, LateralLaw, LateralState};
use crate::path::follow::{Follow, Located};
use crate::path::place::{Place, Spot};
use crate::path::preview::wheel_at_rest;
use crate::path::projection::ClosestPoint;
use crate::path::relocalise::relocalise;
use crate::path::stop::Ahead;
use crate::path::view::PathView;
use crate::status::Status;
use crate::tracker::command::Command;
use crate::tracker::monitor::{Monitor, MonitorParams, MonitorState};
use crate::tracker::reported::Reported;
use crate::tracker::seen::Seen;
use crate::tracker::state::{
    Answer, Deviation, HANDOVER_TIME, Handover, Model, TrackerState, Tracking, widest_offset,
};
use crate::vehicle::gate::Gate;
use crate::vehicle::past::Past;
use crate::vehicle::state::{check_count, period};
use crate::vehicle::{AdaptParams, Estimate, InFlight, Vehicle, VehicleState};

/// At rest: slower than this, in wheelbases a second. Larger: a creeping vehicle is not steered;
/// smaller: noise of the speed turns the wheels of a standing one.
const AT_REST: f64 = 0.02;

/// A controller, and how it adapts to its vehicle.
///
/// With a dead time the controller gets the vehicle as predicted for the time when its command
/// reaches the wheels. Commands keep the vehicle's limits of angle, rate and lateral acceleration.
/// After a driver, or on another path, the command continues from the present angle: its difference
/// to the controller's own angle fades linearly over [`HANDOVER_TIME`]; POP, whose next angle lies
/// in the neighbourhood of the last, needs no fading.
#[expect(clippy::struct_excessive_bools, reason = "each is asked for by itself")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracker<L> {
    pub(super) law: L,
    adapt: Option<AdaptParams>,
    /// Whether that is by default.
    usual: bool,
    pub(super) monitor: Option<Monitor>,
    /// Whether wheels and motion of the vehicle are modelled.
    pub(super) models: bool,
    /// Whether the controller's angle is the command as it is.
    pub(super) bare: bool,
    /// Whether the direction of driving changes where `place` is moved on behind a cusp, and not where the
    /// rear axle arrives there.
    pub(super) parks: bool,
}

impl<L: LateralLaw> Tracker<L> {
    /// A tracker of `law` that adapts as given; not at all if none.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn new(law: L, adapt: Option<AdaptParams>) -> Result<Self, ConfigError> {
        let adapt = adapt.map(AdaptParams::checked).transpose()?;
        Ok(Self::unchecked(law, adapt, false))
    }

    /// A tracker of `law` that adapts by default: only if estimates are used, which is in
    /// controllers that predict, for vehicles with a dead time, and in a [`Driver`](crate::Driver).
    pub fn of(law: L) -> Self {
        let used = law.reads_belief() || law.vehicle().dead_time > 0.0;
        Self::unchecked(law, used.then_some(AdaptParams::DEFAULT), true)
    }

    fn unchecked(law: L, adapt: Option<AdaptParams>, usual: bool) -> Self {
        let vehicle = *law.vehicle();
        let models = law.reads_belief() || vehicle.dead_time > 0.0 || adapt.is_some();
        let bare = !models
            && vehicle.max_steer_rate.is_none()
            && vehicle.max_lateral_acceleration.is_none()
            && vehicle.steer_offset.abs().to_bits() == 0;
        Self {
            law,
            adapt,
            usual,
            monitor: Some(Monitor::new(MonitorParams::DEFAULT, &vehicle)),
            models,
            bare,
            parks: false,
        }
    }

    /// The same tracker in a driver: its place is moved on behind a cusp by the law of the speed, which
    /// reads its estimates.
    pub(crate) fn driving(self) -> Self {
        let monitor = self.monitor;
        let tracker = if self.usual {
            Self::unchecked(self.law, Some(AdaptParams::DEFAULT), true)
        } else {
            self
        };
        Self {
            monitor,
            parks: true,
            ..tracker
        }
    }

    /// The controller.
    pub fn law(&self) -> &L {
        &self.law
    }

    /// The vehicle that is steered.
    pub fn vehicle(&self) -> &Vehicle {
        self.law.vehicle()
    }

    /// How it adapts; None if it does not.
    pub fn adapt(&self) -> Option<&AdaptParams> {
        self.adapt.as_ref()
    }

    /// Which point of the vehicle is tracked, and how it is searched for on the path.
    pub fn follow(&self) -> &Follow {
        self.law.follow()
    }

    /// How far ahead of the pose's point the tracked point lies [m], driving forward.
    pub fn tracked_point(&self) -> f64 {
        self.follow().base + self.follow().reference_offset
    }

    /// The same with the controller made into another by `change`.
    pub fn map<M: LateralLaw>(self, change: impl FnOnce(L) -> M) -> Tracker<M> {
        Tracker {
            law: change(self.law),
            adapt: self.adapt,
            usual: self.usual,
            monitor: self.monitor,
            models: self.models,
            bare: self.bare,
            parks: self.parks,
        }
    }

    /// The state before the first step, with straight wheels.
    pub fn initial_state(&self) -> TrackerState<L::State> {
        let tracking = Tracking {
            law: self.law.initial_state(),
            place: Place::Unknown,
            steer: 0.0,
            handover: None,
            held: 0,
            held_time: 0.0,
            period: 0.0,
            answer: None,
            monitor: None,
            gate: None,
        };
        let model = self.model_at(0.0);
        TrackerState { tracking, model }
    }

    /// What is remembered of the vehicle before the first step, with its wheels at the angle `steer`.
    fn model_at(&self, steer: f64) -> Model {
        let settled = || InFlight::settled(self.law.vehicle(), steer);
        Model {
            in_flight: self.models.then(settled),
            ..Model::default()
        }
    }

    /// The state before the first step of a vehicle that a driver leaves to the controller,
    /// steering at the angle `steer` [rad].
    ///
    /// # Errors
    ///
    /// [`InputError`] where `steer` is not within `max_steer`.
    pub fn state_from(&self, steer: f64) -> Result<TrackerState<L::State>, InputError> {
        check_steer("steer", steer, self.law.vehicle().max_steer)?;
        let mut state = self.initial_state();
        state.steer = steer;
        state.hand_over();
        state.model = self.model_at(steer);
        Ok(state)
    }

    /// After a jump of the vehicle or of its localisation: finds the place that the next step
    /// starts from, by [`relocalise`]. The rest of `state`
    /// stays. Unlike a step it is exact everywhere, and visits every segment at worst.
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
        let point = ClosestPoint::new(path, segment, position).point;
        state.jump_to(Place::Lost(Spot { segment, point }));
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
        state.place.checked(path)?;
        check_steer("steer", state.steer, vehicle.max_steer)?;
        if let Some(Handover { offset, remaining }) = state.handover {
            let widest = widest_offset(vehicle);
            check_steer("handover.offset", offset.unwrap_or(0.0), widest)?;
            input_in_range("handover.remaining", remaining, 0.0, HANDOVER_TIME)?;
        }
        input_in_range("held_time", state.held_time, 0.0, MAX_DT)?;
        input_in_range("period", state.period, 0.0, MAX_DT)?;
        state.answer.map(Answer::checked).transpose()?;
        let model = &state.model;
        model.past.as_ref().map(Past::check).transpose()?;
        model.estimator.checked(vehicle)?;
        state.monitor.map(MonitorState::checked).transpose()?;
        state.gate.map(Gate::checked).transpose()?;
        match (self.models, &model.in_flight) {
            (false, _) => Ok(()),
            (true, Some(in_flight)) => in_flight.check(model.estimator.estimate.dead_time(vehicle)),
            // Without a command in flight nothing could be predicted.
            (true, None) => check_count("in_flight.commands", 0, 1, InFlight::CAPACITY),
        }
    }

    /// The present estimates.
    pub fn estimate(&self, state: &TrackerState<L::State>) -> Estimate {
        state.model.estimator.estimate
    }

    /// One control step: `vehicle` is the pose of the vehicle's point and the speed, measured
    /// `dt` [s] after those of the last step; `reported` is what the vehicle reports besides,
    /// [`Reported::NOTHING`] if nothing.
    ///
    /// A `dt` outside [`MIN_DT`](crate::bounds::MIN_DT) to [`MAX_DT`], of a clock that was set or repeats
    /// a stamp, is no time: the last command is held, as in [`step_or_hold`](Self::step_or_hold) with
    /// [`HOLD_LIMIT`](crate::status::HOLD_LIMIT).
    ///
    /// # Errors
    ///
    /// [`InputError`] where a number in `vehicle` or `reported` is not finite or beyond its bound, or
    /// `dt` is not finite; `state` is then unchanged.
    #[inline]
    pub fn step(
        &self,
        path: &PathView<'_>,
        state: &mut TrackerState<L::State>,
        vehicle: VehicleState,
        dt: f64,
        reported: Reported,
    ) -> Result<Command, InputError> {
        let TrackerState { tracking, model } = state;
        let status = self.advance(path, tracking, model, vehicle, dt, reported)?;
        Ok(tracking.command(status))
    }

    /// The angle of [`step`](Self::step) alone [rad]; same state afterwards.
    ///
    /// # Errors
    ///
    /// As [`step`](Self::step).
    #[inline]
    pub fn steer(
        &self,
        path: &PathView<'_>,
        state: &mut TrackerState<L::State>,
        vehicle: VehicleState,
        dt: f64,
        reported: Reported,
    ) -> Result<f64, InputError> {
        let TrackerState { tracking, model } = state;
        self.advance(path, tracking, model, vehicle, dt, reported)?;
        Ok(tracking.steer)
    }

    /// [`step`](Self::step) on the two parts of a state: its command is [`Tracking::command`] with the
    /// status returned. For those that keep many states, and no model where a vehicle has none.
    ///
    /// # Errors
    ///
    /// As [`step`](Self::step).
    #[inline]
    pub fn advance(
        &self,
        path: &PathView<'_>,
        state: &mut Tracking<L::State>,
        model: &mut Model,
        vehicle: VehicleState,
        dt: f64,
        reported: Reported,
    ) -> Result<Status, InputError> {
        let antenna = vehicle.checked()?;
        let car = self.law.vehicle();
        let reported = reported.checked(car)?;
        let Some(dt) = period(dt)? else {
            return Ok(state.hold(dt));
        };
        let vehicle = antenna.left(-car.antenna_offset(reported.roll));
        let seen = self.see(path, state, model, vehicle, dt, (reported, true, |_| None));
        Ok(self.turn(path, state, &seen, false))
    }

    /// The second half of a step: which angle the controller wants for what was `seen`, and how much of
    /// it the vehicle allows. `straight`: straight wheels are wanted instead.
    #[inline]
    pub(crate) fn turn(
        &self,
        path: &PathView<'_>,
        state: &mut Tracking<L::State>,
        seen: &Seen,
        straight: bool,
    ) -> Status {
        let at = seen.at();
        let decision = if straight {
            Decision {
                steer: 0.0,
                target: at.closest.point,
                status: Status::OK,
            }
        } else {
            self.decide(path, state, at, &seen.belief)
        };
        let limited = self.command(state, at, decision.steer, seen) | self.join(at);
        let ahead = Ahead::of(path, self.law.follow(), &seen.located);
        state.remember(at, &seen.located, decision.target, ahead, seen.here);
        decision.status | limited | seen.status
    }

    /// Whether a path is joined faster than wheels of this rate can end the turn.
    ///
    /// At their rate the yaw is a double integrator, `yaw'' = speed rate / length`. The controller turns
    /// the wheels back on the line `yaw = -length / (gain speed) yaw'`; in time is the parabola
    /// `yaw = yaw'^2 length / (2 speed rate)` (M. Athans and P. Falb, *Optimal Control*, 1966, section
    /// 7.2). Beyond where they meet, `gain yaw = 2 rate length / (gain speed)`, it overshoots its path,
    /// and the farther the more, up to a limit cycle.
    #[inline]
    fn join(&self, at: &Located) -> Status {
        let car = self.law.vehicle();
        let Some(rate) = car.max_steer_rate else {
            return Status::OK;
        };
        let speed = at.vehicle.forward_speed();
        let most = 2.0 * rate * car.turning_length(speed);
        Status::TOO_FAST.when(self.law.pull(at).abs() * speed > most)
    }

    /// Commands the angle `steer` [rad] of the mirrored vehicle as far as the vehicle allows; says what
    /// limited it.
    #[inline]
    fn command(
        &self,
        state: &mut Tracking<L::State>,
        at: &Located,
        steer: f64,
        seen: &Seen,
    ) -> Status {
        let steer = at.mirror(steer);
        state.held = 0;
        if self.bare && state.handover.is_none() {
            state.steer = steer;
            // At rest the controller has not decided.
            state.law.set_steer(steer);
            return Status::OK;
        }
        // While inputs were missing the command stood: their time is none to turn the wheels in.
        let estimate = &seen.belief.estimate;
        self.limit(state, steer, at.vehicle.speed, seen.period, estimate)
    }

    /// What the law decides, which starts from the angle of the wheels. For a vehicle at rest it is
    /// not asked, where [`rest`](Self::rest) has an answer.
    #[inline]
    fn decide(
        &self,
        path: &PathView<'_>,
        state: &mut Tracking<L::State>,
        at: &Located,
        belief: &Belief,
    ) -> Decision {
        if !self.bare {
            // The angle of the last command, with the present estimate of the offset.
            let offset = self.law.vehicle().steer_offset + belief.estimate.steer_offset;
            let wheel = self.law.vehicle().at_wheels(state.steer + offset);
            state.law.set_steer(wheel);
        }
        if at.vehicle.speed.abs() < AT_REST * self.law.vehicle().wheelbase
            && let Some(rest) = self.rest(path, state.steer, at, &belief.estimate)
        {
            if at.direction_changed || at.off_path {
                state.law.leave_path();
            }
            state.law.interrupt();
            rest
        } else {
            self.law.decide(path, &mut state.law, at, belief)
        }
    }

    /// The same tracker with these thresholds of its monitor; without a monitor if none.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn monitored(mut self, params: Option<MonitorParams>) -> Result<Self, ConfigError> {
        let params = params.map(MonitorParams::checked).transpose()?;
        self.monitor = params.map(|params| Monitor::new(params, self.law.vehicle()));
        Ok(self)
    }

    /// The thresholds of its monitor; None without a monitor.
    pub fn monitor(&self) -> Option<&MonitorParams> {
        self.monitor.as_ref().map(Monitor::params)
    }

    /// The angle of a vehicle that stands, or will when the command reaches the wheels. Wheels that
    /// turn at rest have the angle for the path just ahead; others keep theirs, since no error
    /// changes, however long it is looked at. None where the controller's angle is the command.
    #[inline]
    fn rest(
        &self,
        path: &PathView<'_>,
        steer: f64,
        at: &Located,
        estimate: &Estimate,
    ) -> Option<Decision> {
        let car = self.law.vehicle();
        let steer = if car.steers_at_rest {
            wheel_at_rest(car, path, at.closest.segment, at.closest.arc_length(path))
        } else if self.bare {
            return None;
        } else {
            let offset = car.steer_offset + estimate.steer_offset;
            at.mirror(car.at_wheels(steer + offset))
        };
        Some(Decision {
            steer,
            target: at.closest.point,
            status: Status::OK,
        })
    }
}

impl<S> Tracking<S> {
    /// Keeps what the step found: the vehicle as `predicted`, and as measured, `here`, at the pose
    /// `vehicle`.
    #[inline]
    fn remember(
        &mut self,
        predicted: &Located,
        here: &Located,
        target: Point,
        ahead: Ahead,
        vehicle: VehicleState,
    ) {
        self.answer = Some(Answer {
            measured: Deviation::of(here),
            predicted: Deviation::of(predicted),
            target,
            reverse: predicted.reverse,
            ahead,
            vehicle,
        });
        self.place = Place::of(here);
    }
}
