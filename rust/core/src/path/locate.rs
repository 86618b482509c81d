//! Where am I? The exact foot on the path, looked for along the arc around the last one.
//!
//! [`locate_by_scan`] looks at every segment of a bounded stretch and is the definition;
//! [`locate`] leaves it to [`nearby`](super::nearby) where that is certain of the answer.

use super::nearby::locate_nearby;
use super::preview::Preview;
use super::view::{PathView, squared_distance};
use crate::Point;
use crate::math::{atan2, cos, saturate, sin, sqrt};

/// How much farther off a closest point counts where the path leads the opposite way [m], unless
/// another distance is given: right for a wheelbase of 3 m. Larger values hold on to the branch of
/// the heading farther off; smaller ones take a nearer branch that leads elsewhere.
pub const OPPOSITE: f64 = 10.0;

/// Length of path whose heading tells branches apart, as a part of the distance that the opposite
/// one counts as farther off: two thirds of a wheelbase.
const SMOOTHING: f64 = 0.2;

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

/// The foot of a position on one segment: what is needed to choose between several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The segment that carries the foot.
    pub segment: usize,
    /// Where on the segment: 0 at its start, 1 at its end; beyond both on the extensions.
    pub fraction: f64,
    /// The foot [m].
    pub point: Point,
    /// Square of the distance to the foot [m^2].
    pub squared_distance: f64,
    along: Point,
    squared_length: f64,
    side: f64,
}

impl Foot {
    /// The foot of `position` on segment `segment`. Where the path ends, or turns round for the
    /// vehicle to go on the other way, the segment goes on as a straight line.
    #[inline]
    pub fn new(path: &PathView<'_>, segment: usize, position: Point) -> Self {
        let low = match path.preceding(segment) {
            Some(_) => 0.0,
            None => f64::NEG_INFINITY,
        };
        let high = match path.following(segment) {
            Some(_) => 1.0,
            None => f64::INFINITY,
        };
        Self::between(path, segment, position, low, high)
    }

    /// The foot of `position` on what lies between both ends of the segment.
    #[inline]
    pub(super) fn within(path: &PathView<'_>, segment: usize, position: Point) -> Self {
        Self::between(path, segment, position, 0.0, 1.0)
    }

