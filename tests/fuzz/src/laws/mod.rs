//! Whole lives of a controller of any vehicle: steps, hand-overs, resets, jumps, other paths, states
//! saved and restored, and bad input at any point.

mod draw;
mod plain;
mod reported;

use crate::backwards::check_backwards;
use crate::bytes::Bytes;
use crate::scene::{Waypoints, adapt, car, dt, vehicle};
use crate::subject::Subject;
use popsteer_core::bounds::MAX_DT;
use popsteer_core::error::Requirement;
use popsteer_core::laws::{Pid, Pop, PreviewPop, PurePursuit, Stanley};
use popsteer_core::path::{Place, Spot};
use popsteer_core::status::HOLD_LIMIT;
use popsteer_core::tracker::TrackerState;
use popsteer_core::tracker::state::HANDOVER_TIME;
use popsteer_core::vehicle::Estimate;
use popsteer_core::vehicle::bicycle::kinematic_bicycle;
use popsteer_core::vehicle::state::checked_dt;
use popsteer_core::{
    Command, ConfigError, LateralLaw, Path, Reported, Status, Tracker, Vehicle, VehicleState,
};
use std::f64::consts::PI;

/// One life of one controller.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    match bytes.below(6) {
        0 => live::<Pop>(&mut bytes),
        1 => live::<PurePursuit>(&mut bytes),
        2 => live::<Stanley>(&mut bytes),
        3 => live::<Pid>(&mut bytes),
        // Two shares of six: it has the most branches.
        _ => live::<PreviewPop>(&mut bytes),
    }
}

/// A refused parameter is named with its value, which does break the requirement.
fn check_refusal(error: &ConfigError) {
    assert!(!error.field.is_empty() && !error.to_string().is_empty());
    if let Requirement::InRange(low, high) = error.requirement {
        assert!(!(low..=high).contains(&error.value));
    }
}

/// What the law itself makes of it, told how to adapt, or told not to.
fn tracker<L: Subject>(bytes: &mut Bytes, law: L) -> Result<Tracker<L>, ConfigError> {
    match bytes.byte() {
        0..=127 => Ok(Tracker::of(law)),
        128..=169 => Tracker::new(law, None),
        _ => Tracker::new(law, Some(adapt(bytes))),
    }
}

fn live<L: Subject>(bytes: &mut Bytes) {
    let (car, params) = (car(bytes), L::draw(bytes));
    let law = match L::make(&car, params) {
        Ok(law) => law,
        Err(error) => return check_refusal(&error),
    };
    let tracker = match tracker(bytes, law) {
        Ok(tracker) => tracker,
        Err(error) => return check_refusal(&error),
    };
    let Ok(path) = Waypoints::draw(bytes).path() else {
        return;
    };
    if bytes.byte() < 40 && path.view().reverse().is_none() {
        return check_backwards::<L>(&car, params, &path, bytes);
    }
    let mut life = Life::new(tracker, path);
    for _ in 0..12 {
        if bytes.is_empty() {
            break;
        }
        life.go_on(bytes);
    }
}

type State<L> = TrackerState<<L as LateralLaw>::State>;

/// Whether two states are one, however they keep the commands in flight.
fn same<L: Subject>(a: &State<L>, b: &State<L>) -> bool {
    L::same(&a.law, &b.law)
        && a.steer.to_bits() == b.steer.to_bits()
        && (a.handover, a.held) == (b.handover, b.held)
        && (a.held_time, a.period, a.place) == (b.held_time, b.period, b.place)
        && (a.answer, a.model.estimator) == (b.answer, b.model.estimator)
        && a.monitor == b.monitor
        && (a.model.in_flight, a.model.past) == (b.model.in_flight, b.model.past)
}

/// A controller at work, with two states: one is stepped, the other steered, and they stay one.
struct Life<L: Subject> {
    tracker: Tracker<L>,
    car: Vehicle,
    path: Path,
    state: State<L>,
    twin: State<L>,
    saved: Option<State<L>>,
    vehicle: VehicleState,
}

