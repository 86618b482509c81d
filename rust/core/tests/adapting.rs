//! What controllers estimate of their vehicle in the closed loop: forwards, backwards, across cusps,
//! through held input and after a hand-over.

use std::f64::consts::PI;

use popsteer_core::laws::{PreviewPop, PreviewPopParams, PreviewPopState, Stanley, StanleyParams};
use popsteer_core::tracker::TrackerState;
use popsteer_core::vehicle::bicycle::advance;
use popsteer_core::vehicle::{AdaptParams, Estimate, InFlight};
use popsteer_core::{LateralLaw, Path, Reported, Tracker, Vehicle, VehicleState};

/// S-bends of at least 20 m radius, driven forwards or backwards.
fn bends(reverse: bool) -> Path {
    let x: Vec<f64> = (0..800).map(|n| 0.5 * f64::from(n)).collect();
    let y: Vec<f64> = x.iter().map(|x| 5.0 * (x / 10.0).sin()).collect();
    let path = Path::new(&x, &y, None, false).unwrap();
    if reverse {
        path.with_reverse(&vec![true; x.len()]).unwrap()
    } else {
        path
    }
}

/// Lets `tracker` drive `real` along the bends for `steps` of 50 ms; what it knows then, and the
/// mean error of the last quarter [m].
fn drive<L: LateralLaw>(
    tracker: &Tracker<L>,
    real: &Vehicle,
    reverse: bool,
    steps: u32,
) -> (Estimate, f64) {
    let path = bends(reverse);
    let mut state = tracker.initial_state();
    let mut in_flight = InFlight::settled(real, 0.0);
    let (yaw, speed) = if reverse {
        (PI + 0.4, -5.0)
    } else {
        (0.4, 5.0)
    };
    let mut vehicle = VehicleState {
        x: 5.0,
        y: 2.5,
        yaw,
        speed,
    };
    let (mut sum, mut count) = (0.0, 0.0);
    for step in 0..steps {
        let command = tracker
            .step(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING)
            .unwrap();
        if step > steps - steps / 4 {
            sum += command.cross_track_error.abs();
            count += 1.0;
        }
        for _ in 0..10 {
            in_flight.elapse(real, command.steer, 0.005, 0.0);
            let curvature = in_flight.wheel().tan() / real.turning_length(speed);
            let moved = advance(vehicle.ahead(real.no_slip()), speed * 0.005, curvature, 0.0);
            vehicle = moved.ahead(-real.no_slip());
        }
    }
    (tracker.estimate(&state), sum / count)
}

fn preview(vehicle: &Vehicle) -> Tracker<PreviewPop> {
    Tracker::of(PreviewPop::new(*vehicle, PreviewPopParams::DEFAULT).unwrap())
}

#[test]
fn test_turning_is_estimated_alike_forwards_and_backwards() {
    let given = Vehicle {
        dead_time: 0.1,
        ..Vehicle::PAPER
    };
    let real = Vehicle {
        turning_wheelbase: Some(3.3),
        steer_offset: 1_f64.to_radians(),
        ..given
    };
    for reverse in [false, true] {
        let (known, error) = drive(&preview(&given), &real, reverse, 1200);
        assert!(
            (known.gain - 3.0 / 3.3).abs() < 0.02,
            "{reverse}: {known:?}"
        );
        let offset = (known.steer_offset - real.steer_offset).to_degrees();
        assert!(offset.abs() < 0.1, "{reverse}: {known:?}");
        assert!(error < 0.02, "{reverse}: {error}");
    }
}

#[test]
fn test_slip_is_estimated_alike_forwards_and_backwards() {
    // The point that does not slip lies half a metre ahead of the one that is believed not to.
    let given = Vehicle {
        no_slip_point: Some(0.0),
        ..Vehicle::PAPER
    };
    let real = Vehicle {
        no_slip_point: Some(0.5),
        ..given
    };
    for reverse in [false, true] {
        let (known, error) = drive(&preview(&given), &real, reverse, 1200);
        assert!(
            (known.slip_length + 0.5).abs() < 0.1,
            "{reverse}: {known:?}"
        );
        assert!(known.slip.abs() < 0.005, "{reverse}: {known:?}");
        assert!(error < 0.03, "{reverse}: {error}");
        // Without an estimate it stays off the path.
        let law = PreviewPop::new(given, PreviewPopParams::DEFAULT).unwrap();
        let (_, blind) = drive(&Tracker::new(law, None).unwrap(), &real, reverse, 1200);
        assert!(blind > 2.0 * error, "{reverse}: {blind} {error}");
    }
}

