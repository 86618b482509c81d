use super::*;
use crate::Path;
use crate::math::from_count;
use alloc::vec::Vec;

#[test]
fn test_speed_tracker_parks_a_point_mass_within_a_centimetre() {
    let x: Vec<f64> = (0..201).map(|k| 0.5 * from_count(k)).collect();
    let path = Path::new(&x, &[0.0; 201], None, false).unwrap();
    let tracker = SpeedTracker::new(Vehicle::DEFAULT, SpeedTrackerParams::DEFAULT).unwrap();
    let plan = tracker.plan(&path.view()).unwrap();
    let mut state = SpeedTrackerState::default();
    let mut vehicle = VehicleState {
        x: 0.0,
        y: 0.3,
        yaw: 0.0,
        speed: 0.0,
    };
    let mut standing = false;
    for _ in 0..1200 {
        let command = tracker
            .step(&path.view(), &plan, &mut state, vehicle, 0.05)
            .unwrap();
        standing = command.standing;
        assert!(command.acceleration <= 2.4 && command.acceleration >= -3.4);
        for _ in 0..10 {
            let faster = vehicle.speed + 0.005 * command.acceleration;
            vehicle.speed = if faster > 0.0 { faster } else { 0.0 };
            vehicle.x += 0.005 * vehicle.speed;
        }
    }
    assert!(standing && vehicle.speed < 1e-9, "{vehicle:?}");
    assert!((vehicle.x - 100.0).abs() < 0.05, "{vehicle:?}");
}

#[test]
fn test_speed_tracker_refuses_bad_numbers_and_keeps_its_state() {
    let path = Path::new(&[0.0, 9.0], &[0.0; 2], None, false).unwrap();
    let tracker = SpeedTracker::new(Vehicle::DEFAULT, SpeedTrackerParams::DEFAULT).unwrap();
    let mut state = SpeedTrackerState::default();
    let vehicle = VehicleState {
        x: f64::NAN,
        y: 0.0,
        yaw: 0.0,
        speed: 0.0,
    };
    let refused = tracker.step(&path.view(), &[0.0; 2], &mut state, vehicle, 0.05);
    assert_eq!(refused.unwrap_err().field, "x");
    assert_eq!(state, SpeedTrackerState::default());
    let there = VehicleState::ORIGIN;
    let refused = tracker.step(&path.view(), &[0.0; 2], &mut state, there, f64::NAN);
    assert_eq!(refused.unwrap_err().field, "dt");
    assert_eq!(state, SpeedTrackerState::default());
    let bad = SpeedTrackerParams {
        max_jerk: Some(0.0),
        ..SpeedTrackerParams::DEFAULT
    };
    let refused = SpeedTracker::new(Vehicle::DEFAULT, bad);
    assert_eq!(refused.unwrap_err().field, "max_jerk");
    let lost = SpeedTrackerState {
        waypoint: Some(2),
        ..state
    };
    let refused = tracker.check_state(&path.view(), &lost);
    assert_eq!(refused.unwrap_err().field, "waypoint");
}

#[test]
fn test_speed_tracker_holds_its_command_where_no_time_passes() {
    let path = Path::new(&[0.0, 99.0], &[0.0; 2], None, false).unwrap();
    let tracker = SpeedTracker::new(Vehicle::DEFAULT, SpeedTrackerParams::DEFAULT).unwrap();
    let plan = tracker.plan(&path.view()).unwrap();
    let mut state = SpeedTrackerState::default();
    let mut step = |dt| {
        let command = tracker.step(&path.view(), &plan, &mut state, VehicleState::ORIGIN, dt);
        command.unwrap()
    };
    let first = step(0.0);
    assert!(first.standing && first.acceleration.abs() <= 0.0);
    assert_eq!(first.status, Status::INPUT_HELD);
    let driven = step(0.05);
    assert!(driven.acceleration > 0.1 && driven.status == Status::OK);
    for count in 1..=HOLD_LIMIT + 2 {
        let status = Status::held(count, HOLD_LIMIT);
        let dt = if count % 2 == 0 { -60.0 } else { 2000.0 };
        assert_eq!(step(dt), SpeedCommand { status, ..driven });
    }
    assert_eq!(step(0.05).status, Status::OK);
    assert_eq!(state.held, 0);
    let mut wild = state;
    wild.command.as_mut().unwrap().acceleration = f64::NAN;
    let refused = tracker.check_state(&path.view(), &wild);
    assert_eq!(refused.unwrap_err().field, "command");
}

#[test]
fn test_weak_vehicle_on_a_slope_that_nobody_told_of_climbs_and_does_not_roll_back() {
    let x: Vec<f64> = (0..401).map(from_count).collect();
    let path = Path::new(&x, &[0.0; 401], None, false).unwrap();
    let truck = Vehicle {
        max_acceleration: Some(0.5),
        max_speed: Some(10.0),
        ..Vehicle::DEFAULT
    };
    let tracker = SpeedTracker::new(truck, SpeedTrackerParams::DEFAULT).unwrap();
    let plan = tracker.plan(&path.view()).unwrap();
    let mut vehicle = VehicleState {
        x: 20.0,
        ..VehicleState::ORIGIN
    };
    let mut state = SpeedTrackerState::default();
    let mut least: f64 = 20.0;
    for _ in 0..1200 {
        let command = tracker
            .step(&path.view(), &plan, &mut state, vehicle, 0.05)
            .unwrap();
        for _ in 0..10 {
            vehicle.speed += 0.005 * (command.acceleration - 0.976); // a tenth uphill
            vehicle.x += 0.005 * vehicle.speed;
        }
        least = crate::math::smaller(least, vehicle.x);
    }
    assert!(least > 19.0, "rolled back to {least}");
    assert!(vehicle.speed > 5.0, "{vehicle:?} {state:?}");
}
