//! The lookahead point: the paper's search, and an exact one.

use super::projection::ClosestPoint;
use super::resample::Grid;
use super::view::PathView;
use crate::geometry::{Point, get_distance, squared_distance};
use crate::math::{saturate, sqrt};

/// The result of the search.
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
        (last.index, last.point) = (index, point);
        last.found = (get_distance(position, point) - lookahead).abs() <= tolerance;
        if last.found {
            break;
        }
    }
    last
}

/// The first point of the path, from `closest` on, that is `lookahead` [m] away from `position`,
/// and whether there is one.
///
/// At an end of an open path and at a cusp the last segment goes on as a straight line, so there
/// always is one while the closest point lies within the circle. If the closest point is at least
/// `lookahead` away, it is the answer itself. On a closed path that lies within the circle the
/// answer is the point a quarter round.
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
    // Starts from the closest point itself, which keeps digits far beyond the end of the path.
    let mut from = closest.point;
    let mut segment = closest.segment;
    // Remaining share of the segment; more than 1 before the start of the path.
    let mut remaining = 1.0 - closest.fraction;
    let mut left = path.segments();
    while left > 0 {
        let (start, end) = path.segment(segment);
        let next = path.following(segment);
        let goes_on = next.is_none();
        let squared = squared_distance(position, end);
        if goes_on || squared >= squared_lookahead {
            let along = end - start;
            let fraction = exit(from - position, along, squared_lookahead);
            let fraction = if goes_on {
                fraction
            } else {
                saturate(fraction, 0.0, remaining)
            };
            return (from + along * fraction, true);
        }
        let next = next.unwrap_or(segment);
        let within = count_within(path, next, lookahead - sqrt(squared));
        segment = next + within;
        from = path.waypoint(segment);
        remaining = 1.0;
        left = left.saturating_sub(1 + within);
    }
    (quarter_round(path, closest), false)
}

/// How many segments from `segment` on certainly end within the circle: their arc is shorter than
/// `room`, how far inside the circle `segment` begins [m]. A shortcut: none would do.
#[inline]
fn count_within(path: &PathView<'_>, segment: usize, room: f64) -> usize {
    if path.reverse().is_some() {
        return 0;
    }
    let rounding = 1e-6 + 1e-14 * path.length();
    let farthest = path.arc(segment) + (room - rounding);
    // The last segment may go on without an end.
    let ends = path.s().get(segment + 1..path.len() - 1);
    let ends = ends.unwrap_or_default().iter();
    ends.take_while(|&&end| end <= farthest).count()
}

/// Where, in multiples of `along`, a line that starts at `from` inside the circle about the origin
/// leaves it.
#[inline]
fn exit(from: Point, along: Point, squared_radius: f64) -> f64 {
    let a = along.dot(&along);
    let b = from.dot(&along);
    let c = from.dot(&from) - squared_radius;
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
mod tests;
