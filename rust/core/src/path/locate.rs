//! Where am I? The exact closest point on the path, looked for along the arc around the last one.
//!
//! [`locate_by_scan`] looks at every segment of a bounded stretch and is the definition;
//! [`locate`] leaves it to `nearby` where that is certain of the answer.

use super::nearby::locate_nearby;
use super::preview::Preview;
use super::projection::ClosestPoint;
use super::view::PathView;
use crate::geometry::Point;
use crate::math::{cos, sin, sqrt};

/// How much farther off a closest point counts where the path leads the opposite way [m], unless
/// another distance is given: right for a wheelbase of 3 m. Larger values hold on to the branch of
/// the heading farther off; smaller ones take a nearer branch that leads elsewhere.
pub const OPPOSITE: f64 = 10.0;

/// Length of path whose heading tells branches apart, as a part of the distance that the opposite
/// one counts as farther off: two thirds of a wheelbase.
const SMOOTHING: f64 = 0.2;

/// The closest point of `position` within `reach` [m] of arc before and behind the segment at
/// `waypoint`, for a vehicle that drives along the unit vector `heading`; see [`locate_by_scan`],
/// whose answer this is. [`OPPOSITE`] is an `opposite_distance` [m] for a car.
#[inline]
pub fn locate(
    path: &PathView<'_>,
    waypoint: usize,
    position: Point,
    heading: Point,
    reach: f64,
    opposite_distance: f64,
) -> ClosestPoint {
    locate_nearby(path, waypoint, position, heading, reach, opposite_distance).unwrap_or_else(
        || locate_by_scan(path, waypoint, position, heading, reach, opposite_distance),
    )
}

/// The closest point of `position` by the definition: of the segments from the one at `waypoint`
/// until more than `reach` [m] of arc before and behind it, each segment that is no farther off
/// than the one before it and nearer than the one after it is a candidate. The candidate of least
/// distance counts, each distance with up to `opposite_distance` [m] more the less the path leads
/// along `heading`, by the segment or over a fifth of `opposite_distance`, whichever leads along it
/// more; of several the first.
///
/// The stretch ends where an open path does, where the vehicle has to change its direction, and
/// once around a closed path. So the closest point cannot leap to another branch: farther along the
/// path than `reach` it does not look, and within it the heading tells branches apart.
#[cold]
pub fn locate_by_scan(
    path: &PathView<'_>,
    waypoint: usize,
    position: Point,
    heading: Point,
    reach: f64,
    opposite_distance: f64,
) -> ClosestPoint {
    let (first, last) = stretch(path, path.segment_at(waypoint), reach);
    let mut here = ClosestPoint::new(path, first, position);
    let mut behind = f64::INFINITY;
    let (mut best, mut least) = (here, f64::INFINITY);
    for _ in 0..path.segments() {
        let next = if here.segment == last {
            None
        } else {
            path.following(here.segment)
                .map(|next| ClosestPoint::new(path, next, position))
        };
        let ahead = next.map_or(f64::INFINITY, |next| next.squared_distance);
        if here.squared_distance <= behind && here.squared_distance < ahead {
            let cost = least_cost(path, &here, heading, opposite_distance);
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
    let mut remaining = path.segments() - 1;
    while remaining > 0 && behind <= reach {
        let Some(previous) = path.preceding(first) else {
            break;
        };
        behind += path.segment_length(previous);
        first = previous;
        remaining -= 1;
    }
    while remaining > 0 && ahead <= reach {
        let Some(next) = path.following(last) else {
            break;
        };
        ahead += path.segment_length(next);
        last = next;
        remaining -= 1;
    }
    (first, last)
}

/// The cost of a closest point: [`ClosestPoint::cost`], or that with the heading of the path over a
/// fifth of `opposite_distance`, where that is less. One segment of noisy waypoints or of a
/// staircase may lead anywhere, the path about it does not.
fn least_cost(
    path: &PathView<'_>,
    closest: &ClosestPoint,
    heading: Point,
    opposite_distance: f64,
) -> f64 {
    let by_segment = closest.cost(heading, opposite_distance);
    let base = SMOOTHING * opposite_distance;
    let arc_length = closest.arc_length(path);
    let yaw = Preview::yaw_at(path, base, closest.segment, arc_length);
    let along = heading.x * cos(yaw) + heading.y * sin(yaw);
    let smoothed = sqrt(closest.squared_distance) + 0.5 * opposite_distance * (1.0 - along);
    if smoothed < by_segment {
        smoothed
    } else {
        by_segment
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Path;
    use alloc::vec::Vec;

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
