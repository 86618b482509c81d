//! Whole lives of a law: steps, resets, jumps, other paths, states saved and restored, and bad
//! input at any point.

use crate::bytes::Bytes;
use crate::scene::{Waypoints, dt, vehicle};
use crate::subject::Subject;
use popsteer_core::error::Requirement;
use popsteer_core::lateral::{BangBang, Pid, Pop, PurePursuit, Stanley};
use popsteer_core::vehicle::predict::kinematic_bicycle;
use popsteer_core::vehicle::state::checked_dt;
use popsteer_core::{Command, ConfigError, Path, VehicleState};
use std::f64::consts::PI;

/// One life of one law.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    match bytes.below(5) {
        0 => live::<Pop>(&mut bytes),
        1 => live::<PurePursuit>(&mut bytes),
        2 => live::<Stanley>(&mut bytes),
        3 => live::<Pid>(&mut bytes),
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
    let Ok(path) = Waypoints::draw(bytes).path() else {
        return;
    };
    let mut life = Life::new(law, max_steer, path);
    for _ in 0..12 {
        if bytes.is_empty() {
            break;
        }
        life.go_on(bytes);
    }
}

/// A law at work, with two states: one is stepped, the other steered, and they stay one.
struct Life<L: Subject> {
    law: L,
    max_steer: f64,
    path: Path,
    state: L::State,
    twin: L::State,
    saved: Option<L::State>,
    vehicle: VehicleState,
    steer: f64,
}

impl<L: Subject> Life<L> {
    fn new(law: L, max_steer: f64, path: Path) -> Self {
        let state = law.initial_state();
        let (x, y) = (path.view().x()[0], path.view().y()[0]);
        Self {
            twin: state.clone(),
            state,
            law,
            max_steer,
            path,
            saved: None,
            vehicle: VehicleState {
                x,
                y,
                yaw: 0.1,
                speed: 8.0,
            },
            steer: 0.0,
        }
    }

    fn go_on(&mut self, bytes: &mut Bytes) {
        match bytes.byte() {
            0..=99 => {
                self.vehicle =
                    kinematic_bicycle(self.vehicle, self.steer, bytes.within(-3.0, 3.0), 3.0, 0.05);
                self.step(self.vehicle, 0.05);
            }
            100..=179 => {
                let vehicle = vehicle(bytes, &self.path.view());
                let refused = self.step(vehicle, dt(bytes));
                if !refused {
                    self.vehicle = vehicle;
                }
            }
            180..=194 => self.put(self.law.initial_state()),
            195..=219 => self.relocalise(bytes),
            220..=229 => self.swap(bytes),
            230..=239 => self.saved = Some(self.state.clone()),
            240..=247 => {
                if let Some(saved) = self.saved.take() {
                    self.restore(saved);
                }
            }
            _ => {
                if let Some(state) = L::draw_state(bytes) {
                    self.restore(state);
                }
            }
        }
        assert!(L::same(&self.state, &self.twin));
    }

    fn put(&mut self, state: L::State) {
        self.twin = state.clone();
        self.state = state;
    }

    /// Steps the state and steers its twin; whether both refused.
    fn step(&mut self, vehicle: VehicleState, dt: f64) -> bool {
        let path = self.path.view();
        let stepped = self.law.step(&path, &mut self.state, vehicle, dt);
        let good = vehicle.checked().is_ok() && checked_dt(dt).is_ok();
        assert_eq!(stepped.is_ok(), good);
        if stepped.is_err() {
            // Unchanged: the twin has not been touched yet.
            assert!(L::same(&self.state, &self.twin));
        }
        let steered = self.law.steer(&path, &mut self.twin, vehicle, dt);
        match (stepped, steered) {
            (Ok(command), Ok(steer)) => {
                assert_eq!(command.steer.to_bits(), steer.to_bits());
                self.check_command(&command);
                assert_eq!(self.law.check_state(&path, &self.state), Ok(()));
                self.steer = steer;
                false
            }
            (Err(stepped), Err(steered)) => {
                // Written out, as a NaN in it is not equal to itself.
                assert_eq!(stepped.to_string(), steered.to_string());
                true
            }
            mixed => panic!("step and steer disagree: {mixed:?}"),
        }
    }

    fn check_command(&self, command: &Command) {
        assert!(command.steer.abs() <= self.max_steer);
        assert!(command.cross_track_error.is_finite());
        assert!(command.heading_error.abs() <= PI);
        assert!(command.target.x.is_finite() && command.target.y.is_finite());
    }

    fn relocalise(&mut self, bytes: &mut Bytes) {
        let VehicleState { x, y, yaw, .. } = vehicle(bytes, &self.path.view());
        let path = self.path.view();
        let done = self.law.relocalise(&path, &mut self.state, x, y, yaw);
        let good = VehicleState {
            x,
            y,
            yaw,
            speed: 0.0,
        };
        assert_eq!(done.is_ok(), good.checked().is_ok());
        if done.is_err() {
            assert!(L::same(&self.state, &self.twin));
        } else {
            self.put(self.state.clone());
        }
    }

    fn swap(&mut self, bytes: &mut Bytes) {
        if let Ok(path) = Waypoints::draw(bytes).path() {
            self.path = path;
        }
    }

    /// What the law accepts it can go on from.
    fn restore(&mut self, state: L::State) {
        if self.law.check_state(&self.path.view(), &state).is_ok() {
            self.put(state);
        }
    }
}
