//! What the monitor says of a vehicle beside its path, and of one that turns otherwise than commanded.

use popsteer_core::laws::{Stanley, StanleyParams};
use popsteer_core::tracker::{MonitorParams, Reported};
use popsteer_core::vehicle::AdaptParams;
use popsteer_core::{Path, Status, Tracker, Vehicle, VehicleState};

const DT: f64 = 0.05;

fn straight(yaw: f64) -> Path {
    let x = [-100.0 * yaw.cos(), 500.0 * yaw.cos()];
    let y = [-100.0 * yaw.sin(), 500.0 * yaw.sin()];
    Path::new(&x, &y, None, false).unwrap()
}

fn tracker(car: &Vehicle, params: MonitorParams) -> Tracker<Stanley> {
    let law = Stanley::new(*car, StanleyParams::DEFAULT).unwrap();
    Tracker::of(law).monitored(Some(params)).unwrap()
}

/// Whether it deviates, at each of these distances to the left of its path.
fn deviates(params: MonitorParams, places: &[f64]) -> Vec<bool> {
    deviates_in(&Vehicle::PAPER, params, places)
}

fn deviates_in(car: &Vehicle, params: MonitorParams, places: &[f64]) -> Vec<bool> {
    let tracker = tracker(car, params);
    let path = straight(0.0);
    let mut state = tracker.initial_state();
    let at = |&y: &f64| {
        let vehicle = VehicleState {
            x: 0.0,
            y,
            yaw: 0.0,
            speed: 1.0,
        };
        let command = tracker.step(&path.view(), &mut state, vehicle, DT, Reported::NOTHING);
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
    // Else three quarters of its width.
    let wide = Vehicle {
        width: Some(1.2),
        ..Vehicle::PAPER
    };
    let by_width = deviates_in(&wide, MonitorParams::DEFAULT, &[0.85, 0.95, 0.85]);
    assert_eq!(by_width, [false, true, false]);
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
    let tracker = tracker(&Vehicle::PAPER, MonitorParams::DEFAULT);
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
        let command = tracker
            .step(&path.view(), &mut state, vehicle, dt, Reported::NOTHING)
            .unwrap();
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
    // In long periods too, but for those over 0.7 s: too much happens in them.
    for (dt, is_found) in [(0.3, true), (0.4, true), (0.8, false)] {
        assert!(!implausible(0.0, 0.0, dt, 20, None).contains(&true), "{dt}");
        let said = implausible(0.0, 0.5, dt, 20, None);
        assert_eq!(said.contains(&true), is_found, "{dt}");
    }
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
    let tracker = tracker(&car, MonitorParams::DEFAULT);
    let mut state = tracker.initial_state();
    let vehicle = VehicleState {
        x: 0.0,
        y: 0.0,
        yaw: 0.0,
        speed: 5.0,
    };
    tracker
        .step(
            &straight(0.0).view(),
            &mut state,
            vehicle,
            DT,
            Reported::NOTHING,
        )
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
        let tracker = tracker(&car, MonitorParams::DEFAULT);
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
            let command = tracker.step(&path.view(), &mut state, vehicle, DT, Reported::NOTHING);
            command.unwrap().status.contains(Status::DEVIATING)
        });
        assert_eq!(found, expected, "{left}");
    }
}

