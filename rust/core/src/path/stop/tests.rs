use super::super::tests::{FOLLOW, at, shuttle};
use super::*;
use crate::Path;
use crate::geometry::Point;
use alloc::vec::Vec;
use proptest::prelude::*;

fn ahead(follow: &Follow, waypoint: usize, x: f64, speed: f64) -> Ahead {
    let path = shuttle();
    let at = follow.locate(&path.view(), Some(waypoint), at(x, 0.2, speed), 0.05);
    Ahead::of(&path.view(), follow, &at)
}

#[test]
fn test_distance_to_stop_is_the_rear_axles_whatever_point_is_followed() {
    for reference_offset in [3.0, 0.0, -1.5] {
        let follow = Follow {
            reference_offset,
            ..FOLLOW
        };
        for (waypoint, x, speed, distance) in [
            (0, 5.0, 1.0, 15.0),
            (1, 19.0, 1.0, 1.0),
            (2, 18.0, -1.0, 8.0),
            (2, 10.5, -1.0, 0.5),
            (3, 12.0, 1.0, 18.0),
            (4, 31.0, 1.0, -1.0),
        ] {
            let found = ahead(&follow, waypoint, x, speed).distance_to_stop;
            assert!(
                (found - distance).abs() < 1e-9,
                "{reference_offset} {x} {found}"
            );
        }
    }
}

#[test]
fn test_reference_speed_brakes_evenly_and_never_stands_before_a_stop() {
    // From 2 m/s to 0.3 m/s, the creeping speed, over 10 m.
    let at = |x: f64| ahead(&FOLLOW, 1, x, 1.0).reference_speed.unwrap();
    assert!((at(15.0) - sqrt(0.5 * (4.0 + 0.09))).abs() < 1e-12);
    assert!((at(19.84) - 0.3).abs() < 0.1 && at(19.84) > 0.3);
    // Standing speeds at both ends of a leg are the creeping speed all along, backwards.
    let back = ahead(&FOLLOW, 2, 15.0, -1.0).reference_speed.unwrap();
    assert!((back + 0.3).abs() < 1e-12);
    // Just after the cusp, with the rear axle still before it, it is that of the new leg.
    let turned = ahead(&FOLLOW, 1, 19.9, 0.3).reference_speed.unwrap();
    assert!((turned + 0.3).abs() < 1e-12);
}

#[test]
fn test_speed_slower_than_creeping_stays_what_the_path_says() {
    let path = Path::new(&[0.0, 10.0], &[0.0; 2], Some(&[0.1, 0.0]), false).unwrap();
    let speed = speed_beside(&path.view(), &[0.1, 0.0], (0, Some(0)), 9.0, 0.0, 0.3);
    assert!((speed - 0.1).abs() < 1e-12);
}

#[test]
fn test_closed_path_without_a_cusp_has_no_stop() {
    let (x, y) = ([0.0, 10.0, 10.0, 0.0], [0.0, 0.0, 10.0, 10.0]);
    for backwards in [false, true] {
        let path = Path::new(&x, &y, None, true).unwrap();
        let path = path.with_reverse(&[backwards; 4]).unwrap();
        for index in 0..4 {
            assert_eq!(path.view().section_end(index), None);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn test_section_from_the_list_is_that_of_the_scan(
        reverse in proptest::collection::vec(any::<bool>(), 3..60),
        closed: bool,
    ) {
        let points = (0..reverse.len()).map(|k| {
            let k = crate::math::from_count(k);
            Point::new(k, 0.01 * k * k)
        });
        let (x, y): (Vec<_>, Vec<_>) = points.map(|point| (point.x, point.y)).unzip();
        let path = Path::new(&x, &y, None, closed).unwrap().with_reverse(&reverse).unwrap();
        for index in 0..path.view().segments() {
            let view = path.view();
            prop_assert_eq!(view.section(index), view.section_by_scan(index));
        }
    }
}
