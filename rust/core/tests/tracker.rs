//! A step whole: hand-over, limits, points of the vehicle, errors, held input, intention.

use popsteer_core::bounds::MAX_YAW;
use popsteer_core::laws::{
    Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams, PurePursuit, PurePursuitParams,
    Stanley, StanleyParams,
};
use popsteer_core::status::HOLD_LIMIT;
use popsteer_core::vehicle::AdaptParams;
use popsteer_core::{Command, Path, Reported, Status, Tracker, Vehicle, VehicleState};
use std::f64::consts::PI;

fn straight() -> Path {
    Path::new(&[0.0, 100.0], &[0.0, 0.0], None, false).unwrap()
}

fn beside() -> VehicleState {
    VehicleState {
        x: 5.0,
        y: 1.0,
        yaw: 0.1,
        speed: 5.0,
    }
}

fn stanley(vehicle: &Vehicle) -> Tracker<Stanley> {
    Tracker::of(Stanley::new(*vehicle, StanleyParams::DEFAULT).unwrap())
}

#[test]
fn test_handover_starts_from_the_angle_and_fades() {
    let path = straight();
    let tracker = stanley(&Vehicle::PAPER);
    let mut bare = tracker.initial_state();
    let wanted = tracker
        .steer(&path.view(), &mut bare, beside(), 0.1, Reported::NOTHING)
        .unwrap();
    let mut state = tracker.state_from(0.3).unwrap();
    let mut steer = || {
        tracker
            .steer(&path.view(), &mut state, beside(), 0.1, Reported::NOTHING)
            .unwrap()
    };
    assert!((steer() - 0.3).abs() < 1e-15);
    let mut before = 0.3;
    for _ in 0..9 {
        let next = steer();
        assert!((before - next - 0.1 * (0.3 - wanted)).abs() < 1e-12);
        before = next;
    }
    assert!((steer() - wanted).abs() < 1e-12);
    assert_eq!(steer().to_bits(), wanted.to_bits());
    assert_eq!(tracker.state_from(2.0).unwrap_err().field, "steer");
}

#[test]
fn test_handover_pop_goes_on_from_the_angle() {
    let path = straight();
    let law = Pop::new(Vehicle::DEFAULT, PopParams::DEFAULT).unwrap();
    let tracker = Tracker::of(law);
    let mut state = tracker.state_from(0.3).unwrap();
    let steer = tracker
        .steer(&path.view(), &mut state, beside(), 0.05, Reported::NOTHING)
        .unwrap();
    assert!((steer - 0.3).abs() <= PopParams::DEFAULT.steer_span + 1e-15);
}

#[test]
fn test_pop_at_rest_keeps_its_angle() {
    let law = Tracker::of(Pop::new(Vehicle::DEFAULT, PopParams::DEFAULT).unwrap());
    let path = Path::new(&[0.0, 10.0, 20.0], &[0.0, 3.0, 0.0], None, false).unwrap();
    let mut state = law.state_from(0.125).unwrap();
    let vehicle = VehicleState {
        x: 0.0,
        y: 1.0,
        yaw: 0.3,
        speed: 0.0,
    };
    for _ in 0..100 {
        let steer = law.steer(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING);
        assert_eq!(steer, Ok(0.125));
    }
}

#[test]
fn test_limits_of_the_vehicle_are_kept_and_said() {
    let path = straight();
    let rate = Vehicle {
        max_steer_rate: Some(0.2),
        ..Vehicle::PAPER
    };
    let lateral = Vehicle {
        max_lateral_acceleration: Some(0.5),
        ..Vehicle::PAPER
    };
    let lateral_limit = -popsteer_core::math::atan(0.5 * 3.0 / 25.0);
    for (vehicle, limit) in [(rate, -0.2 * 0.05), (lateral, lateral_limit)] {
        let tracker = stanley(&vehicle);
        let mut state = tracker.initial_state();
        let command = tracker
            .step(&path.view(), &mut state, beside(), 0.05, Reported::NOTHING)
            .unwrap();
        assert!((command.steer - limit).abs() < 1e-15, "{command:?}");
        assert!(command.status.contains(Status::SATURATED));
    }
}

#[test]
fn test_conditions_stand_side_by_side_in_a_status() {
    let path = straight();
    let tracker = stanley(&Vehicle::PAPER);
    let mut state = tracker.initial_state();
    let lost = VehicleState {
        x: 140.0,
        y: 50.0,
        yaw: -1.5,
        speed: 5.0,
    };
    let command = tracker
        .step(&path.view(), &mut state, lost, 0.05, Reported::NOTHING)
        .unwrap();
    let all = Status::OFF_PATH | Status::END_OF_PATH | Status::DEVIATING;
    assert_eq!(command.status, all);
    let turned = VehicleState { yaw: 1.5, ..lost };
    let command = tracker
        .step(&path.view(), &mut state, turned, 0.05, Reported::NOTHING)
        .unwrap();
    assert!(command.status.contains(all | Status::SATURATED));
}