impl<L: Subject> Life<L> {
    fn new(tracker: Tracker<L>, path: Path) -> Self {
        let state = tracker.initial_state();
        let (x, y) = (path.view().x()[0], path.view().y()[0]);
        Self {
            twin: state.clone(),
            state,
            car: *tracker.vehicle(),
            tracker,
            path,
            saved: None,
            vehicle: VehicleState {
                x,
                y,
                yaw: 0.1,
                speed: 8.0,
            },
        }
    }

    fn go_on(&mut self, bytes: &mut Bytes) {
        match bytes.byte() {
            0..=79 => {
                let steer = self.state.steer;
                self.vehicle =
                    kinematic_bicycle(self.vehicle, steer, bytes.within(-3.0, 3.0), 3.0, 0.05);
                self.step(self.vehicle, 0.05);
            }
            80..=129 => {
                let vehicle = vehicle(bytes, &self.path.view());
                let refused = self.step(vehicle, dt(bytes));
                if !refused {
                    self.vehicle = vehicle;
                }
            }
            130..=149 => self.step_reported(bytes),
            150..=174 => {
                let vehicle = vehicle(bytes, &self.path.view());
                self.step_or_hold(vehicle, dt(bytes), bytes.below(3));
            }
            175..=189 => self.reset(bytes),
            190..=204 => self.relocalise(bytes),
            205..=219 => self.set_path(bytes),
            220..=229 => self.saved = Some(self.state.clone()),
            230..=239 => {
                if let Some(saved) = self.saved.take() {
                    self.restore(saved);
                }
            }
            _ => {
                if let Some(state) = self.draw_state(bytes) {
                    self.restore(state);
                }
            }
        }
        assert!(same::<L>(&self.state, &self.twin));
    }

    fn put(&mut self, state: State<L>) {
        self.twin = state.clone();
        self.state = state;
    }

    /// Steps the state and steers its twin; whether both refused.
    fn step(&mut self, vehicle: VehicleState, dt: f64) -> bool {
        let path = self.path.view();
        let good = vehicle.checked().is_ok() && dt.is_finite();
        let before = self.state.clone();
        let stepped = self
            .tracker
            .step(&path, &mut self.state, vehicle, dt, Reported::NOTHING);
        assert_eq!(stepped.is_ok(), good, "{stepped:?}");
        let steered = self
            .tracker
            .steer(&path, &mut self.twin, vehicle, dt, Reported::NOTHING);
        match (stepped, steered) {
            (Ok(command), Ok(steer)) => {
                assert_eq!(command.steer.to_bits(), steer.to_bits());
                if checked_dt(dt).is_err() {
                    assert!(same::<L>(&self.state, &self.twin));
                    self.check_held(before, &command, dt, HOLD_LIMIT);
                    return false;
                }
                self.check_command(&command);
                self.check_limits(&before, &command, dt);
                // Where a pose was old once, the commands since are kept, and timed, apart.
                if before.model.past.is_none() {
                    plain::check_step(
                        &self.tracker,
                        &path,
                        &before,
                        &self.state,
                        &command,
                        vehicle,
                        dt,
                    );
                }
                assert_eq!(self.tracker.check_state(&path, &self.state), Ok(()));
                false
            }
            (Err(stepped), Err(steered)) => {
                assert!(same::<L>(&self.state, &before));
                // Written out, as a NaN in it is not equal to itself.
                assert_eq!(stepped.to_string(), steered.to_string());
                true
            }
            mixed => panic!("step and steer disagree: {mixed:?}"),
        }
    }

