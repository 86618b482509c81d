//! A new path during a run, and the trajectory that a controller intends.

use popsteer_core::laws::{
    LateralLaw, Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams, Stanley,
    StanleyParams,
};
use popsteer_core::path::{Place, Spot};
use popsteer_core::tracker::Predicted;
use popsteer_core::vehicle::bicycle::advance;
use popsteer_core::{Path, Point, Reported, Tracker, Vehicle, VehicleState};

/// A vehicle whose wheels do at once what they are commanded; 3 m long.
const CAR: Vehicle = Vehicle {
    steer_lag: 0.0,
    ..Vehicle::PAPER
};
/// One whose controller predicts: the measured and the predicted place differ.
const LATE: Vehicle = Vehicle {
    dead_time: 0.2,
    ..Vehicle::PAPER
};
const DT: f64 = 0.1;

fn bends(from: u32, to: u32) -> Path {
    let x: Vec<f64> = (from..to).map(f64::from).collect();
    let y: Vec<f64> = x.iter().map(|x| 2.0 * (x / 12.0).sin()).collect();
    Path::new(&x, &y, None, false).unwrap()
}

/// How far along the front axle is of a vehicle at 40 m, 0.1 rad off its path [m].
const FRONT: f64 = 42.985_012_495_8;
/// The direction of the lines below [rad]: along no axis.
const TURNED: f64 = 0.7;

/// The place `x` along that direction and `y` to the left of it [m].
fn turned(x: f64, y: f64) -> (f64, f64) {
    let (sin, cos) = TURNED.sin_cos();
    (x * cos - y * sin, x * sin + y * cos)
}

/// A vehicle 40 m along, `left` of the line from the origin and off it by `heading`.
fn at_40(left: f64, heading: f64) -> VehicleState {
    let (x, y) = turned(40.0, left);
    VehicleState {
        x,
        y,
        yaw: TURNED + heading,
        speed: 5.0,
    }
}

/// A line `left` of the origin by so much, and turned by `yaw` about the front axle's place.
fn line(left: f64, yaw: f64, reverse: bool) -> Path {
    let along = (-40..60).map(|k| 1.25 * f64::from(k));
    let (x, y): (Vec<f64>, Vec<f64>) = along
        .map(|s| turned(FRONT + s * yaw.cos(), left + s * yaw.sin()))
        .unzip();
    let path = Path::new(&x, &y, None, false).unwrap();
    if reverse {
        path.with_reverse(&[true; 100]).unwrap()
    } else {
        path
    }
}

/// What the controller answers on the way along bends; `window` hands the path over anew in each
/// step, a part of it around the vehicle.
fn driven<L: LateralLaw>(law: L, window: bool) -> Vec<f64> {
    let tracker = Tracker::of(law);
    let whole = bends(0, 200);
    let mut state = tracker.initial_state();
    let mut vehicle = VehicleState {
        x: 30.0,
        y: 1.5,
        yaw: 0.1,
        speed: 6.0,
    };
    let mut part = bends(0, 200);
    let mut first = 0;
    let mut angles = Vec::new();
    for k in 0..120 {
        if window && k % 2 == 0 {
            // A planner's path begins a little behind the vehicle; waypoints have other numbers.
            first = 12 + k / 2;
            let next = bends(first, first + 90);
            tracker.set_path(&mut state, &part.view(), &next.view());
            part = next;
        }
        let path = if window { &part } else { &whole };
        let steer = tracker
            .steer(&path.view(), &mut state, vehicle, DT, Reported::NOTHING)
            .unwrap();
        angles.push(steer);
        vehicle = advance(vehicle, vehicle.speed * DT, steer.tan() / 3.0, 0.0);
    }
    assert!(!window || first > 50);
    angles
}

#[track_caller]
fn assert_window_changes_nothing<L: LateralLaw>(law: impl Fn(Vehicle) -> L) {
    for car in [CAR, LATE] {
        let (whole, window) = (driven(law(car), false), driven(law(car), true));
        for (k, (one, other)) in whole.iter().zip(&window).enumerate() {
            assert!((one - other).abs() < 1e-6, "step {k}: {one}, {other}");
        }
    }
}