#[test]
fn test_told_steering_offset_is_taken_off_the_command() {
    let path = straight();
    let given = Vehicle {
        steer_offset: 0.02,
        ..Vehicle::PAPER
    };
    let step = |vehicle| {
        let tracker = stanley(&vehicle);
        let mut state = tracker.initial_state();
        let command = tracker.step(&path.view(), &mut state, beside(), 0.05, Reported::NOTHING);
        command.unwrap().steer
    };
    assert!((step(Vehicle::PAPER) - 0.02 - step(given)).abs() < 1e-15);
}

#[test]
fn test_any_point_of_the_vehicle_gives_the_same_angles() {
    let x: Vec<f64> = (0..60).map(f64::from).collect();
    let y: Vec<f64> = x
        .iter()
        .map(|x| 3.0 * popsteer_core::math::sin(x / 9.0))
        .collect();
    let forward = Path::new(&x, &y, None, false).unwrap();
    let backward = Path::new(&x, &y, None, false)
        .unwrap()
        .with_reverse(&[true; 60])
        .unwrap();
    for path in [forward, backward] {
        let reverse = path.view().reverse().is_some();
        let poses: Vec<VehicleState> = (0..40)
            .map(|k| VehicleState {
                x: 1.0 + 0.25 * f64::from(k),
                y: 1.5 * popsteer_core::math::sin(0.1 * f64::from(k)),
                yaw: 0.2 + if reverse { PI } else { 0.0 },
                speed: if reverse { -5.0 } else { 5.0 },
            })
            .collect();
        let angles = |rear_axle: f64| {
            let vehicle = Vehicle {
                rear_axle,
                dead_time: 0.1,
                max_lateral_acceleration: None,
                ..Vehicle::DEFAULT
            };
            let mut all = Vec::new();
            macro_rules! drive {
                ($law:expr) => {
                    let tracker = Tracker::of($law.unwrap());
                    let mut state = tracker.initial_state();
                    for pose in &poses {
                        let pose = pose.ahead(-rear_axle);
                        let view = path.view();
                        all.push(
                            tracker
                                .steer(&view, &mut state, pose, 0.05, Reported::NOTHING)
                                .unwrap(),
                        );
                    }
                };
            }
            drive!(Pop::new(vehicle, PopParams::DEFAULT));
            drive!(PreviewPop::new(vehicle, PreviewPopParams::DEFAULT));
            drive!(Pid::new(vehicle, PidParams::DEFAULT));
            drive!(PurePursuit::new(vehicle, PurePursuitParams::DEFAULT));
            drive!(Stanley::new(vehicle, StanleyParams::DEFAULT));
            all
        };
        let rear = angles(0.0);
        for point in [-1.35, -3.0, 0.8] {
            for (a, b) in rear.iter().zip(angles(point)) {
                assert!((a - b).abs() < 1e-12, "{point} {a} {b}");
            }
        }
    }
}

#[test]
fn test_errors_are_those_of_the_measured_vehicle() {
    let path = straight();
    let tracker = stanley(&Vehicle {
        dead_time: 0.5,
        ..Vehicle::PAPER
    });
    let mut state = tracker.initial_state();
    let command = tracker
        .step(&path.view(), &mut state, beside(), 0.05, Reported::NOTHING)
        .unwrap();
    let front = 1.0 + 3.0 * popsteer_core::math::sin(0.1);
    assert!((command.cross_track_error - front).abs() < 1e-12);
    assert!((command.heading_error - 0.1).abs() < 1e-12);
    let predicted = front + 2.5 * popsteer_core::math::sin(0.1);
    assert!((command.predicted_cross_track_error - predicted).abs() < 1e-12);
}

