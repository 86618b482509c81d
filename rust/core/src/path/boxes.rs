//! Bounding boxes along a path.
//!
//! Neighbours on a path are neighbours in the plane. So each run of [`RUN`] segments gets a
//! bounding box, two of those a box around both, and so on up to the whole path: a binary tree in
//! one flat array, in the order of the arc. Node 1 holds the whole path and nodes 2k and 2k + 1
//! what node k holds; the last half of the array are the runs, one each.

#[cfg(feature = "alloc")]
use alloc::{boxed::Box, vec};

use crate::geometry::Point;
use crate::math::saturate;
#[cfg(feature = "alloc")]
use crate::math::{larger, smaller};

/// Segments in a run, which share a box. Shorter runs leave out more segments, longer ones need
/// less memory: at 32 segments the boxes take 2 bytes per waypoint.
pub(super) const RUN: usize = 32;

/// A path of at most this many segments has no index. To scan it takes no longer than a search on
/// a long path, and a planner makes such paths many times a second.
#[cfg(feature = "alloc")]
pub(super) const SCANNED: usize = 512;

/// A rectangle along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    low: Point,
    high: Point,
}

impl Bounds {
    /// The square of the distance from `position` to the nearest point of the box [m^2].
    #[inline]
    pub(super) fn squared_distance(&self, position: Point) -> f64 {
        let dx = position.x - saturate(position.x, self.low.x, self.high.x);
        let dy = position.y - saturate(position.y, self.low.y, self.high.y);
        dx * dx + dy * dy
    }

    /// The box around both.
    #[cfg(feature = "alloc")]
    fn around(a: Self, b: Self) -> Self {
        Self {
            low: Point::new(smaller(a.low.x, b.low.x), smaller(a.low.y, b.low.y)),
            high: Point::new(larger(a.high.x, b.high.x), larger(a.high.y, b.high.y)),
        }
    }
}

/// The boxes of a path with these waypoints; None if a scan is as quick.
#[cfg(feature = "alloc")]
pub(super) fn build(x: &[f64], y: &[f64], closed: bool) -> Option<Box<[Bounds]>> {
    let segments = if closed {
        x.len()
    } else {
        x.len().saturating_sub(1)
    };
    if segments <= SCANNED {
        return None;
    }
    let runs = segments.div_ceil(RUN);
    let first_run = runs.next_power_of_two();
    let empty = Bounds {
        low: Point::new(f64::INFINITY, f64::INFINITY),
        high: Point::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
    };
    let mut boxes = vec![empty; 2 * runs].into_boxed_slice();
    let waypoint = |index: usize| {
        let index = if index == x.len() && closed { 0 } else { index };
        Some(Point::new(*x.get(index)?, *y.get(index)?))
    };
    for run in 0..runs {
        let node = first_run + run;
        let node = if node < 2 * runs { node } else { node - runs };
        if let Some(room) = boxes.get_mut(node) {
            // A run ends at the waypoint to which its last segment leads.
            for point in (RUN * run..=RUN * (run + 1)).filter_map(waypoint) {
                let (low, high) = (point, point);
                *room = Bounds::around(*room, Bounds { low, high });
            }
        }
    }
    for node in (1..runs).rev() {
        let (Some(&left), Some(&right)) = (boxes.get(2 * node), boxes.get(2 * node + 1)) else {
            break;
        };
        if let Some(room) = boxes.get_mut(node) {
            *room = Bounds::around(left, right);
        }
    }
    Some(boxes)
}
