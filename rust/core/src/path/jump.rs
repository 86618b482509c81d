//! The search of [`lookahead`](super::lookahead) without visiting every grid point.
//!
//! Along a segment the distance from the vehicle falls to a least value and rises again, so the
//! points on the circle lie in at most two stretches, whose ends are roots of a quadratic. The
//! search jumps to the start of each and applies the plain comparison from there. Where rounding
//! could matter the stretches are taken wider than they are, so the first point found is the
//! point that the plain loop finds; `tests` below holds the two together.

use super::resample::SegmentGrid;
use super::view::{PathView, get_distance};
use crate::Point;
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
    let circle = Circle {
        position,
        lookahead,
        tolerance,
    };
    let (first, mut here) = match path.previous(nearest) {
        Some(previous) => (previous, previous),
        None => (nearest, nearest),
    };
    // The window's end as `resample::window` has it: the first waypoint that is far enough
    // ahead, the end of an open path, or once around a closed one.
    let start_arc = path.arc(nearest);
    let mut passed_nearest = first == nearest;
    let mut lap = 0.0;
    let mut from = path.waypoint(here);
    let mut visited = 0;
    while visited < path.segments() {
        let Some(next) = path.next(here) else { break };
        let to = path.waypoint(next);
        if let Some(point) = circle.first_point_on(from, to, spacing) {
            return (point, true);
        }
        if passed_nearest {
            if next < here {
                lap = path.length();
            }
            if path.arc(next) + lap - start_arc >= ahead {
                return (to, circle.carries(to));
            }
        }
        passed_nearest = true;
        visited += 1;
        here = next;
        from = to;
    }
    (from, circle.carries(from))
}

/// The lookahead circle with its threshold.
#[derive(Clone, Copy)]
struct Circle {
    position: Point,
    lookahead: f64,
    tolerance: f64,
}

impl Circle {
    /// The plain comparison.
    #[inline]
    fn carries(&self, point: Point) -> bool {
        (get_distance(self.position, point) - self.lookahead).abs() <= self.tolerance
    }

    /// The first grid point of the segment from `start` to `end` that lies on the circle.
    #[inline]
    fn first_point_on(&self, start: Point, end: Point, spacing: f64) -> Option<Point> {
        let to_start = start - self.position;
        let to_end = end - self.position;
        let size = self.position.x.abs()
            + self.position.y.abs()
            + start.x.abs()
            + start.y.abs()
            + end.x.abs()
            + end.y.abs();
        // More than the plain arithmetic can be off: a grid point is a product and a sum, its
        // distance two differences, two squares and a root, each rounded within EPSILON of `size`.
        let margin = 32.0 * f64::EPSILON * size;
        let inner = self.lookahead - self.tolerance - margin;
        let at_start = to_start.x * to_start.x + to_start.y * to_start.y;
        let at_end = to_end.x * to_end.x + to_end.y * to_end.y;
        // The distance along a segment is largest at an end.
        if inner > 0.0 && at_start < inner * inner && at_end < inner * inner {
            return None;
        }
        self.search(
            SegmentGrid::between(start, end, spacing),
            to_start,
            at_start,
            inner,
            margin,
        )
    }

    /// The search where a point may lie on the circle. `at_start` is the squared distance of the
    /// segment's start; `inner` the radius within which no point can.
    fn search(
        &self,
        grid: SegmentGrid,
        to_start: Point,
        at_start: f64,
        inner: f64,
        margin: f64,
    ) -> Option<Point> {
        let along = grid.along;
        let count = from_count(grid.count);
        let squared_length = along.x * along.x + along.y * along.y;
        let approach = to_start.x * along.x + to_start.y * along.y;
        let outer = self.lookahead + self.tolerance + margin;
        // Of squared_length t^2 + 2 approach t + at_start = radius^2, with what rounding may add.
        let discriminant =
            |radius: f64| approach * approach - squared_length * (at_start - radius * radius);
        let slack = 64.0
            * f64::EPSILON
            * (approach * approach + squared_length * (at_start + outer * outer));

        let exit = || {
            let narrowed = discriminant(inner) - slack;
            if narrowed > 0.0 {
                Self::index_before((sqrt(narrowed) - approach) / squared_length, count)
            } else {
                0
            }
        };

        let mut index = 0;
        let mut jumped = inner <= 0.0;
        if !jumped && at_start < inner * inner {
            jumped = true;
            index = exit();
        } else if at_start > outer * outer {
            let widened = discriminant(outer) + slack;
            if approach >= 0.0 || widened < 0.0 {
                return None;
            }
            let entry = (-approach - sqrt(widened)) / squared_length;
            index = Self::index_before(entry, count);
        }
        while index < grid.count {
            let point = grid.point(index);
            let difference = get_distance(self.position, point) - self.lookahead;
            if difference.abs() <= self.tolerance {
                return Some(point);
            }
            if difference > self.tolerance + margin {
                let fraction = from_count(index) / count;
                if approach + fraction * squared_length > 0.0 {
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

    /// A grid index that lies before `fraction` of the segment, with one to spare for rounding.
    #[inline]
    fn index_before(fraction: f64, count: f64) -> usize {
        to_count(fraction * count).saturating_sub(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Path;
    use crate::path::lookahead::get_lookahead_point;
    use crate::path::resample::{Grid, window};
    use alloc::vec::Vec;
    use proptest::prelude::*;

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
        #[test]
        fn test_jump_finds_what_the_plain_loop_finds(
            (path, origin) in paths(),
            nearest in 0_usize..30,
            place in (-12.0..12.0_f64, -12.0..12.0_f64),
            on_the_path in any::<bool>(),
            lookahead in prop_oneof![0.0..15.0, Just(1.0), Just(6.0), Just(0.0)],
            tangent in any::<bool>(),
            tolerance in prop_oneof![Just(0.01), 1e-9..0.5],
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
            let grid = Grid::new(view, window(&view, nearest, ahead), spacing);
            let plain = get_lookahead_point(&grid, position, lookahead, tolerance);
            let found = find_lookahead_point(
                &view, nearest, ahead, spacing, position, lookahead, tolerance,
            );
            prop_assert_eq!(found, (plain.point, plain.found));
        }
    }
}
