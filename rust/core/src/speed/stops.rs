//! Where a plan stops, and what it asks for in between.

use crate::math::{larger, saturate, smaller};
use crate::path::PathView;

/// How many hops along a plan a stop is searched for. Each is at least a braking distance long, or a
/// segment, so that a stop beyond is far off.
const HOPS: usize = 64;
/// A waypoint's speed below this is one of 0 [m/s]: what an optimiser or the digits of a file leave of it.
/// Larger: a crawl becomes a stop.
pub(super) const STANDSTILL: f64 = 1e-3;
/// Share of a braking distance that surely has no stop, however the speeds were rounded.
const SURELY: f64 = 0.99;

/// What a segment between two stops is driven with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Between {
    /// Largest driving acceleration and planned deceleration [m/s²].
    pub accelerations: (f64, f64),
    /// Largest speed [m/s].
    pub most: f64,
}

/// The plan at a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlanAt {
    /// `w`: the square of the planned speed.
    pub squared: f64,
    /// The acceleration of the plan [m/s²].
    pub slope: f64,
    /// The path's slope.
    pub grade: f64,
    /// The square of the highest speed of the segment: at either end, or between two stops.
    pub highest: f64,
}

/// A path with the planned speed at each waypoint [m/s].
#[derive(Clone, Copy, Debug)]
pub(super) struct Planned<'a, 'b> {
    pub path: &'a PathView<'b>,
    pub speeds: &'a [f64],
    /// The segment beside the vehicle.
    pub segment: usize,
    /// The last segment of its section; none on a closed path without a cusp.
    pub end: Option<usize>,
    pub between: Between,
}

impl Planned<'_, '_> {
    /// The square of the planned speed at waypoint `index`.
    fn squared(&self, index: usize) -> f64 {
        let speed = self.speeds.get(index).copied().unwrap_or(0.0);
        speed * speed
    }

    /// Whether the path says 0 at waypoint `index`: neither the first nor at a cusp or the end, where
    /// every plan begins and ends at rest.
    fn is_stop(&self, index: usize) -> bool {
        index > 0
            && self.squared(index) <= 0.0
            && index < self.path.segments()
            && self.path.preceding(index).is_some()
    }

    /// Whether the path says 0 all along the segment beside the vehicle.
    pub(super) fn stays_at_zero(&self) -> bool {
        self.is_zero(self.segment)
    }

    /// What the plan wants at `arc` [m]; on a closed path that may exceed the length: it continues across
    /// the seam.
    pub(super) fn at(&self, arc: f64) -> PlanAt {
        let path = self.path;
        let (found, share) = match self.end {
            Some(end) if arc >= self.end_arc(end) => (end, 1.0),
            _ if arc <= path.arc(self.segment) => (self.segment, 0.0),
            _ => {
                let wrapped = if path.is_closed() && arc >= path.length() {
                    arc - path.length()
                } else {
                    arc
                };
                let found = path.segment_by_arc(wrapped, self.segment);
                let share = (wrapped - path.arc(found)) / path.segment_length(found);
                (found, saturate(share, 0.0, 1.0))
            }
        };
        let here = self.squared(found);
        let next = path.next(found);
        let then = next.map_or(here, |next| self.squared(next));
        let rise = then - here;
        let grade = path.grade_at(found, share);
        let (squared, slope, highest) = if here <= 0.0 && then <= 0.0 && !self.is_zero(found) {
            self.peak(found, share)
        } else {
            let slope = 0.5 * rise / path.segment_length(found);
            (here + share * rise, slope, larger(here, then))
        };
        PlanAt {
            squared,
            slope,
            grade,
            highest,
        }
    }

    /// Whether the path says 0 all along segment `index`.
    fn is_zero(&self, index: usize) -> bool {
        let next = self.path.next(index).unwrap_or(index);
        let both = self.squared(index) <= 0.0 && self.squared(next) <= 0.0;
        both && (self.is_stop(index) || self.is_stop(next))
    }

