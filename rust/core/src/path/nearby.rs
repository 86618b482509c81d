//! A shortcut of [`locate_by_scan`](super::locate::locate_by_scan): goes downhill from the last
//! segment to the nearest local minimum, then proves by bounds that no other minimum can cost less.
//!
//! Where the proof fails there is no answer, and the scan has to find it.

use super::projection::ClosestPoint;
use super::view::PathView;
use crate::geometry::{Point, squared_distance};
use crate::math::sqrt;

/// Bound of the rounding of a closest point or a waypoint within the bounds of coordinates [m].
const MARGIN: f64 = 1e-6;

/// What the scan finds, if that is certain; None if a place farther along the path could be as
/// good.
#[inline]
pub(super) fn locate_nearby(
    path: &PathView<'_>,
    waypoint: usize,
    position: Point,
    heading: Point,
    reach: f64,
    opposite_distance: f64,
) -> Option<ClosestPoint> {
    // Around a path this short both directions meet.
    if path.is_closed() && path.length() <= 2.0 * reach + 4.0 * path.longest() {
        return None;
    }
    let start = path.segment_at(waypoint);
    let mut closest = ClosestPoint::new(path, start, position);
    let mut ahead = Outward::new(path, start, &closest, true, reach);
    let mut behind = Outward::new(path, start, &closest, false, reach);
    // Downhill to the local minimum; ahead first, as the scan takes the last of several as near.
    while let Some(next) = ahead.closest(position) {
        if next.squared_distance > closest.squared_distance {
            break;
        }
        closest = next;
    }
    if closest.segment == start {
        while let Some(previous) = behind.closest(position) {
            if previous.squared_distance >= closest.squared_distance {
                break;
            }
            closest = previous;
        }
    }
    // At least the scan's cost of it, which is the lesser of this one and the smoothed one.
    let limit = closest.cost(heading, opposite_distance) + MARGIN;
    (ahead.clears(position, limit) && behind.clears(position, limit)).then_some(closest)
}

/// The segments on one side of the last one, outwards, to the end of the stretch.
struct Outward<'a> {
    path: &'a PathView<'a>,
    segment: usize,
    /// Squared distance to the last segment, as the scan has it; infinite where that is not known.
    inner: f64,
    /// Arc passed, the segment included [m].
    arc: f64,
    reach: f64,
    ahead: bool,
}

impl<'a> Outward<'a> {
    #[inline]
    fn new(
        path: &'a PathView<'a>,
        segment: usize,
        closest: &ClosestPoint,
        ahead: bool,
        reach: f64,
    ) -> Self {
        Self {
            path,
            segment,
            inner: closest.squared_distance,
            arc: 0.0,
            reach,
            ahead,
        }
    }

    /// The next segment outwards, while the stretch goes on.
    #[inline]
    fn advance(&mut self) -> Option<usize> {
        if self.arc > self.reach {
            return None;
        }
        let next = self.path.neighbour(self.segment, self.ahead)?;
        self.arc += self.path.segment_length(next);
        self.segment = next;
        Some(next)
    }

    /// The closest point on the next segment.
    #[inline]
    fn closest(&mut self, position: Point) -> Option<ClosestPoint> {
        let closest = ClosestPoint::new(self.path, self.advance()?, position);
        self.inner = closest.squared_distance;
        Some(closest)
    }

    /// Whether no segment farther out can be a candidate of the scan at a cost up to `limit`.
    #[inline]
    fn clears(mut self, position: Point, limit: f64) -> bool {
        let least = self.least_distance(position);
        loop {
            let passed = self.arc;
            if least + passed > limit {
                return true;
            }
            let Some(segment) = self.advance() else {
                return true;
            };
            let (start, end) = self.path.segment(segment);
            let (along, to) = (end - start, position - start);
            let squared_length = along.dot(&along);
            let along_it = to.dot(&along);
            // The inner end, and whether it is the closest point: the same bits as the scan's.
            let (near, is_closest) = if self.ahead {
                (start, along_it <= 0.0)
            } else {
                (start + along, along_it >= squared_length)
            };
            let distance = squared_distance(position, near);
            // From here to the end of the stretch the distance falls by less than the arc grows.
            let rest = self.reach - passed + self.path.longest();
            let within = limit + rest + MARGIN;
            if distance > within * within && !self.comes_to_an_end(segment, rest) {
                return true;
            }
            let rises = if self.ahead {
                distance > self.inner
            } else {
                distance >= self.inner
            };
            if is_closest && (rises || distance > limit * limit) {
                self.inner = distance;
                continue;
            }
            let ends = self.path.neighbour(segment, self.ahead).is_none();
            if ends || distance <= 2.0 * (limit * limit + squared_length) + MARGIN {
                return false;
            }
            self.inner = f64::INFINITY;
        }
    }

    /// A bound on how near the rest of the stretch comes, which grows with the arc: no place is
    /// nearer than this and the arc passed when it is reached. Infinite the other way where the
    /// stretch may reach an end or the seam of the path, or a place where the vehicle turns round.
    ///
    /// From a place on the stretch to its far end it is no farther than the arc between them, so to
    /// the place itself it is at least the distance of the far end less that arc.
    #[inline]
    fn least_distance(&self, position: Point) -> f64 {
        let path = self.path;
        let margin = MARGIN + 1e-14 * path.length();
        let farthest = self.reach - self.arc + margin;
        // The first waypoint beyond the stretch: none where the last segment, which goes on without
        // an end, may be on it.
        let spare = usize::from(!path.is_closed());
        let found = if self.ahead {
            let near = self.segment + 1;
            let far = path.s().get(near..path.len() - spare).and_then(|rest| {
                let start = rest.first()?;
                rest.iter().position(|s| s - start > farthest)
            });
            far.map(|far| (near, near + far))
        } else {
            let near = self.segment;
            let far = path.s().get(spare..=near).and_then(|rest| {
                let start = rest.last()?;
                rest.iter().rev().position(|s| start - s > farthest)
            });
            far.map(|far| (near, near - far))
        };
        match found {
            Some((near, far)) if path.reverse().is_none() => {
                let arc = (path.arc(far) - path.arc(near)).abs();
                let distance = squared_distance(position, path.waypoint(far));
                sqrt(distance) - arc - self.arc - margin
            }
            _ => f64::NEG_INFINITY,
        }
    }

    /// Whether the path may end, or turn round, within `rest` [m] of arc from `segment`: its last
    /// segment goes on without an end.
    #[inline]
    fn comes_to_an_end(&self, segment: usize, rest: f64) -> bool {
        let path = self.path;
        let room = if self.ahead {
            path.length() - path.arc(segment)
        } else {
            path.arc(segment)
        };
        path.reverse().is_some() || !path.is_closed() && room <= rest + 2.0 * path.longest()
    }
}

#[cfg(test)]
mod tests;