    fn check_command(&self, command: &Command) {
        assert!(command.steer.abs() <= self.car.max_steer);
        for (error, yaw) in [
            (command.cross_track_error, command.heading_error),
            (
                command.predicted_cross_track_error,
                command.predicted_heading_error,
            ),
        ] {
            assert!(error.is_finite() && yaw.abs() <= PI, "{command:?}");
        }
        assert!(command.target.x.is_finite() && command.target.y.is_finite());
        assert!(command.reference_speed.is_none_or(f64::is_finite));
        assert!(command.distance_to_stop > f64::NEG_INFINITY);
        assert!(!command.status.contains(Status::INPUT_LOST));
        assert!(!command.status.contains(Status::INPUT_HELD));
        assert_eq!(
            Status::from_bits(command.status.bits()),
            Some(command.status)
        );
        assert_eq!(self.state.steer.to_bits(), command.steer.to_bits());
        assert_eq!(self.state.held, 0);
        let view = self.path.view();
        let Place::Known(spot) = self.state.place else {
            panic!("the vehicle was found");
        };
        assert!(spot.segment < view.segments());
        assert_eq!(command.reverse, view.is_reverse(spot.segment));
        let estimate = if plain::is_modelled(&self.tracker) {
            self.tracker.estimate(&self.state)
        } else {
            Estimate::DEFAULT
        };
        if let Some(steer) = L::previous_steer(&self.state.law) {
            // What the wheels are given, whatever was wanted.
            let offset = self.car.steer_offset + estimate.steer_offset;
            let wheel = self.car.at_wheels(command.steer + offset);
            assert!((steer - wheel).abs() <= 0.0, "{steer} {wheel}");
        }
    }

    /// The rate is kept whatever is wanted, and however long the command stood before.
    fn check_limits(&self, before: &State<L>, command: &Command, dt: f64) {
        let most = self.car.max_steer_rate.unwrap_or(f64::INFINITY) * dt;
        assert!((command.steer - before.steer).abs() <= most + 1e-12);
    }

    /// An answer to anything: that of the step where there is one, else the one that is held.
    fn step_or_hold(&mut self, vehicle: VehicleState, dt: f64, hold_limit: usize) {
        let path = self.path.view();
        let before = self.state.clone();
        let tracker = &self.tracker;
        let command = tracker.step_or_hold(
            &path,
            &mut self.state,
            vehicle,
            dt,
            hold_limit,
            Reported::NOTHING,
        );
        let stepped = tracker.step(&path, &mut self.twin, vehicle, dt, Reported::NOTHING);
        match stepped {
            Ok(stepped) if checked_dt(dt).is_ok() => assert_eq!(command, stepped),
            _ => self.check_held(before, &command, dt, hold_limit),
        }
    }

    /// The last command once more, after the state `before`.
    fn check_held(&mut self, before: State<L>, command: &Command, dt: f64, hold_limit: usize) {
        let held = before.held.saturating_add(1);
        let lost = held > hold_limit;
        let status = if lost {
            Status::INPUT_LOST
        } else {
            Status::INPUT_HELD
        };
        assert_eq!(command.status, status);
        assert_eq!(command.status.faults() != Status::OK, lost);
        assert_eq!(command.steer.to_bits(), before.steer.to_bits());
        assert!(command.heading_error.abs() <= PI && command.predicted_heading_error.abs() <= PI);
        if let Some(answer) = before.answer {
            let errors = [answer.measured, answer.predicted].map(|seen| seen.cross_track_error);
            let given = [
                command.cross_track_error,
                command.predicted_cross_track_error,
            ];
            assert_eq!(given.map(f64::to_bits), errors.map(f64::to_bits));
            assert_eq!(
                (command.target, command.reverse),
                (answer.target, answer.reverse)
            );
        }
        // The time is kept for the next step, and nothing else changes.
        let dt = checked_dt(dt).unwrap_or(0.0);
        let held_time = (before.held_time + dt).min(MAX_DT);
        let mut wanted = before;
        (wanted.held, wanted.held_time) = (held, held_time);
        assert!(same::<L>(&self.state, &wanted));
        self.put(wanted);
    }

