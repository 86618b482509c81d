//! Waypoints in the order in which they are mended: their spacing, their twins, their gaps.

use alloc::vec::Vec;
use core::f64::consts::PI;

use super::mends::{Fault, Mend};
use crate::error::PathError;
use crate::geometry::Point;
use crate::math::{atan2, from_count, sqrt};
use crate::path::measure::COINCIDING;

/// Segments whose lengths differ by no more than this factor are no gap, and none is a twin.
pub(super) const EVEN: f64 = 10.0;
/// A waypoint this much closer to the last one than the spacing tells no direction: its twin.
pub(super) const TWIN: f64 = 1.0 / 20.0;
/// Fewer waypoints do not tell a spacing; they are corners.
pub(super) const CORNERS: usize = 8;
/// By how much the last stretch of a path may turn more than the path before it [rad]: 11 degrees.
pub(super) const TURNED: f64 = 0.2;
/// By how much the path may turn at either end of a gap [rad]: 20 degrees, as a bend of coarse
/// waypoints does.
pub(super) const GAP_TURN: f64 = 0.35;
/// A turn from which on it is taken for a cusp [rad]: 170 degrees. At a cusp the path is tangent to
/// itself, but for what it bends in a spacing.
pub(super) const CUSP: f64 = 2.97;

/// A step back passes at most so many waypoints again.
pub(super) const MOST: usize = 512;

/// Waypoints in some order, what was mended so far, and the spacing.
pub(super) struct Chain<'a> {
    pub(super) x: &'a [f64],
    pub(super) y: &'a [f64],
    pub(super) order: Vec<usize>,
    pub(super) spacing: f64,
    /// How far the path gets from its first waypoint [m].
    pub(super) reach: f64,
    pub(super) mends: Vec<Mend>,
}

