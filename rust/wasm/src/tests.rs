//! The session as a page uses it, and what it is made of.

use super::{Session, Text};
use crate::controllers::{NAMES as CONTROLLERS, make};
use crate::drawn::{segments, smoothed};
use crate::settings::{NAMES, Settings};
use popsteer_core::geometry::get_distance;
use popsteer_core::{Point, Vehicle};

const GOOD: [f64; 8] = [2.7, 0.15, 0.1, 0.4, 10.0, 0.0, -2.0, 1.0];

/// From where a controller joins a straight [m]. Known: from 2 m beside, where its status is
/// `too-fast`, the PID limit-cycles with wheels of 0.4 rad/s.
fn aside(controller: usize) -> f64 {
    if CONTROLLERS[controller] == "pid" {
        -1.0
    } else {
        -2.0
    }
}

fn put(session: &mut Session, numbers: &[f64]) {
    session
        .room(numbers.len())
        .unwrap()
        .copy_from_slice(numbers);
}

fn straight(session: &mut Session) {
    let waypoints: Vec<f64> = (0..150).flat_map(|k| [f64::from(k), 0.0]).collect();
    put(session, &waypoints);
    assert!(session.track(false), "{}", session.text(Text::Message));
}

fn message(session: &mut Session) -> String {
    session.text(Text::Message).to_owned()
}

fn count(session: &mut Session, what: Text) -> usize {
    session.text(what).split(',').count()
}

#[test]
fn test_session_every_controller_drives_a_straight() {
    let mut session = Session::default();
    straight(&mut session);
    let controllers = count(&mut session, Text::Controllers);
    let (metrics, columns) = (
        count(&mut session, Text::Metrics),
        count(&mut session, Text::Columns),
    );
    for controller in 0..controllers {
        let mut settings = GOOD;
        settings[6] = aside(controller);
        put(&mut session, &settings);
        assert!(session.drive(controller), "{}", message(&mut session));
        let output = session.output();
        let steps = (output.len() - metrics) / columns;
        assert_eq!(output.len(), metrics + steps * columns);
        assert_eq!(output[0], popsteer_core::math::from_count(steps));
        // Finished, and close to the path.
        assert_eq!(output[2], 0.0);
        // Known: without any limit, wheels that are slower than the vehicle says are taken for a
        // vehicle that turns less, and preview POP swings about the line.
        let most = if controller == 2 { 1.5 } else { 0.1 };
        assert!(output[3] < most, "{controller}: {}", output[3]);
        assert!(output[3] <= output[4]);
        // Where the front axle was put, to the right.
        assert_eq!(output[metrics + 1], -2.7);
        assert_eq!(output[metrics + 2], aside(controller));
        assert!(message(&mut session).is_empty());
    }
}

#[test]
fn test_session_slower_in_bends_keeps_the_lateral_acceleration() {
    let mut session = Session::default();
    let ring: Vec<f64> = (0..126)
        .map(|k| f64::from(k) * std::f64::consts::TAU / 126.0)
        .flat_map(|angle| [20.0 * angle.cos(), 20.0 * angle.sin()])
        .collect();
    put(&mut session, &ring);
    assert!(session.track(true));
    let mut settings = GOOD;
    settings[4] = 15.0;
    settings[5] = 1.0;
    settings[6] = 0.0;
    put(&mut session, &settings);
    assert!(session.drive(1), "{}", message(&mut session));
    let rows = session.output()[9..].chunks_exact(17);
    assert!(rows.len() > 200);
    // v² / 20 m is nine tenths of 4 m/s², as a driver plans: the rest is for steering.
    for row in rows.skip(100) {
        assert!((row[4] - 72.0_f64.sqrt()).abs() < 0.1, "{}", row[4]);
    }
}

