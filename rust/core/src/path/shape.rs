//! Heading and curvature that a planner gives with its waypoints: the curve between them.
//!
//! Without them a path is its segments. With them the direction between two waypoints is that of a
//! Hermite polynomial through the headings, whose slopes are the curvatures, and the path lies beside
//! the segment by the parabola that turns as far:
//!
//! ```text
//! offset = -L (yaw_1 - yaw_0) t (1 - t) / 2          t = 0 to 1 along a segment of length L
//! ```
//!
//! Both are the vehicle's on the path: where it is driven backwards, the yaw points against the order
//! of the waypoints, and the curvature is positive where the wheels are turned to the left.

#[cfg(feature = "alloc")]
use alloc::{boxed::Box, vec, vec::Vec};

use super::measure::check_column;
use super::projection::ClosestPoint;
use super::view::PathView;
use crate::bounds::MAX_YAW;
use crate::error::PathError;
use crate::geometry::{Point, get_distance, squared_distance};
use crate::math::{PI, atan2, cos, saturate, sin, wrap};

/// How far a heading may be off the waypoints' directions [rad]: 20 degrees. That is far more than
/// centimetres of noise turn a chord of a metre, and less than a wrong unit, sign or frame is off.
const TOLERANCE: f64 = 0.35;
/// What of the turns a curvature may miss besides: it is known at the waypoints alone.
const SHARE: f64 = 0.2;
/// Over how much of the path directions are taken on each side of a waypoint [m], and over how many
/// waypoints directions and turns are at most.
const REACH: f64 = 1.0;
const MOST_WAYPOINTS: usize = 64;
/// The most that a heading may turn along such a chord [rad]; a shorter one is taken in a tighter bend.
const MOST_TURN: f64 = 1.0;
/// Bound of a curvature [1/m].
const MAX_CURVATURE: f64 = 1e3;

/// How a segment bends.
struct Bend {
    /// The direction in which it begins [rad].
    start: f64,
    /// How far it turns [rad].
    turn: f64,
    /// The curvatures at both ends [1/m], positive to the left in the order of the waypoints, where
    /// they are given.
    ends: Option<(f64, f64)>,
}

impl<'a> PathView<'a> {
    /// The same path with the vehicle's heading `yaw` [rad] and, if given, its `curvature` [1/m] at
    /// each waypoint. Give [`with_reverse`](Self::with_reverse) first.
    ///
    /// # Errors
    ///
    /// [`PathError`]: not an entry for each waypoint, one that is not finite or beyond its bound, a
    /// yaw more than 0.35 rad off the directions in which the waypoints come and go on, over a
    /// metre or a turn of 1 rad; curvatures that have added up to another turn than the yaw's, by more than 0.35 rad
    /// and a fifth of all turns.
    pub fn with_yaw(self, yaw: &'a [f64], curvature: Option<&'a [f64]>) -> Result<Self, PathError> {
        check_column("yaw", yaw, self.len(), MAX_YAW)?;
        if let Some(curvature) = curvature {
            check_column("curvature", curvature, self.len(), MAX_CURVATURE)?;
        }
        let shaped = Self {
            yaw: Some(yaw),
            curvature,
            ..self
        };
        shaped.check_yaw(yaw)?;
        shaped.check_curvature()?;
        Ok(shaped)
    }

