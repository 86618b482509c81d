//! What a person reads of a refusal: it names the thing, the bound and the value.

use popsteer_core::laws::{Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams};
use popsteer_core::path::{Place, Spot};
use popsteer_core::{Path, PathError, Reported, Status, Tracker, Vehicle, VehicleState};

fn refused(x: &[f64], y: &[f64]) -> PathError {
    Path::new(x, y, None, false).unwrap_err()
}

#[test]
fn test_refused_paths_say_why() {
    assert_eq!(
        refused(&[1.0], &[2.0]).to_string(),
        "a path needs at least 2 waypoints, got 1"
    );
    assert_eq!(
        refused(&[0.0, 1.0], &[0.0]).to_string(),
        "y has 1 entries for 2 waypoints"
    );
    assert_eq!(
        refused(&[0.0, f64::NAN], &[0.0, 0.0]).to_string(),
        "x of waypoint 1 must be in [-1000000000.0, 1000000000.0], got NaN"
    );
    assert_eq!(
        refused(&[0.0, 0.0], &[0.0, 0.0]).to_string(),
        "waypoints 0 and 1 coincide"
    );
    let path = Path::new(&[0.0, 1.0], &[0.0, 0.0], None, false).unwrap();
    assert_eq!(
        path.view().with_reverse(&[true]).unwrap_err().to_string(),
        "reverse has 1 entries for 2 waypoints"
    );
}

#[test]
fn test_refused_parameters_and_inputs_say_why() {
    let params = PopParams {
        candidate_count: 20,
        ..PopParams::DEFAULT
    };
    assert_eq!(
        Pop::new(Vehicle::DEFAULT, params).unwrap_err().to_string(),
        "candidate_count must be odd and in [3, 100001], got 20.0"
    );
    let path = Path::new(&[0.0, 9.0], &[0.0, 0.0], None, false).unwrap();
    let tracker = Tracker::of(Pop::new(Vehicle::DEFAULT, PopParams::DEFAULT).unwrap());
    let mut state = tracker.initial_state();
    let fast = VehicleState {
        x: 0.0,
        y: 0.0,
        yaw: 0.0,
        speed: 1e5,
    };
    let error = tracker
        .step(&path.view(), &mut state, fast, 0.05, Reported::NOTHING)
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "speed must be in [-10000.0, 10000.0], got 100000.0"
    );
    let point = popsteer_core::Point::new(0.0, 0.0);
    state.place = Place::Known(Spot { segment: 7, point });
    let error = tracker.check_state(&path.view(), &state).unwrap_err();
    assert_eq!(error.to_string(), "place.segment must be below 2, got 7.0");
}

#[test]
fn test_state_of_a_pid_with_another_buffer_is_refused() {
    let of_length = |buffer_length| {
        let params = PidParams {
            buffer_length,
            ..PidParams::DEFAULT
        };
        Tracker::of(Pid::new(Vehicle::DEFAULT, params).unwrap())
    };
    let path = Path::new(&[0.0, 9.0], &[0.0, 0.0], None, false).unwrap();
    let (short, long) = (of_length(20), of_length(30));
    let state = short.initial_state();
    assert_eq!(short.check_state(&path.view(), &state), Ok(()));
    let error = long.check_state(&path.view(), &state).unwrap_err();
    assert_eq!(
        error.to_string(),
        "law.buffer.length must be a count in [30, 30], got 20.0"
    );
}

#[test]
fn test_remembered_angle_that_the_wheels_cannot_have_is_refused() {
    let path = Path::new(&[0.0, 30.0], &[0.0; 2], None, false).unwrap();
    let law = PreviewPop::new(Vehicle::PAPER, PreviewPopParams::DEFAULT).unwrap();
    let tracker = Tracker::of(law);
    let mut state = tracker.initial_state();
    for (angle, accepted) in [(1.2, true), (-1.2, true), (1.3, false), (-1.3, false)] {
        state.law.previous_steer = angle;
        let answer = tracker.check_state(&path.view(), &state);
        assert_eq!(answer.is_ok(), accepted, "{angle}");
        if let Err(error) = answer {
            assert_eq!(error.field, "law.previous_steer");
        }
    }
}

#[test]
fn test_status_is_shown_by_its_conditions() {
    let status = Status::SATURATED | Status::END_OF_PATH;
    assert_eq!(format!("{status:?}"), status.to_string());
    assert!(status.to_string().contains("saturated"));
}