#[test]
fn test_session_slower_in_bends_stops_at_the_end_and_for_a_fault() {
    let mut session = Session::default();
    straight(&mut session);
    let mut settings = GOOD;
    settings[5] = 1.0;
    for controller in 0..6 {
        settings[6] = aside(controller);
        put(&mut session, &settings);
        assert!(session.drive(controller), "{}", message(&mut session));
        let output = session.output();
        let last = &output[output.len() - 17..];
        // Without any limit preview POP swings about the line, and its driver stands for that.
        let (ending, most) = if controller == 2 {
            (1.0, 0.01)
        } else {
            (0.0, 5.0)
        };
        assert_eq!((output[2], output[8] > 0.0), (ending, controller == 2));
        assert!(last[4] < most, "{controller}: {}", last[4]);
    }
    // 60 m beside the path nobody joins it: the driver stands.
    settings[6] = 60.0;
    put(&mut session, &settings);
    assert!(session.drive(4));
    assert!(session.output()[8] > 0.0);
}

#[test]
fn test_session_refusal_says_why_and_the_next_call_works() {
    let mut session = Session::default();
    put(&mut session, &GOOD);
    assert!(!session.drive(0));
    assert_eq!(message(&mut session), "there is no track yet");
    straight(&mut session);
    put(&mut session, &[3.0, 4.0]);
    assert!(!session.track(false));
    assert_eq!(
        message(&mut session),
        "a path needs at least 2 waypoints, got 1"
    );
    put(&mut session, &[0.0, 0.0, f64::NAN, 1.0]);
    assert!(!session.track(false));
    assert!(message(&mut session).starts_with("x of waypoint 1 must be in"));
    assert_eq!(session.draw(), None);
    assert!(message(&mut session).starts_with("x must be in"));
    let mut tiny = GOOD;
    tiny[0] = 1e-9;
    put(&mut session, &tiny);
    assert!(!session.drive(1));
    assert_eq!(
        message(&mut session),
        "wheelbase must be in [0.001, 1000.0], got 1e-9"
    );
    assert!(session.output().is_empty());
    put(&mut session, &GOOD);
    assert!(!session.drive(6));
    assert_eq!(message(&mut session), "there is no controller 6");
    assert!(session.room(usize::MAX).is_none());
    assert!(message(&mut session).contains("room for 262144"));
    put(&mut session, &GOOD);
    assert!(session.drive(0));
    assert!(message(&mut session).is_empty());
}

#[test]
fn test_session_drawn_line_is_driven() {
    let mut session = Session::default();
    let line: Vec<f64> = (0..40)
        .flat_map(|k| [5.0 * f64::from(k), 4.0 * (0.4 * f64::from(k)).sin()])
        .collect();
    put(&mut session, &line);
    assert_eq!(session.draw(), Some(false));
    let waypoints = session.output().len() / 2;
    assert!(waypoints > 190);
    put(&mut session, &GOOD);
    assert!(session.drive(1));
    assert!(session.output()[3] < 0.1);
}

#[test]
fn test_session_extreme_settings_answer() {
    let mut session = Session::default();
    straight(&mut session);
    for (index, extremes) in [
        [1e-3, 1e3],
        [0.0, 10.0],
        [0.0, 10.0],
        [1e-3, 1e6],
        [0.1, 100.0],
        [0.0, 1.0],
        [-1e3, 1e3],
        [0.0, 1.0],
    ]
    .into_iter()
    .enumerate()
    {
        for extreme in extremes {
            let mut settings = GOOD;
            settings[index] = extreme;
            for controller in 0..6 {
                put(&mut session, &settings);
                let done = session.drive(controller);
                assert_eq!(done, message(&mut session).is_empty());
                let rows = session.output().get(9..).unwrap_or(&[]);
                // A target is not a number where there is none.
                let numbers = rows.chunks_exact(17).flat_map(|row| &row[..14]);
                assert!(numbers.clone().all(|number| number.is_finite()));
            }
        }
    }
}

#[test]
fn test_settings_bad_number_is_named() {
    assert!(Settings::of(&GOOD).is_ok());
    for (index, name) in NAMES.iter().enumerate() {
        for bad in [f64::NAN, f64::INFINITY, -1e7] {
            let mut numbers = GOOD;
            numbers[index] = bad;
            assert_eq!(Settings::of(&numbers).unwrap_err().field, *name);
        }
    }
    assert_eq!(Settings::of(&GOOD[..7]).unwrap_err().field, "known");
    assert_eq!(Settings::of(&[]).unwrap_err().field, "wheelbase");
}