    /// The vehicle's heading at each waypoint [rad], where the path has one of its own.
    pub fn yaw(&self) -> Option<&'a [f64]> {
        self.yaw
    }

    /// The curvature at each waypoint [1/m], where the path has one of its own.
    pub fn curvature(&self) -> Option<&'a [f64]> {
        self.curvature
    }

    fn check_yaw(&self, yaw: &[f64]) -> Result<(), PathError> {
        for (index, &value) in yaw.iter().enumerate() {
            let next = (index < self.segments()).then_some(index);
            let outward = next.map(|next| self.heading_along(yaw, next, true));
            let inward = self
                .previous(index)
                .map(|last| self.heading_along(yaw, last, false));
            let onward = outward.or(inward).unwrap_or(value);
            let from = inward.unwrap_or(onward);
            let off = wrap(value - onward).abs() + wrap(value - from).abs();
            if off > wrap(onward - from).abs() + 2.0 * TOLERANCE {
                return Err(PathError::Contradicting {
                    field: "yaw",
                    index,
                    value,
                    expected: onward,
                });
            }
        }
        Ok(())
    }

    /// The vehicle's heading at the start of `segment` by the chord of [`REACH`] ahead of it, or at its
    /// end by the one behind: that of the chord less the mean of what `yaw` has turned along it. The
    /// heading that is looked at has no part in it.
    fn heading_along(&self, yaw: &[f64], segment: usize, ahead: bool) -> f64 {
        let yaw_beyond = |segment: usize| {
            let end = if ahead { self.next(segment) } else { None };
            yaw.get(end.unwrap_or(segment)).copied().unwrap_or(0.0)
        };
        let (mut start, mut end) = self.segment(segment);
        let mut last = segment;
        let (mut length, mut turned) = (self.segment_length(segment), 0.0);
        for _ in 0..MOST_WAYPOINTS {
            if get_distance(start, end) >= REACH {
                break;
            }
            let Some(beyond) = self.neighbour(last, ahead) else {
                break;
            };
            let turn = wrap(yaw_beyond(beyond) - yaw_beyond(segment));
            if turn.abs() > MOST_TURN {
                break;
            }
            length += self.segment_length(beyond);
            turned += turn * self.segment_length(beyond);
            let (from, to) = self.segment(beyond);
            (start, end) = if ahead { (start, to) } else { (from, end) };
            last = beyond;
        }
        let chord = self.vehicle_yaw(segment, atan2(end.y - start.y, end.x - start.x));
        wrap(chord - turned / length)
    }

    fn check_curvature(&self) -> Result<(), PathError> {
        let (mut apart, mut turned) = (0.0, 0.0);
        for index in 0..self.segments() {
            let bend = self.bend(index).map(|bend| (bend.turn, bend.ends));
            let Some((turn, Some((here, next)))) = bend else {
                break;
            };
            let length = self.segment_length(index);
            apart += 0.5 * (here + next) * length - turn;
            turned += turn.abs();
            if f64::abs(apart) > TOLERANCE + SHARE * turned {
                let given = self.curvature.and_then(|all| all.get(index).copied());
                return Err(PathError::Contradicting {
                    field: "curvature",
                    index,
                    value: given.unwrap_or(here),
                    expected: turn / length,
                });
            }
        }
        Ok(())
    }

    /// The heading of a vehicle that drives in the `direction` of segment `index`, or the other way
    /// round [rad].
    fn vehicle_yaw(&self, index: usize, direction: f64) -> f64 {
        if self.is_reverse(index) {
            wrap(direction + PI)
        } else {
            direction
        }
    }

    /// How segment `index` bends; None without headings.
    fn bend(&self, index: usize) -> Option<Bend> {
        let next = self.next(index).unwrap_or(index);
        let both = |column: &[f64]| Some((*column.get(index)?, *column.get(next)?));
        let (start, end) = both(self.yaw?)?;
        let sign = if self.is_reverse(index) { -1.0 } else { 1.0 };
        let ends = self.curvature.and_then(both);
        let ends = ends.map(|(here, next)| (sign * here, sign * next));
        Some(Bend {
            start: self.vehicle_yaw(index, start),
            turn: wrap(end - start),
            ends,
        })
    }

    /// Curvature at an end of segment `index` [1/m], by how far the headings turn over it and over what
    /// lies beyond, which is at least half as long: over centimetres they turn by their noise.
    fn mean_bend(&self, index: usize, ahead: bool) -> f64 {
        let turn = |segment| self.bend(segment).map_or(0.0, |bend| bend.turn);
        let far = self.segment_length(index);
        let (mut last, mut near, mut turned) = (index, 0.0, 0.0);
        for _ in 0..MOST_WAYPOINTS {
            let Some(next) = self.neighbour(last, ahead).filter(|_| near < 0.5 * far) else {
                break;
            };
            near += self.segment_length(next);
            turned += turn(next);
            last = next;
        }
        if last == index {
            return turn(index) / far;
        }
        (turned * far / near + turn(index) * near / far) / (near + far)
    }

    /// Direction of the path `along` [m] its segment `index` [rad]; None without headings.
    #[inline]
    pub(crate) fn direction(&self, index: usize, along: f64) -> Option<f64> {
        let Bend { start, turn, ends } = self.bend(index)?;
        let length = self.segment_length(index);
        let t = saturate(along / length, 0.0, 1.0);
        let (here, next) =
            ends.unwrap_or_else(|| (self.mean_bend(index, false), self.mean_bend(index, true)));
        let rest = 1.0 - t;
        let slopes = t * rest * length * (here * rest - next * t);
        Some(start + t * t * (3.0 - 2.0 * t) * turn + slopes)
    }
}

