//! Places on a lap: segments, sections, speeds and stops, also across the seam.

use popsteer_core::lateral::{Stanley, StanleyParams};
use popsteer_core::longitudinal::{SpeedTracker, SpeedTrackerParams, SpeedTrackerState};
use popsteer_core::{Path, Tracker, Vehicle, VehicleState};

/// A square of 40 m, a waypoint each metre; at waypoint `k` a speed of `1 + k / 10` m/s.
fn square() -> Path {
    let side = |k: u32| f64::from(k % 40);
    let (x, y): (Vec<f64>, Vec<f64>) = (0..160)
        .map(|k| match k / 40 {
            0 => (side(k), 0.0),
            1 => (40.0, side(k)),
            2 => (40.0 - side(k), 40.0),
            _ => (0.0, 40.0 - side(k)),
        })
        .unzip();
    let speed: Vec<f64> = (0..160).map(|k| 1.0 + 0.1 * f64::from(k)).collect();
    Path::new(&x, &y, Some(&speed), true).unwrap()
}

/// Backwards from waypoint 20 to 100.
fn with_cusps() -> Path {
    let reverse: Vec<bool> = (0..160).map(|k| (20..100).contains(&k)).collect();
    square().with_reverse(&reverse).unwrap()
}

fn close(number: f64, expected: f64) -> bool {
    (number - expected).abs() < 1e-9
}

#[test]
fn test_segments_of_a_lap_are_a_metre_each_and_the_last_ends_it() {
    let path = square();
    let view = path.view();
    assert!(close(view.length(), 160.0) && view.segments() == 160);
    for (k, arc) in (0..160).zip(view.s()) {
        assert!(close(*arc, f64::from(k)), "{k}");
        assert_eq!(view.section_end(usize::try_from(k).unwrap()), None);
    }
    let reverse = vec![true; 160];
    assert!(view.with_reverse(&reverse).unwrap().is_reverse(7) && !view.is_reverse(7));
    let cusps = with_cusps();
    for (segment, end) in [(0, 19), (19, 19), (20, 99), (99, 99), (100, 19), (159, 19)] {
        assert_eq!(cusps.view().section_end(segment), Some(end), "{segment}");
    }
    let (x, y) = ([0.0, 1.0, 2.0], [0.0; 3]);
    let open = Path::new(&x, &y, None, false).unwrap();
    assert_eq!(open.view().section_end(0), Some(1));
    let turns = open.with_reverse(&[false, true, true]).unwrap();
    assert_eq!(turns.view().section_end(0), Some(0));
    assert_eq!(turns.view().section_end(1), Some(1));
}

#[test]
fn test_speed_is_that_beside_the_rear_axle_also_before_the_seam() {
    let path = square();
    let law = Stanley::new(Vehicle::PAPER, StanleyParams::DEFAULT).unwrap();
    let tracker = Tracker::of(law);
    // The rear axle at these arcs, the front axle 3 m ahead on the same side of the square.
    for (x, y, yaw, arc) in [(10.5, 0.0, 0.0, 10.5), (0.0, 30.25, -1.0, 129.75_f64)] {
        let vehicle = VehicleState {
            x,
            y,
            yaw: yaw * std::f64::consts::FRAC_PI_2,
            speed: 1.0,
        };
        let mut state = tracker.initial_state();
        let command = tracker
            .step(&path.view(), &mut state, vehicle, 0.05)
            .unwrap();
        // Squares of the speeds are linear between waypoints.
        let squared = |k: f64| (1.0 + 0.1 * k).powi(2);
        let (before, share) = (arc.floor(), arc - arc.floor());
        let expected = squared(before) * (1.0 - share) + squared(before + 1.0) * share;
        let found = command.reference_speed.unwrap();
        assert!(close(found, expected.sqrt()), "{found} at {arc}");
        assert!(command.distance_to_stop.is_infinite());
    }
}

/// From where the wheels are forwards again, at 100 m, across the seam to the cusp at 20 m.
#[test]
fn test_stop_lies_across_the_seam() {
    let path = with_cusps();
    let car = Vehicle {
        steer_lag: 0.0,
        ..Vehicle::PAPER
    };
    let tracker = SpeedTracker::new(car, SpeedTrackerParams::DEFAULT).unwrap();
    let plan = tracker.plan(&path.view()).unwrap();
    assert!(plan[20] <= 0.0 && plan[100] <= 0.0 && plan[10] > 0.0 && plan[0] > 0.0);
    let steering = Tracker::of(Stanley::new(car, StanleyParams::DEFAULT).unwrap());
    for (x, y, yaw, left, reverse) in [
        (0.0, 30.0, -1.0, 50.0, false),
        (0.0, 10.5, -1.0, 30.5, false),
        (5.0, 0.0, 0.0, 15.0, false),
        (30.0, 0.0, 2.0, 70.0, true),
    ] {
        let vehicle = VehicleState {
            x,
            y,
            yaw: yaw * std::f64::consts::FRAC_PI_2,
            speed: 0.0,
        };
        let mut state = SpeedTrackerState::default();
        let command = tracker
            .step(&path.view(), &plan, &mut state, vehicle, 0.05)
            .unwrap();
        assert!(close(command.distance_to_stop, left), "{command:?}");
        assert_eq!(command.reverse, reverse);
        let mut state = steering.initial_state();
        let command = steering
            .step(&path.view(), &mut state, vehicle, 0.05)
            .unwrap();
        assert!(close(command.distance_to_stop, left), "{command:?}");
        assert_eq!(command.reverse, reverse);
    }
}

/// What a step told of the path ahead is checked with a state that is restored.
#[test]
fn test_answer_of_no_path_is_refused() {
    let path = square();
    let law = Stanley::new(Vehicle::PAPER, StanleyParams::DEFAULT).unwrap();
    let tracker = Tracker::of(law);
    let mut state = tracker.initial_state();
    let vehicle = VehicleState {
        x: 10.0,
        y: 0.0,
        yaw: 0.0,
        speed: 1.0,
    };
    tracker
        .step(&path.view(), &mut state, vehicle, 0.05)
        .unwrap();
    let mut check = |speed: Option<f64>, distance: f64| {
        let answer = state.answer.as_mut().unwrap();
        answer.ahead.reference_speed = speed;
        answer.ahead.distance_to_stop = distance;
        tracker.check_state(&path.view(), &state).is_ok()
    };
    assert!(check(None, f64::INFINITY) && check(Some(-1.9e4), -3.0));
    for speed in [f64::NAN, 2.1e4, -2.1e4] {
        assert!(!check(Some(speed), 1.0), "{speed}");
    }
    for distance in [f64::NAN, f64::NEG_INFINITY, 2e18] {
        assert!(!check(None, distance), "{distance}");
    }
}
