use super::super::tests::{FOLLOW, at, shuttle};
use super::*;
use crate::Path;
use alloc::vec;
use alloc::vec::Vec;

#[test]
fn test_follow_turns_round_when_the_rear_axle_has_come() {
    let path = shuttle();
    let view = path.view();
    let forward = FOLLOW.locate(&view, Some(1), at(19.0, 0.5, 1.0), 0.05);
    assert!(!forward.reverse && !forward.direction_changed && forward.closest.segment == 1);
    assert_eq!(forward.closest.point, Point::new(22.0, 0.0));
    assert_eq!(forward.closest.cross_track_error(), 0.5);

    let back = FOLLOW.locate(&view, Some(1), at(19.9, 0.5, 0.3), 0.05);
    assert!(back.reverse && back.direction_changed && back.closest.segment == 2);
    assert!((back.position.x - 16.9).abs() < 1e-12);
    assert_eq!(back.vehicle.speed, -0.3);
    // The path leads the other way: its left is the vehicle's right.
    assert!((back.closest.cross_track_error() + 0.5).abs() < 1e-12);

    let again = FOLLOW.locate(&view, Some(2), at(10.1, 0.0, -0.3), 0.05);
    assert!(!again.reverse && again.direction_changed && again.closest.segment == 3);
}

#[test]
fn test_follow_turns_round_at_one_place_whatever_point_is_followed() {
    // 4 m forward and back in steps of 0.1 m: what is near lies on several segments.
    let there: Vec<f64> = (0..=40).map(|k| 0.1 * f64::from(k)).collect();
    let x: Vec<f64> = there
        .iter()
        .chain(there.iter().rev().skip(1))
        .copied()
        .collect();
    let back: Vec<bool> = (0..x.len()).map(|k| k >= 40).collect();
    let path = Path::new(&x, &vec![0.0; x.len()], None, false).unwrap();
    let path = path.with_reverse(&back).unwrap();
    for reference_offset in [3.0, 0.0, -1.5] {
        let follow = Follow {
            reference_offset,
            ..FOLLOW
        };
        for (x, turned) in [(3.7, false), (3.84, false), (3.86, true), (4.1, true)] {
            let last = crate::math::to_count((x + reference_offset).clamp(0.0, 3.9) / 0.1);
            let found = follow.locate(&path.view(), Some(last), at(x, 0.2, 0.3), 0.05);
            assert_eq!(found.direction_changed, turned, "{reference_offset} {x}");
        }
    }
}

#[test]
fn test_follow_turns_round_by_the_rear_axle_whatever_point_the_pose_is_of() {
    // 40 m along x, 40 m back, 40 m along x again.
    let x: Vec<f64> = (0..=120)
        .map(|k| 40.0 - f64::from((k % 80_i32 - 40).abs()))
        .collect();
    let backwards: Vec<bool> = (0..=120).map(|k| (40..80).contains(&k)).collect();
    let path = Path::new(&x, &[0.0; 121], None, false).unwrap();
    let path = path.with_reverse(&backwards).unwrap();
    let view = path.view();
    for rear_axle in [0.0, -1.35, -4.0, 2.0] {
        for reference_offset in [3.0, 0.0, -1.5] {
            let follow = Follow {
                reference_offset,
                rear_axle,
                ..FOLLOW
            };
            let turned = |last: usize, rear: f64, yaw: f64, speed: f64| {
                let pose = VehicleState {
                    x: rear - rear_axle * cos(yaw),
                    y: 0.2 - rear_axle * sin(yaw),
                    yaw,
                    speed,
                };
                let last = last.min(view.segments() - 1);
                follow
                    .locate(&view, Some(last), pose, 0.05)
                    .direction_changed
            };
            for yaw in [-0.1, 0.0, 0.2] {
                for (rear, is_there) in [(39.7, false), (39.84, false), (39.86, true)] {
                    assert_eq!(turned(38, rear, yaw, 0.3), is_there, "{rear} {rear_axle}");
                    assert_eq!(turned(78, 40.0 - rear, yaw, -0.3), is_there, "{rear}");
                }
            }
        }
    }
}

