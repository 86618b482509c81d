//! The curvature of a path whose waypoints are noisy.
//!
//! Waypoints are smoothed by penalised least squares before their curvature is taken: Whittaker's
//! graduation (E. T. Whittaker, *On a New Method of Graduation*, 1923), with the penalty on the
//! third derivative, which is the change of the curvature, and weights by spacing, as in P. H. C.
//! Eilers, *A Perfect Smoother*, Analytical Chemistry 75, 2003:
//!
//! ```text
//! minimise  sum_k w_k |q_k - p_k|^2 + length^6 sum_k h_k |q'''_k|^2
//! ```
//!
//! A wave of length `2 pi L` along the path is kept up to the factor `1 / (1 + (length / L)^6)`:
//! bends of twice the smoothing length as radius are flattened by 2 %, of three times by 0.1 %,
//! while noise of 2 cm every metre leaves 0.0008 /m of curvature at a length of 2 m.

use alloc::vec;
use alloc::vec::Vec;

use crate::Point;
use crate::math::sqrt;
use crate::path::PathView;

/// Nodes in a smoothing length: waypoints closer together than that are averaged first.
const NODES: f64 = 4.0;
/// How many waypoints are smoothed at once: a longer path takes no more memory.
const PART: usize = 1 << 16;
/// How far a closed path is continued at its seam, and a part beyond its ends, in smoothing lengths:
/// what lies farther off moves a waypoint by less than 1e-4 of its own error.
const SEAM: f64 = 20.0;
/// The same in nodes, where these are far apart.
const SEAM_NODES: usize = 8;

/// Curvature at each waypoint of `path` [1/m], positive to the left, smoothed over `length` [m].
///
/// Where the vehicle turns round, the curvature is that of the section that begins there. Sections
/// of three nodes or fewer are not smoothed, and one of a single segment is straight.
#[must_use]
pub fn path_curvature(path: &PathView<'_>, length: f64) -> Vec<f64> {
    if let Some(given) = path.curvature() {
        let to_the_left = |(index, &bend): (usize, &f64)| {
            if path.is_reverse(index) { -bend } else { bend }
        };
        return given.iter().enumerate().map(to_the_left).collect();
    }
    let mut curvature = vec![0.0; path.len()];
    let segments = path.segments();
    let Some(first_cusp) = (0..segments).find(|&segment| path.ends_at_cusp(segment)) else {
        if path.is_closed() {
            smooth_loop(path, length, &mut curvature);
        } else {
            smooth_section(path, 0, segments, length, &mut curvature);
        }
        return curvature;
    };
    // A closed path begins after its first cusp, so that no section leads across the start.
    let start = if path.is_closed() { first_cusp + 1 } else { 0 };
    let end = start + segments;
    let mut begin = start;
    for segment in start..end {
        let last = segment + 1 == end;
        if last || path.ends_at_cusp(segment % segments) {
            smooth_section(path, begin, segment + 1 - begin, length, &mut curvature);
            begin = segment + 1;
        }
    }
    curvature
}

/// Nodes along a path: arc length [m] and place.
type Nodes = Vec<(f64, Point)>;

/// The curvature of the section of `segments` segments that begins at waypoint `begin`.
fn smooth_section(
    path: &PathView<'_>,
    begin: usize,
    segments: usize,
    length: f64,
    curvature: &mut [f64],
) {
    // The waypoint at its end is the next section's, but for the last of an open path.
    let open_end = !path.is_closed() && begin + segments + 1 == path.len();
    let count = if open_end { segments + 1 } else { segments };
    for first in (0..count).step_by(PART) {
        let kept = PART.min(count - first);
        let before = margin(path, begin + first, length, first, false);
        let last = first + kept - 1;
        let after = margin(path, begin + last, length, segments - last, true);
        let counts = (before, kept, after);
        smooth_part(path, begin + first, counts, length, curvature);
    }
}

