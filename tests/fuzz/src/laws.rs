//! Whole lives of a law behind an actuator, or behind none: steps, hand-overs, resets, jumps, other
//! paths, states saved and restored, and bad input at any point.

use crate::backwards::check_backwards;
use crate::bytes::Bytes;
use crate::scene::{Waypoints, actuator, dt, vehicle};
use crate::subject::{Subject, waypoint};
use popsteer_core::error::Requirement;
use popsteer_core::lateral::tracker::HANDOVER_TIME;
use popsteer_core::lateral::{
    BangBang, Handover, LateralState, Pid, Pop, PreviewPop, PurePursuit, Stanley, Tracker,
    TrackerState,
};
use popsteer_core::path::view::MAX_COORDINATE;
use popsteer_core::vehicle::predict::kinematic_bicycle;
use popsteer_core::vehicle::state::{MAX_YAW, checked_dt};
use popsteer_core::vehicle::{Actuator, Learnt, UnderWay};
use popsteer_core::{Command, ConfigError, LateralLaw, Path, Status, VehicleState};
use std::f64::consts::PI;

/// One life of one law.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    match bytes.below(6) {
        0 => live::<Pop>(&mut bytes),
        1 => live::<PurePursuit>(&mut bytes),
        2 => live::<Stanley>(&mut bytes),
        3 => live::<Pid>(&mut bytes),
        4 => live::<PreviewPop>(&mut bytes),
        _ => live::<BangBang>(&mut bytes),
    }
}

/// A refused parameter is named with its value, which does break the requirement.
fn check_refusal(error: &ConfigError) {
    assert!(!error.field.is_empty() && !error.to_string().is_empty());
    if let Requirement::InRange(low, high) = error.requirement {
        assert!(!(low..=high).contains(&error.value));
    }
}

fn live<L: Subject>(bytes: &mut Bytes) {
    let (law, max_steer) = match L::draw(bytes) {
        Ok(drawn) => drawn,
        Err(error) => return check_refusal(&error),
    };
    let actuator = match (bytes.byte() & 1 == 1).then(|| Actuator::new(actuator(bytes))) {
        Some(Ok(actuator)) => Some(actuator),
        Some(Err(error)) => return check_refusal(&error),
        None => None,
    };
    let Ok(path) = Waypoints::draw(bytes).path() else {
        return;
    };
    if bytes.byte() < 40 && path.view().reverse().is_none() {
        return check_backwards(&law, &path, bytes);
    }
    let mut life = Life::new(Tracker::new(law, actuator), max_steer, path);
    for _ in 0..12 {
        if bytes.is_empty() {
            break;
        }
        life.go_on(bytes);
    }
}

type State<L> = TrackerState<<L as LateralLaw>::State>;

/// Whether two states are one, however they keep what is under way.
fn same<L: Subject>(a: &State<L>, b: &State<L>) -> bool {
    let under_way = match (&a.under_way, &b.under_way) {
        (Some(a), Some(b)) => {
            a.wheel().to_bits() == b.wheel().to_bits() && a.commands().eq(b.commands())
        }
        (a, b) => a.is_none() && b.is_none(),
    };
    L::same(&a.law, &b.law)
        && a.steer.to_bits() == b.steer.to_bits()
        && (a.handover, a.held) == (b.handover, b.held)
        && under_way
}

/// A law at work, with two states: one is stepped, the other steered, and they stay one.
struct Life<L: Subject> {
    tracker: Tracker<L>,
    max_steer: f64,
    path: Path,
    state: State<L>,
    twin: State<L>,
    saved: Option<State<L>>,
    vehicle: VehicleState,
}