    /// `w` and the acceleration on a segment between two stops, `share` of its length along: as fast as the
    /// vehicle's limits allow, and the path's speeds at its ends where it has any; and the square of the most.
    fn peak(&self, index: usize, share: f64) -> (f64, f64, f64) {
        let length = self.path.segment_length(index);
        let (driving, braking) = self.between.accelerations;
        let next = self.path.next(index).unwrap_or(index);
        let own = self.path.speed().map_or(f64::INFINITY, |speed| {
            let at = |index: usize| speed.get(index).copied().unwrap_or(0.0).abs();
            larger(at(index), at(next))
        });
        let most = smaller(own, self.between.most);
        let up = 2.0 * driving * share * length;
        let down = 2.0 * braking * (1.0 - share) * length;
        let (squared, slope) = if up < down {
            (up, driving)
        } else {
            (down, -braking)
        };
        if squared < most * most {
            (squared, slope, most * most)
        } else {
            (most * most, 0.0, most * most)
        }
    }

    /// The arc length at the end of the section that ends with segment `end` [m]; it continues across
    /// the seam.
    fn end_arc(&self, end: usize) -> f64 {
        let arc = self.path.segment_end(end);
        if end < self.segment {
            arc + self.path.length()
        } else {
            arc
        }
    }

    /// The next stop from `arc` [m] on, and how far along it is: the end of the section, or a waypoint
    /// at which the path says 0, the last `behind` [m] counted in. No stop lies within the braking
    /// distance of a planned speed, so the search hops from one such distance to the next.
    pub(super) fn next_stop(&self, arc: f64, behind: f64, braking: f64) -> Option<(usize, f64)> {
        let path = self.path;
        let mut index = self.segment;
        while index > 0 && arc - path.arc(index) <= behind {
            if self.is_stop(index) {
                return Some((index, path.arc(index) - arc));
            }
            index -= 1;
        }
        let end = self.end_stop(arc);
        let far = end.map_or(f64::INFINITY, |(_, distance)| arc + distance);
        let (mut index, mut lap) = (self.segment, 0.0);
        for _ in 0..HOPS {
            let target = path.arc(index) + SURELY * 0.5 * self.squared(index) / braking;
            let last = path.segment_by_arc(smaller(target, path.length()), index);
            index = last + 1;
            if index >= path.segments() && path.is_closed() {
                if lap > 0.0 {
                    break;
                }
                (index, lap) = (0, path.length());
            }
            let place = path.arc(index) + lap;
            if place >= far {
                break;
            }
            if self.is_stop(index) {
                return Some((index, place - arc));
            }
        }
        end
    }

    /// The waypoint that ends the section, and how far from `arc` it is [m].
    pub(super) fn end_stop(&self, arc: f64) -> Option<(usize, f64)> {
        let end = self.end?;
        let waypoint = self.path.next(end).unwrap_or(end + 1);
        Some((waypoint, self.end_arc(end) - arc))
    }

    /// How far along waypoint `index` is from `arc` [m]; on a closed path in the lap in which it is
    /// nearest to `expected` [m].
    pub(super) fn distance(&self, index: usize, arc: f64, expected: f64) -> f64 {
        let path = self.path;
        let found = path.arc(index) - arc;
        if !path.is_closed() {
            return found;
        }
        let laps = [found - path.length(), found, found + path.length()];
        let nearer = |a: f64, b: f64| {
            if (a - expected).abs() < (b - expected).abs() {
                a
            } else {
                b
            }
        };
        laps.into_iter().fold(found, |best, lap| nearer(lap, best))
    }
}

/// The most speed at each waypoint [m/s], where the path has speeds: their magnitudes.
///
/// Zeros in a row with the first waypoint or with a cusp are how a path begins and turns round, unless
/// nothing but zeros follows: beside those two waypoints they count as `creep` [m/s], and all others
/// stay stops.
#[cfg(feature = "alloc")]
pub(super) fn bounds_of(
    path: &PathView<'_>,
    cusps: &[bool],
    creep: f64,
) -> Option<alloc::vec::Vec<f64>> {
    let mut bounds: alloc::vec::Vec<f64> = path.speed()?.iter().map(|v| v.abs()).collect();
    for bound in bounds.iter_mut().filter(|bound| **bound < STANDSTILL) {
        *bound = 0.0;
    }
    let count = bounds.len();
    let is_rest = |index: usize| index == 0 || cusps.get(index) == Some(&true);
    let mut start = 0;
    while start < count {
        let zeros = bounds.iter().skip(start).take_while(|&&v| v <= 0.0).count();
        let end = start + zeros;
        if end < count && (start..end).any(is_rest) {
            let run = bounds.iter_mut().enumerate().take(end).skip(start);
            run.filter(|&(index, _)| !is_rest(index))
                .for_each(|(_, bound)| *bound = creep);
        }
        start = end + 1;
    }
    Some(bounds)
}