/// The curvature of a closed path that is driven in one direction.
fn smooth_loop(path: &PathView<'_>, length: f64, curvature: &mut [f64]) {
    let count = path.len();
    for first in (0..count).step_by(PART) {
        let kept = PART.min(count - first);
        let before = margin(path, first, length, 4 * count, false);
        let after = if kept == count {
            before + 1
        } else {
            margin(path, first + kept - 1, length, count, true)
        };
        smooth_part(path, first, (before, kept, after), length, curvature);
    }
}

/// How many waypoints beside waypoint `place` are smoothed with it, at most `room`.
fn margin(path: &PathView<'_>, place: usize, length: f64, room: usize, ahead: bool) -> usize {
    let count = path.len();
    let (mut beside, mut arc) = (0, 0.0);
    while beside < room && (arc < SEAM * length || beside < SEAM_NODES) {
        beside += 1;
        let segment = if ahead {
            place + beside - 1
        } else {
            place + 5 * count - beside
        };
        arc += path.segment_length(segment % count);
    }
    beside
}

/// The curvature of `kept` waypoints from `first` on, smoothed with those `before` and `after` them.
fn smooth_part(
    path: &PathView<'_>,
    first: usize,
    (before, kept, after): (usize, usize, usize),
    length: f64,
    curvature: &mut [f64],
) {
    let begin = first + 5 * path.len() - before;
    let (mut nodes, arcs) = average(path, begin, before + kept - 1 + after, length);
    smooth(&mut nodes, length);
    let turned = turns_at(&nodes);
    let mut node = 0;
    for (step, &arc) in arcs.iter().skip(before).take(kept).enumerate() {
        if let Some(value) = curvature.get_mut((first + step) % path.len()) {
            *value = between(&nodes, &turned, arc, &mut node);
        }
    }
}

/// The waypoints of a section as nodes, means of those closer together than a part of `length`, and
/// the arc length at each waypoint from the section's start [m].
fn average(path: &PathView<'_>, begin: usize, segments: usize, length: f64) -> (Nodes, Vec<f64>) {
    let origin = path.waypoint(begin % path.len());
    let spacing = length / NODES;
    let mut nodes = Nodes::new();
    let mut arcs = Vec::with_capacity(segments + 1);
    let (mut arc, mut first, mut count) = (0.0, 0.0, 0.0);
    let (mut sum_arc, mut sum) = (0.0, Point::new(0.0, 0.0));
    let mut place = begin % path.len();
    for step in 0..=segments {
        if step > 0 {
            arc += path.segment_length(place);
            place = path.around(place + 1);
        }
        if count > 0.0 && arc - first >= spacing {
            nodes.push((sum_arc / count, sum / count));
            (first, count, sum_arc, sum) = (arc, 0.0, 0.0, Point::new(0.0, 0.0));
        }
        let waypoint = path.waypoint(place) - origin;
        sum_arc += arc;
        sum += waypoint;
        count += 1.0;
        arcs.push(arc);
    }
    nodes.push((sum_arc / count, sum / count));
    (nodes, arcs)
}

