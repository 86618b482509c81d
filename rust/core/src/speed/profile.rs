//! The greatest speeds along a path that a vehicle's limits allow.
//!
//! # Problem
//!
//! The unknowns are the squares of the speeds at the waypoints, `w_i = v_i²`. Between waypoints w is
//! linear in the arc, so that the acceleration `(w_{i+1} - w_i) / (2 l_i)` is constant on a segment
//! of length `l_i`. Wanted are large `w_i` with
//!
//! ```text
//! w_i           <= bound_i                                       before any driving or braking
//! w_{i+1} - w_i <= 2 l_i min(A(w_i, k_i), A(w_{i+1}, k_{i+1}))   driving
//! w_i - w_{i+1} <= 2 l_i min(D(w_i, k_i), D(w_{i+1}, k_{i+1}))   braking
//! ```
//!
//! where `k_i` is the curvature. A and D are the accelerations that the friction ellipse leaves
//! for the direction of travel, next to the lateral one, `w |k|` ([`SpeedLimits`]); they hold at both ends of a segment. The bound
//! of a waypoint is the least of the following; the wheels' time is a segment's and bounds both its
//! ends
//!
//! ```text
//! max_speed², speed_limit²
//! max_lateral_acceleration / |k|                   as the lateral acceleration is w k
//! (tan(max_steer) / |k| - L) / understeer          as tan(wheel) = k (L + understeer w)
//! the square of the speed at which the wheels turn in time     `SpeedLimits::in_time`
//! 0 at a cusp, start_speed² and end_speed² at the ends of an open path
//! ```
//!
//! with L the vehicle's turning length at rest. That of the wheels' angle bounds nothing without
//! understeer, nor where the wheels do not reach `k` even at rest: no speed lets the vehicle turn there
//! as the path does. No one plan need be the greatest at every waypoint: at the lateral
//! limit A is 0, and a slightly lower `w_i` may allow a higher `w_{i+1}`. Along a path with a grade,
//! gravity uphill is taken off A, and D is at most what the brakes can do less gravity downhill.
//!
//! # Method
//!
//! A pass forward lowers each w to what driving reaches from the waypoint before it, and a pass
//! backward to what braking can come down from before the next one: the forward-backward solver of
//! A. Heilmeier et al., *Minimum curvature trajectory planning and control for an autonomous race
//! car*, Vehicle System Dynamics 58, 2020. They are repeated until nothing is lowered any more, at
//! most `ROUNDS` times. One round is enough where the limits of the acceleration do not depend on the
//! speed: after a speed that the pass backward lowers, the vehicle brakes, so nothing is asked of
//! driving; before it the speed rises less, and at a lower speed the ellipse leaves more. With a limit
//! that grows with the speed the last does not hold, and so the passes repeat.
//!
//! A closed path is cut open at its slowest waypoint, whose bound no pass lowers, as none goes below the
//! speed that it starts from.

use alloc::vec::Vec;

use crate::error::ConfigError;
use crate::math::{larger, sqrt, tan};
use crate::speed::defaults::gravity_along;
use crate::speed::limits::{Over, PlanPoint, SpeedLimits};
use crate::vehicle::Vehicle;

/// A square of a speed that a pass lowers to more than this share keeps the name of its old limit:
/// where a bend begins and ends, rounding alone lowers the speed.
const SLIGHTLY: f64 = 0.999;
/// The most rounds of a pass forward and one backward. A plan that would need more keeps its bounds
/// and brakes in time, but may exceed a driving acceleration that grows with the speed.
const ROUNDS: usize = 50;

/// A jump of the curvature is looked for so far on each side of a waypoint, in wheelbases: where the
/// wheels turn for it.
const JUMP_REACH: f64 = 0.4;
/// How far a vehicle that parks (`steers_at_rest`) may be shifted by a jump of the curvature, and any
/// by one at a cusp, in wheelbases. Less: it drives past more slowly.
const JUMP_SHIFT: f64 = 0.003;
/// A turn of the wheels that is no jump [rad]: noise of the waypoints, a bend of a road.
const SMALL_JUMP: f64 = 0.1;

/// A jump of the curvature that is drawn is so many times the median of all along the path: on lines and
/// arcs that is 0, in recorded waypoints it is their noise (a robust test, by the median absolute deviation).
/// Less: noise slows the vehicle. More: bays that are drawn with noise are driven as if the wheels turned at once.
const NOISE: f64 = 6.0;

