//! Where am I? The nearest waypoint, and the exact projection beside it.

use super::view::{PathView, squared_distance};
use crate::Point;
use crate::math::{atan2, saturate, sqrt};

/// The foot of a position on the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// The segment that carries the foot.
    pub segment: usize,
    /// Where on the segment: 0 at its start, 1 at its end; beyond both on the extensions.
    pub fraction: f64,
    /// The foot [m].
    pub point: Point,
    /// Arc length at the foot [m].
    pub arc_length: f64,
    /// Signed distance to the foot [m], positive left of the path.
    pub cross_track_error: f64,
    /// Direction of the segment [rad].
    pub path_yaw: f64,
}

/// The waypoint nearest to `position` of all; the first of several. Visits every waypoint.
pub fn nearest_waypoint(path: &PathView<'_>, position: Point) -> usize {
    let mut nearest = 0;
    let mut least = f64::INFINITY;
    for (index, (&x, &y)) in path.x().iter().zip(path.y()).enumerate() {
        let distance = squared_distance(position, Point::new(x, y));
        if distance < least {
            least = distance;
            nearest = index;
        }
    }
    nearest
}

/// Walks from waypoint `from` to a waypoint with no nearer neighbour: the paper's near
/// neighbourhood. The walk goes on as long as it gets strictly nearer, forward first.
pub fn walk(path: &PathView<'_>, from: usize, position: Point) -> usize {
    let mut nearest = from;
    let mut least = squared_distance(position, path.waypoint(nearest));
    while let Some(next) = path.next(nearest) {
        let distance = squared_distance(position, path.waypoint(next));
        if distance < least {
            least = distance;
            nearest = next;
        } else {
            break;
        }
    }
    while let Some(previous) = path.previous(nearest) {
        let distance = squared_distance(position, path.waypoint(previous));
        if distance < least {
            least = distance;
            nearest = previous;
        } else {
            break;
        }
    }
    nearest
}

/// The waypoint to go on from: a walk from the last one, or the nearest of all where there is
/// no last one on this path.
#[inline]
pub fn locate(path: &PathView<'_>, last: Option<usize>, position: Point) -> usize {
    match last {
        Some(last) if last < path.len() => walk(path, last, position),
        _ => nearest_waypoint(path, position),
    }
}

/// Projects `position` exactly onto the two segments at waypoint `nearest`; the nearer foot
/// counts, the segment ahead where both are as near.
///
/// Before the first and beyond the last waypoint of an open path the end segments go on as
/// straight lines, so the cross-track error stays the offset to the side.
#[inline]
pub fn project(path: &PathView<'_>, nearest: usize, position: Point) -> Projection {
    let incoming = path.previous(nearest);
    let outgoing = path.next(nearest).map(|_| nearest);
    let foot = match (incoming, outgoing) {
        (Some(incoming), Some(outgoing)) => {
            let behind = Foot::new(path, incoming, position);
            let ahead = Foot::new(path, outgoing, position);
            if behind.squared_distance < ahead.squared_distance {
                behind
            } else {
                ahead
            }
        }
        (Some(only), None) | (None, Some(only)) => Foot::new(path, only, position),
        (None, None) => Foot::new(path, nearest, position),
    };
    foot.projection(path)
}

/// The foot of a position on one segment: what is needed to choose between two.
#[derive(Clone, Copy)]
struct Foot {
    segment: usize,
    fraction: f64,
    point: Point,
    along: Point,
    squared_length: f64,
    squared_distance: f64,
    side: f64,
}

impl Foot {
    #[inline]
    fn new(path: &PathView<'_>, segment: usize, position: Point) -> Self {
        let (start, end) = path.segment(segment);
        let along = end - start;
        let to = position - start;
        let squared_length = along.x * along.x + along.y * along.y;
        let open = !path.is_closed();
        let low = if open && segment == 0 {
            f64::NEG_INFINITY
        } else {
            0.0
        };
        let high = if open && segment + 1 == path.segments() {
            f64::INFINITY
        } else {
            1.0
        };
        let fraction = saturate(
            (to.x * along.x + to.y * along.y) / squared_length,
            low,
            high,
        );
        let point = Point::new(start.x + fraction * along.x, start.y + fraction * along.y);
        Self {
            segment,
            fraction,
            point,
            along,
            squared_length,
            squared_distance: squared_distance(position, point),
            side: along.x * to.y - along.y * to.x,
        }
    }

    #[inline]
    fn projection(&self, path: &PathView<'_>) -> Projection {
        Projection {
            segment: self.segment,
            fraction: self.fraction,
            point: self.point,
            arc_length: path.arc(self.segment) + self.fraction * sqrt(self.squared_length),
            cross_track_error: sqrt(self.squared_distance).copysign(self.side),
            path_yaw: atan2(self.along.y, self.along.x),
        }
    }
}

/// Direction of the segment that leads to waypoint `nearest` [rad], of the one that leaves it
/// where none does: the path's heading as the published code takes it, up to a waypoint and a
/// half behind the foot.
pub fn path_yaw_behind(path: &PathView<'_>, nearest: usize) -> f64 {
    let (start, end) = path.segment(path.previous(nearest).unwrap_or(nearest));
    atan2(end.y - start.y, end.x - start.x)
}

/// The reference speed at a projection [m/s], between the waypoints' linearly; none where the
/// path has no speeds.
pub fn reference_speed(path: &PathView<'_>, projection: &Projection) -> Option<f64> {
    let speed = path.speed()?;
    let here = speed.get(projection.segment)?;
    let next = speed.get(path.next(projection.segment)?)?;
    Some(here + saturate(projection.fraction, 0.0, 1.0) * (next - here))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Path;
    use alloc::vec::Vec;

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
    fn test_walk_on_a_circle_finds_the_nearest_both_ways() {
        let angles = (0..100).map(|k| f64::from(k) * core::f64::consts::TAU / 100.0);
        let (x, y): (Vec<_>, Vec<_>) = angles
            .map(|a| (50.0 * crate::math::cos(a), 50.0 * crate::math::sin(a)))
            .unzip();
        let path = Path::new(&x, &y, None, true).unwrap();
        for from in [10, 99, 60] {
            let position = Point::new(48.0, -3.0);
            assert_eq!(
                walk(&path.view(), from, position),
                nearest_waypoint(&path.view(), position)
            );
        }
    }
}
