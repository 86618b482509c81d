//! What the tracker predicts of a vehicle that goes on.

use popsteer_core::laws::{Pop, PopParams, PreviewPop, PreviewPopParams};
use popsteer_core::tracker::intend::Predicted;
use popsteer_core::{Path, Reported, Tracker, Vehicle, VehicleState};
use std::f64::consts::PI;

#[test]
fn test_prediction_drives_on_to_the_next_stop_either_way() {
    let car = Vehicle {
        steer_lag: 0.0,
        rear_axle: -1.0,
        ..Vehicle::PAPER
    };
    let tracker = Tracker::of(Pop::new(car, PopParams::DEFAULT).unwrap());
    let short = || Path::new(&[0.0, 20.0], &[0.0; 2], None, false).unwrap();
    let backwards = short().with_reverse(&[true; 2]).unwrap();
    for (path, yaw, speed) in [(short(), 0.0, 5.0), (backwards, PI, -5.0)] {
        let mut state = tracker.initial_state();
        // The rear axle is 3 m before the end.
        let vehicle = VehicleState {
            x: 17.0 + yaw.cos(),
            y: 0.0,
            yaw,
            speed,
        };
        let view = path.view();
        tracker
            .step(&view, &mut state, vehicle, 0.1, Reported::NOTHING)
            .unwrap();
        let mut out = [Predicted::DEFAULT; 12];
        assert_eq!(tracker.predict(&view, &state, 0.1, &mut out), Ok(12));
        for (k, instant) in (0..12).zip(&out) {
            let time = 0.1 * f64::from(k);
            let rear = f64::min(17.0 + 5.0 * time, 20.0);
            assert!((instant.time - time).abs() < 1e-12);
            let x = instant.vehicle.x - yaw.cos();
            assert!((x - rear).abs() < 1e-9, "{speed}: {x} at {time}");
            assert!(instant.vehicle.y.abs() < 1e-9 && instant.steer.abs() < 1e-9);
        }
    }
}

#[test]
fn test_prediction_starts_from_the_measured_angle_of_the_wheels() {
    let car = Vehicle {
        steer_lag: 0.15,
        dead_time: 0.2,
        steer_offset: 0.02,
        ..Vehicle::PAPER
    };
    // Nothing is learnt of a vehicle that, here, does not answer.
    let law = Pop::new(car, PopParams::DEFAULT).unwrap();
    let tracker = Tracker::new(law, None).unwrap();
    let path = Path::new(&[0.0, 50.0], &[0.0; 2], None, false).unwrap();
    let view = path.view();
    let vehicle = |k: u32| VehicleState {
        x: 0.5 * f64::from(k),
        y: 1.0,
        yaw: 0.0,
        speed: 5.0,
    };
    let mut state = tracker.initial_state();
    for k in 0..10 {
        tracker
            .step(&view, &mut state, vehicle(k), 0.1, Reported::NOTHING)
            .unwrap();
    }
    let mut modelled = state;
    let without = tracker
        .step(&view, &mut modelled, vehicle(10), 0.1, Reported::NOTHING)
        .unwrap();
    let wheel = modelled.model.in_flight.unwrap().wheel();
    let step_measured = |angle: f64| {
        let reported = Reported {
            measured_steer: Some(angle - car.steer_offset),
            ..Reported::NOTHING
        };
        let mut state = state;
        tracker
            .step(&view, &mut state, vehicle(10), 0.1, reported)
            .unwrap()
            .predicted_cross_track_error
    };
    // Within the dead time the wheels come back to the command: for (0.15 s, 5 m/s) a left angle
    // more of 0.1 rad turns by 5 tan(0.1) / L times 0.15 (1 - exp(-0.2 / 0.15)) s.
    assert!((step_measured(wheel) - without.predicted_cross_track_error).abs() < 1e-12);
    let (left, right) = (step_measured(wheel + 0.1), step_measured(wheel - 0.1));
    let turn = 5.0 * 0.1 / car.wheelbase * 0.15 * (1.0 - (-0.2f64 / 0.15).exp());
    // The tracked front axle goes aside by the turn times its distance, and by the way of the rear.
    let aside = turn * car.wheelbase;
    assert!(
        left - right > 1.6 * aside && left - right < 4.0 * aside,
        "{left} {right}"
    );
}

#[test]
fn test_prediction_of_a_vehicle_that_brakes_to_rest_stays_there_in_both_directions() {
    let tracker =
        Tracker::of(PreviewPop::new(Vehicle::DEFAULT, PreviewPopParams::DEFAULT).unwrap());
    let path = |reverse: bool| {
        let path = Path::new(&[0.0, 200.0], &[0.0, 0.0], None, false).unwrap();
        path.with_reverse(&[reverse; 2]).unwrap()
    };
    for (path, sign, yaw) in [(path(false), 1.0, 0.0), (path(true), -1.0, PI)] {
        let mut state = tracker.initial_state();
        let (mut x, mut speed) = (20.0, 4.0);
        for _ in 0..30 {
            let vehicle = VehicleState {
                x,
                y: 0.0,
                yaw,
                speed: sign * speed,
            };
            tracker
                .step(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING)
                .unwrap();
            x += 0.05 * speed;
            speed -= 0.1;
        }
        let mut instants = [Predicted::DEFAULT; 60];
        tracker
            .predict(&path.view(), &state, 0.05, &mut instants)
            .unwrap();
        for instant in &instants {
            assert!(sign * instant.vehicle.speed >= 0.0, "{sign}: {instant:?}");
        }
        assert!(instants[59].vehicle.speed.abs() <= 0.0);
    }
}
