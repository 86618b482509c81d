//! Where a vehicle is on a path that replaces another.
//!
//! A planner sends a path many times a second: the same one, one that begins or ends elsewhere, or
//! one shifted a little. Position and heading alone do not say where the vehicle was on it: a path
//! that leads out and back along one line, or round several laps, passes there more than once. So
//! the place is looked for where the progress says: as far from the start as on the old path, or
//! as far from the end. Only where the new path is elsewhere there, the whole of it is searched.

use super::locate::{least_cost, locate};
use super::projection::ClosestPoint;
use super::relocalise::relocalise_within;
use super::view::PathView;
use crate::geometry::Point;
use crate::math::{PI, atan2, larger, smaller, sqrt};

/// The place on a path: what [`carry_over`] takes along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// The segment.
    pub segment: usize,
    /// The point on it [m].
    pub point: Point,
    /// How far along the path the place can be off [m].
    pub reach: f64,
}

/// Whether `new` has the same segment at `waypoint` as `old`, driven in the same direction. Not where
/// it has that segment earlier, too, as far from its end: a lap that was driven has been dropped.
pub fn goes_on(old: &PathView<'_>, new: &PathView<'_>, waypoint: usize) -> bool {
    let segment = old.segment_at(waypoint);
    let is_at = |place: usize| {
        old.segment(segment) == new.segment(place)
            && old.is_reverse(segment) == new.is_reverse(place)
    };
    let before_end = (segment + new.len()).checked_sub(old.len());
    waypoint < new.len()
        && segment == new.segment_at(waypoint)
        && is_at(segment)
        && !before_end.is_some_and(|place| place < segment && is_at(place))
}

/// The closest point of `new` to a place on `old`: of those at the same distance from the start
/// and from the end, driven the same way, the first, unless the other, or one elsewhere, is better by
/// more than `tolerance` [m]; by distance, and by heading as [`relocalise_within`] weighs it. At most
/// `budget` boxes of the path's index are visited.
pub fn carry_over(
    old: &PathView<'_>,
    new: &PathView<'_>,
    place: Progress,
    opposite_distance: f64,
    tolerance: f64,
    budget: usize,
) -> ClosestPoint {
    let here = ClosestPoint::new(old, place.segment, place.point);
    let along = here.along() / sqrt(here.along().dot(&here.along()));
    let is_reverse = old.is_reverse(here.segment);
    // Where the vehicle looks.
    let yaw = atan2(along.y, along.x);
    let looks = if is_reverse { yaw + PI } else { yaw };
    let found = relocalise_within(new, place.point, looks, opposite_distance, budget);
    let anywhere = ClosestPoint::new(new, found.segment, place.point);
    let cost = |at: &ClosestPoint| least_cost(new, at, along, opposite_distance);
    let distance = |at: &ClosestPoint| sqrt(at.squared_distance);

    let arc = here.arc_length(old);
    let from_end = new.length() - (old.length() - arc);
    let mut best: Option<ClosestPoint> = None;
    // The earlier first: laps that were dropped have been driven, those that were added have not.
    for anchor in [smaller(from_end, arc), larger(from_end, arc)] {
        // Beyond either end there is no such place.
        if anchor < -place.reach || anchor > new.length() + place.reach {
            continue;
        }
        let there = new.segment_by_arc(anchor, 0);
        let Some(near) = beside(new, anchor, there, is_reverse) else {
            continue;
        };
        let (point, reach) = (place.point, place.reach);
        let at = locate(new, near, point, along, reach, opposite_distance);
        if near != there && distance(&at) > distance(&anywhere) + tolerance {
            continue;
        }
        if best.is_none_or(|best| cost(&at) + tolerance < cost(&best)) {
            best = Some(at);
        }
    }
    // A place that is driven the other way may lie as near.
    let turned = new.is_reverse(anywhere.segment) != is_reverse;
    let most = cost(&anywhere) + if turned { opposite_distance } else { tolerance };
    best.filter(|best| cost(best) <= most).unwrap_or(anywhere)
}

/// The segment `at` the `arc` [m] of a path; where that is driven in the other direction, the nearest one
/// that is not: beside a cusp the noise of a plan puts the same arc into either leg.
fn beside(path: &PathView<'_>, arc: f64, at: usize, is_reverse: bool) -> Option<usize> {
    if path.is_reverse(at) == is_reverse {
        return Some(at);
    }
    let (first, last) = path.section(at)?;
    let before = path
        .previous(first)
        .map(|segment| (arc - path.arc(first), segment));
    let after = path
        .next_segment(last)
        .map(|segment| (path.segment_end(last) - arc, segment));
    match (before, after) {
        (Some(before), Some(after)) if after.0 < before.0 => Some(after.1),
        (before, after) => before.or(after).map(|(_, segment)| segment),
    }
}