impl ClosestPoint {
    /// The closest point on the curve that the path's headings make; this one without them.
    #[inline]
    pub(crate) fn on_curve(self, path: &PathView<'_>, position: Point) -> Self {
        let Some(Bend { turn, .. }) = path.bend(self.segment) else {
            return self;
        };
        let (start, end) = path.segment(self.segment);
        let t = saturate(self.fraction, 0.0, 1.0);
        let length = path.segment_length(self.segment);
        let along = end - start;
        let yaw = path.direction(self.segment, t * length).unwrap_or(0.0);
        let towards = Point::new(cos(yaw), sin(yaw));
        let point = if (self.fraction - t).abs() > 0.0 {
            // Beyond an end the path goes on in its own direction there.
            let end = start + along * t;
            end + towards * towards.dot(&(position - end))
        } else {
            // Of the segment's length, to its left.
            let offset = -0.5 * turn * t * (1.0 - t);
            self.point + Point::new(-along.y, along.x) * offset
        };
        Self {
            point,
            squared_distance: squared_distance(position, point),
            side: towards.perp(&(position - point)),
            along: towards * length,
            ..self
        }
    }
}

/// Heading and curvature of the natural cubic spline through the waypoints, whose parameter is the
/// distance between them; it ends at cusps.
#[cfg(feature = "alloc")]
pub(super) fn spline(path: &PathView<'_>) -> (Box<[f64]>, Box<[f64]>) {
    // h_- M_- + 2 (h_- + h) M + h M_+ = 6 ((p_+ - p) / h - (p - p_-) / h_-); M = 0 at the ends. Each
    // sweep of Gauss and Seidel leaves at most a quarter of the error.
    const SWEEPS: usize = 30;
    let count = path.len();
    let through = |index: usize| {
        let before = path.previous(index)?;
        let after = path.next(index)?;
        (path.following(before) == Some(index)).then_some((before, after))
    };
    let slope = |index: usize| {
        let (start, end) = path.segment(index);
        let length = path.segment_length(index);
        (length, (end - start) / length)
    };
    let mut second = vec![Point::new(0.0, 0.0); count];
    let at = |all: &[Point], index: usize| all.get(index).copied().unwrap_or(Point::new(0.0, 0.0));
    for _ in 0..SWEEPS {
        for index in 0..count {
            if let Some((before, after)) = through(index) {
                let ((last, inward), (next, outward)) = (slope(before), slope(index));
                let known = (outward - inward) * 6.0
                    - at(&second, before) * last
                    - at(&second, after) * next;
                if let Some(room) = second.get_mut(index) {
                    *room = known / (2.0 * (last + next));
                }
            }
        }
    }
    let ends = (0..count)
        .map(|index| {
            let segment = path.segment_at(index);
            let (length, chord) = slope(segment);
            let end = path.next(segment).unwrap_or(segment);
            let (here, there) = (at(&second, segment), at(&second, end));
            let tangent = if segment == index {
                chord - (here * 2.0 + there) * (length / 6.0)
            } else {
                chord + (here + there * 2.0) * (length / 6.0)
            };
            let bend = at(&second, index);
            let size = get_distance(tangent, Point::new(0.0, 0.0)) + 1e-9;
            let curvature = tangent.perp(&bend) / (size * size * size);
            let sign = if path.is_reverse(segment) { -1.0 } else { 1.0 };
            let yaw = path.vehicle_yaw(segment, atan2(tangent.y, tangent.x));
            let curvature = saturate(sign * curvature, -MAX_CURVATURE, MAX_CURVATURE);
            (yaw, curvature)
        })
        .unzip::<f64, f64, Vec<f64>, Vec<f64>>();
    (ends.0.into(), ends.1.into())
}