#[test]
fn test_prediction_beyond_the_bounds_is_no_reason_to_refuse() {
    let path = straight();
    for adapt in [None, Some(AdaptParams::DEFAULT)] {
        let vehicle = Vehicle {
            dead_time: 10.0,
            ..Vehicle::PAPER
        };
        let law = Stanley::new(vehicle, StanleyParams::DEFAULT).unwrap();
        let tracker = Tracker::new(law, adapt).unwrap();
        let mut state = tracker.state_from(1.0).unwrap();
        let yaw = MAX_YAW;
        // The faster of the speeds is taken for an acceleration that goes on.
        for (x, y, speed) in [(1e9, -1e9, 9e3), (-1e9, 1e9, 1e4), (1e9, 1e9, -1e4)] {
            let vehicle = VehicleState { x, y, yaw, speed };
            let command = tracker.step(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING);
            assert!(command.unwrap().status.contains(Status::OFF_PATH));
            assert_eq!(tracker.check_state(&path.view(), &state), Ok(()));
        }
    }
}

#[test]
fn test_check_state_refuses_commands_in_flight_to_another_vehicle() {
    let path = straight();
    let dead = |dead_time| {
        stanley(&Vehicle {
            dead_time,
            ..Vehicle::PAPER
        })
    };
    let check = |tracker: &Tracker<Stanley>, state| {
        let answer = tracker.check_state(&path.view(), &state);
        answer.map_err(|error| (error.field, error.value))
    };
    let state = dead(0.2).initial_state();
    assert_eq!(check(&dead(0.2), state), Ok(()));
    assert_eq!(check(&dead(0.3), state), Err(("in_flight.commands", 0.2)));
    assert_eq!(check(&dead(0.0), state), Ok(()));
    let without = dead(0.0).initial_state();
    assert_eq!(check(&dead(0.2), without), Err(("in_flight.commands", 0.0)));
}

#[test]
fn test_handover_across_the_largest_angle_and_an_offset_is_a_state() {
    let path = straight();
    let tracker = stanley(&Vehicle {
        max_steer: 0.3,
        steer_offset: 0.5,
        ..Vehicle::PAPER
    });
    let mut state = tracker.state_from(0.3).unwrap();
    let right = VehicleState {
        yaw: 1.0,
        ..beside()
    };
    tracker
        .step(&path.view(), &mut state, right, 0.05, Reported::NOTHING)
        .unwrap();
    assert_eq!(state.handover.unwrap().offset, Some(1.1));
    assert_eq!(tracker.check_state(&path.view(), &state), Ok(()));
}

#[test]
fn test_estimate_of_another_vehicle_does_not_count_where_nothing_is_modelled() {
    let path = straight();
    for most in [None, Some(100.0)] {
        let tracker = stanley(&Vehicle {
            max_lateral_acceleration: most,
            ..Vehicle::PAPER
        });
        let late = stanley(&Vehicle {
            dead_time: 0.2,
            ..Vehicle::PAPER
        });
        let mut state = tracker.initial_state();
        let mut restored = late.initial_state();
        restored.model.estimator.estimate.steer_offset = 0.1;
        restored.model.estimator.estimate.gain = 2.0;
        assert_eq!(tracker.check_state(&path.view(), &restored), Ok(()));
        let step = |state| tracker.steer(&path.view(), state, beside(), 0.05, Reported::NOTHING);
        assert_eq!(step(&mut restored), step(&mut state));
    }
}

#[test]
fn test_input_refused_holds_all_of_the_last_command_then_is_lost() {
    let x = [0.0, 50.0, 100.0];
    let path = Path::new(&x, &[0.0; 3], None, false).unwrap();
    let path = path.with_reverse(&[true; 3]).unwrap();
    let tracker = stanley(&Vehicle::DEFAULT);
    let mut state = tracker.initial_state();
    let backing = VehicleState {
        yaw: PI,
        speed: -2.0,
        ..beside()
    };
    let good = tracker
        .step(&path.view(), &mut state, backing, 0.05, Reported::NOTHING)
        .unwrap();
    assert!(good.reverse && good.cross_track_error > 0.5);
    let bad = VehicleState {
        x: f64::NAN,
        ..backing
    };
    let mut held = |vehicle| {
        tracker.step_or_hold(
            &path.view(),
            &mut state,
            vehicle,
            0.05,
            2,
            Reported::NOTHING,
        )
    };
    for status in [Status::INPUT_HELD, Status::INPUT_HELD, Status::INPUT_LOST] {
        assert_eq!(held(bad), Command { status, ..good });
    }
    let onward = VehicleState {
        x: backing.x + 0.05,
        ..backing
    };
    assert_eq!(held(onward).status, Status::OK);
    assert_eq!(held(bad).status, Status::INPUT_HELD);
}

