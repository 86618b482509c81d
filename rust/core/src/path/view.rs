//! Waypoints as borrowed slices, validated once.

use super::boxes::Bounds;
use super::measure::{Measures, check_column, check_length, measure};
use crate::bounds::MAX_GRADE;
use crate::error::{InputError, PathError, Requirement};
use crate::geometry::Point;
use crate::math::{from_count, saturate, to_count};

/// N waypoints, the arc length at each, and whether the last leads back to the first.
///
/// Segment `k` runs from waypoint `k` to its successor: N - 1 segments in an open path, N in a
/// closed one.
#[derive(Clone, Copy, Debug)]
pub struct PathView<'a> {
    pub(super) x: &'a [f64],
    pub(super) y: &'a [f64],
    pub(super) s: &'a [f64],
    pub(super) speed: Option<&'a [f64]>,
    pub(super) reverse: Option<&'a [bool]>,
    pub(super) grade: Option<&'a [f64]>,
    pub(super) yaw: Option<&'a [f64]>,
    pub(super) curvature: Option<&'a [f64]>,
    pub(super) measures: Measures,
    pub(super) closed: bool,
    /// The boxes of its index, where it has one.
    pub(super) index: Option<&'a [Bounds]>,
    /// The segments that end at a cusp, in order, where they are known.
    pub(super) ends: Option<&'a [usize]>,
}

impl<'a> PathView<'a> {
    /// Borrows waypoints `x`, `y` [m] and reference speeds `speed` [m/s]; writes the arc length
    /// at each waypoint into `s`, which needs room for N numbers.
    ///
    /// # Errors
    ///
    /// [`PathError`]: fewer than two waypoints (three for a closed path), slices of differing
    /// length, a number that is not finite or beyond its bound, neighbours that coincide.
    pub fn new(
        x: &'a [f64],
        y: &'a [f64],
        speed: Option<&'a [f64]>,
        closed: bool,
        s: &'a mut [f64],
    ) -> Result<Self, PathError> {
        let measures = measure(x, y, speed, closed, s)?;
        Ok(Self {
            x,
            y,
            s,
            speed,
            reverse: None,
            grade: None,
            yaw: None,
            curvature: None,
            measures,
            closed,
            index: None,
            ends: None,
        })
    }

    /// The same path with the stretches that are driven backwards: entry `k` says so of segment
    /// `k`; the last entry of an open path says nothing. Without it all is driven forward.
    ///
    /// # Errors
    ///
    /// [`PathError::LengthMismatch`] unless there is an entry for each waypoint.
    pub fn with_reverse(self, reverse: &'a [bool]) -> Result<Self, PathError> {
        check_length("reverse", reverse.len(), self.len())?;
        Ok(Self {
            reverse: Some(reverse),
            ends: None,
            ..self
        })
    }

    /// The same path with the slope at each waypoint along it, positive uphill in the order of the
    /// waypoints: rise over run. Without it the path is level.
    ///
    /// # Errors
    ///
    /// [`PathError`]: not an entry for each waypoint, or one that is not finite or beyond
    /// [`MAX_GRADE`](crate::bounds::MAX_GRADE).
    pub fn with_grade(self, grade: &'a [f64]) -> Result<Self, PathError> {
        check_column("grade", grade, self.len(), MAX_GRADE)?;
        Ok(Self {
            grade: Some(grade),
            ..self
        })
    }

