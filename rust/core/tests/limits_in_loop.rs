//! Preview POP in a car's loop, behind wheels that turn slowly: no limit cycle, little overshoot,
//! the limits kept.

use popsteer_core::laws::{PreviewPop, PreviewPopParams};
use popsteer_core::status::Status;
use popsteer_core::vehicle::bicycle::advance;
use popsteer_core::vehicle::{AdaptParams, InFlight};
use popsteer_core::{Path, Reported, Tracker, Vehicle, VehicleState};

/// The bicycle of the straight: 2.7 m, lag 0.15 s.
fn car(rate: f64) -> Vehicle {
    Vehicle {
        wheelbase: 2.7,
        steer_lag: 0.15,
        max_steer: 0.6,
        max_steer_rate: Some(rate),
        ..Vehicle::DEFAULT
    }
}

fn straight() -> Path {
    let x: Vec<f64> = (0..900).map(f64::from).collect();
    Path::new(&x, &vec![0.0; x.len()], None, false).unwrap()
}

fn slalom() -> Path {
    let wave = std::f64::consts::TAU / 60.0;
    let x: Vec<f64> = (0..=300).map(f64::from).collect();
    let y: Vec<f64> = x.iter().map(|x| 3.0 * (wave * x).sin()).collect();
    Path::new(&x, &y, None, false).unwrap()
}

/// One step of a run: cross-track error [m], angle commanded [rad], status.
type Step = (f64, f64, Status);

fn drive(path: &Path, car: &Vehicle, start: VehicleState, dt: f64, time: f64) -> Vec<Step> {
    let tracker = Tracker::of(PreviewPop::new(*car, PreviewPopParams::DEFAULT).unwrap());
    let mut state = tracker.initial_state();
    let mut in_flight = InFlight::settled(car, 0.0);
    let mut vehicle = start;
    let mut all = Vec::new();
    let mut left = time;
    while left > 0.0 {
        left -= dt;
        let command = tracker
            .step(&path.view(), &mut state, vehicle, dt, Reported::NOTHING)
            .unwrap();
        all.push((command.cross_track_error, command.steer, command.status));
        for _ in 0..10 {
            in_flight.elapse(car, command.steer, 0.1 * dt, 0.0);
            let curvature = in_flight.wheel().tan() / car.turning_length(vehicle.speed);
            vehicle = advance(vehicle, vehicle.speed * 0.1 * dt, curvature, 0.0);
        }
    }
    all
}

fn beside(aside: f64, speed: f64) -> VehicleState {
    VehicleState {
        x: 5.0,
        y: aside,
        yaw: 0.0,
        speed,
    }
}

fn overshoot(run: &[Step]) -> f64 {
    run.iter().map(|step| -step.0).fold(0.0, f64::max)
}

#[test]
fn test_straight_is_joined_without_overshoot_and_kept() {
    let path = straight();
    for rate in [0.2, 0.4, 0.8] {
        for speed in [3.0, 8.0, 20.0] {
            for aside in [1.0, 3.0] {
                for dt in [0.05, 0.02, 0.01] {
                    let run = drive(&path, &car(rate), beside(aside, speed), dt, 20.0);
                    let over = overshoot(&run);
                    assert!(over <= 0.03 * aside, "{rate} {speed} {aside} {dt}: {over}");
                    let count = run.len();
                    let late = run[count / 4 * 3..].iter().map(|step| step.0.abs());
                    assert!(
                        late.fold(0.0, f64::max) < 1e-3,
                        "{rate} {speed} {aside} {dt}"
                    );
                }
            }
        }
    }
}

#[test]
fn test_control_period_hardly_matters_to_the_way_back() {
    // The horizon's steps are of 50 ms in all of these: what a step may move the wheels by is
    // theirs, what a command may is the control period's.
    let path = straight();
    for rate in [0.2, 0.4] {
        let at = |dt: f64| {
            let run = drive(&path, &car(rate), beside(1.0, 8.0), dt, 6.0);
            for pair in run.windows(2) {
                assert!((pair[1].1 - pair[0].1).abs() <= rate * dt * (1.0 + 1e-9));
            }
            let full = run
                .windows(2)
                .filter(|pair| (pair[1].1 - pair[0].1).abs() >= 0.98 * rate * dt)
                .count();
            assert!(full > 5, "{dt} {full}");
            (1..60)
                .map(|tenth| {
                    let time = 0.1 * f64::from(tenth);
                    let place = run
                        .iter()
                        .enumerate()
                        .find(|(k, _)| f64::from(u32::try_from(*k).unwrap()) * dt >= time - 1e-9);
                    place.unwrap().1.0
                })
                .collect::<Vec<_>>()
        };
        let coarse = at(0.05);
        for dt in [0.01, 0.025] {
            for (a, b) in coarse.iter().zip(at(dt)) {
                assert!((a - b).abs() < 0.03, "{rate} {dt}: {a} {b}");
            }
        }
    }
}