#[test]
fn test_path_handed_over_again_and_again_is_driven_as_the_whole_one() {
    assert_window_changes_nothing(|car| Stanley::new(car, StanleyParams::DEFAULT).unwrap());
    for smoothing_length in [None, Some(0.0)] {
        assert_window_changes_nothing(|car| {
            // With the default derivative it swings from one end of the wheels to the other, and
            // every rounding grows.
            let params = PidParams {
                kd: Some(0.05),
                smoothing_length,
                ..PidParams::DEFAULT
            };
            Pid::new(car, params).unwrap()
        });
    }
    assert_window_changes_nothing(|car| PreviewPop::new(car, PreviewPopParams::DEFAULT).unwrap());
    assert_window_changes_nothing(|car| Pop::new(car, PopParams::DEFAULT).unwrap());
}

/// The angles from the change of the path at 40 m on, and the angle that the controller would begin
/// with on the new path.
fn changed(new: &Path) -> (f64, Vec<f64>, f64) {
    let tracker = Tracker::of(Stanley::new(CAR, StanleyParams::DEFAULT).unwrap());
    let old = line(0.0, 0.0, false);
    let mut state = tracker.initial_state();
    // Off the heading, so that the angle is not 0.
    let vehicle = at_40(0.0, 0.1);
    let before = tracker
        .steer(&old.view(), &mut state, vehicle, DT, Reported::NOTHING)
        .unwrap();
    tracker.set_path(&mut state, &old.view(), &new.view());
    let angles = (0..12)
        .map(|_| {
            tracker
                .steer(&new.view(), &mut state, vehicle, DT, Reported::NOTHING)
                .unwrap()
        })
        .collect();
    let mut fresh = tracker.initial_state();
    let wanted = tracker
        .steer(&new.view(), &mut fresh, vehicle, DT, Reported::NOTHING)
        .unwrap();
    (before, angles, wanted)
}

/// A path within a tenth of the wheelbase and half a radian is the last one, a little changed: its
/// angle counts at once. Any other lies elsewhere: the angle changes over within a second.
#[test]
fn test_path_nearby_is_taken_at_once_and_one_elsewhere_within_a_second() {
    for (left, yaw) in [(0.29, 0.0), (-0.29, 0.0), (0.0, 0.49), (0.0, -0.49)] {
        let (_, angles, wanted) = changed(&line(left, yaw, false));
        for angle in angles {
            assert!(
                (angle - wanted).abs() < 1e-9,
                "{left} {yaw}: {angle}, {wanted}"
            );
        }
    }
    for (left, yaw, reverse) in [
        (0.31, 0.0, false),
        (-0.31, 0.0, false),
        (0.0, 0.51, false),
        (0.0, -0.51, false),
        (0.0, 0.0, true),
    ] {
        let (before, angles, wanted) = changed(&line(left, yaw, reverse));
        for (k, angle) in (0..12).zip(angles) {
            let share = 1.0 - f64::min(0.1 * f64::from(k), 1.0);
            let expected = wanted + share * (before - wanted);
            assert!(
                (angle - expected).abs() < 1e-9,
                "{left} {yaw}: {angle}, {expected}"
            );
        }
    }
}

/// Another path during a hand-over: the angle goes on from where it is, and is the new path's when
/// the second is over that began with the first.
#[test]
fn test_path_that_changes_again_keeps_the_end_of_the_hand_over() {
    let tracker = Tracker::of(Stanley::new(CAR, StanleyParams::DEFAULT).unwrap());
    let paths = [0.0, 1.0, -0.8].map(|left| line(left, 0.0, false));
    let wanted = |path: &Path| {
        let mut fresh = tracker.initial_state();
        tracker
            .steer(
                &path.view(),
                &mut fresh,
                at_40(0.0, 0.0),
                DT,
                Reported::NOTHING,
            )
            .unwrap()
    };
    let mut state = tracker.initial_state();
    let steer = |state: &mut _, path: &Path| {
        tracker
            .steer(&path.view(), state, at_40(0.0, 0.0), DT, Reported::NOTHING)
            .unwrap()
    };
    steer(&mut state, &paths[0]);
    tracker.set_path(&mut state, &paths[0].view(), &paths[1].view());
    let mut last = 0.0;
    for _ in 0..4 {
        last = steer(&mut state, &paths[1]);
    }
    // 0.3 s of it are over.
    assert!((last - 0.3 * wanted(&paths[1])).abs() < 1e-9);
    tracker.set_path(&mut state, &paths[1].view(), &paths[2].view());
    let end = wanted(&paths[2]);
    for k in 1..10 {
        let share = (1.0 - f64::from(k) / 7.0).max(0.0);
        let expected = end + share * (last - end);
        let angle = steer(&mut state, &paths[2]);
        assert!((angle - expected).abs() < 1e-9, "{k}: {angle}, {expected}");
    }
}