impl<L: Subject> Life<L> {
    fn new(tracker: Tracker<L>, max_steer: f64, path: Path) -> Self {
        assert_eq!(tracker.max_steer().to_bits(), max_steer.to_bits());
        let state = tracker.initial_state();
        let (x, y) = (path.view().x()[0], path.view().y()[0]);
        Self {
            twin: state.clone(),
            state,
            tracker,
            max_steer,
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
            80..=149 => {
                let vehicle = vehicle(bytes, &self.path.view());
                let refused = self.step(vehicle, dt(bytes));
                if !refused {
                    self.vehicle = vehicle;
                }
            }
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
        let good = vehicle.checked().is_ok() && checked_dt(dt).is_ok();
        let before = self.state.clone();
        let stepped = self.tracker.step(&path, &mut self.state, vehicle, dt);
        assert_eq!(stepped.is_ok(), good, "{stepped:?}");
        let steered = self.tracker.steer(&path, &mut self.twin, vehicle, dt);
        match (stepped, steered) {
            (Ok(command), Ok(steer)) => {
                assert_eq!(command.steer.to_bits(), steer.to_bits());
                self.check_command(&before, &command, vehicle, dt);
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

    fn check_command(&self, before: &State<L>, command: &Command, vehicle: VehicleState, dt: f64) {
        assert!(command.steer.abs() <= self.max_steer);
        assert!(command.cross_track_error.is_finite());
        assert!(command.heading_error.abs() <= PI);
        assert!(command.target.x.is_finite() && command.target.y.is_finite());
        assert_eq!(self.state.steer.to_bits(), command.steer.to_bits());
        assert_eq!(self.state.held, 0);
        if let Some(steer) = L::previous_steer(&self.state.law) {
            // What was given, whatever was wanted.
            assert_eq!(steer.to_bits(), command.steer.to_bits());
        }
        let view = self.path.view();
        let segment = L::waypoint(&self.state.law).expect("the vehicle was found");
        assert!(segment < view.segments());
        assert_eq!(command.reverse, view.is_reverse(segment));
        if let Some(bare) = self.step_bare(before, vehicle, dt) {
            self.check_against_bare(before, command, &bare);
        }
        let Some(actuator) = self.tracker.actuator() else {
            return;
        };
        let most = actuator.params().max_rate.unwrap_or(f64::INFINITY) * dt;
        assert!((command.steer - before.steer).abs() <= most + 1e-12);
    }

    /// What the law itself answers to the vehicle that it is shown; none where that lies beyond
    /// the bounds of an input.
    fn step_bare(&self, before: &State<L>, vehicle: VehicleState, dt: f64) -> Option<Command> {
        let mut seen = vehicle;
        if let (Some(actuator), Some(under_way)) = (self.tracker.actuator(), &before.under_way) {
            let learnt = actuator.learn(under_way, before.steer, vehicle, dt);
            seen = actuator.predict(under_way, before.steer, vehicle, dt, &learnt);
            let within = [seen.x, seen.y].iter().all(|v| v.abs() <= MAX_COORDINATE);
            if !(within && seen.yaw.abs() <= MAX_YAW) {
                return None;
            }
        }
        let mut state = before.law.clone();
        let law = self.tracker.law();
        let answer = law.step(&self.path.view(), &mut state, seen, dt);
        Some(answer.expect("the input is good"))
    }

    fn check_against_bare(&self, before: &State<L>, command: &Command, bare: &Command) {
        let errors = |command: &Command| {
            let Command {
                cross_track_error,
                heading_error,
                target,
                ..
            } = command;
            [*cross_track_error, *heading_error, target.x, target.y].map(f64::to_bits)
        };
        assert_eq!(errors(command), errors(bare));
        assert_eq!(command.reverse, bare.reverse);
        let limited = bare.status == Status::Ok && command.status == Status::Saturated;
        assert!(command.status == bare.status || limited);
        let unlimited = self.tracker.actuator().is_none();
        match before.handover {
            None if unlimited => assert_eq!(command.steer.to_bits(), bare.steer.to_bits()),
            // Taken over without a jump.
            Some(Handover { offset: None, left }) if unlimited => {
                let share = (left / HANDOVER_TIME).clamp(0.0, 1.0);
                let wanted = bare.steer + share * (before.steer - bare.steer);
                assert!((command.steer - wanted).abs() <= 1e-12);
            }
            _ => {}
        }
    }

    /// An answer to anything: that of the step where there is one, else the angle that is held.
    fn step_or_hold(&mut self, vehicle: VehicleState, dt: f64, hold_limit: usize) {
        let path = self.path.view();
        let before = self.state.clone();
        let tracker = &self.tracker;
        let command = tracker.step_or_hold(&path, &mut self.state, vehicle, dt, hold_limit);
        if let Ok(stepped) = tracker.step(&path, &mut self.twin, vehicle, dt) {
            assert_eq!(command, stepped);
            return;
        }
        let held = before.held.saturating_add(1);
        let lost = held > hold_limit;
        assert_eq!(command.steer.to_bits(), before.steer.to_bits());
        assert_eq!(command.status == Status::InputLost, lost);
        assert_eq!(command.status == Status::InputHeld, !lost);
        assert!(command.steer.abs() <= self.max_steer);
        // Time goes on for what is under way, and nothing else changes.
        let mut wanted = TrackerState { held, ..before };
        if let (Some(actuator), Some(line)) = (tracker.actuator(), &mut wanted.under_way) {
            if let Ok(dt) = checked_dt(dt) {
                actuator.elapse(line, wanted.steer, dt);
            }
            line.lose_sight();
        }
        assert!(same::<L>(&self.state, &wanted));
        self.put(wanted);
    }

    /// From nothing, or from a driver's angle.
    fn reset(&mut self, bytes: &mut Bytes) {
        if bytes.byte() < 100 {
            return self.put(self.tracker.initial_state());
        }
        let steer = bytes.number([-0.5, 0.5], [-self.max_steer, self.max_steer]);
        let answer = self.tracker.state_from(steer);
        assert_eq!(answer.is_ok(), steer.abs() <= self.max_steer);
        if let Ok(state) = answer {
            assert_eq!(state.steer.to_bits(), steer.to_bits());
            assert_eq!(self.tracker.check_state(&self.path.view(), &state), Ok(()));
            self.put(state);
        }
    }

    fn relocalise(&mut self, bytes: &mut Bytes) {
        if bytes.byte() < 50 {
            // Whatever is put there, the next step finds a place on the path.
            let waypoint = waypoint(bytes);
            self.state.set_waypoint(waypoint);
            return self.twin.set_waypoint(waypoint);
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
            let segment = L::waypoint(&self.state.law).expect("the vehicle was found");
            assert!(segment < path.segments());
            self.put(self.state.clone());
        }
    }

    /// Another path, mostly with the law told of it.
    fn set_path(&mut self, bytes: &mut Bytes) {
        let Ok(path) = Waypoints::draw(bytes).path() else {
            return;
        };
        self.path = path;
        if bytes.byte() < 200 {
            let steer = self.state.steer;
            self.state.leave_path();
            self.twin.leave_path();
            assert_eq!(L::waypoint(&self.state.law), None);
            assert_eq!(self.state.steer.to_bits(), steer.to_bits());
            let path = self.path.view();
            assert_eq!(self.tracker.check_state(&path, &self.state), Ok(()));
        }
    }

    fn draw_state(&self, bytes: &mut Bytes) -> Option<State<L>> {
        let steer = bytes.number([-1.0, 1.0], [-1.57, 1.57]);
        let handover = (bytes.byte() & 1 == 1).then(|| Handover {
            offset: (bytes.byte() & 1 == 1).then(|| bytes.number([-1.0, 1.0], [-PI, PI])),
            left: bytes.number([0.0, 1.0], [0.0, HANDOVER_TIME]),
        });
        let under_way = match (self.tracker.actuator(), bytes.byte()) {
            (Some(actuator), 0..=99) => Some(actuator.settled(bytes.within(-1.0, 1.0))),
            (Some(actuator), 100..=249) => {
                let part = 0.25 * actuator.params().dead_time;
                let line: Vec<_> = (0..4).map(|_| (bytes.within(-1.0, 1.0), part)).collect();
                Some(
                    actuator
                        .restore(line.into_iter(), bytes.within(-1.0, 1.0), Learnt::default())
                        .ok()?,
                )
            }
            (None, 0..=249) | (_, 250..=252) => None,
            // Of another vehicle.
            _ => Some(Actuator::new(actuator(bytes)).ok()?.settled(0.1)),
        };
        Some(TrackerState {
            law: L::draw_state(bytes)?,
            steer,
            handover,
            held: [0, 1, usize::MAX][bytes.below(3)],
            under_way: under_way.map(Box::new),
        })
    }

    /// What the law accepts it can go on from; what is under way goes through a copy of its parts.
    fn restore(&mut self, state: State<L>) {
        if self.tracker.check_state(&self.path.view(), &state).is_err() {
            return;
        }
        let under_way = match (self.tracker.actuator(), state.under_way.as_deref()) {
            (Some(actuator), Some(line)) => Some(Box::new(copied(actuator, line))),
            _ => state.under_way.clone(),
        };
        self.put(state.clone());
        self.twin = TrackerState { under_way, ..state };
    }
}

fn copied(actuator: &Actuator, line: &UnderWay) -> UnderWay {
    let commands: Vec<_> = line.commands().collect();
    let restored = actuator.restore(commands.into_iter(), line.wheel(), *line.learnt());
    restored.expect("the state was accepted")
}
