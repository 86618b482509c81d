//! Folds between the ends: waypoints in the opposite order, a step back, a standstill.
//!
//! One pass over the waypoints: those behind are done, and a fold is at the last of them.

use alloc::vec::Vec;

use super::chain::{CUSP, Chain, MOST, along, size, turn};
use super::ends::APART;
use super::mends::Fault;
use crate::error::PathError;
use crate::geometry::{Point, get_distance};
use crate::math::{from_count, larger, saturate};

/// What is left out lies within this many spacings of what stays: one, and what spacings vary by.
const PASSED: f64 = 1.1;
/// Where the path has corners at most waypoints, those farther aside of it are driven.
const ASIDE: f64 = 0.25;
/// A run of more waypoints in the opposite order is driven.
const LONGEST_RUN: usize = 16;

/// What a repair at a fold leaves.
struct Repair {
    fault: Fault,
    /// How many of the waypoints that were done are taken back.
    back: usize,
    /// Waypoints to add, by their place in the order.
    add: Vec<usize>,
    /// From which place on the path goes on.
    on: usize,
}

impl Chain<'_> {
    /// Mends a lap: begins far from a fold, so that the seam lies between the ends.
    pub(super) fn mend_lap(&mut self) -> Result<(), PathError> {
        let count = self.order.len();
        let calm = |start: usize| {
            (0..5).all(|k| {
                let place = |k: usize| (start + k) % count;
                let (here, next) = (self.step(place(k)), self.step(place(k + 1)));
                here.dot(&next) >= 0.0
            })
        };
        let start = (count / 2..count).chain(0..count / 2).find(|&at| calm(at));
        let Some(start) = start else {
            return Ok(()); // Too few waypoints, all of them corners.
        };
        let first = self.order.first().copied();
        self.order.rotate_left((start + 2) % count);
        self.mend_folds()?;
        let least = self.order.iter().min().copied();
        let begins = self.order.iter().position(|&index| Some(index) == first);
        let begins = begins.or_else(|| self.order.iter().position(|&index| Some(index) == least));
        self.order.rotate_left(begins.unwrap_or(0));
        Ok(())
    }

    /// Mends the folds that are certain, and refuses those that may be cusps.
    pub(super) fn mend_folds(&mut self) -> Result<(), PathError> {
        let count = self.order.len();
        if !(1..count).any(|place| self.is_fold(place)) {
            return Ok(());
        }
        // Between long steps it is no noise that folds the path.
        let is_long = |place: usize| size(self.step(place)) > 0.5 * self.spacing;
        let long = |place: &usize| self.is_fold(*place) && is_long(place - 1) && is_long(*place);
        self.check_order((1..count).filter(long).count(), count)?;
        // `done` and what comes are places of the order as it was.
        let mut done: Vec<usize> = Vec::with_capacity(count);
        let mut left = Vec::new();
        let mut place = 0;
        while place < count {
            if self.folds(&done, place) {
                if let Some(repair) = self.repair(&done, place) {
                    let tip = done.last().copied().unwrap_or(0);
                    done.truncate(done.len() - repair.back);
                    done.extend(&repair.add);
                    let index = self.order.get(tip).copied().unwrap_or(0);
                    let added = repair.add.len();
                    let left_out = (repair.back + repair.on - place).saturating_sub(added);
                    self.note(repair.fault, left_out, index);
                    place = repair.on;
                    continue;
                }
                left.push(done.len() - 1);
            }
            done.push(place);
            place += 1;
        }
        self.order = done
            .iter()
            .filter_map(|&place| self.order.get(place).copied())
            .collect();
        self.check_folds(&left)
    }

    /// Refuses corners that may be cusps.
    pub(super) fn check_corners(&self) -> Result<(), PathError> {
        let places = 1..self.order.len();
        let folds: Vec<usize> = places.filter(|&place| self.is_fold(place)).collect();
        self.check_folds(&folds)
    }

    /// Refuses folds that are left if they are most of the path, or may be cusps.
    fn check_folds(&self, left: &[usize]) -> Result<(), PathError> {
        let count = self.order.len();
        let index = |place: usize| self.order.get(place).copied().unwrap_or(0);
        self.check_order(left.len(), count)?;
        let cusp = left.iter().copied().find(|&place| {
            // Over a few waypoints, which noise does not turn round.
            let (start, end) = (place.saturating_sub(3), (place + 3).min(count - 1));
            let here = self.at(place);
            self.turn_at(place) > CUSP && turn(here - self.at(start), self.at(end) - here) > 2.6
        });
        cusp.map_or(Ok(()), |place| {
            Err(PathError::Fold {
                index: index(place),
            })
        })
    }

    /// Refuses waypoints of which more than a quarter are folds.
    fn check_order(&self, folds: usize, count: usize) -> Result<(), PathError> {
        if count < 12 || 4 * folds <= count {
            return Ok(());
        }
        Err(PathError::Unordered {
            folds,
            waypoints: self.x.len(),
        })
    }

    /// Whether the way to `place` folds at the last waypoint that is done.
    fn folds(&self, done: &[usize], place: usize) -> bool {
        let [.., before, tip] = done else {
            return false;
        };
        let tip_at = self.at(*tip);
        (tip_at - self.at(*before)).dot(&(self.at(place) - tip_at)) < 0.0
    }

    /// How to mend the fold at the last waypoint that is done, on the way to `place`.
    fn repair(&self, done: &[usize], place: usize) -> Option<Repair> {
        self.turn_round(done, place)
            .or_else(|| self.stand(done, place))
            .or_else(|| self.step_back(done, place))
    }

    /// Turns the last waypoint and those that follow round, if that makes even steps of a long one,
    /// steps back, and a long one (the 2-opt move): of two neighbours it exchanges them.
    fn turn_round(&self, done: &[usize], place: usize) -> Option<Repair> {
        let [.., before, tip] = done else { return None };
        let least = 0.4 * self.spacing_about(done, place);
        let is_even = |last: &usize| {
            if last + 1 >= self.order.len() {
                return false;
            }
            let run = (place..=*last).rev().chain([*tip, last + 1]);
            let (in_by, out_by) = (
                self.at(*tip) - self.at(*before),
                self.at(last + 1) - self.at(*last),
            );
            let longest = larger(size(in_by), size(out_by));
            let most = 1.6 * longest / from_count(last + 2 - place);
            let (mut from, mut inward) = (*before, None);
            run.into_iter().all(|at| {
                let step = self.at(at) - self.at(from);
                let ahead = inward.is_none_or(|inward| along(inward, step));
                (from, inward) = (at, Some(step));
                ahead && size(step) > least && size(step) < most
            })
        };
        let last = (place..place + LONGEST_RUN).find(is_even)?;
        let fault = if last == place {
            Fault::Swapped
        } else {
            Fault::Reversed
        };
        Some(Repair {
            fault,
            back: 1,
            add: (place..=last).rev().chain([*tip]).collect(),
            on: last + 1,
        })
    }

    /// Leaves one waypoint of a standstill.
    fn stand(&self, done: &[usize], place: usize) -> Option<Repair> {
        let tip = *done.last()?;
        let (mut last, mut folds) = (tip, 1);
        let mut at = place;
        let near = |at| get_distance(self.at(at), self.at(tip)) < 8.0 * self.spacing;
        while at + 1 < self.order.len() && at <= last + APART && near(at) {
            if self.is_fold(at) {
                (last, folds) = (at, folds + 1);
            }
            at += 1;
        }
        let middle = self.middle_of_standstill(tip, last, folds)?;
        let (point, least) = (self.at(middle), 0.5 * self.spacing);
        let mut back = 1;
        // What lies beside it is left out, too.
        let before = loop {
            let before = done.get(done.len().checked_sub(back + 1)?)?;
            if get_distance(self.at(*before), point) >= least {
                break *before;
            }
            back += 1;
        };
        let ahead = |at: &usize| get_distance(self.at(*at), point) >= least;
        let on = (last + 1..self.order.len().min(last + MOST)).find(ahead)?;
        let straight = along(point - self.at(before), self.at(on) - point);
        straight.then_some(Repair {
            fault: Fault::Standstill,
            back,
            add: [middle].into(),
            on,
        })
    }

    /// Leaves out what a step back passes again: on the way that follows, or on the way before, of
    /// which it is that with fewer waypoints.
    fn step_back(&self, done: &[usize], place: usize) -> Option<Repair> {
        let ahead = self.leave_ahead(done, place);
        let behind = self.leave_behind(done, place);
        match (ahead, behind) {
            (Some(ahead), Some(behind)) if behind.back < ahead.on - place => Some(behind),
            (None, behind) => behind,
            (ahead, _) => ahead,
        }
    }

    /// Goes on from the last waypoint to the first that lies ahead of it.
    fn leave_ahead(&self, done: &[usize], place: usize) -> Option<Repair> {
        let last = *done.last()?;
        let tip = self.at(last);
        let heading = self.heading_of(done)?;
        let step = |at: usize| self.at(at + 1) - self.at(at);
        let spacing = self.spacing_about(done, place);
        let end = self.order.len().min(place + MOST);
        let progress = |at: usize| heading.dot(&(self.at(at) - tip)) / size(heading);
        let on = (place + 1..end).find(|&at| progress(at) >= 0.5 * spacing)?;
        // A way back of several steps was driven, and so are folds, but for noise about the tip.
        let away = |at: usize| get_distance(self.at(at), tip) > 0.5 * spacing;
        let back = |at: usize| at + 1 < self.order.len() && heading.dot(&step(at)) < 0.0;
        let driven = (place..place + 2).all(|at| away(at) && back(at));
        let folded = (place + 1..on).any(|at| away(at) && self.is_fold(at));
        let onward = if on + 1 < self.order.len() {
            step(on)
        } else {
            self.at(on) - tip
        };
        let straight = along(heading, self.at(on) - tip) && along(self.at(on) - tip, onward);
        let corners = self.has_corners(done, place);
        let passed = |at: usize| {
            let kept = done.iter().copied().rev().take(MOST).chain([on]);
            let pairs = done.windows(2).rev().take(MOST);
            let pairs = pairs.filter_map(|pair| <[usize; 2]>::try_from(pair).ok());
            self.is_passed(at, spacing, kept, pairs.chain([[last, on]]), corners)
        };
        let certain = !driven && !folded && straight && (place..on).all(passed);
        certain.then_some(Repair {
            fault: Fault::StepBack,
            back: 0,
            add: Vec::new(),
            on,
        })
    }

    /// Goes on to `place` from the last waypoint that lies behind it.
    fn leave_behind(&self, done: &[usize], place: usize) -> Option<Repair> {
        let here = self.at(place);
        let end = self.order.len().min(place + MOST);
        let spacing = self.spacing_about(done, place);
        let reach = (place + 1..end).find(|&at| get_distance(self.at(at), here) >= spacing)?;
        let heading = self.at(reach) - here;
        let progress = |at: usize| heading.dot(&(here - self.at(at))) / size(heading);
        let mut back = 0;
        let before = loop {
            let at = *done.get(done.len().checked_sub(back + 1)?)?;
            if progress(at) >= 0.5 * spacing {
                break at;
            }
            back += 1;
            if back > MOST {
                return None;
            }
        };
        let kept = done.get(..done.len() - back)?;
        let straight = along(here - self.at(before), heading)
            && self
                .heading_of(kept)
                .is_none_or(|inward| along(inward, here - self.at(before)));
        let corners = self.has_corners(done, place);
        let passed = |at: usize| {
            let kept = (place..end).chain([before]);
            let pairs = (place + 1..end).map(|next| [next - 1, next]);
            self.is_passed(at, spacing, kept, pairs.chain([[before, place]]), corners)
        };
        let gone = done.get(done.len() - back..)?;
        let certain = straight && back > 0 && gone.iter().all(|&at| passed(at));
        certain.then_some(Repair {
            fault: Fault::StepBack,
            back,
            add: Vec::new(),
            on: place,
        })
    }

    /// Whether what stays passes by the waypoint at a place: one that is `kept` is near, and where there
    /// are `corners` it lies on the way between a pair of them.
    fn is_passed(
        &self,
        at: usize,
        spacing: f64,
        mut kept: impl Iterator<Item = usize>,
        mut pairs: impl Iterator<Item = [usize; 2]>,
        corners: bool,
    ) -> bool {
        let near = |kept| get_distance(self.at(kept), self.at(at)) <= PASSED * spacing;
        let beside = |[start, end]: [usize; 2]| self.beside(start, end, at) <= ASIDE * spacing;
        kept.any(near) && (!corners || pairs.any(beside))
    }

    /// Whether the path turns by more than half a radian at most waypoints about a fold.
    fn has_corners(&self, done: &[usize], place: usize) -> bool {
        let sharp = |a, b, c| turn(self.at(b) - self.at(a), self.at(c) - self.at(b)) > 0.5;
        let before = done.windows(3).rev().take(4);
        let before = before.map(|three| matches!(three, &[a, b, c] if sharp(a, b, c)));
        let after = (place + 2..self.order.len()).take(4);
        let after = after.map(|at| sharp(at - 2, at - 1, at));
        let count = |(sharp, all), is| (sharp + usize::from(is), all + 1);
        let (sharp, all) = before.chain(after).fold((0, 0), count);
        2 * sharp > all
    }

    /// How far the waypoint at a place is from the segment between two others [m].
    fn beside(&self, start: usize, end: usize, at: usize) -> f64 {
        let (start, along) = (self.at(start), self.at(end) - self.at(start));
        let share =
            along.dot(&(self.at(at) - start)) / larger(along.dot(&along), f64::MIN_POSITIVE);
        get_distance(start + along * saturate(share, 0.0, 1.0), self.at(at))
    }

    /// How far apart the waypoints are about a fold [m]: the median of eight on each side.
    fn spacing_about(&self, done: &[usize], place: usize) -> f64 {
        let before = done.windows(2).rev().skip(1).take(8);
        let before = before.filter_map(|pair| match pair {
            [a, b] => Some(get_distance(self.at(*a), self.at(*b))),
            _ => None,
        });
        let after = (place + 1..self.order.len().saturating_sub(1)).take(8);
        let after = after.map(|at| get_distance(self.at(at), self.at(at + 1)));
        let mut lengths: Vec<f64> = before.chain(after).collect();
        lengths.sort_unstable_by(f64::total_cmp);
        lengths
            .get(lengths.len() / 2)
            .copied()
            .unwrap_or(self.spacing)
    }

    /// The chord to the last of these places over at least a spacing, or from the first.
    fn heading_of(&self, places: &[usize]) -> Option<Point> {
        let end = self.at(*places.last()?);
        let mut heading = None;
        for &place in places.iter().rev().skip(1) {
            let chord = end - self.at(place);
            heading = Some(chord);
            if size(chord) >= self.spacing {
                break;
            }
        }
        heading
    }
}