/// Of two branches the new path takes the one that leads where the vehicle looks.
#[test]
fn test_new_path_that_comes_back_beside_itself_is_driven_on_the_right_branch() {
    let tracker = Tracker::of(Stanley::new(CAR, StanleyParams::DEFAULT).unwrap());
    for backwards in [false, true] {
        let old = line(0.0, 0.0, backwards);
        let mut state = tracker.initial_state();
        let vehicle = at_40(0.0, if backwards { std::f64::consts::PI } else { 0.0 });
        tracker
            .steer(&old.view(), &mut state, vehicle, DT, Reported::NOTHING)
            .unwrap();
        // Back first, 0.1 m beside the vehicle, then round and there, 0.2 m beside it.
        let back = (0..80).map(|k| (80.0 - f64::from(k), 0.1));
        let there = (0..80).map(|k| (f64::from(k), -0.2));
        let turn = [(-3.0, 2.0), (-5.0, 0.0), (-3.0, -2.0)];
        let points: Vec<(f64, f64)> = back.chain(turn).chain(there).collect();
        let (x, y): (Vec<f64>, Vec<f64>) = points.iter().map(|&(x, y)| turned(x, y)).unzip();
        let mut new = Path::new(&x, &y, None, false).unwrap();
        if backwards {
            new = new.with_reverse(&vec![true; x.len()]).unwrap();
        }
        tracker.set_path(&mut state, &old.view(), &new.view());
        let found = state.place.segment().unwrap();
        assert!(found > 83, "{found}");
    }
}

/// The derivative sees no jump of a path that moves aside, and the integral goes on.
#[test]
fn test_pid_sees_no_jump_of_a_path_that_moves_aside() {
    let params = PidParams {
        kp: Some(0.2),
        ki: Some(0.05),
        kd: Some(0.1),
        smoothing_length: Some(0.0),
        ..PidParams::DEFAULT
    };
    let tracker = Tracker::of(Pid::new(CAR, params).unwrap());
    let (old, new) = (line(0.0, 0.0, false), line(0.2, 0.0, false));
    let mut state = tracker.initial_state();
    let vehicle = at_40(0.05, 0.0);
    let before = tracker
        .steer(&old.view(), &mut state, vehicle, DT, Reported::NOTHING)
        .unwrap();
    assert!((before + 0.2 * 0.05 + 0.05 * 0.05 * DT).abs() < 1e-12);
    tracker.set_path(&mut state, &old.view(), &new.view());
    let after = tracker
        .steer(&new.view(), &mut state, vehicle, DT, Reported::NOTHING)
        .unwrap();
    let sum = (0.05 - 0.15) * DT;
    assert!((after - 0.2 * 0.15 + 0.05 * sum).abs() < 1e-12, "{after}");
}

/// A step of the prediction's own, so that one of them is exact [s].
const STEP: f64 = 0.05;

fn predicted<L: LateralLaw>(law: L, count: usize) {
    let tracker = Tracker::of(law);
    let path = bends(0, 80);
    let start = VehicleState {
        x: 50.0,
        y: -2.0,
        yaw: -0.4,
        speed: 8.0,
    };
    let mut state = tracker.initial_state();
    let mut out = vec![Predicted::DEFAULT; count];
    assert_eq!(tracker.predict(&path.view(), &state, STEP, &mut out), Ok(0));
    let steer = tracker
        .steer(&path.view(), &mut state, start, STEP, Reported::NOTHING)
        .unwrap();
    let before = state.clone();
    let written = tracker
        .predict(&path.view(), &state, STEP, &mut out)
        .unwrap();
    assert!(written == count && state == before);
    assert!(out[0].vehicle == start && (out[0].steer - steer).abs() <= 0.0);
    let end = path.view().length();
    let mut travelled = 0.0;
    for (k, pair) in out.windows(2).enumerate() {
        let [now, next] = [pair[0], pair[1]];
        assert!((next.time - now.time - STEP).abs() < 1e-9, "{k}");
        // The vehicle turns as commanded...
        let (from, to) = (now.vehicle, next.vehicle);
        let expected = advance(from, to.speed * STEP, now.steer.tan() / 3.0, 0.0);
        assert!(
            (to.x - expected.x).abs() < 1e-9 && (to.y - expected.y).abs() < 1e-9,
            "{k}"
        );
        assert!((to.yaw - expected.yaw).abs() < 1e-9);
        travelled += to.speed * STEP;
        // ... at its speed, until the path ends...
        assert!(
            (to.speed - 8.0).abs() < 1e-9 || travelled + 51.0 > end,
            "{k}"
        );
        // ... and the controller answers there as it will.
        let steer = tracker
            .steer(&path.view(), &mut state, to, STEP, Reported::NOTHING)
            .unwrap();
        assert!((next.steer - steer).abs() <= 0.0, "{k}");
    }
    let last = out[count - 1].vehicle;
    assert!(last.speed.abs() < 1e-9);
    assert!((last.x - 79.0).abs() < 0.5, "{last:?}");
}

