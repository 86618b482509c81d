//! The search of [`lookahead`](super::lookahead) without visiting every grid point.
//!
//! Along a segment the distance from the vehicle falls to a least value and rises again, so the
//! points on the circle lie in at most two stretches, whose ends are roots of a quadratic. The
//! search jumps to the start of each and applies the plain comparison from there. Where rounding
//! could matter the stretches are taken wider than they are, so the first point found is the
//! point that the plain loop finds; `tests` below holds the two together.

use super::resample::SegmentGrid;
use super::view::PathView;
use crate::geometry::{Point, get_distance, squared_distance};
use crate::math::{from_count, sqrt, to_count};

/// The point that [`get_lookahead_point`](super::lookahead::get_lookahead_point) finds in the
/// window from one waypoint behind `nearest` to `ahead` [m] of arc beyond it, and whether it lies
/// on the circle.
#[inline]
pub fn find_lookahead_point(
    path: &PathView<'_>,
    nearest: usize,
    ahead: f64,
    spacing: f64,
    position: Point,
    lookahead: f64,
    tolerance: f64,
) -> (Point, bool) {
    let circle = Circle::new(position, lookahead, tolerance);
    let (mut here, mut ends_window) = match path.previous(nearest) {
        Some(previous) => (previous, false),
        None => (nearest, true),
    };
    // The window ends as `resample::window` has it: at the first waypoint that is far enough
    // ahead, at the end of an open path, or once around a closed one.
    let start_arc = path.arc(nearest);
    let mut lap = 0.0;
    // Segments with both ends well inside the circle carry no point on it. The run of them that
    // most windows start with is left behind in one go, where it does not end the window.
    let mut run = circle.clear_run(path, here);
    if run > 0 && path.arc(here + run) - start_arc < ahead {
        here += run;
        ends_window = true;
    } else {
        run = 0;
    }
    let mut from = path.waypoint(here);
    let mut from_inside = circle.clears(from);
    for _ in run..path.segments() {
        let Some(next) = path.next(here) else { break };
        let to = path.waypoint(next);
        let to_inside = circle.clears(to);
        // The distance along a segment is largest at an end.
        if !(from_inside && to_inside)
            && let Some(point) = circle.first_point_on(from, to, spacing)
        {
            return (point, true);
        }
        if ends_window {
            if next < here {
                lap = path.length();
            }
            if path.arc(next) + lap - start_arc >= ahead {
                return (to, circle.carries(to));
            }
        }
        ends_window = true;
        (here, from, from_inside) = (next, to, to_inside);
    }
    (from, circle.carries(from))
}

/// More than the plain arithmetic can be off, as a share of the numbers in it: a grid point is a
/// product and a sum, its distance two differences, two squares and a root, which the lookahead
/// and its threshold are then taken from.
const MARGIN: f64 = 32.0 * f64::EPSILON;

/// The lookahead circle with its threshold.
#[derive(Clone, Copy)]
struct Circle {
    position: Point,
    lookahead: f64,
    tolerance: f64,
    /// The square of a radius within which no grid point can be on the circle; 0 for none.
    squared_clear: f64,
}

impl Circle {
    #[inline]
    fn new(position: Point, lookahead: f64, tolerance: f64) -> Self {
        // Within the circle no number is larger than this.
        let size = 2.0 * (position.x.abs() + position.y.abs() + 2.0 * lookahead + tolerance);
        let clear = lookahead - tolerance - MARGIN * size;
        let squared_clear = if clear > 0.0 { clear * clear } else { 0.0 };
        Self {
            position,
            lookahead,
            tolerance,
            squared_clear,
        }
    }

    /// Whether a point is so far inside that it cannot be on the circle.
    #[inline]
    fn clears(&self, point: Point) -> bool {
        squared_distance(self.position, point) < self.squared_clear
    }

    /// How many segments from waypoint `here` on have both ends cleared; at most a few dozen, and
    /// none across the seam of a closed path.
    #[inline]
    fn clear_run(&self, path: &PathView<'_>, here: usize) -> usize {
        let end = path.len().min(here + 32);
        let (Some(x), Some(y)) = (path.x().get(here..end), path.y().get(here..end)) else {
            return 0;
        };
        let out = x
            .iter()
            .zip(y)
            .position(|(&x, &y)| !self.clears(Point::new(x, y)));
        out.unwrap_or(x.len()).saturating_sub(1)
    }

