//! A vehicle k times as large, on a path k times as large, steers by the same angles: every default
//! length, speed and gain per metre scales with the wheelbase, the estimates included.

use popsteer_core::laws::{
    Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams, PurePursuit, PurePursuitParams,
    Stanley, StanleyParams,
};
use popsteer_core::path::Follow;
use popsteer_core::speed::{Phase, SpeedTracker, SpeedTrackerParams, SpeedTrackerState};
use popsteer_core::vehicle::{AdaptParams, InFlight};
use popsteer_core::{LateralLaw, Path, Reported, Tracker, Vehicle, VehicleState};

/// A car whose every length is `k` times the usual one.
fn car(k: f64) -> Vehicle {
    Vehicle {
        wheelbase: 2.7 * k,
        rear_axle: -1.3 * k,
        no_slip_point: Some(-1.1 * k),
        turning_wheelbase: Some(2.8 * k),
        understeer: 0.004 / k,
        steer_offset: 0.01,
        steer_lag: 0.12,
        dead_time: 0.15,
        max_steer: 0.6,
        max_steer_rate: Some(0.7),
        max_lateral_acceleration: Some(5.0 * k),
        max_deceleration: Some(3.0 * k),
        ..Vehicle::DEFAULT
    }
}

/// The angles and errors of a run of 1,000 steps beside S-bends that cross themselves, by a vehicle
/// that turns 8 % less than is believed, has 1 degree of offset and slips.
fn drive<L: LateralLaw>(k: f64, make: impl Fn(Vehicle) -> L) -> (Vec<f64>, Vec<f64>) {
    let points = 900;
    let waypoint = |n: u32| {
        let t = f64::from(n) * 0.02;
        (60.0 * k * t.sin(), 25.0 * k * (2.0 * t).sin())
    };
    let (x, y): (Vec<f64>, Vec<f64>) = (0..points).map(waypoint).unzip();
    let path = Path::new(&x, &y, None, false).unwrap();
    let tracker = Tracker::new(make(car(k)), Some(AdaptParams::DEFAULT)).unwrap();
    let real = Vehicle {
        turning_wheelbase: Some(3.0 * k),
        steer_offset: 0.027,
        ..car(k)
    };
    let mut in_flight = InFlight::settled(&real, 0.0);
    let mut state = tracker.initial_state();
    let mut vehicle = VehicleState {
        x: 0.0,
        y: 1.0 * k,
        yaw: 0.8,
        speed: 8.0 * k,
    };
    let (mut angles, mut errors) = (Vec::new(), Vec::new());
    for step in 0..1000_u32 {
        let command = tracker
            .step(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING)
            .unwrap();
        angles.push(command.steer);
        errors.push(command.cross_track_error);
        for _ in 0..5 {
            in_flight.elapse(&real, command.steer, 0.01, 0.0);
            let curvature = in_flight.wheel().tan() / real.turning_length(vehicle.speed);
            let moved = vehicle.ahead(real.no_slip());
            let slip = 0.01 - 0.1 * k * curvature;
            let moved = popsteer_core::vehicle::bicycle::advance(
                moved,
                vehicle.speed * 0.01,
                curvature,
                slip,
            );
            vehicle = moved.ahead(-real.no_slip());
        }
        vehicle.speed = k * (8.0 + 3.0 * (f64::from(step) * 0.01).sin());
    }
    (angles, errors)
}

fn assert_scales<L: LateralLaw>(name: &str, make: impl Fn(Vehicle) -> L) {
    let (angles, errors) = drive(1.0, &make);
    let (doubled, doubled_errors) = drive(2.0, &make);
    for (step, (a, b)) in angles.iter().zip(&doubled).enumerate() {
        assert_eq!(a.to_bits(), b.to_bits(), "{name}: step {step}: {a} {b}");
    }
    for (a, b) in errors.iter().zip(&doubled_errors) {
        assert_eq!((2.0 * a).to_bits(), b.to_bits(), "{name}");
    }
    for k in [0.1, 10.0] {
        let (others, other_errors) = drive(k, &make);
        for (step, (a, b)) in angles.iter().zip(&others).enumerate() {
            assert!((a - b).abs() < 1e-9, "{name}, {k}: step {step}: {a} {b}");
        }
        for (a, b) in errors.iter().zip(&other_errors) {
            assert!(
                (k * a - b).abs() < 1e-9 * k.max(1.0),
                "{name}, {k}: {a} {b}"
            );
        }
    }
}

