//! States of a tracker, mostly within their bounds.

use super::{Life, State};
use crate::bytes::Bytes;
use crate::scene::{car, estimator, symmetric, walk};
use crate::subject::{Subject, waypoint};
use popsteer_core::bounds::{MAX_COORDINATE, MAX_DT, MAX_YAW};
use popsteer_core::path::{Ahead, Place, Spot};
use popsteer_core::tracker::monitor::course::Course;
use popsteer_core::tracker::state::HANDOVER_TIME;
use popsteer_core::tracker::{
    Answer, Deviation, Handover, Model, MonitorState, TrackerState, Tracking,
};
use popsteer_core::vehicle::{Cusum, Estimate, Estimator, InFlight, Noise};
use popsteer_core::{Point, Vehicle, VehicleState};
use std::f64::consts::PI;

impl<L: Subject> Life<L> {
    pub(super) fn draw_state(&self, bytes: &mut Bytes) -> Option<State<L>> {
        let Vehicle {
            wheelbase,
            dead_time,
            ..
        } = self.car;
        let handover = (bytes.byte() & 1 == 1).then(|| Handover {
            offset: (bytes.byte() & 1 == 1).then(|| symmetric(bytes, 1.0, PI)),
            remaining: bytes.number([0.0, 1.0], [0.0, HANDOVER_TIME]),
        });
        let answer = (bytes.byte() & 1 == 1).then(|| Answer {
            measured: draw_deviation(bytes),
            predicted: draw_deviation(bytes),
            target: Point::new(
                symmetric(bytes, 10.0, 4.0 * MAX_COORDINATE),
                symmetric(bytes, 10.0, 4.0 * MAX_COORDINATE),
            ),
            reverse: bytes.byte() & 1 == 1,
            ahead: Ahead {
                reference_speed: Some(1.0),
                distance_to_stop: f64::INFINITY,
            },
            vehicle: VehicleState {
                x: 0.0,
                y: 0.0,
                yaw: 0.0,
                speed: 1.0,
            },
        });
        let estimator = if bytes.byte() < 100 {
            self.state.model.estimator
        } else {
            estimator(bytes, wheelbase, dead_time)
        };
        let mut tracking = Tracking {
            law: L::draw_state(bytes)?,
            place: draw_place(bytes),
            steer: symmetric(bytes, 1.0, 1.57),
            handover,
            held: [0, 1, usize::MAX][bytes.below(3)],
            held_time: bytes.number([0.0, 0.5], [0.0, MAX_DT]),
            period: bytes.number([0.0, 0.1], [0.0, MAX_DT]),
            answer,
            gate: self.state.gate,
            monitor: self.state.monitor,
        };
        let model = Model {
            in_flight: self.draw_in_flight(bytes, &estimator.estimate),
            past: None,
            estimator,
        };
        tracking.monitor = draw_monitor(bytes).or(tracking.monitor);
        Some(TrackerState { tracking, model })
    }

    fn draw_in_flight(&self, bytes: &mut Bytes, estimate: &Estimate) -> Option<InFlight> {
        let dead_time = estimate.dead_time(&self.car);
        match bytes.byte() {
            0..=49 => Some(InFlight::settled(&self.car, bytes.within(-1.57, 1.57))),
            50..=199 => {
                let part = 0.25 * dead_time;
                let line: Vec<_> = (0..4).map(|_| (bytes.within(-1.0, 1.0), part)).collect();
                let wheel = bytes.within(-1.0, 1.0);
                InFlight::restore(line.into_iter(), wheel, dead_time).ok()
            }
            200..=249 => None,
            // To another vehicle.
            _ => {
                let other = car(bytes).checked().ok()?;
                Some(InFlight::settled(&other, 0.1))
            }
        }
    }

    /// What the tracker accepts it can go on from; commands in flight go through a copy of their
    /// parts.
    pub(super) fn restore(&mut self, state: State<L>) {
        if self.tracker.check_state(&self.path.view(), &state).is_err() {
            return;
        }
        let dead_time = state.model.estimator.estimate.dead_time(&self.car);
        let in_flight = state.model.in_flight.map(|in_flight| {
            let commands: Vec<_> = in_flight.commands().collect();
            let wheel = in_flight.wheel();
            let copied = InFlight::restore(commands.into_iter(), wheel, dead_time);
            // Where none are modelled those that are there do not count.
            let accepted = in_flight.check(dead_time).is_ok();
            assert_eq!(copied.is_ok(), accepted);
            copied.unwrap_or(in_flight)
        });
        self.put(state.clone());
        self.twin = state;
        self.twin.model.in_flight = in_flight;
    }
}

/// A place that a path may or may not have.
pub(super) fn draw_place(bytes: &mut Bytes) -> Place {
    let Some(segment) = waypoint(bytes) else {
        return Place::Unknown;
    };
    let point = Point::new(symmetric(bytes, 50.0, 4e9), symmetric(bytes, 50.0, 4e9));
    let spot = Spot { segment, point };
    if bytes.byte() & 1 == 1 {
        Place::Known(spot)
    } else {
        Place::Lost(spot)
    }
}

fn draw_monitor(bytes: &mut Bytes) -> Option<MonitorState> {
    if bytes.byte() < 150 {
        return None;
    }
    let unknown = |bytes: &mut Bytes| bytes.byte() & 1 == 1;
    let most: f64 = [1.0, 1e100][bytes.below(2)];
    Some(MonitorState {
        wheel: symmetric(bytes, 1.0, 1.57),
        yaw: unknown(bytes).then(|| symmetric(bytes, 4.0, MAX_YAW)),
        turned: Cusum {
            over: symmetric(bytes, 0.1, most).abs(),
            under: symmetric(bytes, 0.1, most).abs(),
        },
        rates: (symmetric(bytes, 0.5, most), symmetric(bytes, 0.5, most)),
        later: symmetric(bytes, 0.1, most).abs(),
        known: [
            (
                bytes.within(0.0, Estimator::MAX_GAIN),
                bytes.within(0.0, 1.0),
            ),
            (
                symmetric(bytes, 0.1, 1.0),
                symmetric(bytes, 0.1, most).abs(),
            ),
        ],
        noise: Noise {
            variance: symmetric(bytes, 1e-4, most).abs(),
            last: unknown(bytes).then(|| symmetric(bytes, 0.1, most.min(1e49))),
            count: bytes.within(1.0, 200.0),
        },
        gain: walk(bytes),
        yaw_rate: symmetric(bytes, 0.5, most),
        course: Course {
            turn: symmetric(bytes, 0.1, most.min(1e20)),
            aside: symmetric(bytes, 0.5, most.min(1e20)),
            commanded: symmetric(bytes, 0.5, most.min(1e20)),
        },
        heading: bytes.byte() & 1 == 1,
        alarm: bytes.within(0.0, MonitorState::ALARM_TIME),
        within: bytes.byte() & 1 == 1,
    })
}

fn draw_deviation(bytes: &mut Bytes) -> Deviation {
    Deviation {
        cross_track_error: symmetric(bytes, 2.0, 4.0 * MAX_COORDINATE),
        yaw: symmetric(bytes, 4.0, 2.0 * MAX_YAW),
        along: Point::new(
            symmetric(bytes, 2.0, 4.0 * MAX_COORDINATE),
            symmetric(bytes, 2.0, 4.0 * MAX_COORDINATE),
        ),
    }
}