#[test]
fn test_step_in_no_time_holds_all_of_the_last_command_then_is_lost() {
    let tracker = stanley(&Vehicle::DEFAULT);
    let (path, mut state) = (straight(), tracker.initial_state());
    let view = path.view();
    let mut step = |dt| {
        let command = tracker.step(&view, &mut state, beside(), dt, Reported::NOTHING);
        (command.unwrap(), state)
    };
    let (good, before) = step(0.05);
    for held in 1..=HOLD_LIMIT + 1 {
        let lost = held > HOLD_LIMIT;
        let status = if lost {
            Status::INPUT_LOST
        } else {
            Status::INPUT_HELD
        };
        let dt = [0.0, -60.0, 2000.0][held % 3];
        let (command, mut state) = step(dt);
        assert_eq!(command, Command { status, ..good });
        assert_eq!(state.held, held);
        state.held = 0;
        assert_eq!(state, before);
    }
    assert_eq!(step(0.05).1.held, 0);
    for dt in [f64::NAN, f64::INFINITY] {
        let (before, mut after) = (state, state);
        let refused = tracker.step(&view, &mut after, beside(), dt, Reported::NOTHING);
        assert_eq!(refused.unwrap_err().field, "dt");
        assert_eq!(after, before);
    }
}

#[test]
fn test_pid_takes_no_drift_at_rest_nor_a_jump_for_the_motion_of_a_period() {
    let law = Tracker::of(Pid::new(Vehicle::DEFAULT, PidParams::DEFAULT).unwrap());
    let path = straight();
    let step = |state: &mut _, y: f64, speed: f64| {
        let (x, yaw) = (5.0, 0.0);
        let vehicle = VehicleState { x, y, yaw, speed };
        law.steer(&path.view(), state, vehicle, 0.05, Reported::NOTHING)
            .unwrap()
    };
    let fresh = step(&mut law.initial_state(), 0.3, 2.0);
    let mut state = law.initial_state();
    step(&mut state, 0.0, 2.0);
    for k in 0..=400 {
        step(&mut state, 0.3 * f64::from(k) / 400.0, 0.0);
    }
    assert!((step(&mut state, 0.3, 2.0) - fresh).abs() < 1e-3);
    let mut state = law.initial_state();
    step(&mut state, 0.0, 2.0);
    law.relocalise(&path.view(), &mut state, 5.0, 0.3, 0.0)
        .unwrap();
    assert!((step(&mut state, 0.3, 2.0) - fresh).abs() < 1e-3);
}

#[test]
fn test_pure_pursuit_keeps_a_circle_within_its_lookahead() {
    let law = Tracker::of(PurePursuit::new(Vehicle::DEFAULT, PurePursuitParams::DEFAULT).unwrap());
    for radius in [3.0, 4.0, 4.9, 10.0] {
        let angles = (0..200).map(|k| PI * f64::from(k) / 100.0);
        let (x, y): (Vec<f64>, Vec<f64>) = angles
            .map(|angle| (radius * angle.sin(), radius * (1.0 - angle.cos())))
            .unzip();
        let path = Path::new(&x, &y, None, true).unwrap();
        let vehicle = VehicleState {
            speed: 2.0,
            ..VehicleState::ORIGIN
        };
        let mut state = law.initial_state();
        let steer = law
            .steer(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING)
            .unwrap();
        let right = (law.vehicle().wheelbase / radius).atan();
        assert!((steer / right - 1.0).abs() < 0.02, "{radius}: {steer}");
    }
}

#[test]
fn test_full_lock_beyond_an_offset_is_the_lock() {
    let vehicle = Vehicle {
        steer_offset: 0.45,
        ..Vehicle::DEFAULT
    };
    let tracker = Tracker::of(PurePursuit::new(vehicle, PurePursuitParams::DEFAULT).unwrap());
    let path = Path::new(&[0.0, 100.0], &[60.0, 60.0], None, false).unwrap();
    let mut state = tracker.state_from(vehicle.max_steer).unwrap();
    let (mut pose, mut wheel) = (VehicleState::ORIGIN, vehicle.at_wheels(1.22 + 0.45));
    pose.speed = 2.0;
    for _ in 0..120 {
        let reported = Reported {
            applied_steer: Some(vehicle.max_steer),
            ..Reported::NOTHING
        };
        let command = tracker
            .step(&path.view(), &mut state, pose, 0.05, reported)
            .unwrap();
        for odd in [Status::IMPLAUSIBLE, Status::OUTLIER] {
            assert!(!command.status.contains(odd), "{command:?}");
        }
        let moved = vehicle.move_wheel(wheel, vehicle.max_steer, 0.05);
        wheel = moved.wheel;
        let curvature = moved.mean.tan() / vehicle.turning_length(2.0);
        pose = popsteer_core::vehicle::bicycle::advance(pose, 0.1, curvature, 0.0);
    }
}