#[test]
fn test_follow_round_a_path_driven_backwards_never_turns_round() {
    let (x, y) = ([0.0, 1e-8, 1e-8, 0.0], [0.0, 0.0, 1e-8, 1e-8]);
    let path = Path::new(&x, &y, None, true).unwrap();
    let path = path.with_reverse(&[true; 4]).unwrap();
    let found = FOLLOW.locate(&path.view(), Some(1), at(0.0, 0.1, -1.0), 0.05);
    assert!(found.reverse && !found.direction_changed);
}

#[test]
fn test_follow_round_a_tiny_path_driven_backwards_comes_to_an_end() {
    let (x, y) = ([0.0, 2e-9, 0.0], [0.0, 0.0, 2e-9]);
    let path = Path::new(&x, &y, None, true).unwrap();
    let path = path.with_reverse(&[true; 3]).unwrap();
    let follow = Follow {
        reference_offset: -1e3,
        ..FOLLOW
    };
    let found = follow.locate(&path.view(), Some(0), at(0.0, 0.0, -1.0), 0.05);
    assert!(found.reverse && !found.direction_changed);
}

#[test]
fn test_follow_lost_is_found_anew_and_said_so() {
    let x = [0.0, 100.0, 200.0, 300.0];
    let path = Path::new(&x, &[0.0; 4], None, false).unwrap();
    let near = FOLLOW.locate(&path.view(), Some(0), at(20.0, 29.0, 5.0), 0.05);
    assert!(!near.off_path);
    let found = FOLLOW.locate(&path.view(), Some(0), at(240.0, 2.0, 5.0), 0.05);
    assert!(found.off_path && found.closest.segment == 2);
    let lost = FOLLOW.locate(&path.view(), Some(0), at(40.0, 31.0, 5.0), 0.05);
    assert!(lost.off_path && lost.closest.segment == 0);
}

/// Once round a circle of 100,000 m, a waypoint each metre.
fn circle() -> Path {
    let angle = |k| core::f64::consts::TAU * f64::from(k) / 1e5;
    let radius = 1e5 / core::f64::consts::TAU;
    let (x, y): (Vec<_>, Vec<_>) = (0..100_000)
        .map(|k| (radius * cos(angle(k)), radius * sin(angle(k))))
        .unzip();
    Path::new(&x, &y, None, true).unwrap()
}

#[test]
fn test_follow_lost_at_the_centre_of_a_circle_keeps_its_place() {
    let path = circle();
    let centre = at(0.0, 0.0, 5.0);
    for last in [0, 31_000, 99_999] {
        let lost = FOLLOW.locate(&path.view(), Some(last), centre, 0.05);
        assert!(lost.off_path);
        let arc = lost.closest.arc_length(&path.view()) - f64::from(u32::try_from(last).unwrap());
        assert!(arc.abs() <= 8.0 || arc.abs() >= 1e5 - 8.0, "{last} {arc}");
    }
    let first = FOLLOW.locate(&path.view(), None, centre, 0.05);
    assert!(first.off_path && !first.direction_changed);
}

#[test]
fn test_follow_lost_on_many_laps_is_found_where_the_search_comes_near() {
    // 400 laps of 1,000 m: more boxes are near than a step visits.
    let lap = |k: u32| core::f64::consts::TAU * f64::from(k) / 1e3;
    let (x, y): (Vec<_>, Vec<_>) = (0..400_000)
        .map(|k| (160.0 * cos(lap(k)), 160.0 * sin(lap(k))))
        .unzip();
    let path = Path::new(&x, &y, None, true).unwrap();
    let vehicle = at(-160.0, 0.5, 5.0);
    let found = FOLLOW.find_anew(&path.view(), vehicle);
    assert!(!found.is_exact);
    let place = FOLLOW.locate(&path.view(), Some(0), vehicle, 0.05);
    assert!(place.off_path && place.closest.squared_distance < 16.0);
}
