//! What the monitor says of a vehicle beside its path, and of one that turns otherwise than commanded.

use popsteer_core::laws::{Stanley, StanleyParams};
use popsteer_core::tracker::MonitorParams;
use popsteer_core::{Path, Status, Tracker, Vehicle, VehicleState};

const DT: f64 = 0.05;

fn straight(yaw: f64) -> Path {
    let x = [-100.0 * yaw.cos(), 500.0 * yaw.cos()];
    let y = [-100.0 * yaw.sin(), 500.0 * yaw.sin()];
    Path::new(&x, &y, None, false).unwrap()
}

fn tracker(car: Vehicle, params: MonitorParams) -> Tracker<Stanley> {
    let law = Stanley::new(car, StanleyParams::DEFAULT).unwrap();
    Tracker::of(law).monitored(Some(params)).unwrap()
}

/// Whether it deviates, at each of these distances to the left of its path.
fn deviates(params: MonitorParams, places: &[f64]) -> Vec<bool> {
    let tracker = tracker(Vehicle::PAPER, params);
    let path = straight(0.0);
    let mut state = tracker.initial_state();
    let at = |&y: &f64| {
        let vehicle = VehicleState {
            x: 0.0,
            y,
            yaw: 0.0,
            speed: 1.0,
        };
        let command = tracker.step(&path.view(), &mut state, vehicle, DT);
        command.unwrap().status.contains(Status::DEVIATING)
    };
    places.iter().map(at).collect()
}

#[test]
fn test_vehicle_deviates_beyond_the_limit_once_it_was_within() {
    // Half a wheelbase by default.
    for side in [1.0, -1.0] {
        let places = [2.0, 1.6, 1.4, 1.6, 2.0, 1.4, 1.6].map(|y| side * y);
        let expected = [false, false, false, true, true, false, true];
        assert_eq!(deviates(MonitorParams::DEFAULT, &places), expected);
    }
    let narrow = MonitorParams {
        deviation_limit: Some(0.2),
        ..MonitorParams::DEFAULT
    };
    assert_eq!(deviates(narrow, &[0.1, 0.3, -0.3]), [false, true, true]);
    let bad = MonitorParams {
        deviation_limit: Some(-1.0),
        ..MonitorParams::DEFAULT
    };
    let law = Stanley::new(Vehicle::PAPER, StanleyParams::DEFAULT).unwrap();
    let refused = Tracker::of(law).monitored(Some(bad)).unwrap_err();
    assert_eq!(refused.field, "deviation_limit");
}

/// Which of the steps are implausible, of a vehicle that drives straight on, `left` of its path.
fn implausible(yaw: f64, left: f64, dt: f64, steps: u32, alarm: Option<f64>) -> Vec<bool> {
    let tracker = tracker(Vehicle::PAPER, MonitorParams::DEFAULT);
    let path = straight(yaw);
    let mut state = tracker.initial_state();
    let mut all = Vec::new();
    for k in 0..steps {
        let along = 5.0 * dt * f64::from(k);
        let vehicle = VehicleState {
            x: along * yaw.cos() - left * yaw.sin(),
            y: along * yaw.sin() + left * yaw.cos(),
            yaw,
            speed: 5.0,
        };
        let command = tracker.step(&path.view(), &mut state, vehicle, dt).unwrap();
        all.push(command.status.contains(Status::IMPLAUSIBLE));
        if let (0, Some(alarm), Some(monitor)) = (k, alarm, &mut state.monitor) {
            monitor.alarm = alarm;
        }
    }
    all
}

#[test]
fn test_wheels_that_stick_are_implausible_and_straight_driving_is_not() {
    for yaw in [0.0, 2.0, std::f64::consts::PI, -1.0] {
        assert!(
            implausible(yaw, 0.0, DT, 60, None)
                .iter()
                .all(|&said| !said)
        );
        for left in [0.5, -0.5] {
            let said = implausible(yaw, left, DT, 60, None);
            // Not at once: noise is measured first. From then on.
            assert!(said.iter().take(3).all(|&said| !said), "{said:?}");
            assert!(said.iter().skip(20).all(|&said| said), "{said:?}");
        }
    }
    // Too much happens in a long period.
    assert!(
        implausible(0.0, 0.5, 0.4, 20, None)
            .iter()
            .all(|&said| !said)
    );
}

#[test]
fn test_implausible_lasts_for_the_time_of_its_alarm() {
    let said = implausible(2.0, 0.0, DT, 60, Some(1.025));
    let expected: Vec<bool> = (0..60).map(|k| (1..=20).contains(&k)).collect();
    assert_eq!(said, expected);
}

#[test]
fn test_modelled_wheels_begin_where_they_stand_at_the_command_0() {
    let car = Vehicle {
        steer_offset: 0.1,
        steer_lag: 10.0,
        ..Vehicle::PAPER
    };
    let tracker = tracker(car, MonitorParams::DEFAULT);
    let mut state = tracker.initial_state();
    let vehicle = VehicleState {
        x: 0.0,
        y: 0.0,
        yaw: 0.0,
        speed: 5.0,
    };
    tracker
        .step(&straight(0.0).view(), &mut state, vehicle, DT)
        .unwrap();
    let wheel = state.monitor.unwrap().wheel;
    assert!((wheel - 0.1).abs() < 1e-3, "{wheel}");
}

/// 20 m forwards along x, and back on a line `aside` to the left.
fn shuttle(aside: f64) -> Path {
    let (x, y) = ([0.0, 20.0, 0.0], [0.0, 0.0, aside]);
    let path = Path::new(&x, &y, None, false).unwrap();
    path.with_reverse(&[false, true, true]).unwrap()
}

#[test]
fn test_vehicle_that_deviates_at_a_cusp_deviates_after_it() {
    let car = Vehicle {
        rear_axle: 0.0,
        ..Vehicle::PAPER
    };
    for (left, expected) in [
        (1.8, [false, true, true, true, true]),
        (-1.8, [false, true, true, true, true]),
        (1.2, [false; 5]),
    ] {
        let tracker = tracker(car, MonitorParams::DEFAULT);
        let path = shuttle(0.01);
        let mut state = tracker.initial_state();
        let places = [
            (10.0, 0.0, 1.0),
            (15.0, left, 1.0),
            (19.9, left, 1.0),
            (19.8, left, -1.0),
            (15.0, left, -1.0),
        ];
        let found = places.map(|(x, y, speed)| {
            let yaw = 0.0;
            let vehicle = VehicleState { x, y, yaw, speed };
            let command = tracker.step(&path.view(), &mut state, vehicle, DT);
            command.unwrap().status.contains(Status::DEVIATING)
        });
        assert_eq!(found, expected, "{left}");
    }
}