#[test]
fn test_preview_pop_scales_with_its_vehicle() {
    assert_scales("preview POP", |vehicle| {
        PreviewPop::new(vehicle, PreviewPopParams::DEFAULT).unwrap()
    });
}

#[test]
fn test_pop_scales_with_its_vehicle() {
    assert_scales("POP", |vehicle| {
        Pop::new(vehicle, PopParams::DEFAULT).unwrap()
    });
}

#[test]
fn test_pop_of_the_paper_scales_with_its_vehicle() {
    assert_scales("POP, the paper's search", |vehicle| {
        let params = PopParams {
            exact_lookahead: false,
            ..PopParams::DEFAULT
        };
        Pop::new(vehicle, params).unwrap()
    });
}

#[test]
fn test_pure_pursuit_scales_with_its_vehicle() {
    assert_scales("pure pursuit", |vehicle| {
        PurePursuit::new(vehicle, PurePursuitParams::DEFAULT).unwrap()
    });
}

#[test]
fn test_stanley_scales_with_its_vehicle() {
    assert_scales("Stanley", |vehicle| {
        Stanley::new(vehicle, StanleyParams::DEFAULT).unwrap()
    });
}

#[test]
fn test_pid_scales_with_its_vehicle() {
    assert_scales("PID", |vehicle| {
        Pid::new(vehicle, PidParams::DEFAULT).unwrap()
    });
}

/// The commands of a drive to the end of S-bends, every length and limit `k` times the usual one.
fn keep_speed(k: f64) -> (Vec<f64>, Vec<f64>) {
    let waypoint = |n: u32| {
        (
            0.5 * k * f64::from(n),
            8.0 * k * (0.03 * f64::from(n)).sin(),
        )
    };
    let (x, y): (Vec<f64>, Vec<f64>) = (0..300).map(waypoint).unzip();
    let path = Path::new(&x, &y, None, false).unwrap();
    let car = Vehicle {
        max_speed: Some(20.0 * k),
        max_acceleration: Some(2.0 * k),
        max_deceleration: Some(3.0 * k),
        brake_deceleration: Some(6.0 * k),
        drive_lag: 0.2,
        ..car(k)
    };
    let params = SpeedTrackerParams {
        max_jerk: Some(20.0 * k),
        reserve: 0.4 * k,
        ..SpeedTrackerParams::DEFAULT
    };
    let tracker = SpeedTracker::new(car, params).unwrap();
    let plan = tracker.plan(&path.view()).unwrap();
    let mut state = SpeedTrackerState::default();
    let (mut along, mut speed, mut pull) = (0.0, 0.0, 0.0);
    let mut commands = Vec::new();
    for _ in 0..600 {
        let place = along / path.view().length() * 299.0;
        let at = f64::from(299).min(place);
        let vehicle = VehicleState {
            x: 0.5 * k * at + 1.3 * k,
            y: 8.0 * k * (0.03 * at).sin(),
            yaw: (0.48 * (0.03 * at).cos()).atan(),
            speed,
        };
        let command = tracker
            .step(&path.view(), &plan, &mut state, vehicle, 0.05)
            .unwrap();
        if command.phase == Phase::Stopping {
            break;
        }
        commands.push(command.acceleration);
        pull += (command.acceleration - pull) * 0.2;
        speed = (speed + 0.05 * pull).max(0.0);
        along += 0.05 * speed;
    }
    (plan, commands)
}