/// Periods of a vehicle whose wheels follow the command 0.2 rad with a lag: the turn expected in each
/// is that of their mean angle.
#[test]
fn test_expected_turn_is_that_of_the_mean_angle_of_the_wheels() {
    // With a dead time the wheels are modelled; without it the monitor has a model of its own.
    for (dead_time, nearly) in [(0.1, 1e-12), (0.0, 1e-3)] {
        let car = Vehicle {
            steer_lag: 0.4,
            dead_time,
            ..Vehicle::PAPER
        };
        let law = Stanley::new(car, StanleyParams::DEFAULT).unwrap();
        let tracker = Tracker::new(law, None).unwrap();
        let path = straight(0.0);
        let mut state = tracker.initial_state();
        let mut yaw = 0.0;
        let mut wheels = vec![0.0];
        for k in 0..6_u32 {
            let vehicle = VehicleState {
                x: 0.4 * f64::from(k),
                y: 0.0,
                yaw,
                speed: 8.0,
            };
            let reported = Reported {
                applied_steer: (k > 0).then_some(0.2),
                ..Reported::NOTHING
            };
            tracker
                .step(&path.view(), &mut state, vehicle, DT, reported)
                .unwrap();
            let monitor = state.monitor.unwrap();
            let wheel = wheels[wheels.len() - 1];
            let kept = f64::exp(-DT / 0.4);
            let (next, mean) = if k == 0 || f64::from(k - 1) * DT < dead_time - 1e-9 {
                (wheel, wheel)
            } else {
                let gap = wheel - 0.2;
                (0.2 + gap * kept, 0.2 + gap * (1.0 - kept) * 0.4 / DT)
            };
            wheels.push(next);
            if k > 0 {
                let turn = 0.01 + 0.004 * f64::from((k - 1) * (k - 1));
                let residual = turn - 8.0 / 3.0 * f64::tan(mean) * DT;
                let found = monitor.noise.last.unwrap();
                let off = (found - residual).abs();
                assert!(off < nearly, "{k}: {monitor:?}, not {residual}");
            }
            yaw += 0.01 + 0.004 * f64::from(k * k);
        }
        assert!(wheels[wheels.len() - 1] > 0.04);
    }
}

/// A sixth of the mean square of how residuals change, over those measured so far.
#[test]
fn test_noise_is_a_sixth_of_the_square_of_the_change_of_residuals() {
    let tracker = tracker(&Vehicle::PAPER, MonitorParams::DEFAULT);
    let path = straight(0.0);
    let mut state = tracker.initial_state();
    for k in 0..60_u32 {
        let vehicle = VehicleState {
            x: 0.4 * f64::from(k),
            y: 0.0,
            yaw: 0.004 * f64::from(k * k).sin(),
            speed: 8.0,
        };
        let before = state.monitor;
        tracker
            .step(&path.view(), &mut state, vehicle, DT, Reported::NOTHING)
            .unwrap();
        let monitor = state.monitor.unwrap();
        let Some(before) = before else { continue };
        let count = (before.noise.count + 1.0).min(2.0 / DT);
        // There is no residual before the second pose, and no change before the third.
        if k > 0 {
            assert!((monitor.noise.count - count).abs() < 1e-12);
        }
        if let (Some(one), Some(two)) = (before.noise.last, monitor.noise.last) {
            let square = (two - one).powi(2) / 6.0;
            let noise = before.noise.variance + (square - before.noise.variance) / count;
            assert!(
                (monitor.noise.variance - noise).abs() < 1e-12,
                "{monitor:?}"
            );
        }
    }
}

#[test]
fn test_thresholds_of_the_monitor_are_those_given() {
    let params = MonitorParams {
        turn_tolerance: 0.03,
        ..MonitorParams::DEFAULT
    };
    assert_eq!(tracker(&Vehicle::PAPER, params).monitor(), Some(&params));
}

/// A vehicle that is elsewhere when its direction changes has a new task there.
#[test]
fn test_vehicle_that_turns_round_beyond_the_limit_does_not_deviate() {
    let car = Vehicle {
        rear_axle: 0.0,
        ..Vehicle::PAPER
    };
    let tracker = tracker(&car, MonitorParams::DEFAULT);
    let path = shuttle(0.01);
    for left in [-2.0, 2.0] {
        let mut state = tracker.initial_state();
        let step = |state: &mut _, x: f64, y: f64, speed: f64| {
            let yaw = 0.0;
            let vehicle = VehicleState { x, y, yaw, speed };
            let command = tracker
                .step(&path.view(), state, vehicle, DT, Reported::NOTHING)
                .unwrap();
            command.status.contains(Status::DEVIATING)
        };
        assert!(!step(&mut state, 15.0, 0.0, 1.0));
        assert!(!step(&mut state, 20.1, left, 1.0), "{left}");
        // Once it was within, it deviates again.
        step(&mut state, 19.0, 0.0, -1.0);
        assert!(step(&mut state, 18.0, 2.0, -1.0));
    }
}

