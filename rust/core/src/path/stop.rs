//! The next stop: its distance, and the speed until there.
//!
//! A vehicle stops at the end of an open path, and at each cusp, where it changes its direction.
//! The rear axle decides, whatever point a controller tracks, so both numbers here are those beside
//! the rear axle.

use super::follow::{Follow, Located};
use super::view::PathView;
use crate::bounds::MAX_SPEED;
use crate::error::{InputError, input_within};
use crate::math::{larger, saturate, smaller, sqrt};

/// Reference speed and distance to the next stop, beside the rear axle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ahead {
    /// Reference speed [m/s], negative where the path is driven backwards; None if the path
    /// has no speeds.
    pub reference_speed: Option<f64>,
    /// Distance along the path to the next cusp, or to the end [m]; negative past it, infinite
    /// where there is neither.
    pub distance_to_stop: f64,
}

impl Ahead {
    /// Speed that replaces a speed of 0 at a cusp or at the end, in arrival distances a second: a
    /// tenth of the wheelbase a second. Larger: the vehicle arrives faster. Smaller: the last
    /// centimetres take longer; at 0 it would never leave a cusp.
    const CREEP: f64 = 2.0;
    /// Bound of a distance along a path [m], which no valid path reaches.
    const MAX_DISTANCE: f64 = 1e18;

    /// Refuses, as part of `field`, values that no path gives.
    pub(crate) fn check(&self, field: &'static str) -> Result<(), InputError> {
        input_within(field, self.reference_speed.unwrap_or(0.0), 2.0 * MAX_SPEED)?;
        if self.distance_to_stop < f64::INFINITY || self.distance_to_stop.is_nan() {
            input_within(field, self.distance_to_stop, Self::MAX_DISTANCE)?;
        }
        Ok(())
    }

    /// The values beside the rear axle of a vehicle that `follow` has located.
    #[inline]
    pub fn of(path: &PathView<'_>, follow: &Follow, at: &Located) -> Self {
        // Distance of the tracked point ahead of the rear axle, in the direction of driving.
        let lead = follow.reference_offset - at.mirror(follow.rear_axle - follow.base);
        Self::behind(path, follow, at, lead)
    }

    /// Speed that replaces a speed of 0 at a cusp or at the end [m/s].
    #[inline]
    pub fn creep(follow: &Follow) -> f64 {
        Self::CREEP * follow.arrival_distance
    }

    /// The values `lead` [m] behind the point that `follow` has located.
    #[inline]
    pub fn behind(path: &PathView<'_>, follow: &Follow, at: &Located, lead: f64) -> Self {
        let segment = at.closest.segment;
        let end = path.section_end(segment);
        // Most closed paths say neither.
        if end.is_none() && path.speed().is_none() {
            return Self {
                reference_speed: None,
                distance_to_stop: f64::INFINITY,
            };
        }
        let arc = at.closest.arc_length(path) - lead;
        let distance_to_stop = match end {
            None => f64::INFINITY,
            Some(last) => path.end_ahead(segment, last) - arc,
        };
        let reference_speed = path.speed().map(|speed| {
            let creep = Self::creep(follow);
            let magnitude = speed_beside(path, speed, (segment, end), arc, lead, creep);
            if at.reverse { -magnitude } else { magnitude }
        });
        Self {
            reference_speed,
            distance_to_stop,
        }
    }
}

/// The magnitude of the reference speed at `arc` [m], near segment `near`, in the section that ends
/// with segment `end`; beyond the section, that at its nearer end.
///
/// Between waypoints the square of the speed is linear in the arc, as under a constant
/// acceleration. A speed of 0 at an end of the section counts as `creep` [m/s], so that no vehicle
/// stops before it or stays there.
#[inline(never)]
fn speed_beside(
    path: &PathView<'_>,
    speed: &[f64],
    (near, end): (usize, Option<usize>),
    arc: f64,
    lead: f64,
    creep: f64,
) -> f64 {
    let (length, closed) = (path.length(), path.is_closed());
    let arc = if closed && arc < 0.0 {
        arc + length
    } else if closed && arc > length {
        arc - length
    } else {
        arc
    };
    let mut segment = path.segment_by_arc(arc, near);
    let mut share = (arc - path.arc(segment)) / path.segment_length(segment);
    if path.reverse().is_some()
        && let Some(end) = end
        && path.section_end(segment) != Some(end)
    {
        // The rear axle has not come to this section yet, or is past it.
        let first = path.section(end).map_or(segment, |(first, _)| first);
        (segment, share) = if lead > 0.0 { (first, 0.0) } else { (end, 1.0) };
    }
    let at = |index: usize| speed.get(index).copied().unwrap_or(0.0).abs();
    let (start, finish) = (at(segment), at(path.next(segment).unwrap_or(segment)));
    let (before, after) = (path.preceding(segment), path.following(segment));
    let here = before.map_or_else(|| at_stop(start, finish, creep), |_| start);
    let next = after.map_or_else(|| at_stop(finish, start, creep), |_| finish);
    let (here, next) = (here * here, next * next);
    sqrt(here + saturate(share, 0.0, 1.0) * (next - here))
}

/// A speed at an end of a section: at least `creep`, or the faster one at the ends of the segment
/// where that is slower.
fn at_stop(speed: f64, other: f64, creep: f64) -> f64 {
    let faster = larger(speed, other);
    if faster <= 0.0 {
        return creep;
    }
    larger(smaller(faster, creep), speed)
}

impl PathView<'_> {
    /// The last segment of the section that segment `index` is in: it ends at a cusp or at the end
    /// of the path. None if there is neither.
    #[inline]
    pub fn section_end(&self, index: usize) -> Option<usize> {
        if self.reverse().is_none() {
            return (!self.is_closed()).then(|| self.segments() - 1);
        }
        self.section(index).map(|(_, last)| last)
    }

    /// The first and the last segment of the section that segment `index` is in. None if a closed path
    /// has no cusp.
    pub(crate) fn section(&self, index: usize) -> Option<(usize, usize)> {
        let Some(ends) = self.ends else {
            return self.section_by_scan(index);
        };
        let (before, after) = ends.split_at_checked(ends.partition_point(|&end| end < index))?;
        let (before, after) = (before.last(), after.first());
        if self.is_closed() {
            let before = before.or(ends.last())?;
            Some((self.around(before + 1), *after.or(ends.first())?))
        } else {
            let first = before.map_or(0, |before| before + 1);
            Some((first, *after.unwrap_or(&(self.segments() - 1))))
        }
    }

    /// The same by its definition: from segment to segment until the direction changes.
    pub fn section_by_scan(&self, index: usize) -> Option<(usize, usize)> {
        let edge = |ahead: bool| {
            let mut last = index;
            for _ in 0..self.segments() {
                match self.neighbour(last, ahead) {
                    Some(next) => last = next,
                    None => return Some(last),
                }
            }
            None
        };
        Some((edge(false)?, edge(true)?))
    }

    /// Arc length at the end of segment `last`, which comes after segment `index` [m]: beyond the path's
    /// where the seam lies between them.
    #[inline]
    pub(crate) fn end_ahead(&self, index: usize, last: usize) -> f64 {
        let seam = if last < index { self.length() } else { 0.0 };
        self.segment_end(last) + seam
    }
}

#[cfg(test)]
mod tests;