#[test]
fn test_slalom_is_kept_behind_slow_wheels() {
    // The vehicle identified from the authors' run, the no-slip point its own.
    for rate in [0.4, 0.2] {
        let car = Vehicle {
            turning_wheelbase: Some(3.553),
            understeer: 2.9e-4,
            max_steer_rate: Some(rate),
            ..Vehicle::DEFAULT
        };
        for aside in [2.44, -2.44] {
            let start = VehicleState {
                x: 2.0,
                y: aside + 0.6,
                yaw: 0.3,
                speed: 8.0,
            };
            let run = drive(&slalom(), &car, start, 0.05, 35.0);
            let settled: Vec<f64> = run.iter().skip(100).map(|step| step.0.abs()).collect();
            let count = f64::from(u32::try_from(settled.len()).unwrap());
            let mean = settled.iter().sum::<f64>() / count;
            assert!(mean < 0.01, "{rate} {aside}: {mean}");
        }
    }
}

#[test]
fn test_vehicle_that_has_become_too_fast_unwinds_at_the_full_rate() {
    let path = straight();
    let car = car(0.4);
    let law = PreviewPop::new(car, PreviewPopParams::DEFAULT).unwrap();
    // A vehicle that does not move would teach it nonsense.
    let tracker = Tracker::new(law, None).unwrap();
    let mut state = tracker.state_from(0.5).unwrap();
    let limit = (4.0 * 2.7 / 225.0_f64).atan();
    let mut before = 0.5;
    while before > limit + 0.02 {
        // Far to the right of the path and heading away from it, it would steer to the left.
        let vehicle = VehicleState {
            x: 20.0,
            y: -3.0,
            yaw: -0.5,
            speed: 15.0,
        };
        let command = tracker
            .step(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING)
            .unwrap();
        assert!(
            (before - command.steer - 0.02).abs() < 1e-12,
            "{before} {command:?}"
        );
        assert!(command.status.contains(Status::SATURATED));
        before = command.steer;
    }
}

#[test]
fn test_largest_curvature_is_reached_at_the_full_rate() {
    // With 0.3 s of lag the horizon is longer than 1 s, and its steps than a control period.
    let car = Vehicle {
        steer_lag: 0.3,
        ..car(1.0)
    };
    let tracker = Tracker::of(PreviewPop::new(car, PreviewPopParams::DEFAULT).unwrap());
    let heading = VehicleState {
        yaw: -0.35,
        ..beside(0.5, 25.0)
    };
    let most = (4.0 * 2.7 / 625.0_f64).atan();
    for (dt, reached) in [(0.05, most), (0.02, most), (0.01, 0.01)] {
        let mut state = tracker.initial_state();
        let command = tracker.step(
            &straight().view(),
            &mut state,
            heading,
            dt,
            Reported::NOTHING,
        );
        let command = command.unwrap();
        assert!((command.steer - reached).abs() < 1e-9, "{dt} {command:?}");
        assert!(command.status.contains(Status::SATURATED));
    }
}

#[test]
fn test_wheels_of_a_told_rate_turn_at_all_of_it_down_to_half_the_min_speed() {
    let path = straight();
    let law = PreviewPop::new(car(0.4), PreviewPopParams::DEFAULT).unwrap();
    let tracker = Tracker::new(law, None).unwrap();
    // `min_speed` is 0.9 m/s.
    for (speed, share) in [(1.0, 1.0), (0.6, 1.0), (0.46, 1.0), (0.18, 0.4), (0.0, 0.0)] {
        let mut state = tracker.initial_state();
        let vehicle = VehicleState {
            yaw: -0.35,
            ..beside(-1.0, speed)
        };
        let command = tracker.step(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING);
        let command = command.unwrap();
        assert!(
            (command.steer - share * 0.02).abs() < 1e-12,
            "{speed} {command:?}"
        );
        let saturated = command.status.contains(Status::SATURATED);
        assert_eq!(saturated, speed > 0.45, "{speed} {command:?}");
    }
}

