//! Tracks a point of the vehicle along the path: forwards, backwards, and through cusps.
//!
//! A vehicle that drives backwards equals one that drives forward with its heading turned by 180
//! degrees, its axles mirrored about the rear axle and its steering angle negated; for the
//! kinematic bicycle exactly. Controllers are therefore written for driving forward only. Where the
//! path is driven backwards, [`Follow::find`] gives them the mirrored vehicle, and
//! [`Located::mirror`] converts their angle.

use super::locate::locate;
use super::projection::ClosestPoint;
use super::view::PathView;
use crate::geometry::Point;
use crate::math::{PI, cos, larger, sin, sqrt};
use crate::vehicle::{Vehicle, VehicleState};

/// Which point of the vehicle is tracked, and how it is searched for on the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follow {
    /// Point about which the vehicle is mirrored where it drives backwards, ahead of the pose's
    /// point [m]: the rear axle or the no-slip point.
    pub base: f64,
    /// Tracked point, ahead of `base` in the direction of driving [m].
    pub reference_offset: f64,
    /// Rear axle, ahead of the pose's point in the vehicle's frame [m]: 0 for a pose of the rear
    /// axle, negative for a pose farther forward.
    pub rear_axle: f64,
    /// Arc of the path to search on each side of the last projection [m], in addition to the
    /// distance travelled in a step.
    pub search_distance: f64,
    /// Distance from the path beyond which the vehicle is lost and is searched for on the whole
    /// path [m].
    pub lost_distance: f64,
    /// Distance to a cusp at which the rear axle counts as arrived [m].
    pub arrival_distance: f64,
    /// Cost of a path that leads opposite to the heading, as a distance [m].
    pub opposite_distance: f64,
}

/// The tracked point on the path, and the vehicle as one that drives forward.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each says one thing of one step"
)]
pub struct Located {
    /// The tracked point [m].
    pub position: Point,
    /// The path's closest point to it.
    pub closest: ClosestPoint,
    /// The vehicle, mirrored where the path is driven backwards, so that it drives forward.
    pub vehicle: VehicleState,
    /// The unit vector along the mirrored vehicle's heading.
    pub heading: Point,
    /// Control period [s].
    pub dt: f64,
    /// Whether the path is driven backwards here.
    pub reverse: bool,
    /// Whether the direction of driving differs from that of the last step.
    pub direction_changed: bool,
    /// Whether the vehicle was lost in this step.
    pub off_path: bool,
    /// Whether the point is past the last waypoint of an open path.
    pub past_end: bool,
    /// Whether the point is before the first waypoint of an open path.
    pub before_start: bool,
}

impl Follow {
    /// Tracks the point `ahead` [m] of `base`, which lies so far [m] ahead of the pose's point. The
    /// search covers two wheelbases of path on each side, and the vehicle is never lost.
    pub fn of(vehicle: &Vehicle, base: f64, ahead: f64) -> Self {
        let wheelbase = vehicle.wheelbase;
        Self {
            base,
            reference_offset: ahead,
            rear_axle: vehicle.rear_axle,
            search_distance: 2.0 * wheelbase,
            lost_distance: f64::INFINITY,
            arrival_distance: 0.05 * wheelbase,
            // 10 m at the paper's wheelbase, to the last bit.
            opposite_distance: wheelbase * 10.0 / 3.0,
        }
    }

    /// Projects the tracked point of a checked vehicle, about segment `segment`, from which it can have
    /// `travelled` so far [m] in the period `dt` [s].
    #[inline]
    pub(super) fn locate_from(
        &self,
        path: &PathView<'_>,
        segment: usize,
        mut vehicle: VehicleState,
        dt: f64,
        travelled: f64,
    ) -> Located {
        let reverse = path.is_reverse(segment);
        if reverse {
            vehicle.yaw += PI;
            vehicle.speed = -vehicle.speed;
        }
        let heading = Point::new(cos(vehicle.yaw), sin(vehicle.yaw));
        let base = if reverse { -self.base } else { self.base };
        let ahead = self.reference_offset + base;
        let position = Point::new(vehicle.x + ahead * heading.x, vehicle.y + ahead * heading.y);
        let reach = self.search_distance + travelled;
        let opposite = self.opposite_distance;
        let closest = locate(path, segment, position, heading, reach, opposite);
        let closest = closest.on_curve(path, position);
        Located {
            position,
            closest,
            vehicle,
            heading,
            dt,
            reverse,
            direction_changed: false,
            off_path: false,
            past_end: closest.fraction > 1.0 && path.next_segment(closest.segment).is_none(),
            before_start: closest.fraction < 0.0 && closest.segment == 0 && !path.is_closed(),
        }
    }

    /// The first segment behind a cusp, once the rear axle has arrived at the cusp.
    ///
    /// The rear axle decides for every tracked point and every point of the pose, so that all
    /// change direction in one step. The projection only tells which cusp is next.
    pub(super) fn next_section(
        &self,
        path: &PathView<'_>,
        at: &Located,
        vehicle: VehicleState,
    ) -> Option<usize> {
        let closest = &at.closest;
        // Distance of the tracked point behind the rear axle, in the direction of driving.
        let behind = at.mirror(self.rear_axle - self.base) - self.reference_offset;
        let last = path.section_end(closest.segment)?;
        let rest = path.end_ahead(closest.segment, last) - closest.arc_length(path);
        if rest > larger(behind, 0.0) + 4.0 * self.arrival_distance {
            return None;
        }
        let next = path.next_segment(last)?;
        let (start, end) = path.segment(last);
        let along = end - start;
        let to = end - vehicle.point_ahead(self.rear_axle);
        let remaining = to.dot(&along) / sqrt(along.dot(&along));
        (remaining <= self.arrival_distance).then_some(next)
    }
}

impl Located {
    /// Converts an angle [rad] or a curvature of the mirrored vehicle to the real one, and back:
    /// the sign changes where the path is driven backwards.
    #[inline]
    pub fn mirror(&self, steer: f64) -> f64 {
        if self.reverse { -steer } else { steer }
    }
}

#[cfg(test)]
mod tests;