/// What limits the speed at a waypoint.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub enum Limit {
    /// The top speed.
    #[default]
    TopSpeed,
    /// The speed limit there.
    SpeedLimit,
    /// The lateral acceleration.
    Lateral,
    /// The angle of the wheels, with the understeer.
    SteerAngle,
    /// The rate of the wheels.
    SteerRate,
    /// The start, a cusp or the end, with the speed given there.
    Stop,
    /// The driving acceleration.
    Driving,
    /// The braking deceleration.
    Braking,
}

impl Limit {
    /// The number that stands for it in arrays.
    #[must_use]
    pub fn code(self) -> u8 {
        match self {
            Self::TopSpeed => 0,
            Self::SpeedLimit => 1,
            Self::Lateral => 2,
            Self::SteerAngle => 3,
            Self::SteerRate => 4,
            Self::Stop => 5,
            Self::Driving => 6,
            Self::Braking => 7,
        }
    }
}

/// What is to be driven: N waypoints.
#[derive(Clone, Copy, Debug, Default)]
pub struct Course<'a> {
    /// Curvature at each waypoint [1/m].
    pub curvature: &'a [f64],
    /// The same smoothed less, to find jumps for a vehicle that parks; nowhere a jump if None.
    pub sharp: Option<&'a [f64]>,
    /// Length of each segment [m]: N - 1 of an open path, N of a closed one.
    pub spacing: &'a [f64],
    /// Whether the last waypoint leads back to the first: the speeds are the same in each lap.
    pub closed: bool,
    /// At which waypoints the vehicle changes its direction; nowhere if None.
    pub cusps: Option<&'a [bool]>,
    /// The speed limit at each waypoint [m/s]; no limits if None.
    pub speed_limits: Option<&'a [f64]>,
    /// The slope at each waypoint, positive uphill; level if None.
    pub grade: Option<&'a [f64]>,
    /// Largest speed at the first waypoint of an open path [m/s].
    pub start_speed: Option<f64>,
    /// Largest speed at its last waypoint [m/s].
    pub end_speed: Option<f64>,
}

impl Course<'_> {
    fn curvature_at(&self, index: usize) -> f64 {
        self.curvature.get(index).copied().unwrap_or(0.0)
    }

    /// How much gravity hinders along the segment that starts at waypoint `index` [m/s²]: driving
    /// uphill with `sign` 1, braking downhill with -1. The stronger of its ends; 0 if it helps.
    fn hinders(&self, index: usize, sign: f64) -> f64 {
        let Some(grade) = self.grade else {
            return 0.0;
        };
        let at = |index: usize| -sign * gravity_along(grade.get(index).copied().unwrap_or(0.0));
        larger(0.0, larger(at(index), at(self.next(index))))
    }

    fn is_cusp(&self, index: usize) -> bool {
        self.cusps
            .is_some_and(|cusps| cusps.get(index) == Some(&true))
    }

    /// The curvature `sharp` at most `reach` [m] `ahead` of waypoint `index`, or behind it, in its
    /// section.
    fn beyond(&self, sharp: &[f64], index: usize, reach: f64, ahead: bool) -> f64 {
        let (mut place, mut distance) = (index, 0.0);
        for _ in 0..self.spacing.len() {
            let before = place.checked_sub(1).unwrap_or(self.curvature.len() - 1);
            let next = if ahead { self.next(place) } else { before };
            let (segment, end) = if ahead { (place, next) } else { (next, place) };
            distance += self.spacing.get(segment).copied().unwrap_or(f64::INFINITY);
            // The curvature at a cusp is that of the section after it.
            if distance > reach || self.is_cusp(end) {
                break;
            }
            place = next;
        }
        sharp.get(place).copied().unwrap_or(0.0)
    }

    fn next(&self, index: usize) -> usize {
        if index + 1 < self.curvature.len() {
            index + 1
        } else {
            0
        }
    }
}

