//! Places on a lap: segments, sections, speeds and stops, also across the seam.

use popsteer_core::laws::{Stanley, StanleyParams};
use popsteer_core::path::follow::Follow;
use popsteer_core::path::preview::Preview;
use popsteer_core::path::stop::Ahead;
use popsteer_core::speed::{SpeedTracker, SpeedTrackerParams, SpeedTrackerState};
use popsteer_core::{Path, Reported, Tracker, Vehicle, VehicleState};

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
            .step(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING)
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
            .step(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING)
            .unwrap();
        assert!(close(command.distance_to_stop, left), "{command:?}");
        assert_eq!(command.reverse, reverse);
    }
}

/// What a step answers of the path ahead is checked with a state that is restored.
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
        .step(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING)
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

/// What `Ahead` says `lead` behind the point of the square at `arc`.
fn ahead(path: &Path, arc: f64, lead: f64) -> Ahead {
    let (side, along) = ((arc / 40.0).floor(), arc % 40.0);
    let (x, y) = match arc {
        0.0..40.0 => (along, 0.0),
        40.0..80.0 => (40.0, along),
        80.0..120.0 => (40.0 - along, 40.0),
        _ => (0.0, 40.0 - along),
    };
    let waypoint = (0..160_u32).rfind(|&k| f64::from(k) <= arc).unwrap();
    let waypoint = usize::try_from(waypoint).unwrap();
    let backwards = path.view().is_reverse(waypoint);
    let quarters = if backwards { side + 2.0 } else { side };
    let vehicle = VehicleState {
        x,
        y,
        yaw: quarters * std::f64::consts::FRAC_PI_2,
        speed: if backwards { -1.0 } else { 1.0 },
    };
    let follow = Follow::of(&Vehicle::PAPER, 0.0, 0.0);
    let at = follow.locate(&path.view(), Some(waypoint), vehicle, 0.05);
    assert_eq!((at.closest.segment, at.reverse), (waypoint, backwards));
    Ahead::behind(&path.view(), &follow, &at, lead)
}

#[test]
fn test_speed_and_stop_are_those_across_the_seam() {
    let path = square();
    for (arc, lead, waypoint) in [
        (1.0, 4.0, 157.0),
        (2.5, 5.5, 157.0),
        (157.0, -4.0, 1.0),
        (158.5, -3.5, 2.0),
        (30.0, 4.0, 26.0),
        (30.0, -4.0, 34.0),
    ] {
        let found = ahead(&path, arc, lead);
        let speed = found.reference_speed.unwrap();
        assert!(close(speed, 1.0 + 0.1 * waypoint), "{speed} at {arc}");
        assert!(found.distance_to_stop.is_infinite());
    }
}

/// The tracked point decides which section the vehicle is in, whatever the rear axle is beside.
#[test]
fn test_speed_and_stop_are_those_of_the_section_also_beyond_its_ends() {
    let path = with_cusps();
    for (arc, lead, speed, distance) in [
        (22.5, 5.0, -3.0, 82.5),
        (22.5, 1.5, -3.1, 79.0),
        (97.5, -5.0, -11.0, -2.5),
        (101.5, 4.0, 11.0, 82.5),
        (17.5, -4.5, 3.0, -2.0),
    ] {
        let found = ahead(&path, arc, lead);
        let here = found.reference_speed.unwrap();
        assert!(close(found.distance_to_stop, distance), "{arc} {lead}");
        assert!(close(here, speed), "{here} at {arc} {lead}");
    }
}

#[test]
fn test_stop_is_the_rear_axles_whatever_the_vehicle_is_mirrored_about() {
    let path = Path::new(&[0.0, 30.0], &[0.0; 2], None, false).unwrap();
    let car = Vehicle {
        rear_axle: -1.0,
        ..Vehicle::PAPER
    };
    for base in [-1.0, 0.0, 1.5] {
        let follow = Follow::of(&car, base, 2.0);
        let vehicle = VehicleState {
            x: 10.0,
            y: 0.0,
            yaw: 0.0,
            speed: 1.0,
        };
        let at = follow.locate(&path.view(), None, vehicle, 0.05);
        let found = Ahead::of(&path.view(), &follow, &at);
        assert!(close(found.distance_to_stop, 21.0), "{base} {found:?}");
    }
}

/// On a loop of few waypoints a chord reaches a quarter of the loop each way, not a segment.
#[test]
fn test_chord_reaches_a_quarter_of_a_short_loop() {
    let path = Path::new(&[0.0, 12.0, 6.0], &[0.0, 0.0, 8.0], None, true).unwrap();
    let view = path.view();
    // 8 m behind and ahead of each place on a lap of 32 m.
    for (arc, segment, (x, y)) in [
        (3.0, 0, (8.0, -4.0)),
        (9.0, 0, (8.0, 4.0)),
        // The chord of the corner is shorter than its reach: the segment counts.
        (17.0, 1, (-6.0, 8.0)),
    ] {
        let yaw = Preview::new(&view, 4.0, segment, arc, 0.0).path_yaw(arc);
        assert!(close(yaw, f64::atan2(y, x)), "{arc}");
    }
}