#[test]
fn test_settings_unknown_vehicle_has_wheels_that_turn_at_once() {
    let mut numbers = GOOD;
    assert_eq!(Settings::of(&numbers).unwrap().believed.dead_time, 0.1);
    numbers[7] = 0.0;
    let settings = Settings::of(&numbers).unwrap();
    let believed = settings.believed;
    assert_eq!(
        (
            believed.steer_lag,
            believed.dead_time,
            believed.max_steer_rate
        ),
        (0.0, 0.0, None)
    );
    assert_eq!(settings.plant.vehicle.steer_lag, 0.15);
}

fn ring(count: u32, radius: f64, turns: f64) -> Vec<Point> {
    (0..=count)
        .map(|k| {
            let angle = turns * std::f64::consts::TAU * f64::from(k) / f64::from(count);
            Point::new(radius * angle.cos(), radius * angle.sin())
        })
        .collect()
}

#[test]
fn test_drawn_ring_is_a_lap_of_equal_steps() {
    let (line, closed) = smoothed(&ring(37, 40.0, 0.97)).unwrap();
    assert!(closed);
    for (from, to) in segments(&line, true) {
        assert!((get_distance(from, to) - 1.0).abs() < 0.05);
    }
    for point in &line {
        let radius = get_distance(*point, Point::new(0.0, 0.0));
        assert!((38.0..40.5).contains(&radius), "{radius}");
    }
}

#[test]
fn test_drawn_corner_becomes_a_bend_and_the_ends_stay() {
    let corner = [(0.0, 0.0), (50.0, 0.0), (50.0, 50.0)].map(|(x, y)| Point::new(x, y));
    let (line, closed) = smoothed(&corner).unwrap();
    assert!(!closed);
    assert_eq!(line.first(), corner.first());
    assert_eq!(line.last(), corner.last());
    let sharpest = line
        .windows(3)
        .map(|at| {
            let (a, b) = (at[1] - at[0], at[2] - at[1]);
            (a.x * b.y - a.y * b.x).abs()
        })
        .fold(0.0, f64::max);
    assert!((0.1..0.19).contains(&sharpest), "{sharpest}");
}

#[test]
fn test_drawn_line_that_is_none_is_refused() {
    let refused = |points: &[(f64, f64)]| {
        let points: Vec<Point> = points.iter().map(|&(x, y)| Point::new(x, y)).collect();
        smoothed(&points).unwrap_err().to_string()
    };
    assert!(refused(&[]).contains("at least 20 m"));
    assert!(refused(&[(1.0, 2.0)]).contains("at least 20 m"));
    assert!(refused(&[(0.0, 0.0); 9]).contains("is 0.0 m"));
    assert!(refused(&[(0.0, 0.0), (f64::NAN, 1.0)]).starts_with("x must be"));
    assert!(refused(&[(0.0, 0.0), (90.0, 1e9)]).starts_with("y must be"));
    assert!(refused(&[(0.0, 0.0), (9e4, 0.0)]).contains("at most 20000 m"));
}

#[test]
fn test_drawn_scribble_makes_a_track_or_is_refused() {
    // There and back on one line, and points on top of each other.
    let mut scribble = Vec::new();
    for k in 0..60 {
        let x = f64::from(if k < 30 { k } else { 60 - k });
        scribble.extend([Point::new(x, 0.0); 3]);
    }
    if let Ok((line, closed)) = smoothed(&scribble) {
        assert!(segments(&line, closed).all(|(from, to)| get_distance(from, to) > 1e-6));
    }
}

#[test]
fn test_controllers_each_name_makes_one() {
    for name in CONTROLLERS {
        assert!(make(name, &Vehicle::DEFAULT).unwrap().is_some(), "{name}");
    }
    assert!(make("mpc", &Vehicle::DEFAULT).unwrap().is_none());
    let bad = Vehicle {
        wheelbase: 0.0,
        ..Vehicle::DEFAULT
    };
    assert_eq!(make("pop", &bad).unwrap_err().field, "wheelbase");
}