/// The greatest speed at each waypoint of `course` within `limits` [m/s], into `speed`, and what
/// limits it there, into `limit`: both are N long.
///
/// # Errors
///
/// [`ConfigError`], naming the limit that is out of its range.
pub fn plan_speeds(
    course: &Course<'_>,
    limits: &SpeedLimits<'_>,
    speed: &mut [f64],
    limit: &mut [Limit],
) -> Result<(), ConfigError> {
    limits.checked()?;
    // Squares, until the last lines.
    bound(course, limits, speed, limit);
    let count = speed.len();
    let segments = course.spacing.len();
    let mut start = 0;
    if course.closed {
        let slowest = (speed.iter().enumerate()).min_by(|one, other| one.1.total_cmp(other.1));
        start = slowest.map_or(0, |(index, _)| index);
    }
    let varies = limits.acceleration.values.len() > 1 || limits.deceleration.values.len() > 1;
    let assumed = larger(
        limits.vehicle.strongest_braking(),
        limits.deceleration.most(),
    );
    let strongest = limits.vehicle.brake_deceleration.unwrap_or(assumed);
    let rounds = if varies { ROUNDS } else { 1 };
    for _ in 0..rounds {
        let mut lowered = false;
        for step in 0..segments {
            let index = (start + step) % count;
            // Uphill a part of what the drive gives is used up.
            let over = Over {
                table: &limits.acceleration,
                lost: course.hinders(index, 1.0),
                most: f64::INFINITY,
            };
            let ends = (index, course.next(index), index, Limit::Driving);
            lowered |= lower(course, limits, &over, ends, speed, limit);
        }
        for step in (0..segments).rev() {
            let index = (start + step) % count;
            // Downhill the brakes have to hold the vehicle, too. A comfortable deceleration is less
            // than they can do, so only from that gravity is taken off.
            let over = Over {
                table: &limits.deceleration,
                lost: 0.0,
                most: strongest - course.hinders(index, -1.0),
            };
            let ends = (course.next(index), index, index, Limit::Braking);
            lowered |= lower(course, limits, &over, ends, speed, limit);
        }
        if !lowered {
            break;
        }
    }
    for value in speed.iter_mut() {
        *value = sqrt(*value);
    }
    Ok(())
}

/// Lowers `w` at the waypoint `to` to what the limit `over` reaches `from` the other end of
/// `segment`, and notes the limit `by` that lowered it. Returns whether it was lowered.
fn lower(
    course: &Course<'_>,
    limits: &SpeedLimits<'_>,
    over: &Over<'_>,
    (from, to, segment, by): (usize, usize, usize, Limit),
    squared: &mut [f64],
    limit: &mut [Limit],
) -> bool {
    let plan_point = |index: usize| PlanPoint {
        squared: squared.get(index).copied().unwrap_or(0.0),
        curvature: course.curvature_at(index),
    };
    let (start, end) = (plan_point(from), plan_point(to));
    if end.squared <= start.squared {
        return false;
    }
    let length = course.spacing.get(segment).copied().unwrap_or(1.0);
    let reached = limits.reach(over, start, end, length);
    if reached >= end.squared {
        return false;
    }
    if let (Some(value), Some(limit)) = (squared.get_mut(to), limit.get_mut(to)) {
        *value = reached;
        if reached < SLIGHTLY * end.squared {
            *limit = by;
        }
    }
    true
}

/// The bound of each waypoint, into `squared`, and what it comes from, into `limit`.
fn bound(course: &Course<'_>, limits: &SpeedLimits<'_>, squared: &mut [f64], limit: &mut [Limit]) {
    let car = &limits.vehicle;
    let base = car.turning_length(0.0);
    let last = squared.len().saturating_sub(1);
    let locked = tan(car.max_steer);
    for (index, (value, by)) in squared.iter_mut().zip(limit.iter_mut()).enumerate() {
        (*value, *by) = (limits.max_speed * limits.max_speed, Limit::TopSpeed);
        let mut at_most = |bound: f64, cause: Limit| {
            if bound < *value {
                (*value, *by) = (bound, cause);
            }
        };
        if let Some(&most) = course.speed_limits.and_then(|all| all.get(index)) {
            at_most(most * most, Limit::SpeedLimit);
        }
        let bend = course.curvature_at(index).abs();
        if bend > 0.0 {
            at_most(limits.max_lateral_acceleration / bend, Limit::Lateral);
            let room = locked / bend - base;
            if car.understeer > 0.0 && room > 0.0 {
                at_most(room / car.understeer, Limit::SteerAngle);
            }
        }
        if course.is_cusp(index) {
            at_most(0.0, Limit::Stop);
        }
        if !course.closed {
            if let (0, Some(most)) = (index, course.start_speed) {
                at_most(most * most, Limit::Stop);
            }
            if let (true, Some(most)) = (index == last, course.end_speed) {
                at_most(most * most, Limit::Stop);
            }
        }
    }
    if car.max_steer_rate.is_some() {
        bound_by_rate(course, limits, squared, limit);
    }
}

