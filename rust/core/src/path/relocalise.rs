//! Where am I after a jump? The nearest waypoint where the path leads the vehicle's way.
//!
//! [`relocalise`] visits every waypoint and is the definition. [`Relocalisation`] is the same
//! search for whoever knows, from a spatial index, which waypoints need no visit.

use super::view::{PathView, squared_distance};
use crate::Point;
use crate::math::{cos, sin, sqrt};

/// How much farther off than the nearest waypoint of all one whose direction fits may be [m].
pub const REACH: f64 = 10.0;

/// The waypoint to go on from after a jump to `position` with heading `yaw`: of those at most
/// [`REACH`] farther off than the nearest of all, the nearest where the path leads at most 90
/// degrees off `yaw`; the first of several. The nearest of all where it does so nowhere. Visits
/// every waypoint.
///
/// The heading thus tells branches apart that cross or lie alongside, where it points against one
/// of them. The path's direction at a waypoint is that of the segment that leaves it, at the end
/// of an open path that of the last.
pub fn relocalise(path: &PathView<'_>, position: Point, yaw: f64) -> usize {
    let mut search = Relocalisation::new(position, yaw);
    for (index, (&x, &y)) in path.x().iter().zip(path.y()).enumerate() {
        search.visit(path, index, Point::new(x, y));
    }
    search.waypoint()
}

/// [`relocalise`], waypoint by waypoint in any order: for a search that need not visit all.
#[derive(Clone, Copy, Debug)]
pub struct Relocalisation {
    position: Point,
    heading: Point,
    /// Squared distance and index, so that of several as near the first is the least.
    nearest: (f64, usize),
    /// The same of the waypoints whose direction fits.
    fitting: (f64, usize),
}

impl Relocalisation {
    /// The search before its first waypoint.
    #[inline]
    pub fn new(position: Point, yaw: f64) -> Self {
        Self {
            position,
            heading: Point::new(cos(yaw), sin(yaw)),
            nearest: (f64::INFINITY, 0),
            fitting: (f64::INFINITY, 0),
        }
    }

    /// Takes waypoint `index` of `path` into account; `waypoint` is where it lies [m].
    #[inline]
    pub fn visit(&mut self, path: &PathView<'_>, index: usize, waypoint: Point) {
        let candidate = (squared_distance(self.position, waypoint), index);
        // What fits is never nearer than the nearest.
        if candidate < self.fitting {
            if candidate < self.nearest {
                self.nearest = candidate;
            }
            if self.fits(path, index) {
                self.fitting = candidate;
            }
        }
    }

    /// Whether no waypoint whose squared distance is at least this [m^2] can change the answer.
    #[inline]
    pub fn is_settled(&self, squared_distance: f64) -> bool {
        squared_distance > self.fitting.0 || sqrt(squared_distance) > self.bound()
    }

    /// The answer, once all waypoints that count are visited.
    #[inline]
    pub fn waypoint(&self) -> usize {
        if sqrt(self.fitting.0) <= self.bound() {
            self.fitting.1
        } else {
            self.nearest.1
        }
    }

    /// How far off a waypoint whose direction fits may be [m].
    #[inline]
    fn bound(&self) -> f64 {
        sqrt(self.nearest.0) + REACH
    }

