//! The session as a page uses it.

use super::{Session, Text};

const GOOD: [f64; 8] = [2.7, 0.15, 0.1, 0.4, 10.0, 0.0, -2.0, 1.0];

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
    let mut session = Session::new();
    straight(&mut session);
    let controllers = count(&mut session, Text::Controllers);
    let (metrics, columns) = (
        count(&mut session, Text::Metrics),
        count(&mut session, Text::Columns),
    );
    for controller in 0..controllers {
        put(&mut session, &GOOD);
        assert!(session.drive(controller), "{}", message(&mut session));
        let output = session.output();
        let steps = (output.len() - metrics) / columns;
        assert_eq!(output.len(), metrics + steps * columns);
        assert_eq!(output[0], popsteer_core::math::from_count(steps));
        // Finished, and close to the path.
        assert_eq!(output[2], 0.0);
        assert!(output[3] < 0.1, "{controller}: {}", output[3]);
        assert!(output[3] <= output[4]);
        // Where the front axle was put, 2 m to the right.
        assert_eq!(output[metrics + 3], -2.7);
        assert_eq!(output[metrics + 4], -2.0);
        assert!(message(&mut session).is_empty());
    }
}

#[test]
fn test_session_slower_in_bends_keeps_the_lateral_acceleration() {
    let mut session = Session::new();
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
    // v² / 20 m = 4 m/s², once the pedals have found it.
    for row in rows.skip(100) {
        assert!((row[6] - 80.0_f64.sqrt()).abs() < 0.1, "{}", row[6]);
    }
}

#[test]
fn test_session_refusal_says_why_and_the_next_call_works() {
    let mut session = Session::new();
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
    let mut session = Session::new();
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
    let mut session = Session::new();
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