/// Up to 0.7 s a period counts, beyond it nothing is concluded of it.
#[test]
fn test_turn_of_a_period_counts_up_to_seven_tenths_of_a_second() {
    for (dt, counts) in [(0.7, true), (0.71, false)] {
        let tracker = tracker(&Vehicle::PAPER, MonitorParams::DEFAULT);
        let path = straight(0.0);
        let mut state = tracker.initial_state();
        for k in 0..3 {
            let vehicle = VehicleState {
                x: f64::from(k),
                y: 0.0,
                yaw: 0.02 * f64::from(k),
                speed: 4.0,
            };
            tracker
                .step(&path.view(), &mut state, vehicle, dt, Reported::NOTHING)
                .unwrap();
        }
        let turned = state.monitor.unwrap().yaw_rate.abs() > 0.0;
        assert_eq!(turned, counts, "{dt}");
    }
}

/// Straight on at 8 m/s, `aside(k)` to the left of the path at step `k`, while the speed signal says
/// `said`: status and cross-track error of each step.
fn straight_on(said: f64, aside: impl Fn(u32) -> f64) -> Vec<(Status, f64)> {
    straight_on_by(DT, said, |k| (aside(k), 0.0))
}

/// The same in periods of `dt`; `late(k)` is how far aside a pose is, and its age.
fn straight_on_by(dt: f64, said: f64, late: impl Fn(u32) -> (f64, f64)) -> Vec<(Status, f64)> {
    let car = Vehicle {
        dead_time: 0.1,
        ..Vehicle::PAPER
    };
    // The speed counts as it is told.
    let adapt = AdaptParams {
        speed_time: 0.0,
        ..AdaptParams::DEFAULT
    };
    let tracker = Tracker::new(*tracker(&car, MonitorParams::DEFAULT).law(), Some(adapt)).unwrap();
    let path = straight(0.0);
    let mut state = tracker.initial_state();
    let step = |k: u32| {
        let (y, pose_age) = late(k);
        let vehicle = VehicleState {
            x: 8.0 * (dt * f64::from(k) - pose_age),
            y,
            yaw: 0.0,
            speed: said,
        };
        let reported = Reported {
            pose_age,
            ..Reported::NOTHING
        };
        let command = tracker.step(&path.view(), &mut state, vehicle, dt, reported);
        let command = command.unwrap();
        (command.status, command.cross_track_error)
    };
    (0..60).map(step).collect()
}

/// In a period the vehicle goes 0.4 m, by the speed 0.05 s times it: `0.4 - 0.05 said` apart. What is
/// beyond 0.3 of the longer of both and 0.05 wheelbases a second adds up, each time at most half the limit
/// of 0.05 wheelbases and eight deviations of the noise, which is 2 cm at first, more by (13 / n)^2 of n
/// changes, and fades where there is none.
#[test]
fn test_poses_that_move_otherwise_than_the_speed_says_are_implausible() {
    for (said, fault) in [
        (8.0, None),
        (6.0, None),
        (10.8, None),
        (4.0, Some(10)),
        (0.0, Some(6)),
        (-8.0, Some(6)),
        (16.0, Some(8)),
    ] {
        let (mut sum, mut variance, mut count) = (0.0, 0.02 * 0.02, 1.0);
        let expected = (0..60).position(|k| {
            if k == 0 {
                return false;
            }
            count = f64::min(count + 1.0, 2.0 / DT);
            if k > 1 {
                variance -= variance / count;
            }
            let noise = variance.sqrt() * (1.0 + (13.0 / count) * (13.0 / count));
            let driven = DT * said;
            let explained = 0.3 * f64::max(0.4, driven.abs()) + 0.05 * 3.0 * DT;
            let limit = 0.05 * 3.0 + 8.0 * noise;
            let beyond = f64::min(f64::abs(0.4 - driven) - explained, 0.5 * limit);
            sum = f64::max(sum + beyond - noise * DT, 0.0);
            sum > limit
        });
        let found = straight_on(said, |_| 0.0);
        let found = found
            .iter()
            .position(|(status, _)| status.contains(Status::IMPLAUSIBLE));
        assert_eq!(found, expected, "{said}");
        assert_eq!(found.is_some(), fault.is_some(), "{said}");
        if let (Some(found), Some(fault)) = (found, fault) {
            assert!(found <= fault, "{said}: {found}");
        }
    }
}

