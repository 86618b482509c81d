//! The two ends of an open path: neighbours swapped, a vehicle that stood there, a short last stretch
//! that points aside.

use alloc::vec::Vec;

use super::chain::{Chain, MOST, TURNED, along, mean, size, turn};
use super::mends::Fault;
use crate::geometry::{Point, get_distance, squared_distance};
use crate::math::{larger, saturate};

/// Folds at most so many waypoints from one another are of one standstill: in noise alone two of three
/// waypoints are folds.
pub(super) const APART: usize = 6;
/// From so many folds on they are a standstill.
pub(super) const STANDSTILL: usize = 4;

impl Chain<'_> {
    /// Mends the end and the start.
    pub(super) fn mend_ends(&mut self) {
        for _ in 0..2 {
            let mended = self.swap_last() || self.leave_last_standstill() || self.leave_overrun();
            if !mended {
                self.leave_tail();
            }
            self.order.reverse();
        }
    }

    /// The turn at `place` of the order [rad].
    pub(super) fn turn_at(&self, place: usize) -> f64 {
        place.checked_sub(1).map_or(0.0, |before| {
            turn(self.step(before), self.at(place + 1) - self.at(place))
        })
    }

    /// Whether the path turns by more than a right angle at `place` of the order.
    pub(super) fn is_fold(&self, place: usize) -> bool {
        place > 0
            && place + 1 < self.order.len()
            && self.step(place - 1).dot(&self.step(place)) < 0.0
    }

    /// Exchanges the last two waypoints, if the path leaves one out on its way to the last but one and
    /// comes back for it.
    fn swap_last(&mut self) -> bool {
        let count = self.order.len();
        if count < 4 || !self.is_fold(count - 2) {
            return false;
        }
        let (before, tip, last) = (self.at(count - 3), self.at(count - 2), self.at(count - 1));
        let (back, first) = (get_distance(tip, last), get_distance(before, last));
        let even = back > 0.5 * first && first > 0.5 * back && back > 0.4 * self.spacing;
        let ahead = along(last - before, tip - last) && along(self.step(count - 4), last - before);
        if even && ahead {
            let index = self.order.get(count - 1).copied().unwrap_or(0);
            self.order.swap(count - 2, count - 1);
            self.note(Fault::Swapped, 0, index);
        }
        even && ahead
    }

    /// Leaves one waypoint of a standstill at the end.
    fn leave_last_standstill(&mut self) -> bool {
        let count = self.order.len();
        let mut folds: Vec<usize> = Vec::new(); // The latest first.
        for place in (1..count - 1).rev() {
            if place + APART < folds.last().copied().unwrap_or(count - 1) {
                break;
            }
            if self.is_fold(place) {
                folds.push(place);
            }
        }
        // In noise the vehicle also sets off: of the folds, as many as lie together.
        let stand = |many: usize| {
            let first = *folds.get(many.checked_sub(1)?)?;
            Some((first, self.middle_of_standstill(first, count - 1, many)?))
        };
        let (mut many, mut most) = (STANDSTILL, folds.len());
        while many < most {
            let half = (many + most).div_ceil(2);
            if stand(half).is_some() {
                many = half;
            } else {
                most = half - 1;
            }
        }
        let Some((first, middle)) = stand(many).filter(|(first, _)| *first > 1) else {
            return false;
        };
        let index = self.order.get(first).copied().unwrap_or(0);
        let rest = self.order.get(middle).copied().unwrap_or(0);
        self.order.truncate(first);
        self.order.push(rest);
        let left_out = count - self.order.len() + self.leave_beside_last(0.5);
        self.note(Fault::Standstill, left_out, index);
        true
    }

    /// The waypoint in the middle of those from `first` to `last`, if they are a standstill: that many
    /// folds, all within two spacings or what their noise explains.
    pub(super) fn middle_of_standstill(
        &self,
        first: usize,
        last: usize,
        folds: usize,
    ) -> Option<usize> {
        if folds < STANDSTILL {
            return None;
        }
        let places = || first..=last;
        let middle = mean(places().map(|place| self.at(place)));
        let step = mean((first..last).map(|place| Point::new(size(self.step(place)), 0.0))).x;
        let radius = saturate(6.0 * step, 2.0 * self.spacing, 4.0 * self.spacing);
        let distance = |place: usize| squared_distance(self.at(place), middle);
        // A list of points without an order is all within a circle of its spacing.
        let within =
            2.0 * radius < self.reach && places().all(|place| distance(place) < radius * radius);
        let nearest = places().min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        nearest.filter(|_| within && step < 0.8 * self.spacing)
    }

    /// Leaves out what is closer to the last waypoint than half a spacing, if the path turns there by
    /// more than it did before.
    fn leave_tail(&mut self) {
        let count = self.order.len();
        let goal = self.at(count - 1);
        let near =
            |place: usize, share: f64| get_distance(self.at(place), goal) < share * self.spacing;
        let mut first = count - 1;
        while first > 1 && near(first - 1, if self.is_fold(first - 1) { 0.75 } else { 0.5 }) {
            first -= 1;
        }
        if first < 2 || first + 1 == count {
            return;
        }
        let most = (first..count - 1).map(|place| self.turn_at(place));
        let usual = self.turn_at(first - 1);
        if most.fold(0.0, larger) <= TURNED + 2.0 * usual {
            return;
        }
        let before = self.step(first - 2);
        if !along(before, goal - self.at(first - 1)) {
            return; // The path turns there, and not in its last stretch alone.
        }
        let index = self.order.get(first).copied().unwrap_or(0);
        self.order.drain(first..count - 1);
        self.note(Fault::End, count - 1 - first, index);
    }

    /// Leaves out what lies beyond the last waypoint, if that is one step back to where the path has
    /// passed: longer than the spacing, it was not driven.
    fn leave_overrun(&mut self) -> bool {
        let count = self.order.len();
        if count < 8 || !self.is_fold(count - 2) {
            return false;
        }
        let goal = self.at(count - 1);
        let back = self.at(count - 2) - goal;
        let progress = |place: usize| back.dot(&(goal - self.at(place))) / size(back);
        let least = (2 * count / 3).max(count.saturating_sub(MOST));
        let before = (least..count - 2)
            .rev()
            .find(|&place| progress(place) >= 0.5 * self.spacing);
        let Some(before) = before else { return false };
        let near = |place: usize| get_distance(self.at(place), goal) <= self.spacing;
        let straight = along(self.heading_before(before, 1.0), goal - self.at(before));
        if !straight || !(near(before) || near(before + 1)) {
            return false;
        }
        let index = self.order.get(count - 2).copied().unwrap_or(0);
        self.order.drain(before + 1..count - 1);
        self.note(Fault::StepBack, count - 2 - before, index);
        true
    }

    /// Leaves out the waypoints before the last one that it is not ahead of by this share of the
    /// spacing. Returns how many.
    fn leave_beside_last(&mut self, share: f64) -> usize {
        let last = self.order.pop().unwrap_or(0);
        let point = self.given(last);
        let before = self.order.len();
        while self.order.len() > 2 {
            let tip = self.order.len() - 1;
            let direction = self.heading_before(tip, 1.0);
            let ahead = direction.dot(&(point - self.at(tip)));
            if ahead >= share * self.spacing * size(direction) {
                break;
            }
            self.order.pop();
        }
        let gone = before - self.order.len();
        self.order.push(last);
        gone
    }

    /// The chord from `place` of the order over at least half a spacing, or to the end.
    pub(super) fn heading_after(&self, place: usize) -> Point {
        let start = self.at(place);
        let far = |&end: &usize| get_distance(start, self.at(end)) >= 0.5 * self.spacing;
        let last = self.order.len() - 1;
        self.at((place..last).find(far).unwrap_or(last)) - start
    }

    /// The chord to `place` of the order over at least this share of the spacing, or from the start.
    pub(super) fn heading_before(&self, place: usize, share: f64) -> Point {
        let end = self.at(place);
        let reach = share * share * self.spacing * self.spacing;
        let mut start = place;
        while start > 0 && (start == place || squared_distance(self.at(start), end) < reach) {
            start -= 1;
        }
        end - self.at(start)
    }
}
