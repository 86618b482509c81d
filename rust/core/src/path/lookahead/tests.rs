use super::*;
use crate::path::jump::find_lookahead_point;
use crate::path::locate::{OPPOSITE, locate_by_scan};
use crate::path::resample::{Grid, MAX_GRID_POINTS, Window, window};
use crate::{Path, PathError};
use alloc::vec::Vec;
use proptest::prelude::*;

#[test]
fn test_lookahead_straight_lies_on_the_circle() {
    let path = Path::new(&[0.0, 10.0, 20.0, 30.0], &[0.0; 4], None, false).unwrap();
    let view = path.view();
    let grid = Grid::new(view, window(&view, 0, 20.0), 0.01);
    let found = get_lookahead_point(&grid, Point::new(1.0, 0.0), 6.0, 0.01);
    assert!(found.found);
    assert!((found.point.x - 7.0).abs() <= 0.01 + 1e-12);
}

#[test]
fn test_lookahead_out_of_reach_takes_the_last() {
    let path = Path::new(&[0.0, 10.0], &[0.0; 2], None, false).unwrap();
    let view = path.view();
    let grid = Grid::new(view, window(&view, 0, 20.0), 0.01);
    let lost = get_lookahead_point(&grid, Point::new(0.0, 0.0), 50.0, 0.01);
    assert_eq!(
        lost,
        Lookahead {
            index: 1000,
            point: Point::new(10.0, 0.0),
            found: false
        }
    );
}

fn crossing(path: &Path, position: (f64, f64), lookahead: f64) -> (Point, bool) {
    let position = Point::new(position.0, position.1);
    let view = path.view();
    let closest = locate_by_scan(&view, 0, position, Point::new(1.0, 0.0), 1e3, OPPOSITE);
    get_crossing(&view, &closest, position, lookahead)
}

#[test]
fn test_crossing_lies_on_the_circle_ahead() {
    let path = Path::new(&[0.0, 10.0, 20.0], &[0.0, 0.0, 10.0], None, false).unwrap();
    let (point, found) = crossing(&path, (3.0, 3.0), 5.0);
    assert!(found);
    assert_eq!(point, Point::new(7.0, 0.0));
    let (point, found) = crossing(&path, (8.0, 0.0), 6.0);
    assert!(found && point.y > 0.0);
    assert!((get_distance(Point::new(8.0, 0.0), point) - 6.0).abs() < 1e-14);
}

#[test]
fn test_crossing_before_the_start_lies_on_the_circle_too() {
    let path = Path::new(&[0.0, 1.0, 2.0], &[0.0; 3], None, false).unwrap();
    // On the extension, on the first segment, on the second.
    for (at, expected) in [(-9.0, -5.0), (-3.5, 0.5), (-2.5, 1.5)] {
        let found = crossing(&path, (at, 3.0), 5.0);
        assert_eq!(found, (Point::new(expected, 0.0), true));
    }
}

#[test]
fn test_crossing_too_far_off_or_touching_is_the_closest_point() {
    let path = Path::new(&[0.0, 10.0], &[0.0; 2], None, false).unwrap();
    for lookahead in [5.0, 4.0, 0.0] {
        assert_eq!(
            crossing(&path, (3.0, 5.0), lookahead),
            (Point::new(3.0, 0.0), false)
        );
    }
}

#[test]
fn test_crossing_past_the_end_goes_on_straight() {
    let path = Path::new(&[0.0, 10.0], &[0.0; 2], None, false).unwrap();
    for at in [7.0, 10.0, 30.0, 1e8] {
        let (point, found) = crossing(&path, (at, 3.0), 5.0);
        assert_eq!((point, found), (Point::new(at + 4.0, 0.0), true));
    }
}

#[test]
fn test_crossing_of_a_path_within_the_circle_is_a_quarter_round() {
    let path = Path::new(&[0.0, 1.0, 1.0, 0.0], &[0.0, 0.0, 1.0, 1.0], None, true).unwrap();
    assert_eq!(
        crossing(&path, (0.5, 0.2), 9.0),
        (Point::new(1.0, 0.0), false)
    );
}

