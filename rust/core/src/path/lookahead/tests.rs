use super::*;
use crate::Path;
use crate::path::locate::{OPPOSITE, locate_by_scan};
use crate::path::resample::window;

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
