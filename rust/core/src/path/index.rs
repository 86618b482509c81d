//! Searches the boxes along a path for the closest segments, without visiting all of it.
//!
//! It goes down the tree of [`boxes`](super::boxes), the nearer box first, and leaves out each box
//! that is farther off than the best segment so far. Unless its budget runs out it finds what
//! [`relocalise_by_scan`](super::relocalise::relocalise_by_scan), the definition, finds.

use super::best::Best;
use super::boxes::{Bounds, RUN};
use super::view::PathView;

/// Bound of the tree's levels: each has twice the boxes of the one above.
const LEVELS: usize = 64;

/// Bound of the rounding of a closest point, as a share of its coordinates: a length would not
/// scale with the path.
const MARGIN: f64 = 32.0 * f64::EPSILON;

/// How many boxes a control step visits at most. Larger values find the exact place on maps where
/// more of the path is as near; smaller ones bound the step sooner. Within 50 m of a path of ten
/// million waypoints a search visits a few dozen, on a dense net of streets a few hundred. At the
/// centre of a circle it would visit all: 2,048 boxes bound such a step at some 0.2 ms.
pub const STEP_BUDGET: usize = 2048;

/// What a search found, and how it went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    /// The segment of least cost of those visited.
    pub segment: usize,
    /// Whether no other segment costs less: the budget was enough.
    pub is_exact: bool,
    /// How many boxes were visited; 0 on a path without an index.
    pub visits: usize,
}

/// Visits the segments of `path` that can matter, until `budget` of its boxes are visited.
pub(super) fn search(
    path: &PathView<'_>,
    boxes: &[Bounds],
    mut best: Best,
    budget: usize,
) -> Found {
    let position = best.position;
    let runs = boxes.len() / 2;
    let start = path.waypoint(0);
    let size = path.length() + start.x.abs() + start.y.abs() + position.x.abs() + position.y.abs();
    let margin = MARGIN * (size + best.opposite_distance);
    let distance = |node: usize| {
        let found = boxes.get(node);
        found.map_or(f64::INFINITY, |found| found.squared_distance(position))
    };
    let mut limit = f64::INFINITY;
    let mut pending = [(0.0, 0); LEVELS];
    let mut count = 0;
    let mut visited = 0;
    let mut is_exact = true;
    let mut next = Some((distance(1), 1));
    while let Some((squared_distance, node)) = next {
        if squared_distance <= limit {
            if visited == budget {
                is_exact = false;
                break;
            }
            visited += 1;
            if node < runs {
                let child = |node| (distance(node), node);
                let (left, right) = (child(2 * node), child(2 * node + 1));
                let (near, far) = if right.0 < left.0 {
                    (right, left)
                } else {
                    (left, right)
                };
                if let Some(room) = pending.get_mut(count) {
                    *room = far;
                    count += 1;
                }
                next = Some(near);
                continue;
            }
            let first = run_of(node, runs) * RUN;
            for segment in first..path.segments().min(first + RUN) {
                best.visit(path, segment);
            }
            let least = best.least.0 + margin;
            limit = least * least;
        }
        next = None;
        if count > 0 {
            count -= 1;
            next = pending.get(count).copied();
        }
    }
    Found {
        segment: best.least.1,
        is_exact,
        visits: visited,
    }
}

/// The first segment along `path` that costs at most `limit` [m] by `best`, where `budget` boxes
/// are enough to find it.
pub(super) fn first_within(
    path: &PathView<'_>,
    boxes: &[Bounds],
    best: &Best,
    limit: f64,
    budget: usize,
) -> Option<usize> {
    let runs = boxes.len() / 2;
    // A box that rounding lets in has segments that are weighed and found to cost more.
    let reach = limit + MARGIN * (path.length() + limit);
    // Depth first, the left half first, is the order along the path.
    let mut pending = [1; LEVELS];
    let mut count = 1;
    for _ in 0..budget {
        count = usize::checked_sub(count, 1)?;
        let node = pending.get(count).copied()?;
        let far = boxes.get(node)?.squared_distance(best.position) > reach * reach;
        if far {
            continue;
        }
        if node < runs {
            for child in [2 * node + 1, 2 * node] {
                *pending.get_mut(count)? = child;
                count += 1;
            }
            continue;
        }
        let first = run_of(node, runs) * RUN;
        let mut segments = first..path.segments().min(first + RUN);
        let found = segments.find(|&segment| best.least_cost(path, segment) <= limit);
        if found.is_some() {
            return found;
        }
    }
    None
}

/// The run that leaf `node` of a tree of so many `runs` holds: the leaves lie on its last two levels,
/// and the runs begin on the lower one.
fn run_of(node: usize, runs: usize) -> usize {
    let first_run = runs.next_power_of_two();
    let before = if node < first_run { runs } else { 0 };
    node + before - first_run
}

#[cfg(test)]
mod tests;