impl Chain<'_> {
    /// The waypoint given as `index`.
    pub(super) fn given(&self, index: usize) -> Point {
        let x = self.x.get(index).copied().unwrap_or(0.0);
        Point::new(x, self.y.get(index).copied().unwrap_or(0.0))
    }

    /// The waypoint at `place` of the order.
    pub(super) fn at(&self, place: usize) -> Point {
        self.given(self.order.get(place).copied().unwrap_or(0))
    }

    /// From the waypoint at `place` of the order to the next, across the seam too.
    pub(super) fn step(&self, place: usize) -> Point {
        let next = if place + 1 < self.order.len() {
            place + 1
        } else {
            0
        };
        self.at(next) - self.at(place)
    }

    pub(super) fn note(&mut self, fault: Fault, left_out: usize, index: usize) {
        if let Some(mend) = self.mends.iter_mut().find(|mend| mend.fault == fault) {
            mend.times += 1;
            mend.left_out += left_out;
            mend.index = mend.index.min(index);
        } else {
            self.mends.push(Mend {
                fault,
                times: 1,
                left_out,
                index,
            });
        }
    }

    /// Says which waypoints were not distinct.
    pub(super) fn note_coinciding(&mut self, closed: bool) {
        let gone = |kept: &[usize], index: &usize| kept.binary_search(index).is_err();
        let missing: Vec<usize> = (0..self.x.len())
            .filter(|index| gone(&self.order, index))
            .collect();
        let last = self.order.last().copied().unwrap_or(0);
        for index in missing {
            let fault = if closed && index > last {
                Fault::Repeated
            } else {
                Fault::Coinciding
            };
            self.note(fault, 1, index);
        }
    }

    /// The length that a segment usually has [m]: half of the path is in segments at least as long,
    /// without the fiftieth of them that are longest, which are gaps if any are.
    pub(super) fn usual_spacing(&self, closed: bool) -> f64 {
        let segments = self.order.len() - usize::from(!closed);
        let mut lengths: Vec<f64> = (0..segments).map(|place| size(self.step(place))).collect();
        lengths.sort_unstable_by(f64::total_cmp);
        if lengths.len() > 2 {
            lengths.truncate(lengths.len() - lengths.len().div_ceil(50));
        }
        let half = 0.5 * lengths.iter().sum::<f64>();
        let mut passed = 0.0;
        let halfway = lengths.iter().find(|&&length| {
            passed += length;
            passed >= half
        });
        halfway.copied().unwrap_or(0.0)
    }

    /// Leaves out waypoints that are too close to the last one to tell a direction, if they do not lie
    /// along the path and it goes on as it came.
    pub(super) fn leave_twins(&mut self, closed: bool) {
        let given = core::mem::take(&mut self.order);
        let least = TWIN * self.spacing;
        let mut kept: Vec<usize> = Vec::with_capacity(given.len());
        for (place, &index) in given.iter().enumerate() {
            let is_last = place + 1 == given.len() && !closed;
            if self.is_twin(
                &kept,
                index,
                given.get(place + 1..).unwrap_or_default(),
                least,
            ) {
                self.note(Fault::Coinciding, 1, index);
                if !is_last || kept.len() < 2 {
                    continue;
                }
                kept.pop(); // The goal stays.
            }
            kept.push(index);
        }
        self.order = kept;
        if let [_, .., before, last] = self.order[..]
            && closed
        {
            let gap = self.step(self.order.len() - 1);
            let inward = self.given(last) - self.given(before);
            if size(gap) < least && turn(gap, inward) > TURNED {
                self.order.pop();
                self.note(Fault::Repeated, 1, last);
            }
        }
    }

    /// Leaves out waypoints that stand where the next does, now that what lay between them is gone.
    pub(super) fn rejoin(&mut self) {
        let given = core::mem::take(&mut self.order);
        for index in given {
            while let Some(&last) = self.order.last()
                && size(self.given(index) - self.given(last)) <= COINCIDING
            {
                self.order.pop();
                self.note(Fault::Coinciding, 1, last);
            }
            self.order.push(index);
        }
    }

    /// Whether `index`, between those kept and those to come, is a twin of the last that is kept.
    pub(super) fn is_twin(&self, kept: &[usize], index: usize, next: &[usize], least: f64) -> bool {
        let Some(&last) = kept.last() else {
            return false;
        };
        let (origin, here) = (self.given(last), self.given(index));
        let step = here - origin;
        if size(step) >= least {
            return false;
        }
        let before = kept.len().checked_sub(2).and_then(|place| kept.get(place));
        let before = before.map(|&before| origin - self.given(before));
        let onward = next
            .iter()
            .take(MOST)
            .map(|&next| self.given(next) - origin);
        let onward = onward
            .into_iter()
            .find(|onward| size(*onward) >= 4.0 * least);
        let turned = |other: Option<Point>| other.is_some_and(|other| turn(step, other) > TURNED);
        let goes_on = match (before, onward) {
            (Some(before), Some(onward)) => along(before, onward),
            _ => true,
        };
        goes_on && (turned(before) || turned(onward))
    }

    /// Mends what is certain, and refuses folds that may be cusps.
    pub(super) fn mend(&mut self, closed: bool) -> Result<(), PathError> {
        if self.order.len() < CORNERS {
            return self.check_corners();
        }
        self.leave_twins(closed);
        if closed {
            return self.mend_lap();
        }
        self.mend_ends();
        self.mend_folds()
    }

    /// Refuses a segment far longer than the others at whose ends the path turns; that which closes a
    /// path was asked for, and so is a cusp at one of its ends if it is `directed`.
    pub(super) fn check_gaps(&self, directed: bool) -> Result<(), PathError> {
        let count = self.order.len();
        let places = if count < CORNERS { 0..0 } else { 0..count - 1 };
        for place in places {
            let gap = self.step(place);
            let length = size(gap);
            if length <= EVEN * self.spacing {
                continue;
            }
            // Over half a spacing: where a vehicle stood, single steps are noise.
            let beside = [
                self.heading_before(place, 0.5),
                self.heading_after(place + 1),
            ];
            let [least, most] = match beside.map(|other| turn(gap, other)) {
                [one, other] if one > other => [other, one],
                both => both,
            };
            let cusp = directed && PI - most <= GAP_TURN;
            if most > GAP_TURN && !(cusp && least <= GAP_TURN) {
                let index = |place: usize| self.order.get(place).copied().unwrap_or(0);
                return Err(PathError::Gap {
                    index: index(place),
                    next: index(place + 1),
                    length,
                    spacing: self.spacing,
                });
            }
        }
        Ok(())
    }
}

/// The length of a step [m].
pub(super) fn size(step: Point) -> f64 {
    sqrt(step.dot(&step))
}

/// The angle between two directions [rad].
pub(super) fn turn(a: Point, b: Point) -> f64 {
    atan2(a.perp(&b).abs(), a.dot(&b))
}

/// Whether one step is within 60 degrees of another.
pub(super) fn along(a: Point, b: Point) -> bool {
    let dot = a.dot(&b);
    dot > 0.0 && 4.0 * dot * dot > a.dot(&a) * b.dot(&b)
}

/// The mean of points; the origin of none.
pub(super) fn mean(points: impl Iterator<Item = Point>) -> Point {
    let (mut sum, mut count) = (Point::new(0.0, 0.0), 0);
    for point in points {
        sum += point;
        count += 1;
    }
    sum / from_count(count.max(1))
}