#[test]
fn test_crossing_is_the_first_one_that_a_walk_over_all_segments_finds() {
    let places = 0..200;
    let x: Vec<f64> = places
        .clone()
        .map(|k| (f64::from(k) * 0.11).sin() * 9.0)
        .collect();
    let y: Vec<f64> = places.map(|k| (f64::from(k) * 0.07).cos() * 7.0).collect();
    for closed in [false, true] {
        let path = Path::new(&x, &y, None, closed).unwrap();
        let view = path.view();
        for k in 0..400_u32 {
            let at = |n: u32| f64::from(k * n % 397) / 397.0;
            let position = Point::new(20.0 * at(31) - 10.0, 16.0 * at(77) - 8.0);
            let lookahead = 0.2 + 12.0 * at(53);
            let heading = Point::new(1.0, 0.0);
            let closest = locate_by_scan(&view, 90, position, heading, 1e3, OPPOSITE);
            let found = get_crossing(&view, &closest, position, lookahead);
            if closest.squared_distance >= lookahead * lookahead {
                assert_eq!(found, (closest.point, false));
                continue;
            }
            let mut segment = closest.segment;
            let mut expected = None;
            for passed in 0..view.segments() {
                let (start, end) = view.segment(segment);
                let next = view.following(segment);
                if next.is_none() || get_distance(position, end) >= lookahead {
                    let from = if passed == 0 { closest.point } else { start };
                    let along = (end - start).dot(&(found.0 - from));
                    assert!(along >= -1e-9, "{closed} {k}");
                    let off = (end - start).perp(&(found.0 - from));
                    assert!(off.abs() < 1e-9, "{closed} {k}: on another segment");
                    expected = Some(get_distance(position, found.0));
                    break;
                }
                segment = next.unwrap_or(segment);
            }
            match expected {
                Some(distance) => assert!((distance - lookahead).abs() < 1e-9, "{closed} {k}"),
                None => assert!(!found.1, "{closed} {k}"),
            }
        }
    }
}

#[test]
fn test_window_one_waypoint_behind_to_the_arc_ahead() {
    let x: Vec<f64> = (0..50).map(f64::from).collect();
    let path = Path::new(&x, &[0.0; 50], None, false).unwrap();
    let view = path.view();
    assert_eq!(
        window(&view, 10, 20.0),
        Window {
            first: 9,
            segments: 21
        }
    );
    assert_eq!(
        window(&view, 0, 20.0),
        Window {
            first: 0,
            segments: 20
        }
    );
    assert_eq!(
        window(&view, 49, 20.0),
        Window {
            first: 48,
            segments: 1
        }
    );
}

#[test]
fn test_window_on_a_closed_path_crosses_the_seam_once() {
    let path = Path::new(&[0.0, 3.0, 3.0, 0.0], &[0.0, 0.0, 3.0, 3.0], None, true).unwrap();
    let view = path.view();
    assert_eq!(
        window(&view, 3, 4.0),
        Window {
            first: 2,
            segments: 3
        }
    );
    assert_eq!(
        window(&view, 0, 100.0),
        Window {
            first: 3,
            segments: 4
        }
    );
    let grid = Grid::new(view, window(&view, 3, 4.0), 1.0);
    assert_eq!(grid.points().count(), 10);
    assert_eq!(grid.last(), Point::new(3.0, 0.0));
}

#[test]
fn test_grid_that_is_too_large_is_refused_with_its_size() {
    let path = Path::new(&[0.0, 1e5, 1e9], &[0.0; 3], None, false).unwrap();
    let view = path.view();
    let points = |segments, spacing| {
        let grid = Grid::new(view, Window { first: 0, segments }, spacing);
        grid.checked().map(|grid| grid.points().count())
    };
    let refused = |points| {
        let most = MAX_GRID_POINTS;
        Err(PathError::GridTooLarge { points, most })
    };
    assert_eq!(points(1, 0.1), Ok(1_000_001));
    assert_eq!(points(1, 0.01), refused(10_000_001));
    assert_eq!(points(2, 1e-4), refused(10_000_000_000_001));
}

