//! Projects a position onto the path, near the segment of the last projection.
//!
//! [`locate_by_scan`] visits every segment of a bounded stretch and is the definition. [`locate`]
//! gives the same answer: it first tries `nearby`, which visits fewer segments, and scans only
//! where `nearby` cannot prove its answer.

use super::nearby::locate_nearby;
use super::preview::Preview;
use super::projection::ClosestPoint;
use super::view::PathView;
use crate::geometry::Point;
use crate::math::{cos, sin, smaller, sqrt};

/// The `opposite_distance` of a vehicle with a wheelbase of 3 m: the cost of a path that leads
/// opposite to the heading, as a distance [m]. Controllers scale it with the wheelbase
/// ([`Follow`](super::follow::Follow)). Larger values keep to the branch along the heading from
/// farther off. Smaller values take a nearer branch that leads elsewhere.
pub const OPPOSITE: f64 = 10.0;

/// Length of path over which its heading is smoothed, as a share of `opposite_distance`; two thirds
/// of a wheelbase for that of the controllers.
const SMOOTHING: f64 = 0.2;

/// The path's closest point to `position`, near the segment at `waypoint`, for a vehicle that drives
/// along the unit vector `heading`. Same answer as [`locate_by_scan`], which defines it; lengths in
/// metres.
#[inline]
pub fn locate(
    path: &PathView<'_>,
    waypoint: usize,
    position: Point,
    heading: Point,
    reach: f64,
    opposite_distance: f64,
) -> ClosestPoint {
    let nearby = locate_nearby(path, waypoint, position, heading, reach, opposite_distance);
    match nearby {
        Some(closest) => facing(path, closest, position, heading, opposite_distance),
        None => locate_by_scan(path, waypoint, position, heading, reach, opposite_distance),
    }
}

/// Finds the local minima of the distance to `position` within `reach` [m] of arc behind and ahead
/// of the segment at `waypoint`, and returns the one of least cost; of equal ones, the first along
/// the path.
///
/// A segment holds a local minimum if it is no farther off than the segment before it and nearer
/// than the one after it; a missing neighbour, at an end of the stretch, counts as infinitely far.
/// Its cost [m], with the angle `d` from `heading` to the path, is
///
/// ```text
/// distance + opposite_distance (1 - cos d) / 2
/// ```
///
/// once with the direction of the segment and once with the path's smoothed direction about the
/// closest point; the lesser counts.
///
/// The stretch consists of whole segments, so it is longer than `reach` by up to a segment. It ends
/// early at the end of an open path, at a cusp, and once around a closed path. The answer cannot
/// leap to another branch of the path: beyond the stretch there is no search, and within it the
/// heading distinguishes branches.
///
/// A segment that leads elsewhere, as the jitter of a recorded standstill does, has the smoothed
/// direction: the vehicle is on the side of the path about it.
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
        let next = path
            .following(here.segment)
            .filter(|_| here.segment != last);
        let next = next.map(|next| ClosestPoint::new(path, next, position));
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
    facing(path, best, position, heading, opposite_distance)
}

/// The first and the last segment of the stretch around `segment`: behind and ahead of it, whole
/// segments until their lengths exceed `reach` [m].
fn stretch(path: &PathView<'_>, segment: usize, reach: f64) -> (usize, usize) {
    let mut remaining = path.segments() - 1;
    let mut end = |ahead: bool| {
        let (mut last, mut arc) = (segment, 0.0);
        while remaining > 0
            && arc <= reach
            && let Some(next) = path.neighbour(last, ahead)
        {
            arc += path.segment_length(next);
            last = next;
            remaining -= 1;
        }
        last
    };
    (end(false), end(true))
}

/// `closest` with the path's smoothed direction, if its segment leads elsewhere: more than 60 degrees
/// off that and off `heading`, which is asked first and seldom so.
#[inline]
fn facing(
    path: &PathView<'_>,
    closest: ClosestPoint,
    position: Point,
    heading: Point,
    opposite_distance: f64,
) -> ClosestPoint {
    let length = sqrt(closest.squared_length);
    let leads = |towards: &Point| towards.dot(&closest.along) > 0.5 * length;
    if leads(&heading) {
        return closest;
    }
    let towards = smoothed(path, &closest, opposite_distance);
    if leads(&towards) {
        return closest;
    }
    ClosestPoint {
        along: towards * length,
        side: towards.perp(&(position - closest.point)),
        ..closest
    }
}

/// The lesser of two costs: by the direction of the segment, [`ClosestPoint::cost`], and by the
/// path's smoothed direction. A single segment of noisy waypoints or of a staircase may lead
/// anywhere; the path about it does not.
pub(super) fn least_cost(
    path: &PathView<'_>,
    closest: &ClosestPoint,
    heading: Point,
    opposite_distance: f64,
) -> f64 {
    let by_segment = closest.cost(heading, opposite_distance);
    let along = heading.dot(&smoothed(path, closest, opposite_distance));
    let smoothed = sqrt(closest.squared_distance) + 0.5 * opposite_distance * (1.0 - along);
    smaller(smoothed, by_segment)
}

/// The path's direction about `closest`, smoothed over a fifth of `opposite_distance`: a unit vector.
fn smoothed(path: &PathView<'_>, closest: &ClosestPoint, opposite_distance: f64) -> Point {
    let base = SMOOTHING * opposite_distance;
    let yaw = Preview::yaw_at(path, base, closest.segment, closest.arc_length(path));
    Point::new(cos(yaw), sin(yaw))
}
