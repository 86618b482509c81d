//! Finds the vehicle on the whole path after a jump: the segment of least distance and heading
//! error.
//!
//! [`relocalise_by_scan`] visits every segment and is the definition; [`relocalise`] leaves out
//! those that the `index` shows to be too far off.

use super::best::Best;
use super::index::{self, Found};
use super::view::PathView;
use crate::geometry::Point;

/// The segment to start from after a jump to `position` with heading `yaw`, as
/// [`relocalise_by_scan`] has it. On a path with an index it takes a few microseconds where few
/// segments are as near, and visits all of them at worst.
pub fn relocalise(path: &PathView<'_>, position: Point, yaw: f64, opposite_distance: f64) -> usize {
    relocalise_within(path, position, yaw, opposite_distance, usize::MAX).segment
}

/// [`relocalise`] that visits at most `budget` boxes of the path's index: the best of the segments
/// in those where that is not enough. A path without an index is scanned.
pub fn relocalise_within(
    path: &PathView<'_>,
    position: Point,
    yaw: f64,
    opposite_distance: f64,
    budget: usize,
) -> Found {
    match path.index {
        Some(boxes) => {
            let best = Best::new(position, yaw, opposite_distance);
            index::search(path, boxes, best, budget)
        }
        None => Found {
            segment: relocalise_by_scan(path, position, yaw, opposite_distance),
            is_exact: true,
            visits: 0,
        },
    }
}

/// [`first_as_good_by_scan`], or the segment `found` where a `budget` of boxes of the path's index does
/// not reach one.
pub fn first_as_good(
    path: &PathView<'_>,
    position: Point,
    yaw: f64,
    opposite_distance: f64,
    (found, noise): (usize, f64),
    budget: usize,
) -> usize {
    let Some(boxes) = path.index else {
        return first_as_good_by_scan(path, position, yaw, opposite_distance, (found, noise));
    };
    let mut best = Best::new(position, yaw, opposite_distance);
    best.visit(path, found);
    let limit = best.least.0 + noise;
    let first = index::first_within(path, boxes, &best, limit, budget);
    first.map_or(found, |first| {
        best_of_pass(path, &best, first, limit, budget)
    })
}

/// The place where the path first passes a vehicle at `position` with heading `yaw` at a cost of at most
/// `noise` [m] more than that of the segment `found`: of the segments in a row that cost no more than
/// that, the first row along the path, the best. A cost is by a segment's own direction or by the path's
/// smoothed one, whichever is less.
pub fn first_as_good_by_scan(
    path: &PathView<'_>,
    position: Point,
    yaw: f64,
    opposite_distance: f64,
    (found, noise): (usize, f64),
) -> usize {
    let mut best = Best::new(position, yaw, opposite_distance);
    best.visit(path, found);
    let limit = best.least.0 + noise;
    let first = (0..found).find(|&segment| best.least_cost(path, segment) <= limit);
    best_of_pass(path, &best, first.unwrap_or(found), limit, usize::MAX)
}

/// The best of at most `most` segments in a row, from `first` on, that cost at most `limit` [m].
fn best_of_pass(path: &PathView<'_>, best: &Best, first: usize, limit: f64, most: usize) -> usize {
    let row = (first..path.segments()).map(|segment| (best.least_cost(path, segment), segment));
    let pass = row.take_while(|&(cost, _)| cost <= limit).take(most);
    pass.reduce(|least, next| if next.0 < least.0 { next } else { least })
        .map_or(first, |least| least.1)
}

/// The segment to start from after a jump to `position` with heading `yaw`: the one of least
/// distance plus a penalty that grows as the heading turns away from the path, up to
/// `opposite_distance` [m] against it; the first of several. Visits every segment.
///
/// The heading thus distinguishes branches that cross or lie alongside. Where the path is driven
/// backwards, the heading of a vehicle on it is opposite to the path's.
pub fn relocalise_by_scan(
    path: &PathView<'_>,
    position: Point,
    yaw: f64,
    opposite_distance: f64,
) -> usize {
    let mut best = Best::new(position, yaw, opposite_distance);
    for segment in 0..path.segments() {
        best.visit(path, segment);
    }
    best.least.1
}

#[cfg(test)]
mod tests;