#[test]
fn test_grid_neighbours_at_most_the_spacing_apart() {
    let path = Path::new(&[0.0, 1.005, 2.0], &[0.0, 0.0, 0.3], None, false).unwrap();
    let view = path.view();
    let points: Vec<Point> = Grid::new(view, window(&view, 0, 20.0), 0.01)
        .points()
        .collect();
    assert_eq!(points.len(), 101 + 104 + 1);
    for (&here, &next) in points.iter().zip(points.iter().skip(1)) {
        assert!(get_distance(here, next) <= 0.01 + 1e-12);
    }
}

/// Waypoints from steps of a drawn length and turn, about an origin near or far away.
fn paths() -> impl Strategy<Value = (Path, f64)> {
    let step = (prop_oneof![Just(1.0), 0.05..3.0, Just(6.0)], -3.0..3.0_f64);
    let bend = prop_oneof![Just(0.0), Just(0.05), Just(1.0)];
    let origin = prop_oneof![Just(0.0), -1e3..1e3, Just(1e7), Just(-1e7)];
    (
        proptest::collection::vec(step, 2..30),
        bend,
        origin,
        any::<bool>(),
    )
        .prop_filter_map(
            "closing segment of no length",
            |(steps, bend, origin, closed)| {
                let (mut x, mut y, mut yaw) = (origin, -origin, 0.3);
                let (mut xs, mut ys) = (Vec::new(), Vec::new());
                for (length, turn) in steps {
                    xs.push(x);
                    ys.push(y);
                    yaw += bend * turn;
                    x += length * crate::math::cos(yaw);
                    y += length * crate::math::sin(yaw);
                }
                Path::new(&xs, &ys, None, closed && xs.len() > 2)
                    .ok()
                    .map(|path| (path, origin))
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn test_jump_finds_what_the_plain_loop_finds(
        (path, origin) in paths(),
        nearest in 0_usize..30,
        place in (-12.0..12.0_f64, -12.0..12.0_f64),
        on_the_path in any::<bool>(),
        lookahead in prop_oneof![0.0..15.0, Just(1.0), Just(6.0), Just(0.0)],
        tangent in any::<bool>(),
        tolerance in prop_oneof![Just(0.01), 1e-9..0.5, Just(1e3)],
        on_the_edge in prop_oneof![Just(0.0), Just(1.0), Just(-1.0)],
        spacing in prop_oneof![Just(0.01), 0.01..2.0],
        ahead in prop_oneof![Just(20.0), 0.1..40.0],
    ) {
        let view = path.view();
        let nearest = nearest % view.len();
        let position = if on_the_path {
            view.waypoint(nearest)
        } else {
            Point::new(origin + place.0, -origin + place.1)
        };
        // A circle that touches a segment, to within rounding.
        let lookahead = if tangent {
            let (start, end) = view.segment(nearest % view.segments());
            let along = end - start;
            let to = position - start;
            let length = sqrt(along.x * along.x + along.y * along.y);
            ((along.x * to.y - along.y * to.x) / length).abs()
        } else {
            lookahead
        };
        // ... or whose threshold's inner or outer edge does.
        let lookahead = (lookahead + on_the_edge * tolerance).max(0.0);
        let grid = Grid::new(view, window(&view, nearest, ahead), spacing);
        let plain = get_lookahead_point(&grid, position, lookahead, tolerance);
        let found = find_lookahead_point(
            &view, nearest, ahead, spacing, position, lookahead, tolerance,
        );
        prop_assert_eq!(found, (plain.point, plain.found));
    }
}