/// Poses that lie aside are outliers, and the expected ones take their place, for 0.15 s
/// and 0.35 s more for each wheelbase; then the vehicle is where they say.
#[test]
fn test_jump_of_the_position_that_lasts_is_believed_after_its_time() {
    for jump in [1.5, 3.3, -3.3] {
        let found = straight_on(8.0, |k| if k < 20 { 0.0 } else { jump });
        let patience = 0.15 + 0.35 * f64::abs(jump) / 3.0;
        for (k, (status, error)) in (0_u32..).zip(found) {
            let since = DT * (f64::from(k) - 19.0);
            // The outlier that is believed is the last one.
            let is_outlier = since > 1e-9 && since < patience + DT + 1e-9;
            assert_eq!(status.contains(Status::OUTLIER), is_outlier, "{jump}: {k}");
            let is_fault = status.contains(Status::IMPLAUSIBLE);
            assert!(!(is_outlier && is_fault), "{jump}: {k}");
            let there = if since > patience + 1e-9 { jump } else { 0.0 };
            assert!((error - there).abs() < 0.01, "{jump}: {k}: {error}");
        }
    }
}

#[test]
fn test_one_outlier_alone_is_believed_in_no_period() {
    for dt in [0.05, 0.4, 0.7, 1.0] {
        let found = straight_on_by(dt, 8.0, |k| (if k == 20 { 6.0 } else { 0.0 }, 0.0));
        for (k, (status, error)) in (0_u32..).zip(found) {
            assert_eq!(status.contains(Status::OUTLIER), k == 20, "{dt}: {k}");
            assert!(error.abs() < 0.01, "{dt}: {k}: {error}");
        }
        let found = straight_on_by(dt, 8.0, |k| (if k < 20 { 0.0 } else { 6.0 }, 0.0));
        let believed = found.iter().position(|(_, error)| *error > 5.99);
        assert!((21..40).contains(&believed.unwrap()), "{dt}");
    }
}

/// The next pose in order lies a period after the last one in order.
#[test]
fn test_poses_after_one_out_of_order_are_believed() {
    for (dt, late) in [(0.05, 0.3), (0.05, 1.0), (0.1, 0.4)] {
        let found = straight_on_by(dt, 8.0, |k| (0.0, if k == 20 { late } else { 0.0 }));
        for (k, (status, _)) in found.iter().enumerate() {
            assert_eq!(*status, Status::OK, "{dt} {late}: {k}");
        }
    }
}

#[test]
fn test_pose_that_stands_still_while_the_vehicle_drives_is_stale_in_periods_of_any_length() {
    let tracker = tracker(&Vehicle::DEFAULT, MonitorParams::DEFAULT);
    let path = straight(0.0);
    for dt in [0.1, 0.05, 0.01, 0.001] {
        for (speed, is_old) in [(2.5, true), (0.2, true), (0.02, false)] {
            let mut state = tracker.initial_state();
            let vehicle = VehicleState {
                speed,
                ..VehicleState::ORIGIN
            };
            let mut step = || {
                let view = path.view();
                let command = tracker.step(&view, &mut state, vehicle, dt, Reported::NOTHING);
                command.unwrap().status.contains(Status::POSE_STALE)
            };
            step();
            assert_eq!(step(), is_old, "{dt} {speed}");
        }
    }
}