    /// From nothing, or from a driver's angle.
    fn reset(&mut self, bytes: &mut Bytes) {
        if bytes.byte() < 100 {
            return self.put(self.tracker.initial_state());
        }
        let most = self.car.max_steer;
        let steer = bytes.number([-0.5, 0.5], [-most, most]);
        let answer = self.tracker.state_from(steer);
        assert_eq!(answer.is_ok(), steer.abs() <= most);
        if let Ok(state) = answer {
            assert_eq!(state.steer.to_bits(), steer.to_bits());
            assert_eq!(self.tracker.check_state(&self.path.view(), &state), Ok(()));
            self.put(state);
        }
    }

    fn relocalise(&mut self, bytes: &mut Bytes) {
        if bytes.byte() < 50 {
            // Whatever is put there, the next step finds a place on the path.
            let place = draw::draw_place(bytes);
            // One that is no number is not even equal to itself.
            let is_number = |spot: Spot| !(spot.point.x.is_nan() || spot.point.y.is_nan());
            self.state.place = match place.spot() {
                Some(spot) if !is_number(spot) => Place::Unknown,
                _ => place,
            };
            self.twin.place = self.state.place;
            return;
        }
        let VehicleState { x, y, yaw, .. } = vehicle(bytes, &self.path.view());
        let path = self.path.view();
        let done = self.tracker.relocalise(&path, &mut self.state, x, y, yaw);
        let speed = 0.0;
        let good = VehicleState { x, y, yaw, speed }.checked().is_ok();
        assert_eq!(done.is_ok(), good);
        if done.is_err() {
            assert!(same::<L>(&self.state, &self.twin));
        } else {
            let segment = self.state.place.segment();
            assert!(segment.expect("the vehicle was found") < path.segments());
            assert_eq!(self.state.model.estimator.last_measured, None);
            self.put(self.state.clone());
        }
    }

    /// Another path, mostly with the controller told of it: the same, what is ahead of it, or any.
    fn set_path(&mut self, bytes: &mut Bytes) {
        let kind = bytes.byte();
        let path = match kind {
            0..=49 => Some(self.path.clone()),
            50..=119 => self.cut(bytes),
            _ => Waypoints::draw(bytes).path().ok(),
        };
        let Some(path) = path else {
            return;
        };
        let old = std::mem::replace(&mut self.path, path);
        if kind < 50 || bytes.byte() < 200 {
            let before = self.state.clone();
            // A state may be one of a path that the controller was not told of.
            if self.tracker.check_state(&old.view(), &before).is_err() {
                return;
            }
            let (old, new) = (old.view(), self.path.view());
            self.tracker.set_path(&mut self.state, &old, &new);
            self.tracker.set_path(&mut self.twin, &old, &new);
            let remaining =
                |state: &State<L>| state.handover.map_or(0.0, |handover| handover.remaining);
            assert!(remaining(&self.state) <= HANDOVER_TIME);
            assert!(before.handover.is_none() || remaining(&self.state) <= remaining(&before));
            assert_eq!(self.state.steer.to_bits(), before.steer.to_bits());
            assert_eq!(self.state.model.estimator, before.model.estimator);
            assert_eq!(self.state.model.in_flight, before.model.in_flight);
            // A waypoint that was set, the last one too, stays where the path goes on.
            let place = self.state.place.segment().is_none_or(|k| k < new.len());
            assert!(kind < 50 || place);
            if kind < 50 {
                assert!(same::<L>(&self.state, &before) || before.place == Place::Unknown);
            }
            assert_eq!(self.tracker.check_state(&new, &self.state), Ok(()));
        }
    }

    /// The path from some waypoint on.
    fn cut(&self, bytes: &mut Bytes) -> Option<Path> {
        let view = self.path.view();
        let first = bytes.below(view.len());
        let (x, y) = (view.x().get(first..)?, view.y().get(first..)?);
        let speed = view.speed().and_then(|speed| speed.get(first..));
        Path::new(x, y, speed, false).ok()
    }
}