/// Moves `nodes` to where the penalised least squares have them.
fn smooth(nodes: &mut Nodes, length: f64) {
    let count = nodes.len();
    if count < 4 {
        return;
    }
    let arc = |index: usize| nodes.get(index).map_or(0.0, |node| node.0);
    // Row k of a symmetric band: the diagonal, and the three entries after it.
    let mut rows = vec![[0.0; 4]; count];
    let mut right = Vec::with_capacity(count);
    for (index, row) in rows.iter_mut().enumerate() {
        let before = if index > 0 { index - 1 } else { 0 };
        let after = if index + 1 < count { index + 1 } else { index };
        let weight = 0.5 * (arc(after) - arc(before));
        row[0] = weight;
        let place = nodes.get(index).map_or(Point::new(0.0, 0.0), |node| node.1);
        right.push(place * weight);
    }
    let cube = length * length * length;
    for first in 0..count - 3 {
        let s = [arc(first), arc(first + 1), arc(first + 2), arc(first + 3)];
        // The third derivative of the cubic through four nodes: six times a divided difference.
        let third = [
            6.0 / ((s[0] - s[1]) * (s[0] - s[2]) * (s[0] - s[3])),
            6.0 / ((s[1] - s[0]) * (s[1] - s[2]) * (s[1] - s[3])),
            6.0 / ((s[2] - s[0]) * (s[2] - s[1]) * (s[2] - s[3])),
            6.0 / ((s[3] - s[0]) * (s[3] - s[1]) * (s[3] - s[2])),
        ]
        .map(|entry| entry * cube);
        let weight = (s[3] - s[0]) / 3.0;
        for (offset, &entry) in third.iter().enumerate() {
            if let Some(row) = rows.get_mut(first + offset) {
                for (value, &other) in row.iter_mut().zip(third.iter().skip(offset)) {
                    *value += weight * entry * other;
                }
            }
        }
    }
    solve(&mut rows, &mut right);
    for (node, place) in nodes.iter_mut().zip(right) {
        node.1 = place;
    }
}

/// Solves a symmetric positive definite band of seven diagonals in place, by `L D L^T`.
fn solve(rows: &mut [[f64; 4]], right: &mut [Point]) {
    for index in 0..rows.len() {
        let (done, below) = rows.split_at_mut(index + 1);
        let (known, open) = right.split_at_mut(index + 1);
        let (Some(&[pivot, one, two, three]), Some(&known)) = (done.last(), known.last()) else {
            return;
        };
        let after = [one, two, three];
        let each = after.iter().enumerate().zip(below.iter_mut().zip(open));
        for ((offset, lead), (row, value)) in each {
            let factor = lead / pivot;
            for (entry, other) in row.iter_mut().zip(after.iter().skip(offset)) {
                *entry -= factor * other;
            }
            *value -= known * factor;
        }
    }
    for (index, row) in rows.iter().enumerate().rev() {
        let (open, done) = right.split_at_mut(index + 1);
        if let Some(value) = open.last_mut() {
            for (&known, &entry) in done.iter().zip(&row[1..]) {
                *value -= known * entry;
            }
            *value /= row[0];
        }
    }
}

/// The curvature at each node: of the circle through it and its neighbours, at the ends that of the
/// node beside them.
fn turns_at(nodes: &Nodes) -> Vec<f64> {
    let mut turned: Vec<f64> = nodes
        .windows(3)
        .map(|nodes| match nodes {
            [a, b, c] => circle_through(a.1, b.1, c.1),
            _ => 0.0,
        })
        .collect();
    let first = turned.first().copied().unwrap_or(0.0);
    let last = turned.last().copied().unwrap_or(0.0);
    turned.insert(0, first);
    turned.push(last);
    turned
}

/// Curvature of the circle through three points [1/m]; 0 where two of them coincide.
fn circle_through(a: Point, b: Point, c: Point) -> f64 {
    let (one, two, chord) = (b - a, c - b, c - a);
    let twice_area = one.perp(&two);
    let squares = one.dot(&one) * two.dot(&two) * chord.dot(&chord);
    if squares > 0.0 {
        2.0 * twice_area / sqrt(squares)
    } else {
        0.0
    }
}

/// The curvature at `arc` [m], linear between nodes; `node` is where to go on looking.
fn between(nodes: &Nodes, turned: &[f64], arc: f64, node: &mut usize) -> f64 {
    while nodes.get(*node + 1).is_some_and(|next| next.0 <= arc) {
        *node += 1;
    }
    let here = turned.get(*node).copied().unwrap_or(0.0);
    let Some(&(start, _)) = nodes.get(*node) else {
        return here;
    };
    match (nodes.get(*node + 1), turned.get(*node + 1)) {
        (Some(&(end, _)), Some(&next)) if arc > start => {
            here + (arc - start) / (end - start) * (next - here)
        }
        _ => here,
    }
}