#[test]
fn test_speed_tracker_scales_with_its_vehicle() {
    // A stop has the noise of the world in it, which does not scale.
    let (plan, commands) = keep_speed(1.0);
    let (doubled_plan, doubled) = keep_speed(2.0);
    for (a, b) in plan.iter().zip(&doubled_plan) {
        assert_eq!((2.0 * a).to_bits(), b.to_bits(), "plan: {a} {b}");
    }
    assert!(commands.iter().any(|&pull| pull < -1.0));
    for (step, (a, b)) in commands.iter().zip(&doubled).enumerate() {
        // A power of 1/3 is rounded.
        assert!((2.0 * a - b).abs() < 1e-9, "step {step}: {a} {b}");
    }
}

/// What the documentation says of each default, at the paper's wheelbase and at another.
#[test]
fn test_default_lengths_are_those_multiples_of_the_wheelbase_that_are_documented() {
    for wheelbase in [3.0, 0.75] {
        let car = Vehicle {
            wheelbase,
            max_steer_rate: Some(0.4),
            ..Vehicle::DEFAULT
        };
        let assert_is = |value: f64, wheelbases: f64| {
            let expected = wheelbases * wheelbase;
            assert!((value - expected).abs() < 1e-9, "{value}, not {expected}");
        };
        let pop = PopParams::DEFAULT.resolved(&car);
        let pursuit = PurePursuitParams::DEFAULT.resolved(&car);
        assert_is(pop.min_lookahead, 2.0);
        assert_is(pursuit.min_lookahead, 10.0 / 3.0);
        for (tolerance, window, spacing) in [
            (pop.lookahead_tolerance, pop.window_ahead, pop.grid_spacing),
            (
                pursuit.lookahead_tolerance,
                pursuit.window_ahead,
                pursuit.grid_spacing,
            ),
        ] {
            assert_is(tolerance, 1.0 / 300.0);
            assert_is(window, 20.0 / 3.0);
            assert_is(spacing, 1.0 / 300.0);
        }
        let preview = PreviewPopParams::DEFAULT.resolved(&car);
        assert_is(preview.heading_cost, 1.0);
        assert_is(preview.steer_rate_cost, 1.0 / 12.0);
        assert_is(preview.min_speed, 1.0 / 3.0);
        assert_is(preview.smoothing_length, 2.0 / 3.0);
        assert_is(preview.steer_span_rate, 0.4 / wheelbase);
        // The paper's 3 degrees in 50 ms.
        let free = Vehicle {
            max_steer_rate: None,
            ..car
        };
        let preview = PreviewPopParams::DEFAULT.resolved(&free);
        assert!((preview.steer_span_rate - 60.0_f64.to_radians()).abs() < 1e-12);
        assert_is(preview.min_speed, 5.0 / 3.0);
        let stanley = StanleyParams::DEFAULT.resolved(&car);
        assert_is(stanley.softening, 1.0 / 3.0);
        assert_is(stanley.smoothing_length, 1.0);
        let pid = PidParams::DEFAULT.resolved(&car);
        assert_is(pid.smoothing_length, 2.0);
        // Gains per metre go with the inverse.
        for (gain, at_3_m) in [(pid.kp, 0.25), (pid.ki, 0.01), (pid.kd, 0.2)] {
            assert_is(gain * wheelbase * wheelbase, at_3_m * 3.0);
        }
        for (search_distance, lost_distance) in [
            (pop.search_distance, pop.lost_distance),
            (pursuit.search_distance, pursuit.lost_distance),
            (preview.search_distance, preview.lost_distance),
            (stanley.search_distance, stanley.lost_distance),
            (pid.search_distance, pid.lost_distance),
        ] {
            assert_is(search_distance, 2.0);
            assert_is(lost_distance, 10.0);
        }
        let follow = Follow::of(&car, 0.0, 0.0);
        assert_is(follow.search_distance, 2.0);
        assert_is(follow.arrival_distance, 0.05);
        assert_is(follow.opposite_distance, 10.0 / 3.0);
    }
}
