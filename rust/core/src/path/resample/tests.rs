use super::*;
use crate::Path;
use alloc::vec::Vec;

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