/// 20 m forward along x and back again, the vehicle driving; the state half a metre before the
/// cusp.
fn before_the_cusp(tracker: &Tracker<PreviewPop>) -> (Path, TrackerState<PreviewPopState>) {
    let x: Vec<f64> = (0..=20).chain((0..20).rev()).map(f64::from).collect();
    let back: Vec<bool> = (0..x.len()).map(|n| n >= 20).collect();
    let path = Path::new(&x, &vec![0.0; x.len()], None, false).unwrap();
    let path = path.with_reverse(&back).unwrap();
    let mut state = tracker.initial_state();
    for n in 0..46_u32 {
        let here = VehicleState {
            x: 0.5 * f64::from(n) - 3.0,
            y: 0.0,
            yaw: 0.0,
            speed: 10.0,
        };
        tracker
            .step(&path.view(), &mut state, here, 0.05, Reported::NOTHING)
            .unwrap();
    }
    (path, state)
}

#[test]
fn test_nothing_is_estimated_across_a_cusp() {
    let law = PreviewPop::new(Vehicle::PAPER, PreviewPopParams::DEFAULT).unwrap();
    let tracker = Tracker::new(law, Some(AdaptParams::DEFAULT)).unwrap();
    let (path, mut state) = before_the_cusp(&tracker);
    let before = tracker.estimate(&state);
    // On the other side of the cusp, rolling back, and half a metre aside.
    let beyond = VehicleState {
        x: 20.0,
        y: 0.5,
        yaw: 0.0,
        speed: -1.0,
    };
    let command = tracker
        .step(&path.view(), &mut state, beyond, 0.05, Reported::NOTHING)
        .unwrap();
    assert!(command.reverse);
    let after = tracker.estimate(&state);
    assert_eq!(
        (after.slip, after.slip_length),
        (before.slip, before.slip_length)
    );
}

#[test]
fn test_nothing_is_estimated_from_the_motion_through_held_input() {
    let path = bends(false);
    let tracker = preview(&Vehicle::PAPER);
    let mut state = tracker.initial_state();
    let at = |x: f64| VehicleState {
        x,
        y: 5.0 * (x / 10.0).sin(),
        yaw: (0.5 * (x / 10.0).cos()).atan(),
        speed: 10.0,
    };
    for n in 0..20_u32 {
        let here = at(5.0 + 0.4 * f64::from(n));
        tracker
            .step(&path.view(), &mut state, here, 0.05, Reported::NOTHING)
            .unwrap();
    }
    let before = tracker.estimate(&state);
    let lost = VehicleState {
        x: f64::NAN,
        ..at(0.0)
    };
    for _ in 0..20 {
        tracker.step_or_hold(&path.view(), &mut state, lost, 0.05, 20, Reported::NOTHING);
    }
    // More than a second later the vehicle looks elsewhere and rolls slower.
    let seen = VehicleState {
        speed: 2.0,
        ..at(18.0)
    };
    tracker
        .step(&path.view(), &mut state, seen, 0.05, Reported::NOTHING)
        .unwrap();
    let after = tracker.estimate(&state);
    // Of an acceleration that is measured no more nothing is left.
    assert!(after.acceleration.abs() <= 0.01 * before.acceleration.abs());
    let acceleration = after.acceleration;
    assert_eq!(
        after,
        Estimate {
            acceleration,
            ..before
        }
    );
}

#[test]
fn test_a_vehicle_taken_over_in_a_bend_is_known_to_turn() {
    // Wheels that were settled straight would seem not to turn the vehicle, which does turn.
    let car = Vehicle {
        dead_time: 0.2,
        steer_offset: 0.01,
        ..Vehicle::PAPER
    };
    let path = bends(false);
    let law = Stanley::new(car, StanleyParams::DEFAULT).unwrap();
    let tracker = Tracker::new(law, Some(AdaptParams::DEFAULT)).unwrap();
    let mut state = tracker.state_from(0.3).unwrap();
    let mut vehicle = VehicleState {
        x: 5.0,
        y: 2.5,
        yaw: 0.4,
        speed: 5.0,
    };
    for _ in 0..4 {
        tracker
            .step(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING)
            .unwrap();
        vehicle = advance(vehicle, 0.25, 0.31_f64.tan() / 3.0, 0.0);
    }
    let known = tracker.estimate(&state);
    assert!((known.gain - 1.0).abs() < 1e-6, "{known:?}");
    assert!(known.steer_offset.abs() < 1e-6, "{known:?}");
}

#[test]
fn test_motion_of_a_period_counts_up_to_a_second() {
    for (dt, counts) in [(0.25, true), (0.99, true), (1.01, false)] {
        let path = bends(false);
        let tracker = preview(&Vehicle::PAPER);
        let mut state = tracker.initial_state();
        let mut x = 5.0;
        // Of how much is noise so few speeds say little.
        for k in 0..6_u32 {
            let speed = 1.0 + 2.0 * f64::from(k) * dt;
            x += (speed - dt) * dt * 0.4_f64.cos();
            let vehicle = VehicleState {
                x,
                y: 2.5 + (x - 5.0) * 0.4_f64.tan(),
                yaw: 0.4,
                speed,
            };
            tracker
                .step(&path.view(), &mut state, vehicle, dt, Reported::NOTHING)
                .unwrap();
        }
        let gains = tracker.estimate(&state).acceleration > 0.0;
        assert_eq!(gains, counts, "{dt}");
    }
}
