//! The closest point of a segment, and the path's arc length, direction and speed there.

use super::view::PathView;
use crate::geometry::{Point, squared_distance};
use crate::math::{atan2, saturate, sqrt};

/// A position projected onto the path: the closest point, and what the path says there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// The segment of the closest point.
    pub segment: usize,
    /// Where on the segment: 0 at its start, 1 at its end; outside of 0..1 on an extension.
    pub fraction: f64,
    /// The closest point [m].
    pub point: Point,
    /// Arc length at the closest point [m].
    pub arc_length: f64,
    /// Distance to the closest point [m], positive left of the path.
    pub cross_track_error: f64,
    /// Direction of the segment [rad].
    pub path_yaw: f64,
}

/// The waypoint nearest to `position`; the first of several. Visits every waypoint.
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

/// Projects `position` onto the two segments that meet at waypoint `nearest`, and returns the
/// nearer point; that of the segment ahead if both are equally near.
///
/// Beyond the ends of an open path the end segments go on as straight lines, so that the
/// cross-track error remains the lateral offset.
#[inline]
pub fn project(path: &PathView<'_>, nearest: usize, position: Point) -> Projection {
    let incoming = path.previous(nearest);
    let behind = incoming.map(|incoming| ClosestPoint::new(path, incoming, position));
    let ahead = ClosestPoint::new(path, path.segment_at(nearest), position);
    behind
        .filter(|behind| behind.squared_distance < ahead.squared_distance)
        .unwrap_or(ahead)
        .projection(path)
}

/// The closest point of one segment. It holds what is needed to choose between segments; the rest
/// is computed on request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// The segment that carries the closest point.
    pub segment: usize,
    /// Where on the segment: 0 at its start, 1 at its end; beyond both on the extensions.
    pub fraction: f64,
    /// The closest point [m].
    pub point: Point,
    /// Square of the distance to the closest point [m^2].
    pub squared_distance: f64,
    pub(super) along: Point,
    pub(super) squared_length: f64,
    pub(super) side: f64,
}

impl ClosestPoint {
    /// The closest point of segment `segment`. At an end of the path and at a cusp the segment goes
    /// on as a straight line.
    #[inline]
    pub fn new(path: &PathView<'_>, segment: usize, position: Point) -> Self {
        let low = path.preceding(segment).map_or(f64::NEG_INFINITY, |_| 0.0);
        let high = path.following(segment).map_or(f64::INFINITY, |_| 1.0);
        Self::between(path, segment, position, low, high)
    }

    /// The closest point between both ends of the segment, without extension.
    #[inline]
    pub(super) fn within(path: &PathView<'_>, segment: usize, position: Point) -> Self {
        Self::between(path, segment, position, 0.0, 1.0)
    }

    #[inline]
    fn between(path: &PathView<'_>, segment: usize, position: Point, low: f64, high: f64) -> Self {
        let (start, end) = path.segment(segment);
        let along = end - start;
        let to = position - start;
        let squared_length = along.dot(&along);
        let fraction = saturate(to.dot(&along) / squared_length, low, high);
        let point = start + along * fraction;
        Self {
            segment,
            fraction,
            point,
            along,
            squared_length,
            squared_distance: squared_distance(position, point),
            side: along.perp(&to),
        }
    }

    /// The closest point with arc length, cross-track error and direction.
    #[inline]
    pub fn projection(&self, path: &PathView<'_>) -> Projection {
        Projection {
            segment: self.segment,
            fraction: self.fraction,
            point: self.point,
            arc_length: self.arc_length(path),
            cross_track_error: self.cross_track_error(),
            path_yaw: self.path_yaw(),
        }
    }

    /// Arc length at the closest point [m].
    #[inline]
    pub fn arc_length(&self, path: &PathView<'_>) -> f64 {
        path.arc(self.segment) + self.fraction * sqrt(self.squared_length)
    }

    /// Distance to the closest point [m], positive left of the path.
    #[inline]
    pub fn cross_track_error(&self) -> f64 {
        sqrt(self.squared_distance).copysign(self.side)
    }

    /// Direction of the segment [rad].
    #[inline]
    pub fn path_yaw(&self) -> f64 {
        atan2(self.along.y, self.along.x)
    }

    /// Vector from the start of the segment to its end [m].
    #[inline]
    pub fn along(&self) -> Point {
        self.along
    }

    /// The end of the segment that is nearer to the closest point; its start where both are as
    /// near.
    #[inline]
    pub fn nearest_waypoint(&self, path: &PathView<'_>) -> usize {
        if self.fraction > 0.5 {
            path.next(self.segment).unwrap_or(self.segment)
        } else {
            self.segment
        }
    }

    /// `distance + opposite_distance (1 - cos d) / 2` [m], with the angle `d` from the unit vector
    /// `heading` to the segment.
    #[inline]
    pub(super) fn cost(&self, heading: Point, opposite_distance: f64) -> f64 {
        let along = heading.dot(&self.along) / sqrt(self.squared_length);
        sqrt(self.squared_distance) + 0.5 * opposite_distance * (1.0 - along)
    }
}

/// Direction of the segment that ends at waypoint `nearest` [rad]; of the one that starts there if
/// none ends there. The published code takes it for the path's heading. It lies up to one and a
/// half segments behind the closest point.
pub fn path_yaw_behind(path: &PathView<'_>, nearest: usize) -> f64 {
    let (start, end) = path.segment(path.previous(nearest).unwrap_or(nearest));
    atan2(end.y - start.y, end.x - start.x)
}

/// The reference speed at a projection [m/s], negative where the path is driven backwards.
/// Magnitudes are interpolated linearly between waypoints. None if the path has no speeds.
pub fn reference_speed(path: &PathView<'_>, projection: &Projection) -> Option<f64> {
    let speed = path.speed()?;
    let here = speed.get(projection.segment)?.abs();
    let next = speed.get(path.next(projection.segment)?)?.abs();
    let magnitude = here + saturate(projection.fraction, 0.0, 1.0) * (next - here);
    Some(if path.is_reverse(projection.segment) {
        -magnitude
    } else {
        magnitude
    })
}