    /// The slope at each waypoint, where the path has one.
    pub fn grade(&self) -> Option<&'a [f64]> {
        self.grade
    }

    /// The slope at the `share` of segment `index`, linear between waypoints; 0 without any.
    #[inline]
    pub(crate) fn grade_at(&self, index: usize, share: f64) -> f64 {
        let at = |index: usize| self.grade.and_then(|grade| grade.get(index).copied());
        let here = at(index).unwrap_or(0.0);
        let next = self.next(index).and_then(at).unwrap_or(here);
        here + share * (next - here)
    }

    /// The number of waypoints.
    #[inline]
    #[expect(clippy::len_without_is_empty, reason = "a path is never empty")]
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// The number of segments.
    #[inline]
    pub fn segments(&self) -> usize {
        self.len() - usize::from(!self.closed)
    }

    /// Whether the last waypoint leads back to the first.
    #[inline]
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Arc length of the whole path [m], the closing segment included.
    #[inline]
    pub fn length(&self) -> f64 {
        self.measures.length
    }

    /// Length of the longest segment [m].
    #[inline]
    pub fn longest(&self) -> f64 {
        self.measures.longest
    }

    /// The abscissas of the waypoints [m].
    pub fn x(&self) -> &'a [f64] {
        self.x
    }

    /// The ordinates of the waypoints [m].
    pub fn y(&self) -> &'a [f64] {
        self.y
    }

    /// The arc length at each waypoint [m].
    pub fn s(&self) -> &'a [f64] {
        self.s
    }

    /// The reference speed at each waypoint [m/s], where the path has one.
    pub fn speed(&self) -> Option<&'a [f64]> {
        self.speed
    }

    /// For each segment whether it is driven backwards, where any is.
    pub fn reverse(&self) -> Option<&'a [bool]> {
        self.reverse
    }

    /// Waypoint `index`; the origin beyond the last, which no caller in this crate asks for.
    #[inline]
    pub(crate) fn waypoint(&self, index: usize) -> Point {
        match (self.x.get(index), self.y.get(index)) {
            (Some(&x), Some(&y)) => Point::new(x, y),
            _ => Point::new(0.0, 0.0),
        }
    }

    /// Arc length at waypoint `index` [m]; that of the whole path beyond the last.
    #[inline]
    pub fn arc(&self, index: usize) -> f64 {
        self.s.get(index).copied().unwrap_or(self.measures.length)
    }

    /// `index` counted on across the seam of a closed path, at most once.
    #[inline]
    pub(crate) fn around(&self, index: usize) -> usize {
        if index < self.len() {
            index
        } else {
            index - self.len()
        }
    }

    /// The waypoint after `index`; None after the last of an open path.
    #[inline]
    pub(crate) fn next(&self, index: usize) -> Option<usize> {
        if index + 1 < self.len() {
            return Some(index + 1);
        }
        self.closed.then_some(0)
    }

    /// The waypoint before `index`; None before the first of an open path.
    #[inline]
    pub(crate) fn previous(&self, index: usize) -> Option<usize> {
        if index > 0 {
            return Some(index - 1);
        }
        self.closed.then_some(self.len() - 1)
    }

    /// Whether a remembered waypoint is one of this path.
    pub(crate) fn check_waypoint(
        &self,
        field: &'static str,
        waypoint: Option<usize>,
    ) -> Result<(), InputError> {
        match waypoint {
            Some(index) if index >= self.len() => Err(InputError {
                field,
                value: from_count(index),
                requirement: Requirement::Below(self.len()),
            }),
            _ => Ok(()),
        }
    }

    /// The segment that starts at waypoint `index`, or ends there where none starts.
    #[inline]
    pub(crate) fn segment_at(&self, index: usize) -> usize {
        index.min(self.segments() - 1)
    }

    /// Arc length at the end of segment `index` [m].
    #[inline]
    pub(crate) fn segment_end(&self, index: usize) -> f64 {
        self.arc(index + 1)
    }

    /// Length of segment `index` [m].
    #[inline]
    pub fn segment_length(&self, index: usize) -> f64 {
        self.segment_end(index) - self.arc(index)
    }

    /// The segment that holds `arc` [m]: the last whose start does not lie beyond it, the first
    /// before all. It is searched for on segment `near` and those beside it, then about where it is
    /// if all segments are as long as `near`, then by bisection.
    #[inline]
    pub fn segment_by_arc(&self, arc: f64, near: usize) -> usize {
        self.segment_beside(arc, near)
            .unwrap_or_else(|| self.distant_segment(arc, near))
    }

    /// The segment that holds `arc` [m], which is not beside `near`.
    #[expect(
        clippy::inline_always,
        reason = "a call costs a step of preview POP 300 instructions"
    )]
    #[inline(always)]
    fn distant_segment(&self, arc: f64, near: usize) -> usize {
        let last = self.segments() - 1;
        let away = (arc - self.arc(near)) / self.segment_length(near);
        let about = to_count(saturate(from_count(near) + away, 0.0, from_count(last)));
        self.segment_beside(arc, about).unwrap_or_else(|| {
            let begun = self.s.partition_point(|&start| start <= arc);
            begun.saturating_sub(1).min(last)
        })
    }

    /// The segment that holds `arc` [m], where it is one of a few about `near`.
    #[inline]
    fn segment_beside(&self, arc: f64, near: usize) -> Option<usize> {
        let last = self.segments() - 1;
        let mut segment = if near < last { near + 1 } else { last };
        for _ in 0..5 {
            if self.arc(segment) <= arc {
                let is_it = segment == last || self.arc(segment + 1) > arc;
                return is_it.then_some(segment);
            }
            segment = segment.saturating_sub(1);
        }
        None
    }

    /// Whether segment `index` is driven backwards.
    #[inline]
    pub fn is_reverse(&self, index: usize) -> bool {
        let reverse = self.reverse.and_then(|reverse| reverse.get(index));
        reverse.copied().unwrap_or(false)
    }

    /// The segment after `index`; None after the last of an open path.
    #[inline]
    pub(crate) fn next_segment(&self, index: usize) -> Option<usize> {
        self.next(index).filter(|&next| next < self.segments())
    }

    /// The segment after `index`; None if the path ends or a cusp lies between.
    #[inline]
    pub(crate) fn following(&self, index: usize) -> Option<usize> {
        self.next_segment(index)
            .filter(|&next| self.goes_on(index, next))
    }

    /// The segment before `index`, where the vehicle comes without changing its direction.
    #[inline]
    pub(crate) fn preceding(&self, index: usize) -> Option<usize> {
        self.previous(index)
            .filter(|&previous| self.goes_on(previous, index))
    }

    /// The segment after `index`, or the one before it, in the same section.
    #[inline]
    pub(crate) fn neighbour(&self, index: usize, ahead: bool) -> Option<usize> {
        if ahead {
            self.following(index)
        } else {
            self.preceding(index)
        }
    }

    /// Whether a cusp ends segment `index`: the next one is driven in the other direction.
    #[cfg(feature = "alloc")]
    #[inline]
    pub(crate) fn ends_at_cusp(&self, index: usize) -> bool {
        self.next_segment(index)
            .is_some_and(|next| !self.goes_on(index, next))
    }

    /// At which waypoints the vehicle changes its direction.
    #[cfg(feature = "alloc")]
    #[must_use]
    pub fn cusps(&self) -> alloc::vec::Vec<bool> {
        let mut cusps = alloc::vec![false; self.len()];
        for segment in (0..self.segments()).filter(|&segment| self.ends_at_cusp(segment)) {
            if let Some(cusp) = self.next(segment).and_then(|next| cusps.get_mut(next)) {
                *cusp = true;
            }
        }
        cusps
    }

    /// Whether one segment is driven in the direction of the other.
    #[inline]
    fn goes_on(&self, from: usize, to: usize) -> bool {
        self.reverse.is_none() || self.is_reverse(from) == self.is_reverse(to)
    }

    /// Both ends of segment `index`.
    #[inline]
    pub fn segment(&self, index: usize) -> (Point, Point) {
        let end = self.next(index).unwrap_or(index);
        (self.waypoint(index), self.waypoint(end))
    }
}