    /// Whether the path leads at most 90 degrees off the heading.
    #[inline]
    fn fits(&self, path: &PathView<'_>, index: usize) -> bool {
        let segment = if path.next(index).is_some() {
            index
        } else {
            path.previous(index).unwrap_or(index)
        };
        let (start, end) = path.segment(segment);
        let along = end - start;
        self.heading.x * along.x + self.heading.y * along.y >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Path;
    use crate::math::{PI, from_count};
    use alloc::vec::Vec;
    use core::f64::consts::{FRAC_PI_2, TAU};
    use proptest::prelude::*;

    /// A figure of eight that crosses itself at the origin, leading 27 and 153 degrees there.
    fn eight() -> Path {
        let (x, y): (Vec<_>, Vec<_>) = (0..400)
            .map(|k| TAU * from_count(k) / 400.0)
            .map(|t| (50.0 * sin(t), 12.5 * sin(2.0 * t)))
            .unzip();
        Path::new(&x, &y, None, true).unwrap()
    }

    #[test]
    fn test_relocalise_on_a_crossing_takes_the_branch_of_the_heading() {
        let path = eight();
        let crossing = Point::new(0.0, 0.0);
        for (yaw, branch) in [(0.464, 0), (PI - 0.464, 200)] {
            for askew in [-0.5, 0.0, 0.5] {
                let found = relocalise(&path.view(), crossing, yaw + askew);
                assert_eq!(found, branch, "{yaw} {askew}");
            }
        }
        // Neither leads against this heading: the nearer one counts.
        let left = Point::new(-3.0, 1.5);
        assert_eq!(relocalise(&path.view(), left, FRAC_PI_2), 204);
    }

    #[test]
    fn test_relocalise_beyond_reach_takes_the_nearest_of_all() {
        // There, and back so far beside it.
        let found = |apart: f64, yaw: f64| {
            let path = Path::new(
                &[0.0, 5.0, 10.0, 10.0, 5.0, 0.0],
                &[0.0, 0.0, 0.0, apart, apart, apart],
                None,
                false,
            );
            relocalise(&path.unwrap().view(), Point::new(5.0, 0.0), yaw)
        };
        assert_eq!((found(10.0, 0.0), found(10.0, 3.3)), (1, 4));
        assert_eq!((found(10.1, 0.0), found(10.1, 3.3)), (1, 1));
    }

    #[test]
    fn test_relocalise_at_the_ends_takes_the_end_segments() {
        let (x, y) = ([0.0, 10.0, 10.0], [0.0, 0.0, 10.0]);
        let open = Path::new(&x, &y, None, false).unwrap();
        let found = |path: &Path, yaw| relocalise(&path.view(), Point::new(10.0, 9.0), yaw);
        assert_eq!((found(&open, FRAC_PI_2), found(&open, -0.75 * PI)), (2, 2));
        // The segment from the last waypoint leads back to the first.
        let closed = Path::new(&x, &y, None, true).unwrap();
        assert_eq!((found(&closed, -0.75 * PI), found(&closed, 0.3)), (2, 1));
    }

    /// The definition word by word.
    fn by_definition(path: &PathView<'_>, position: Point, yaw: f64) -> usize {
        let distance = |k: usize| sqrt(squared_distance(position, path.waypoint(k)));
        let fits = |k: usize| {
            let last = !path.is_closed() && k + 1 == path.len();
            let (start, end) = path.segment(if last { k - 1 } else { k });
            cos(yaw) * (end.x - start.x) + sin(yaw) * (end.y - start.y) >= 0.0
        };
        let first_nearest = |among: &dyn Fn(usize) -> bool| {
            (0..path.len())
                .filter(|&k| among(k))
                .min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
        };
        let nearest = first_nearest(&|_| true).unwrap();
        first_nearest(&|k| fits(k) && distance(k) <= distance(nearest) + REACH).unwrap_or(nearest)
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

        #[test]
        fn test_relocalise_is_its_definition_word_by_word(
            steps in proptest::collection::vec((-4..=4_i32, 1..=4_i32, any::<bool>()), 2..60),
            place in (-30..=30_i32, -30..=30_i32),
            yaw in -7.0..7.0_f64,
            closed in any::<bool>(),
        ) {
            // On a lattice squares of distances are exact, and so are ties.
            let (mut x, mut y) = (0.0, 0.0);
            let (xs, ys): (Vec<_>, Vec<_>) = steps
                .iter()
                .map(|&(across, along, ahead)| {
                    x += f64::from(across);
                    y += f64::from(if ahead { along } else { -along });
                    (x, y)
                })
                .unzip();
            let ends_meet = xs.first() == xs.last() && ys.first() == ys.last();
            let closed = closed && xs.len() > 2 && !ends_meet;
            let path = Path::new(&xs, &ys, None, closed).unwrap();
            let position = Point::new(f64::from(place.0), f64::from(place.1));
            prop_assert_eq!(
                relocalise(&path.view(), position, yaw),
                by_definition(&path.view(), position, yaw)
            );
        }
    }
}