#[test]
fn test_prediction_is_what_happens_where_the_vehicle_does_what_it_says() {
    predicted(Stanley::new(CAR, StanleyParams::DEFAULT).unwrap(), 120);
    predicted(Pid::new(CAR, PidParams::DEFAULT).unwrap(), 120);
    predicted(Pop::new(CAR, PopParams::DEFAULT).unwrap(), 120);
}

/// A path that moves aside a little twice before the next step has moved a little each time.
#[test]
fn test_path_that_moves_twice_before_a_step_starts_no_hand_over() {
    let tracker = Tracker::of(Stanley::new(CAR, StanleyParams::DEFAULT).unwrap());
    let lines = [0.0, 0.25, 0.5].map(|left| line(left, 0.0, false));
    let mut state = tracker.initial_state();
    tracker
        .steer(
            &lines[0].view(),
            &mut state,
            at_40(0.0, 0.0),
            DT,
            Reported::NOTHING,
        )
        .unwrap();
    tracker.set_path(&mut state, &lines[0].view(), &lines[1].view());
    tracker.set_path(&mut state, &lines[1].view(), &lines[2].view());
    assert_eq!(state.handover, None);
    // At once it lies elsewhere.
    tracker.set_path(&mut state, &lines[2].view(), &lines[0].view());
    assert!(state.handover.is_some());
}

/// Laps that a new path lacks have been driven, and those that it has besides have not, whether its
/// waypoints are the old ones, a little aside or within noise of them.
#[test]
fn test_path_of_laps_loses_those_driven_and_gains_those_to_drive() {
    let laps = |(from, to): (u32, u32), shift: f64, noise: f64| {
        let (x, y): (Vec<f64>, Vec<f64>) = (from..=to)
            .map(|k| {
                let radius = 20.0 + noise * f64::sin(37.0 * f64::from(k * k % 101));
                let angle = f64::from(k % 60) * std::f64::consts::TAU / 60.0;
                (radius * angle.cos() + shift, radius * angle.sin())
            })
            .unzip();
        Path::new(&x, &y, None, false).unwrap()
    };
    let tracker = Tracker::of(Stanley::new(CAR, StanleyParams::DEFAULT).unwrap());
    for (shift, noise) in [(0.0, 0.0), (1e-3, 0.0), (0.0, 0.02), (1e-3, 0.02)] {
        for (before, after, place, expected) in [
            ((0, 180), (60, 180), 85, 25),
            ((0, 120), (0, 180), 85, 85),
            ((0, 180), (60, 180), 40, 40),
            // As near to either end as a search goes.
            ((0, 180), (0, 180), 178, 178),
            ((0, 180), (0, 180), 1, 1),
            ((0, 180), (60, 180), 61, 1),
        ] {
            let (old, new) = (laps(before, 0.0, noise), laps(after, shift, noise));
            let point = |k: usize| Point::new(old.view().x()[k], old.view().y()[k]);
            let mut state = tracker.initial_state();
            state.place = Place::Known(Spot {
                segment: place,
                point: (point(place) + point(place + 1)) * 0.5,
            });
            tracker.set_path(&mut state, &old.view(), &new.view());
            assert_eq!(
                state.place.segment(),
                Some(expected),
                "{after:?} {shift} {noise}"
            );
        }
    }
}
