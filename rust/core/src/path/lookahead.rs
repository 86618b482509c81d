//! Where do I aim? The paper's search for the lookahead point, and an exact one.

use super::projection::ClosestPoint;
use super::resample::Grid;
use super::view::PathView;
use crate::geometry::{Point, get_distance, squared_distance};
use crate::math::{saturate, sqrt};

/// What the search came back with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lookahead {
    /// The index of the point in the grid.
    pub index: usize,
    /// The point itself [m].
    pub point: Point,
    /// Whether it lies on the circle; otherwise it is the last point of the grid.
    pub found: bool,
}

/// The first grid point whose distance from `position` differs from `lookahead` [m] by at most
/// `tolerance` [m], else the last: the paper's `get_lookahead_point_index` (Equation 5) and
/// `get_lookahead_point` in one pass.
///
/// The equation prints only the distance; the text, "almost equal to the lookahead distance",
/// says what is compared.
pub fn get_lookahead_point(
    grid: &Grid<'_>,
    position: Point,
    lookahead: f64,
    tolerance: f64,
) -> Lookahead {
    let mut last = Lookahead {
        index: 0,
        point: grid.last(),
        found: false,
    };
    for (index, point) in grid.points().enumerate() {
        let difference = get_distance(position, point) - lookahead;
        if difference.abs() <= tolerance {
            return Lookahead {
                index,
                point,
                found: true,
            };
        }
        last.index = index;
    }
    last
}

/// The index alone: the paper's `get_lookahead_point_index` (Equation 5).
pub fn get_lookahead_point_index(
    grid: &Grid<'_>,
    position: Point,
    lookahead: f64,
    tolerance: f64,
) -> usize {
    get_lookahead_point(grid, position, lookahead, tolerance).index
}

/// The first point of the path, from `closest` on, that is `lookahead` [m] away from `position`,
/// and whether there is one.
///
/// Where an open path ends, or the vehicle has to turn round, the last segment goes on as a
/// straight line, so there always is one while the closest point lies within the circle. Of a
/// position farther than `lookahead` from its closest point the point is the closest point, in
/// which a circle that touches the path ends as well; on a closed path that lies within the circle
/// it is the point a quarter round.
#[inline]
pub fn get_crossing(
    path: &PathView<'_>,
    closest: &ClosestPoint,
    position: Point,
    lookahead: f64,
) -> (Point, bool) {
    let squared_lookahead = lookahead * lookahead;
    if closest.squared_distance >= squared_lookahead {
        return (closest.point, false);
    }
    // From the closest point itself, which keeps the digits far beyond the end of the path.
    let mut from = closest.point;
    let mut segment = closest.segment;
    // How much of the segment is left; more than all of it before the start of the path.
    let mut remaining = 1.0 - closest.fraction;
    for _ in 0..path.segments() {
        let (start, end) = path.segment(segment);
        let next = path.following(segment);
        let goes_on = next.is_none();
        if goes_on || squared_distance(position, end) >= squared_lookahead {
            let along = end - start;
            let fraction = exit(from - position, along, squared_lookahead);
            let fraction = if goes_on {
                fraction
            } else {
                saturate(fraction, 0.0, remaining)
            };
            let point = Point::new(from.x + fraction * along.x, from.y + fraction * along.y);
            return (point, true);
        }
        from = end;
        remaining = 1.0;
        segment = next.unwrap_or(segment);
    }
    (quarter_round(path, closest), false)
}

/// Where, in multiples of `along`, a line that starts at `from` inside the circle about the origin
/// leaves it.
#[inline]
fn exit(from: Point, along: Point, squared_radius: f64) -> f64 {
    let a = along.x * along.x + along.y * along.y;
    let b = from.x * along.x + from.y * along.y;
    let c = from.x * from.x + from.y * from.y - squared_radius;
    let inside = b * b - a * c;
    let root = if inside > 0.0 { sqrt(inside) } else { 0.0 };
    // The form that does not subtract.
    if b > 0.0 {
        -c / (b + root)
    } else {
        (root - b) / a
    }
}

/// The waypoint at least a quarter of a closed path on from `closest`.
fn quarter_round(path: &PathView<'_>, closest: &ClosestPoint) -> Point {
    let mut segment = closest.segment;
    let mut passed = 0.0;
    for _ in 0..path.segments() {
        passed += path.segment_length(segment);
        segment = path.following(segment).unwrap_or(segment);
        if passed >= 0.25 * path.length() {
            break;
        }
    }
    path.waypoint(segment)
}

#[cfg(test)]
mod tests {
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
}
