//! The trajectory that a controller intends, by hand.

use popsteer_core::laws::{Pop, PopParams};
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
    let straight = || Path::new(&[0.0, 20.0], &[0.0; 2], None, false).unwrap();
    let backwards = straight().with_reverse(&[true; 2]).unwrap();
    for (path, yaw, speed) in [(straight(), 0.0, 5.0), (backwards, PI, -5.0)] {
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