    #[inline]
    fn between(path: &PathView<'_>, segment: usize, position: Point, low: f64, high: f64) -> Self {
        let (start, end) = path.segment(segment);
        let along = end - start;
        let to = position - start;
        let squared_length = along.x * along.x + along.y * along.y;
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

    /// All about the foot.
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

    /// Arc length at the foot [m].
    #[inline]
    pub fn arc_length(&self, path: &PathView<'_>) -> f64 {
        path.arc(self.segment) + self.fraction * sqrt(self.squared_length)
    }

    /// Signed distance to the foot [m], positive left of the path.
    #[inline]
    pub fn cross_track_error(&self) -> f64 {
        sqrt(self.squared_distance).copysign(self.side)
    }

    /// Direction of the segment [rad].
    #[inline]
    pub fn path_yaw(&self) -> f64 {
        atan2(self.along.y, self.along.x)
    }

    /// From the start of the segment to its end [m].
    #[inline]
    pub fn along(&self) -> Point {
        self.along
    }

    /// The end of the segment that is nearer to the foot; its start where both are as near.
    #[inline]
    pub fn nearest_waypoint(&self, path: &PathView<'_>) -> usize {
        if self.fraction > 0.5 {
            path.next(self.segment).unwrap_or(self.segment)
        } else {
            self.segment
        }
    }

    /// Distance [m], and up to `opposite_distance` [m] more the less the path leads along the unit
    /// vector `heading`.
    #[inline]
    pub(super) fn cost(&self, heading: Point, opposite_distance: f64) -> f64 {
        let along =
            (heading.x * self.along.x + heading.y * self.along.y) / sqrt(self.squared_length);
        sqrt(self.squared_distance) + 0.5 * opposite_distance * (1.0 - along)
    }

    /// [`cost`](Self::cost), or that with the heading of the path over a fifth of
    /// `opposite_distance`, where that is less: one segment of noisy waypoints or of a staircase may
    /// lead anywhere, the path about it does not.
    fn least_cost(&self, path: &PathView<'_>, heading: Point, opposite_distance: f64) -> f64 {
        let by_segment = self.cost(heading, opposite_distance);
        let base = SMOOTHING * opposite_distance;
        let arc_length = self.arc_length(path);
        let yaw = Preview::new(path, base, self.segment, arc_length, 0.0).path_yaw(arc_length);
        let along = heading.x * cos(yaw) + heading.y * sin(yaw);
        let smoothed = sqrt(self.squared_distance) + 0.5 * opposite_distance * (1.0 - along);
        if smoothed < by_segment {
            smoothed
        } else {
            by_segment
        }
    }
}

/// The foot of `position` within `reach` [m] of arc before and behind the segment at `waypoint`,
/// for a vehicle that drives along the unit vector `heading`; see [`locate_by_scan`], whose
/// answer this is. [`OPPOSITE`] is an `opposite_distance` [m] for a car.
#[inline]
pub fn locate(
    path: &PathView<'_>,
    waypoint: usize,
    position: Point,
    heading: Point,
    reach: f64,
    opposite_distance: f64,
) -> Foot {
    locate_nearby(path, waypoint, position, heading, reach, opposite_distance).unwrap_or_else(
        || locate_by_scan(path, waypoint, position, heading, reach, opposite_distance),
    )
}

/// The foot of `position` by the definition: of the segments from the one at `waypoint` until
/// more than `reach` [m] of arc before and behind it, each segment that is no farther off than
/// the one before it and nearer than the one after it is a candidate. The candidate of least
/// distance counts, each distance with up to `opposite_distance` [m] more the less the path leads
/// along `heading`, by the segment or over a fifth of `opposite_distance`, whichever leads along it
/// more; of several the first.
///
/// The stretch ends where an open path does, where the vehicle has to change its direction, and
/// once around a closed path. So the foot cannot leap to another branch: farther along the path
/// than `reach` it does not look, and within it the heading tells branches apart.
#[cold]
pub fn locate_by_scan(
    path: &PathView<'_>,
    waypoint: usize,
    position: Point,
    heading: Point,
    reach: f64,
    opposite_distance: f64,
) -> Foot {
    let (first, last) = stretch(path, path.segment_at(waypoint), reach);
    let mut here = Foot::new(path, first, position);
    let mut behind = f64::INFINITY;
    let (mut best, mut least) = (here, f64::INFINITY);
    for _ in 0..path.segments() {
        let next = if here.segment == last {
            None
        } else {
            path.following(here.segment)
                .map(|next| Foot::new(path, next, position))
        };
        let ahead = next.map_or(f64::INFINITY, |next| next.squared_distance);
        if here.squared_distance <= behind && here.squared_distance < ahead {
            let cost = here.least_cost(path, heading, opposite_distance);
            if cost < least {
                (best, least) = (here, cost);
            }
        }
        behind = here.squared_distance;
        match next {
            Some(next) => here = next,
            None => break,
        }
    }
    best
}

/// The first and the last segment of the stretch around `segment`.
fn stretch(path: &PathView<'_>, segment: usize, reach: f64) -> (usize, usize) {
    let (mut first, mut last) = (segment, segment);
    let (mut behind, mut ahead) = (0.0, 0.0);
    let mut left = path.segments() - 1;
    while left > 0 && behind <= reach {
        let Some(previous) = path.preceding(first) else {
            break;
        };
        behind += path.segment_length(previous);
        first = previous;
        left -= 1;
    }
    while left > 0 && ahead <= reach {
        let Some(next) = path.following(last) else {
            break;
        };
        ahead += path.segment_length(next);
        last = next;
        left -= 1;
    }
    (first, last)
}

/// Direction of the segment that leads to waypoint `nearest` [rad], of the one that leaves it
/// where none does: the path's heading as the published code takes it, up to a waypoint and a
/// half behind the foot.
pub fn path_yaw_behind(path: &PathView<'_>, nearest: usize) -> f64 {
    let (start, end) = path.segment(path.previous(nearest).unwrap_or(nearest));
    atan2(end.y - start.y, end.x - start.x)
}

/// The reference speed at a projection [m/s], negative where the path is driven backwards; the
/// magnitudes are taken linearly between the waypoints'. None where the path has no speeds.
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
    fn test_locate_out_and_back_keeps_to_the_branch_of_the_heading() {
        let x: Vec<f64> = (0..100).chain((0..100).rev()).map(f64::from).collect();
        let y: Vec<f64> = (0..200).map(|k| if k < 100 { 0.0 } else { 0.5 }).collect();
        let path = Path::new(&x, &y, None, false).unwrap();
        // Nearer to the other branch all the way, and near the turn.
        for (at, last) in [(50.2, 50), (95.7, 95), (97.5, 97)] {
            let position = Point::new(at, 0.4);
            let there = locate(
                &path.view(),
                last,
                position,
                Point::new(1.0, 0.0),
                6.0,
                OPPOSITE,
            );
            assert_eq!(there.segment, last);
            let turned = locate(
                &path.view(),
                last,
                position,
                Point::new(-1.0, 0.0),
                6.0,
                OPPOSITE,
            );
            assert_eq!(turned.segment > 99, at > 95.0);
        }
    }
}
