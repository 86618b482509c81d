//! Finds the vehicle on the whole path after a jump: the segment of least distance and heading
//! error.
//!
//! [`relocalise_by_scan`] visits every segment and is the definition; [`relocalise`] leaves out
//! those that the `index` shows to be too far off.

use super::best::Best;
use super::index::{self, Found};
use super::view::PathView;
use crate::geometry::Point;

/// The segment to start from after a jump to `position` with heading `yaw`, as
/// [`relocalise_by_scan`] has it. On a path with an index it takes a few microseconds where few
/// segments are as near, and visits all of them at worst.
pub fn relocalise(path: &PathView<'_>, position: Point, yaw: f64, opposite_distance: f64) -> usize {
    relocalise_within(path, position, yaw, opposite_distance, usize::MAX).segment
}

/// [`relocalise`] that visits at most `budget` boxes of the path's index: the best of the segments
/// in those where that is not enough. A path without an index is scanned.
pub fn relocalise_within(
    path: &PathView<'_>,
    position: Point,
    yaw: f64,
    opposite_distance: f64,
    budget: usize,
) -> Found {
    match path.index {
        Some(boxes) => {
            let best = Best::new(position, yaw, opposite_distance);
            index::search(path, boxes, best, budget)
        }
        None => Found {
            segment: relocalise_by_scan(path, position, yaw, opposite_distance),
            is_exact: true,
            visits: 0,
        },
    }
}

/// The segment to start from after a jump to `position` with heading `yaw`: the one of least
/// distance plus a penalty that grows as the heading turns away from the path, up to
/// `opposite_distance` [m] against it; the first of several. Visits every segment.
///
/// The heading thus distinguishes branches that cross or lie alongside. Where the path is driven
/// backwards, the heading of a vehicle on it is opposite to the path's.
pub fn relocalise_by_scan(
    path: &PathView<'_>,
    position: Point,
    yaw: f64,
    opposite_distance: f64,
) -> usize {
    let mut best = Best::new(position, yaw, opposite_distance);
    for segment in 0..path.segments() {
        best.visit(path, segment);
    }
    best.segment()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Path;
    use crate::math::{PI, from_count, sin};
    use crate::path::locate::OPPOSITE;
    use alloc::vec::Vec;
    use core::f64::consts::{FRAC_PI_2, TAU};

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
        for (yaw, branches) in [(0.464, [399, 0]), (PI - 0.464, [199, 200])] {
            for askew in [-0.5, 0.0, 0.5] {
                let found = relocalise(&path.view(), crossing, yaw + askew, OPPOSITE);
                assert!(branches.contains(&found), "{yaw} {askew} {found}");
            }
        }
    }

    #[test]
    fn test_relocalise_square_crossing_goes_by_the_heading() {
        // Along x, round by the right, and back across it along y.
        let path = Path::new(
            &[-30.0, 30.0, 30.0, 0.0, 0.0],
            &[0.0, 0.0, -30.0, -30.0, 30.0],
            None,
            false,
        )
        .unwrap();
        let found = |yaw| relocalise(&path.view(), Point::new(0.3, -0.2), yaw, OPPOSITE);
        assert_eq!([0.0, 0.7, -0.7].map(found), [0; 3]);
        assert_eq!([FRAC_PI_2, 0.9, 2.3].map(found), [3; 3]);
    }

    #[test]
    fn test_relocalise_there_and_back_weighs_distance_against_heading() {
        // There, and back so far beside it.
        let found = |apart: f64, yaw: f64| {
            let path = Path::new(
                &[0.0, 10.0, 10.0, 0.0],
                &[0.0, 0.0, apart, apart],
                None,
                false,
            );
            relocalise(&path.unwrap().view(), Point::new(5.0, 0.0), yaw, OPPOSITE)
        };
        assert_eq!((found(9.0, 0.0), found(9.0, PI)), (0, 2));
        assert_eq!((found(11.0, 0.0), found(11.0, PI)), (0, 0));
    }

    #[test]
    fn test_relocalise_on_a_reverse_stretch_looks_against_it() {
        let (x, y) = ([0.0, 10.0, 0.0], [0.0, 0.0, 1.0]);
        let path = Path::new(&x, &y, None, false).unwrap();
        let path = path.with_reverse(&[false, true, false]).unwrap();
        let found = |yaw| relocalise(&path.view(), Point::new(2.0, 0.7), yaw, OPPOSITE);
        assert_eq!((found(0.0), found(PI)), (1, 1));
        assert_eq!(
            relocalise(&path.view(), Point::new(2.0, 0.1), 0.0, OPPOSITE),
            0
        );
    }
}
