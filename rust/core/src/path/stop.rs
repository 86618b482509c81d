//! The next stop: its distance, and the speed until there.
//!
//! A vehicle stops at the end of an open path, and at each cusp, where it changes its direction.
//! The rear axle decides, whatever point a controller tracks, so both numbers here are those beside
//! the rear axle.

use super::follow::{Follow, Located};
use super::view::PathView;
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
            Some(last) => {
                let seam = if last < segment { path.length() } else { 0.0 };
                path.segment_end(last) + seam - arc
            }
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
    if path.reverse().is_some() {
        // The rear axle may not have come to this section yet, or be past it.
        if lead > 0.0 {
            for _ in 0..path.segments() {
                let last = path.section_end(segment);
                if last == end {
                    break;
                }
                let Some(next) = last.and_then(|last| path.next_segment(last)) else {
                    break;
                };
                segment = next;
                share = 0.0;
            }
        } else if let Some(last) = end
            && path.section_end(segment) != end
        {
            segment = last;
            share = 1.0;
        }
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
        match self.ends {
            None => self.section_end_by_scan(index),
            Some(ends) => {
                let place = ends.partition_point(|&end| end < index);
                match (ends.get(place), self.is_closed()) {
                    (Some(&end), _) => Some(end),
                    (None, true) => ends.first().copied(),
                    (None, false) => Some(self.segments() - 1),
                }
            }
        }
    }

    /// The same by its definition: from segment to segment until the direction changes.
    pub fn section_end_by_scan(&self, index: usize) -> Option<usize> {
        let mut last = index;
        for _ in 0..self.segments() {
            match self.following(last) {
                Some(next) => last = next,
                None => return Some(last),
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{FOLLOW, at, shuttle};
    use super::*;
    use crate::Path;
    use crate::geometry::Point;
    use alloc::vec::Vec;
    use proptest::prelude::*;

    fn ahead(follow: &Follow, waypoint: usize, x: f64, speed: f64) -> Ahead {
        let path = shuttle();
        let at = follow.locate(&path.view(), Some(waypoint), at(x, 0.2, speed), 0.05);
        Ahead::of(&path.view(), follow, &at)
    }

    #[test]
    fn test_distance_to_stop_is_the_rear_axles_whatever_point_is_followed() {
        for reference_offset in [3.0, 0.0, -1.5] {
            let follow = Follow {
                reference_offset,
                ..FOLLOW
            };
            for (waypoint, x, speed, distance) in [
                (0, 5.0, 1.0, 15.0),
                (1, 19.0, 1.0, 1.0),
                (2, 18.0, -1.0, 8.0),
                (2, 10.5, -1.0, 0.5),
                (3, 12.0, 1.0, 18.0),
                (4, 31.0, 1.0, -1.0),
            ] {
                let found = ahead(&follow, waypoint, x, speed).distance_to_stop;
                assert!(
                    (found - distance).abs() < 1e-9,
                    "{reference_offset} {x} {found}"
                );
            }
        }
    }

    #[test]
    fn test_reference_speed_brakes_evenly_and_never_stands_before_a_stop() {
        // From 2 m/s to 0.3 m/s, the creeping speed, over 10 m.
        let at = |x: f64| ahead(&FOLLOW, 1, x, 1.0).reference_speed.unwrap();
        assert!((at(15.0) - sqrt(0.5 * (4.0 + 0.09))).abs() < 1e-12);
        assert!((at(19.84) - 0.3).abs() < 0.1 && at(19.84) > 0.3);
        // Standing speeds at both ends of a leg are the creeping speed all along, backwards.
        let back = ahead(&FOLLOW, 2, 15.0, -1.0).reference_speed.unwrap();
        assert!((back + 0.3).abs() < 1e-12);
        // Just after the cusp, with the rear axle still before it, it is that of the new leg.
        let turned = ahead(&FOLLOW, 1, 19.9, 0.3).reference_speed.unwrap();
        assert!((turned + 0.3).abs() < 1e-12);
    }

    #[test]
    fn test_speed_slower_than_creeping_stays_what_the_path_says() {
        let path = Path::new(&[0.0, 10.0], &[0.0; 2], Some(&[0.1, 0.0]), false).unwrap();
        let speed = speed_beside(&path.view(), &[0.1, 0.0], (0, Some(0)), 9.0, 0.0, 0.3);
        assert!((speed - 0.1).abs() < 1e-12);
    }

    #[test]
    fn test_closed_path_without_a_cusp_has_no_stop() {
        let (x, y) = ([0.0, 10.0, 10.0, 0.0], [0.0, 0.0, 10.0, 10.0]);
        for backwards in [false, true] {
            let path = Path::new(&x, &y, None, true).unwrap();
            let path = path.with_reverse(&[backwards; 4]).unwrap();
            for index in 0..4 {
                assert_eq!(path.view().section_end(index), None);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

        #[test]
        fn test_section_end_from_the_list_is_that_of_the_scan(
            reverse in proptest::collection::vec(any::<bool>(), 3..60),
            closed: bool,
        ) {
            let points = (0..reverse.len()).map(|k| {
                let k = crate::math::from_count(k);
                Point::new(k, 0.01 * k * k)
            });
            let (x, y): (Vec<_>, Vec<_>) = points.map(|point| (point.x, point.y)).unzip();
            let path = Path::new(&x, &y, None, closed).unwrap().with_reverse(&reverse).unwrap();
            for index in 0..path.view().segments() {
                let view = path.view();
                prop_assert_eq!(view.section_end(index), view.section_end_by_scan(index));
            }
        }
    }
}