#[test]
fn test_limits_that_do_not_bind_change_no_bit() {
    let loose = Vehicle {
        max_steer_rate: Some(100.0),
        max_lateral_acceleration: Some(1e3),
        ..car(1.0)
    };
    let none = Vehicle {
        max_steer_rate: None,
        max_lateral_acceleration: None,
        ..loose
    };
    let law = |vehicle| {
        let params = PreviewPopParams {
            steer_span_rate: Some(90.0),
            ..PreviewPopParams::DEFAULT
        };
        // This vehicle does not obey: of wheels that did not lag any more every rate would bind.
        let adapt = AdaptParams {
            turn_time: 0.0,
            ..AdaptParams::DEFAULT
        };
        Tracker::new(PreviewPop::new(vehicle, params).unwrap(), Some(adapt)).unwrap()
    };
    let (loose, none) = (law(loose), law(none));
    let (mut a, mut b) = (loose.initial_state(), none.initial_state());
    let path = slalom();
    for k in 0..500 {
        let x = 0.4 * f64::from(k);
        let vehicle = VehicleState {
            x,
            y: 3.0 * (std::f64::consts::TAU / 60.0 * x).sin() + 0.1,
            yaw: 0.2,
            speed: 8.0,
        };
        let first = loose
            .steer(&path.view(), &mut a, vehicle, 0.05, Reported::NOTHING)
            .unwrap();
        let second = none
            .steer(&path.view(), &mut b, vehicle, 0.05, Reported::NOTHING)
            .unwrap();
        assert_eq!(first.to_bits(), second.to_bits());
    }
}

#[test]
fn test_wheels_at_their_stop_are_held_by_the_angle_whatever_the_last_plan_reached() {
    let path = straight();
    let car = Vehicle {
        max_steer: 0.25,
        ..car(0.4)
    };
    let tracker = Tracker::new(
        PreviewPop::new(car, PreviewPopParams::DEFAULT).unwrap(),
        None,
    )
    .unwrap();
    // Far to the right of the path, heading away from it.
    let vehicle = VehicleState {
        x: 20.0,
        y: -3.0,
        yaw: -1.5,
        speed: 5.0,
    };
    for code in 0..8 {
        let mut state = tracker.state_from(0.25).unwrap();
        state.law.reached_limits = (0..20).fold(0, |bits, _| bits << 3 | code);
        let command = tracker
            .step(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING)
            .unwrap();
        assert!((command.steer - 0.25).abs() < 1e-12, "{code} {command:?}");
        assert!(command.status.contains(Status::SATURATED), "{code}");
    }
}

#[test]
fn test_wheels_turn_at_the_neighbourhoods_rate_in_every_control_period() {
    // The vehicle has no rate of its own, so nothing but the plan keeps this one.
    let path = straight();
    let free = Vehicle {
        max_steer: 1.2,
        max_steer_rate: None,
        max_lateral_acceleration: None,
        ..car(1.0)
    };
    let params = PreviewPopParams {
        steer_span_rate: Some(0.5),
        ..PreviewPopParams::DEFAULT
    };
    let tracker = Tracker::new(PreviewPop::new(free, params).unwrap(), None).unwrap();
    for dt in [0.05, 0.01] {
        let mut state = tracker.initial_state();
        let mut before = 0.0;
        let mut x = 20.0;
        while before < 1.1 {
            x += 1e-9;
            // Far to the right of the path and heading away from it.
            let vehicle = VehicleState {
                x,
                y: -3.0,
                yaw: -1.5,
                speed: 5.0,
            };
            let command = tracker
                .step(&path.view(), &mut state, vehicle, dt, Reported::NOTHING)
                .unwrap();
            let moved = command.steer - before;
            assert!((moved - 0.5 * dt).abs() < 1e-12, "{dt} {before} {moved}");
            before = command.steer;
        }
    }
}
