//! What the wheels did, for poses that come late, by hand.

use popsteer_core::vehicle::bicycle::{Rollout, advance};
use popsteer_core::vehicle::{Estimate, Past};
use popsteer_core::{Vehicle, VehicleState};

/// Wheels that do at once what they are commanded.
const CAR: Vehicle = Vehicle {
    steer_lag: 0.0,
    ..Vehicle::PAPER
};

/// Straight on at 0.1 rad for long, at 0.3 rad for 0.2 s, and at -0.2 rad for the last 0.3 s.
fn past() -> Past {
    let mut past = Past::settled(0.1);
    past.elapse(&CAR, [(0.3, 9.0)].into_iter(), 0.1, 0.2);
    past.elapse(&CAR, [(-0.2, 9.0)].into_iter(), 0.3, 0.3);
    past
}

#[test]
fn test_angles_of_the_wheels_are_remembered_for_their_time() {
    let mut past = past();
    assert!((past.wheel() + 0.2).abs() < 1e-12 && (past.since() - 0.5).abs() < 1e-12);
    let angles: Vec<(f64, f64)> = past.angles().collect();
    assert_eq!(angles[angles.len() - 2..], [(0.3, 0.2), (-0.2, 0.3)]);
    assert!((angles[0].0 - 0.1).abs() < 1e-12);
    // From a pose 0.45 s old to one 0.1 s old.
    past.see(0.45);
    let reached = past.wheel_integrals(0.1);
    let turn = 0.15 * f64::tan(0.3) + 0.2 * f64::tan(-0.2);
    assert!((reached.turn - turn).abs() < 1e-12, "{reached:?}");
    past.see(0.05);
    assert!((past.since() - 0.05).abs() < 1e-12);
}

#[test]
fn test_old_pose_is_rolled_through_the_angles_since() {
    let start = VehicleState {
        x: 3.0,
        y: -2.0,
        yaw: 0.7,
        speed: 8.0,
    };
    for (age, turns) in [
        (0.2, &[(-0.2, 0.2)][..]),
        (0.4, &[(0.3, 0.1), (-0.2, 0.3)]),
        (0.7, &[(0.1, 0.2), (0.3, 0.2), (-0.2, 0.3)]),
    ] {
        let found = past().advance(&CAR, start, age, &Estimate::DEFAULT);
        let mut rollout = Rollout::new(&CAR, &Estimate::DEFAULT, start);
        for &(angle, time) in turns {
            rollout.turn(angle, time);
        }
        let expected = rollout.state();
        let off = (found.x - expected.x).abs() + (found.y - expected.y).abs();
        assert!(
            off < 1e-9 && (found.yaw - expected.yaw).abs() < 1e-12,
            "{age}"
        );
    }
}

#[test]
fn test_past_that_no_wheels_can_have_is_refused() {
    let restored = |angle: f64, time: f64, wheel: f64, since: f64| {
        let angles = [(0.0, 0.5), (angle, time)];
        Past::restore(angles.into_iter(), wheel, since)
    };
    assert!(restored(0.1, 0.2, 0.1, 0.05).is_ok());
    for (angle, time, wheel, since, field) in [
        (1.6, 0.2, 0.1, 0.05, "past.angles"),
        (0.1, -0.2, 0.1, 0.05, "past.angles"),
        (0.1, 0.2, -1.6, 0.05, "past.wheel"),
        (0.1, 0.2, 0.1, -0.1, "past.since"),
    ] {
        let refused = restored(angle, time, wheel, since).unwrap_err();
        assert_eq!(refused.field, field);
    }
}

/// A vehicle slips, and moves off its heading by that, and by what its curvature adds.
#[test]
fn test_slip_turns_the_way_and_not_the_vehicle() {
    let start = VehicleState {
        x: 3.0,
        y: -2.0,
        yaw: 0.7,
        speed: 8.0,
    };
    let estimate = Estimate {
        slip: 0.05,
        slip_length: 0.3,
        ..Estimate::DEFAULT
    };
    let mut rollout = Rollout::new(&CAR, &estimate, start);
    rollout.turn(0.2, 0.05);
    let curvature = 0.2_f64.tan() / 3.0;
    let expected = advance(start, 0.4, curvature, 0.05 + 0.3 * curvature);
    let found = rollout.state();
    assert!((found.x - expected.x).abs() < 1e-12 && (found.y - expected.y).abs() < 1e-12);
    assert!((found.yaw - 0.7 - 0.4 * curvature).abs() < 1e-12);
}

#[test]
fn test_pasts_are_equal_where_all_their_angles_are() {
    let driven = |angle: f64| {
        let mut past = Past::settled(0.1);
        past.elapse(&CAR, [(angle, 9.0)].into_iter(), 0.1, 0.2);
        past.elapse(&CAR, [(0.2, 9.0)].into_iter(), 0.1, 0.2);
        past
    };
    assert!(driven(0.3) == driven(0.3) && driven(0.3) != driven(0.31));
}
