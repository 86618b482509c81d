//! Waypoints, projection, location; and what the tests of other files drive on.

use super::follow::Follow;
use super::locate::{OPPOSITE, locate};
use super::projection::{project, reference_speed};
use super::sound::{distinct_waypoints, sound};
use super::{Path, PathView};
use crate::error::PathError;
use crate::geometry::Point;
use crate::vehicle::VehicleState;
use alloc::vec::Vec;

/// How the front axle of a wheelbase of 3 m is followed.
pub(super) const FOLLOW: Follow = Follow {
    base: 0.0,
    reference_offset: 3.0,
    rear_axle: 0.0,
    search_distance: 6.0,
    lost_distance: 30.0,
    arrival_distance: 0.15,
    opposite_distance: 10.0,
};

/// 20 m forward along x, 10 m back, 20 m forward again, standing at each cusp and at the end.
pub(super) fn shuttle() -> Path {
    let x: [f64; 6] = [0.0, 10.0, 20.0, 10.0, 20.0, 30.0];
    let speed = [2.0, 2.0, 0.0, 0.0, 2.0, 0.0];
    let path = Path::new(&x, &[0.0; 6], Some(&speed), false).unwrap();
    path.with_reverse(&[false, false, true, false, false, false])
        .unwrap()
}

/// A vehicle that looks along x.
pub(super) fn at(x: f64, y: f64, speed: f64) -> VehicleState {
    VehicleState {
        x,
        y,
        yaw: 0.0,
        speed,
    }
}

#[test]
fn test_path_arc_length_open_and_closed() {
    let (x, y) = ([0.0, 3.0, 3.0], [0.0, 0.0, 4.0]);
    let mut s = [0.0; 3];
    let open = PathView::new(&x, &y, None, false, &mut s).unwrap();
    assert_eq!((open.length(), open.segments()), (7.0, 2));
    assert_eq!(open.s(), [0.0, 3.0, 7.0]);
    let mut s = [0.0; 3];
    let closed = PathView::new(&x, &y, None, true, &mut s).unwrap();
    assert_eq!((closed.length(), closed.segments()), (12.0, 3));
}

#[test]
fn test_path_bad_waypoints_names_them() {
    let mut s = [0.0; 3];
    let error = |x: &[f64], y: &[f64], closed, s: &mut [f64]| {
        PathView::new(x, y, None, closed, s)
            .map(|_| ())
            .unwrap_err()
    };
    assert_eq!(
        error(&[0.0], &[0.0], false, &mut s[..1]),
        PathError::TooFewWaypoints { count: 1, least: 2 }
    );
    assert_eq!(
        error(&[0.0, 1.0, 1.0], &[0.0; 3], false, &mut s),
        PathError::Coinciding { index: 1, next: 2 }
    );
    assert_eq!(
        error(&[0.0, 1.0, 0.0], &[0.0, 1.0, 0.0], true, &mut s),
        PathError::Coinciding { index: 2, next: 0 }
    );
    assert_eq!(
        error(&[0.0, 1.0], &[0.0], false, &mut s[..2]),
        PathError::LengthMismatch {
            field: "y",
            length: 1,
            waypoints: 2
        }
    );
    assert!(matches!(
        error(&[0.0, f64::NAN], &[0.0; 2], false, &mut s[..2]),
        PathError::OutOfRange {
            field: "x",
            index: 1,
            ..
        }
    ));
}

#[test]
fn test_reverse_by_the_signs_of_the_speeds() {
    let x = [0.0, 1.0, 2.0, 1.0, 0.0, -1.0];
    let y = [0.0; 6];
    let directions = |speed: &[f64]| {
        let path = Path::new(&x, &y, Some(speed), false).unwrap();
        (0..5)
            .map(|k| path.view().is_reverse(k))
            .collect::<Vec<_>>()
    };
    assert_eq!(
        directions(&[1.0, 1.0, -1.0, 0.0, 0.0, -1.0]),
        [false, false, true, true, true]
    );
    assert_eq!(
        directions(&[0.0, 1.0, 0.0, -1.0, 0.0, 0.0]),
        [false, false, true, true, true]
    );
    assert!(
        Path::new(&x, &y, Some(&[1.0; 6]), false)
            .unwrap()
            .view()
            .reverse()
            .is_none()
    );
}