    /// The plain comparison.
    #[inline]
    fn carries(&self, point: Point) -> bool {
        (get_distance(self.position, point) - self.lookahead).abs() <= self.tolerance
    }

    /// The first grid point of the segment from `start` to `end` that lies on the circle.
    #[inline]
    fn first_point_on(&self, start: Point, end: Point, spacing: f64) -> Option<Point> {
        let grid = SegmentGrid::between(start, end, spacing);
        let count = from_count(grid.count);
        let margin = MARGIN
            * (self.lookahead
                + self.tolerance
                + self.position.x.abs()
                + self.position.y.abs()
                + start.x.abs()
                + start.y.abs()
                + end.x.abs()
                + end.y.abs());
        let inner = self.lookahead - self.tolerance - margin;
        let outer = self.lookahead + self.tolerance + margin;
        let distances = SquaredDistances::new(start - self.position, grid.along, outer);
        // The last grid index before the segment leaves the inner circle.
        let exit = || to_count(distances.exit(inner).unwrap_or(0.0) * count);

        let mut index = 0;
        let mut jumped = inner <= 0.0;
        if !jumped && distances.at_start < inner * inner {
            jumped = true;
            index = exit() + 1;
        } else if distances.at_start > outer * outer {
            index = to_count(distances.entry(outer)? * count).saturating_sub(1);
        }
        while index < grid.count {
            let point = grid.point(index);
            let difference = get_distance(self.position, point) - self.lookahead;
            if difference.abs() <= self.tolerance {
                return Some(point);
            }
            if difference > self.tolerance + margin {
                if distances.grow_at(from_count(index) / count) {
                    // Outside the circle, and going away from it.
                    return None;
                }
            } else if !jumped && difference < -(self.tolerance + 2.0 * margin) {
                // Inside the circle: on to where the segment leaves it. Both that place and this
                // one are inside, so all between them is.
                jumped = true;
                index = index.max(exit());
            }
            index += 1;
        }
        None
    }
}

/// The squared distance of a segment's points from the vehicle: at the fraction `t` of the segment
///
/// ```text
/// squared_length t² + 2 approach t + at_start
/// ```
struct SquaredDistances {
    squared_length: f64,
    /// 1 over `squared_length`.
    inverse: f64,
    approach: f64,
    at_start: f64,
    /// What rounding may add to a discriminant.
    slack: f64,
}

impl SquaredDistances {
    /// Of a segment `along` from a start that lies at `to_start` from the vehicle; `outer` is the
    /// largest radius that will be asked for.
    #[inline]
    fn new(to_start: Point, along: Point, outer: f64) -> Self {
        let squared_length = along.dot(&along);
        let approach = to_start.dot(&along);
        let at_start = to_start.dot(&to_start);
        Self {
            squared_length,
            inverse: 1.0 / squared_length,
            approach,
            at_start,
            slack: 64.0
                * f64::EPSILON
                * (approach * approach + squared_length * (at_start + outer * outer)),
        }
    }

    /// A quarter of the discriminant of the equation for the points at a `radius`.
    #[inline]
    fn discriminant(&self, radius: f64) -> f64 {
        self.approach * self.approach - self.squared_length * (self.at_start - radius * radius)
    }

    /// The fraction at which the segment surely has not yet left the circle of this `radius`.
    #[inline]
    fn exit(&self, radius: f64) -> Option<f64> {
        let narrowed = self.discriminant(radius) - self.slack;
        (narrowed > 0.0).then(|| (sqrt(narrowed) - self.approach) * self.inverse)
    }

    /// The fraction before which the segment, from outside, surely does not enter the circle of
    /// this `radius`; None if it never does.
    #[inline]
    fn entry(&self, radius: f64) -> Option<f64> {
        let widened = self.discriminant(radius) + self.slack;
        if self.approach >= 0.0 || widened < 0.0 {
            return None;
        }
        Some((-self.approach - sqrt(widened)) * self.inverse)
    }

    /// Whether the distance grows at a fraction of the segment.
    #[inline]
    fn grow_at(&self, fraction: f64) -> bool {
        self.approach + fraction * self.squared_length > 0.0
    }
}
