//! The gate and the monitor: poses that repeat, jump, drift or are no numbers, then ones that agree.

use crate::bytes::Bytes;
use popsteer_core::bounds::{MAX_COORDINATE, MAX_DT, MAX_SPEED, MAX_YAW, MIN_DT};
use popsteer_core::laws::{Stanley, StanleyParams};
use popsteer_core::status::HOLD_LIMIT;
use popsteer_core::tracker::Reported;
use popsteer_core::vehicle::state::checked_dt;
use popsteer_core::{Path, Status, Tracker, Vehicle, VehicleState};

/// How many poses may be anything, and how many agree after them, a tenth of a second apart.
const WILD: usize = 10;
const CALM: u32 = 24;

/// Drives one vehicle on a straight.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let car = Vehicle {
        dead_time: bytes.within(0.01, 0.3),
        steer_lag: bytes.within(0.0, 0.3),
        max_steer: 0.6,
        max_steer_rate: Some(0.4),
        ..Vehicle::PAPER
    };
    let law = Stanley::new(car, StanleyParams::DEFAULT).expect("a vehicle as any");
    let tracker = Tracker::of(law);
    let path = Path::new(&[-1e4, 1e4], &[0.0, 0.0], None, false).expect("two waypoints");
    let view = path.view();
    let mut state = tracker.initial_state();
    let mut pose = VehicleState {
        speed: 8.0,
        ..VehicleState::ORIGIN
    };
    for _ in 0..WILD {
        let dt = bytes.number([0.01, 0.3], [MIN_DT, MAX_DT]);
        let last = pose;
        match bytes.byte() % 4 {
            0 => {}
            1 => pose.x += pose.speed * dt,
            2 => pose.y += bytes.within(-10.0, 10.0),
            _ => {
                pose.x = bytes.number([-100.0, 100.0], [-MAX_COORDINATE, MAX_COORDINATE]);
                pose.yaw = bytes.number([-3.0, 3.0], [-MAX_YAW, MAX_YAW]);
                pose.speed = bytes.number([-10.0, 30.0], [-MAX_SPEED, MAX_SPEED]);
            }
        }
        let before = state;
        if let Ok(command) = tracker.step(&view, &mut state, pose, dt, Reported::NOTHING) {
            assert!(command.steer.abs() <= car.max_steer);
            assert!(command.cross_track_error.is_finite() && command.heading_error.is_finite());
            let repeats = before.gate.is_some_and(|gate| {
                gate.measured.x.to_bits() == pose.x.to_bits()
                    && gate.measured.y.to_bits() == pose.y.to_bits()
            });
            assert!(repeats || !command.status.contains(Status::POSE_STALE));
            if checked_dt(dt).is_err() {
                let held = before.held + 1;
                assert_eq!(command.status.faults() != Status::OK, held > HOLD_LIMIT);
                assert_eq!(state.held, held);
                assert!(state.gate == before.gate && state.answer == before.answer);
                pose = last;
                continue;
            }
            let gate = state.gate.expect("a vehicle with a dead time has a gate");
            assert!(gate.checked().is_ok(), "{gate:?}");
        } else {
            assert!(state == before, "a refused input changes nothing");
            pose = last;
        }
        if bytes.is_empty() {
            break;
        }
    }
    let from = bytes.within(-500.0, 500.0);
    // So slow that no commanded angle explains another turn than a straight drive.
    for k in 0..CALM {
        let calm = VehicleState {
            x: from + 0.2 * f64::from(k),
            y: 0.3,
            yaw: 0.0,
            speed: 2.0,
        };
        let command = tracker.step(&view, &mut state, calm, 0.1, Reported::NOTHING);
        let status = command.expect("a good input").status;
        let doubted = Status::OUTLIER | Status::POSE_STALE;
        let is_doubted = doubted
            .names()
            .any(|name| status.names().any(|each| each == name));
        assert!(
            k < CALM - 4 || !is_doubted,
            "poses that agree are doubted: {status}"
        );
    }
}
