//! The best of several segments by distance and heading, for a vehicle that may be anywhere.

use super::locate::least_cost;
use super::projection::ClosestPoint;
use super::view::PathView;
use crate::geometry::Point;
use crate::math::{cos, sin};

/// More than rounding takes off a cost, as a share of the opposite distance and of the cost.
const ROUNDING: f64 = 1e-12;

/// The best segment of those visited, in any order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best {
    pub(super) position: Point,
    heading: Point,
    pub(super) opposite_distance: f64,
    /// The least cost found [m] and its segment, so that of several as good the first is the least.
    pub(super) least: (f64, usize),
}

impl Best {
    /// The search before its first segment.
    #[inline]
    pub(super) fn new(position: Point, yaw: f64, opposite_distance: f64) -> Self {
        Self {
            position,
            heading: Point::new(cos(yaw), sin(yaw)),
            opposite_distance,
            least: (f64::INFINITY, 0),
        }
    }

    /// Takes segment `segment` of `path` into account.
    #[inline]
    pub(super) fn visit(&mut self, path: &PathView<'_>, segment: usize) {
        let closest = ClosestPoint::within(path, segment, self.position);
        // The heading only adds to the distance; most segments are too far off without it.
        let most = (1.0 + ROUNDING) * self.least.0 + ROUNDING * self.opposite_distance;
        if closest.squared_distance > most * most {
            return;
        }
        let heading = self.heading_on(path, segment);
        let candidate = (closest.cost(heading, self.opposite_distance), segment);
        if candidate < self.least {
            self.least = candidate;
        }
    }

    /// What segment `segment` of `path` costs [m], by its direction or the path's smoothed one: the
    /// lesser.
    #[inline]
    pub(super) fn least_cost(&self, path: &PathView<'_>, segment: usize) -> f64 {
        let closest = ClosestPoint::within(path, segment, self.position);
        least_cost(
            path,
            &closest,
            self.heading_on(path, segment),
            self.opposite_distance,
        )
    }

    /// The heading of the vehicle, as one that drives forward on segment `segment`.
    #[inline]
    fn heading_on(&self, path: &PathView<'_>, segment: usize) -> Point {
        if path.is_reverse(segment) {
            -self.heading
        } else {
            self.heading
        }
    }
}