/// Lowers the bounds to those of wheels that turn at their rate.
fn bound_by_rate(
    course: &Course<'_>,
    limits: &SpeedLimits<'_>,
    squared: &mut [f64],
    limit: &mut [Limit],
) {
    let car = &limits.vehicle;
    for (segment, &length) in course.spacing.iter().enumerate() {
        let next = course.next(segment);
        if course.is_cusp(next) {
            continue; // the curvature there is that of the next section
        }
        let (from, to) = (course.curvature_at(segment), course.curvature_at(next));
        let speed = limits.in_time(from, to, length, limits.max_speed);
        for index in [segment, next] {
            turn_in_time(speed, index, squared, limit);
        }
    }
    if let Some(sharp) = course.sharp.filter(|_| car.steers_at_rest) {
        let jumps: Vec<f64> = (0..squared.len())
            .map(|index| jump(course, sharp, index, car))
            .collect();
        let noise = NOISE * median(&jumps);
        for (index, &jump) in jumps.iter().enumerate().filter(|&(_, &jump)| jump > noise) {
            turn_in_time(jump_speed(jump, car), index, squared, limit);
        }
    }
    if !car.steers_at_rest {
        for cusp in (0..squared.len()).filter(|&index| course.is_cusp(index)) {
            leave_cusp(course, car, cusp, squared, limit);
        }
    }
}

/// Bounds the speeds behind a `cusp` of a vehicle whose wheels turn only while it drives: they are still
/// where the section before it needed them.
///
/// Wheels that turn at their rate from there on, for `t = L Δk / max_steer_rate`, shift a vehicle that
/// starts with the constant acceleration a by `7/30 Δk l²` to the side, with `l = a t² / 2`. That is
/// to be `shift`:
///
/// ```text
/// v² <= 2 a s,  a = 2 l / t²,  l = sqrt(30/7 shift / Δk)       up to the first waypoint s >= l behind it
/// ```
fn leave_cusp(
    course: &Course<'_>,
    car: &Vehicle,
    cusp: usize,
    squared: &mut [f64],
    limit: &mut [Limit],
) {
    let before = cusp.checked_sub(1).unwrap_or(squared.len() - 1);
    // The wheels are to the same side where it turns the other way, as it drives the other way.
    let jump = (course.curvature_at(cusp) + course.curvature_at(before)).abs();
    let turn = jump * car.turning_length(0.0);
    let Some(rate) = car.max_steer_rate.filter(|_| turn >= SMALL_JUMP) else {
        return;
    };
    let length = sqrt(30.0 / 7.0 * JUMP_SHIFT * car.wheelbase / jump);
    let time = turn / rate;
    let (mut place, mut gone) = (cusp, 0.0);
    while let Some(spacing) = course.spacing.get(place).filter(|_| gone < length) {
        gone += spacing;
        place = course.next(place);
        turn_in_time(sqrt(4.0 * length * gone) / time, place, squared, limit);
    }
}

fn turn_in_time(speed: f64, index: usize, squared: &mut [f64], limit: &mut [Limit]) {
    if let (Some(value), Some(by)) = (squared.get_mut(index), limit.get_mut(index))
        && speed * speed < *value
    {
        (*value, *by) = (speed * speed, Limit::SteerRate);
    }
}

/// By how much the curvature jumps near waypoint `index` [1/m].
fn jump(course: &Course<'_>, sharp: &[f64], index: usize, car: &Vehicle) -> f64 {
    let reach = JUMP_REACH * car.wheelbase;
    let beyond = |ahead: bool| course.beyond(sharp, index, reach, ahead);
    (beyond(true) - beyond(false)).abs()
}

/// The middle one of some numbers, 0 of none.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

/// The speed at which a vehicle that parks drives past a `jump` of the curvature [1/m], infinite if that
/// is none.
///
/// Wheels that turn at their rate, half before the jump `Δk` and half after it, shift the vehicle by
/// `Δk l² / 24` to the side, with `l = v t` and `t = L Δk / max_steer_rate`. That is to be `shift`:
///
/// ```text
/// v = sqrt(24 shift) max_steer_rate / (L Δk^1.5)
/// ```
fn jump_speed(jump: f64, car: &Vehicle) -> f64 {
    let rate = car.max_steer_rate.unwrap_or(f64::INFINITY);
    let length = car.turning_length(0.0);
    if jump * length < SMALL_JUMP {
        return f64::INFINITY;
    }
    sqrt(24.0 * JUMP_SHIFT * car.wheelbase / jump) * rate / (length * jump)
}

#[cfg(test)]
#[expect(clippy::indexing_slicing, reason = "a test fails by panicking")]
mod tests;