#[test]
fn test_distinct_waypoints_keep_the_last_of_several() {
    let x = [0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 0.0];
    let y = [0.0; 7];
    assert_eq!(distinct_waypoints(&x, &y, false), [1, 2, 5, 6]);
    assert_eq!(distinct_waypoints(&x, &y, true), [1, 2, 5]);
    assert_eq!(distinct_waypoints(&[1.0; 3], &[1.0; 3], true), [2]);
    // The last coincides with both before, which do not with each other.
    let close = [0.0, 1.2e-9, 0.6e-9, 1.0];
    assert_eq!(distinct_waypoints(&close, &[0.0; 4], false), [2, 3]);
}

#[test]
fn test_place_that_is_left_and_come_back_to_is_kept_once() {
    // As a simulator rolls at its start, to the millimetre: aside and back before it sets off.
    let x = [
        0, 0, 0, -1, 0, 1, 3, 5, 8, 13, 19, 26, 34, 43, 51, 60, 69, 78,
    ];
    let y = [
        0, 1, 1, 1, 0, -4, -10, -17, -28, -45, -68, -98, -134, -172, -212, -255, -300, -346,
    ];
    let [x, y] = [x, y].map(|each| each.map(|mm| 1e-3 * f64::from(mm)));
    let kept = sound(&x, &y, false, false).unwrap().kept.unwrap();
    let places = kept.iter().map(|&index| x.get(index));
    assert!(places.clone().zip(places.skip(1)).all(|(a, b)| a != b));
}

fn bent() -> Path {
    Path::new(
        &[0.0, 10.0, 10.0],
        &[0.0, 0.0, 10.0],
        Some(&[1.0, 2.0, 4.0]),
        false,
    )
    .unwrap()
}

#[test]
fn test_project_either_side_signs_the_error() {
    let path = bent();
    let left = project(&path.view(), 0, Point::new(4.0, 1.5));
    assert_eq!((left.segment, left.cross_track_error), (0, 1.5));
    assert!((left.fraction - 0.4).abs() < 1e-15);
    let right = project(&path.view(), 1, Point::new(12.0, 5.0));
    assert_eq!((right.segment, right.cross_track_error), (1, -2.0));
    assert_eq!(reference_speed(&path.view(), &right), Some(3.0));
}

#[test]
fn test_project_beyond_the_end_measures_to_the_side() {
    let path = bent();
    let beyond = project(&path.view(), 2, Point::new(9.0, 14.0));
    assert_eq!(beyond.cross_track_error, 1.0);
    assert_eq!(reference_speed(&path.view(), &beyond), Some(4.0));
}

#[test]
fn test_locate_out_and_back_keeps_to_the_branch_of_the_heading() {
    let x: Vec<f64> = (0..100).chain((0..100).rev()).map(f64::from).collect();
    let y: Vec<f64> = (0..200).map(|k| if k < 100 { 0.0 } else { 0.5 }).collect();
    let path = Path::new(&x, &y, None, false).unwrap();
    // Nearer to the other branch all the way, and near the turn.
    for (at, last) in [(50.2, 50), (95.7, 95), (97.5, 97)] {
        let position = Point::new(at, 0.4);
        let there = locate(
            &path.view(),
            last,
            position,
            Point::new(1.0, 0.0),
            6.0,
            OPPOSITE,
        );
        assert_eq!(there.segment, last);
        let turned = locate(
            &path.view(),
            last,
            position,
            Point::new(-1.0, 0.0),
            6.0,
            OPPOSITE,
        );
        assert_eq!(turned.segment > 99, at > 95.0);
    }
}
