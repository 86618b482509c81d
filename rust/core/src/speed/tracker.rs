//! Keeps the speed that a path allows, and stops where it has to: a plan fed forward, a PI
//! controller of the speed, and a stop of its own.
//!
//! # Equations
//!
//! The rear axle is at the arc length `s` and moves at the speed `v` along the path. The plan is a
//! speed for each waypoint; between them its square `w(s)` is linear, so that its acceleration
//! `a(s) = w'(s) / 2` is constant on a segment. A command takes effect after the drive's delay and
//! lag, and is held for a period; on average that is at the time `T` from now:
//!
//! ```text
//! T       = drive_delay + drive_lag + dt / 2
//! e       = target - v                      target = sqrt(w(s)), but the creeping speed before a stop
//! I       = I + ki e dt                     only while |e| is small (anti-windup); |I| is bounded
//! command = a(s + v T) + kp e + I           feedforward, proportional and integral part
//! ```
//!
//! Where the path ends or changes its direction the vehicle stops, and errors of the speed may not
//! shift the place. With the distance `d` to the stop, the command is a constant deceleration to it:
//!
//! ```text
//! v_T     = max(v + last command * T, 0)    speed when the command takes effect
//! d_T     = d - margin - T (v + v_T) / 2    distance that remains then
//! command = -v_T² / (2 d_T)                 once that is near the largest deceleration
//! ```
//!
//! In the end the command is kept within the vehicle's accelerations, extended by `reserve`, and
//! within `max_jerk * dt` of the last one.
//!
//! The feedforward with a PI controller is the usual one; the rules of a stop, with the constants
//! below, were found by driving and follow no publication.

use crate::bounds::MAX_SPEED;
use crate::error::{ConfigError, InputError, input_within};
use crate::math::{saturate, smaller, sqrt};
use crate::params;
use crate::path::follow::Located;
use crate::path::{Follow, PathView};
use crate::speed::defaults;
use crate::vehicle::state::checked_dt;
use crate::vehicle::{Vehicle, VehicleState};

/// Largest speed at which the vehicle creeps to a stop, in wheelbases a second. More: it arrives
/// faster, and stops less exactly.
const CREEP: f64 = 0.1;
/// It creeps when it is this near to the stop, in wheelbases, whatever the plan still allows there.
const CREEP_DISTANCE: f64 = 1.0 / 15.0;
/// It has arrived when it is this near to the stop, in wheelbases, and is then held.
const ARRIVED: f64 = 1.0 / 120.0;
/// It goes on in the other direction when it is this near to a cusp, in wheelbases: farther than
/// [`ARRIVED`], so that it always does.
const AT_CUSP: f64 = 1.0 / 100.0;
/// How far before a stop the braking ends, in wheelbases: brakes that respond late do not pass it.
const MARGIN: f64 = 1.0 / 60.0;
/// The stop takes over once it needs this share of the largest deceleration; the vehicle then stops
/// in its place even if the brakes are weaker than they were taken for. Less: it takes over before
/// the plan brakes.
const STOP_SHARE: f64 = 0.8;
/// Share of the largest deceleration that holds a vehicle where it stands.
const HOLD: f64 = 0.5;
/// Anti-windup: the integrator is frozen above this error of the speed, in wheelbases a second.
const INTEGRATION_BAND: f64 = 1.0 / 6.0;
/// Bound of the integral's share of the command [m/s²].
const MAX_INTEGRAL: f64 = 1.0;

params! {
    /// Parameters of [`SpeedTracker`].
    pub struct SpeedTrackerParams {
        /// Acceleration for an error of the speed [1/s].
        kp: f64 = 1.5, in [0.0, 1e3];
        /// Acceleration for its integral [1/s^2].
        ki: f64 = 0.2, in [0.0, 1e3];
        /// Largest change of the acceleration [m/s^3].
        max_jerk: f64 = 20.0, in [1e-3, 1e6];
        /// Acceleration beyond that of the plan that may correct an error [m/s^2].
        reserve: f64 = 0.4, in [0.0, 1e3];
        /// Time from a command to its first effect on the drive [s].
        drive_delay: f64 = 0.0, in [0.0, 10.0];
    }
}

/// What [`SpeedTracker`] remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SpeedTrackerState {
    /// Where the segment beside the rear axle starts; None before the first step.
    pub waypoint: Option<usize>,
    /// The last command [m/s^2].
    pub acceleration: f64,
    /// The integral's share of the command [m/s^2].
    pub integral: f64,
}

/// What a step of [`SpeedTracker`] answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedCommand {
    /// Acceleration in the direction of driving [m/s^2]; negative brakes.
    pub acceleration: f64,
    /// Speed that the path allows beside the rear axle [m/s], never negative.
    pub reference_speed: f64,
    /// Distance along the path to the next cusp or the end [m]; infinite where there is none.
    pub distance_to_stop: f64,
    /// Whether the vehicle is to drive backwards.
    pub reverse: bool,
    /// Whether the vehicle is to be held where it stands.
    pub standing: bool,
}

/// Keeps the speed that a path allows, and stops at its cusps and its end.
///
/// A step takes the acceleration of a plan where the vehicle will be when the command takes effect,
/// and corrects the error of the speed:
///
/// ```text
/// command = a(s + v (drive_delay + drive_lag + dt / 2)) + kp e + integral of ki e,   e = v(s) - v
/// ```
///
/// Before a stop it brakes by the remaining distance. [`SpeedTracker::plan`] makes the plan; the
/// equations of the step are those of the [module](self).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedTracker {
    vehicle: Vehicle,
    params: SpeedTrackerParams,
    /// Largest driving acceleration [m/s²].
    driving: f64,
    /// Largest braking deceleration [m/s²].
    braking: f64,
    follow: Follow,
}

/// The vehicle on its plan, in a step.
struct Situation {
    /// `v`: speed along the path [m/s], negative if the vehicle rolls the other way.
    speed: f64,
    /// `d`: distance to the next stop [m]; infinite if there is none.
    to_stop: f64,
    /// `T`: time until the command takes effect [s].
    delay: f64,
    /// `sqrt(w(s))`: the planned speed here [m/s], at least `slowest`.
    reference: f64,
    /// The speed to keep here [m/s].
    target: f64,
    /// The least speed to keep here [m/s]: to creep away from a start, past a waypoint whose speed
    /// is 0, and up to a stop. 0 if the plan stays at 0 along this segment.
    slowest: f64,
    /// `a(s + v T)`: the planned acceleration where the command takes effect [m/s²].
    feedforward: f64,
    /// Whether the vehicle is to be held where it stands.
    standing: bool,
}

impl SpeedTracker {
    /// The controller of a vehicle.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the field or the parameter that is out of its range.
    pub fn new(vehicle: Vehicle, params: SpeedTrackerParams) -> Result<Self, ConfigError> {
        let car = vehicle.checked()?;
        Ok(Self {
            vehicle,
            params: params.checked()?,
            driving: car.max_acceleration.unwrap_or(defaults::MAX_ACCELERATION),
            braking: car.max_deceleration.unwrap_or(defaults::MAX_DECELERATION),
            follow: Follow {
                lost_distance: 10.0 * car.wheelbase,
                arrival_distance: AT_CUSP * car.wheelbase,
                ..Follow::of(&car, car.rear_axle, 0.0)
            },
        })
    }

    /// The greatest speed at each waypoint of `path` within the vehicle's limits and at most the
    /// path's own [m/s], never negative. For a limit that the vehicle does not have, that of
    /// [`defaults`] is taken. Plans use 0.9 of the lateral acceleration in bends: the rest is for the
    /// steering to correct errors.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], where a limit of the vehicle is out of the range of a plan.
    #[cfg(feature = "alloc")]
    pub fn plan(&self, path: &PathView<'_>) -> Result<alloc::vec::Vec<f64>, ConfigError> {
        use crate::speed::{Course, Limit, OverSpeed, SpeedLimits, path_curvature, plan_speeds};
        use alloc::vec;
        use alloc::vec::Vec;

        let segments = path.segments();
        let cusps = path.cusps();
        let bounds = path.speed();
        let bounds: Option<Vec<f64>> = bounds.map(|all| all.iter().map(|v| v.abs()).collect());
        let car = self.vehicle;
        let lateral = car
            .max_lateral_acceleration
            .unwrap_or(defaults::MAX_LATERAL_ACCELERATION);
        let curvature = path_curvature(path, defaults::SMOOTHING * car.wheelbase);
        let spacing: Vec<f64> = (0..segments).map(|k| path.segment_length(k)).collect();
        let course = Course {
            curvature: &curvature,
            spacing: &spacing,
            closed: path.is_closed(),
            cusps: Some(&cusps),
            speed_limits: bounds.as_deref(),
            start_speed: None,
            end_speed: Some(0.0),
        };
        let limits = SpeedLimits {
            max_speed: car.max_speed.unwrap_or(defaults::MAX_SPEED),
            max_lateral_acceleration: defaults::BEND_SHARE * lateral,
            acceleration: OverSpeed {
                speeds: &[0.0],
                values: &[self.driving],
            },
            deceleration: OverSpeed {
                speeds: &[0.0],
                values: &[self.braking],
            },
            longitudinal_grip: None,
            exponent: 2.0,
            vehicle: car,
        };
        let mut speed = vec![0.0; path.len()];
        let mut limit = vec![Limit::default(); path.len()];
        plan_speeds(&course, &limits, &mut speed, &mut limit)?;
        Ok(speed)
    }

    /// The command for a vehicle on `path`, whose planned speeds are `plan` [m/s], one a waypoint.
    ///
    /// # Errors
    ///
    /// [`InputError`] for a number that is not finite or beyond its bound; `state` is then
    /// unchanged.
    pub fn step(
        &self,
        path: &PathView<'_>,
        plan: &[f64],
        state: &mut SpeedTrackerState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<SpeedCommand, InputError> {
        let vehicle = vehicle.checked()?;
        let dt = checked_dt(dt)?;
        let at = self.follow.locate(path, state.waypoint, vehicle, dt);
        let now = self.situation(path, plan, &at, dt);
        // Command and integral of the other direction do not count.
        let (last, mut integral) = if at.direction_changed {
            (0.0, 0.0)
        } else {
            (state.acceleration, state.integral)
        };
        let command = if now.standing {
            integral = 0.0;
            -HOLD * self.braking
        } else {
            let tracking = self.track(&now, &mut integral, dt);
            self.brake_for_stop(&now, last).unwrap_or(tracking)
        };
        let reserve = self.params.reserve;
        let command = saturate(command, -self.braking - reserve, self.driving + reserve);
        let change = self.params.max_jerk * dt;
        let command = saturate(command, last - change, last + change);
        *state = SpeedTrackerState {
            waypoint: Some(at.closest.segment),
            acceleration: command,
            integral,
        };
        Ok(SpeedCommand {
            acceleration: command,
            reference_speed: now.reference,
            distance_to_stop: now.to_stop,
            reverse: at.reverse,
            standing: now.standing,
        })
    }

    /// Where the vehicle is on its plan, and what the plan wants there.
    fn situation(&self, path: &PathView<'_>, plan: &[f64], at: &Located, dt: f64) -> Situation {
        let car = &self.vehicle;
        let segment = at.closest.segment;
        let arc = at.closest.arc_length(path);
        let end = path.section_end(segment);
        let stop = end.map_or(f64::INFINITY, |end| end_of(path, end, segment));
        let to_stop = stop - arc;
        let speed = at.vehicle.speed;
        let delay = self.params.drive_delay + car.drive_lag + 0.5 * dt;
        let forward = at.vehicle.forward_speed();
        let (squared, slope) = lookup(path, plan, arc, segment, end);
        let (_, planned) = lookup(path, plan, arc + forward * delay, segment, end);

        let room = if to_stop > 0.0 { to_stop } else { 0.0 };
        let creep = CREEP * car.wheelbase;
        let stays_at_zero = squared <= 0.0 && slope <= 0.0;
        let slowest = if stays_at_zero {
            0.0
        } else {
            smaller(creep, sqrt(self.braking * room))
        };
        let planned_speed = sqrt(squared);
        let reference = if planned_speed < slowest {
            slowest
        } else {
            planned_speed
        };
        let target = if room < CREEP_DISTANCE * car.wheelbase {
            slowest
        } else {
            reference
        };
        let arrived = to_stop <= ARRIVED * car.wheelbase && end.is_some();
        Situation {
            speed,
            to_stop,
            delay,
            reference,
            target,
            slowest,
            // A vehicle that is slower than it may creep has no speed to lose.
            feedforward: if speed < slowest && planned < 0.0 {
                0.0
            } else {
                planned
            },
            standing: (arrived || stays_at_zero) && speed < creep,
        }
    }

    /// Feedforward and PI controller: the acceleration that keeps the target speed [m/s²].
    fn track(&self, now: &Situation, integral: &mut f64, dt: f64) -> f64 {
        let params = &self.params;
        let error = now.target - now.speed;
        if error.abs() <= INTEGRATION_BAND * self.vehicle.wheelbase {
            *integral += params.ki * error * dt;
            *integral = saturate(*integral, -MAX_INTEGRAL, MAX_INTEGRAL);
        }
        now.feedforward + params.kp * error + *integral
    }

    /// The acceleration of a constant braking to the stop [m/s²], after the `last` command; None if
    /// it is still gentle, if the vehicle creeps already, or without a stop.
    fn brake_for_stop(&self, now: &Situation, last: f64) -> Option<f64> {
        let &Situation { speed, delay, .. } = now;
        let mut arriving = speed + last * delay;
        if arriving < 0.0 {
            arriving = 0.0;
        }
        let travelled = 0.5 * (speed + arriving) * delay;
        let remaining = now.to_stop - MARGIN * self.vehicle.wheelbase - travelled;
        let needed = if remaining > 1e-3 {
            arriving * arriving / (2.0 * remaining)
        } else {
            f64::INFINITY
        };
        let takes_over = needed >= STOP_SHARE * self.braking
            && speed > now.slowest
            && now.to_stop < f64::INFINITY;
        takes_over.then_some(-needed)
    }

    /// The path `new` replaces `old`; its own plan replaces the old one.
    ///
    /// The command and the integral continue. So does the location, if the segment beside the
    /// vehicle is the same; otherwise the next step searches the whole new path.
    pub fn set_path(&self, state: &mut SpeedTrackerState, old: &PathView<'_>, new: &PathView<'_>) {
        let goes_on = |last: usize| {
            let segment = old.segment_at(last);
            segment < new.segments()
                && new.segment(segment) == old.segment(segment)
                && new.is_reverse(segment) == old.is_reverse(segment)
        };
        state.waypoint = state.waypoint.filter(|&last| goes_on(last));
    }

    /// Whether `state` is one that this controller could have on `path`.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the field that is not.
    pub fn check_state(
        &self,
        path: &PathView<'_>,
        state: &SpeedTrackerState,
    ) -> Result<(), InputError> {
        path.check_waypoint("waypoint", state.waypoint)?;
        input_within("acceleration", state.acceleration, MAX_SPEED)?;
        input_within("integral", state.integral, MAX_INTEGRAL)?;
        Ok(())
    }
}

/// `w` and `a`, the square of the planned speed at `arc` [m] and the acceleration there.
///
/// On a closed path `arc` may exceed the length: it continues across the seam. `segment` is where
/// the vehicle is, and `end` the last segment of its section.
fn lookup(
    path: &PathView<'_>,
    plan: &[f64],
    arc: f64,
    segment: usize,
    end: Option<usize>,
) -> (f64, f64) {
    let (found, share) = match end {
        Some(end) if arc >= end_of(path, end, segment) => (end, 1.0),
        _ if arc <= path.arc(segment) => (segment, 0.0),
        _ => {
            let wrapped = if path.is_closed() && arc >= path.length() {
                arc - path.length()
            } else {
                arc
            };
            let found = path.segment_by_arc(wrapped, segment);
            let share = (wrapped - path.arc(found)) / path.segment_length(found);
            (found, saturate(share, 0.0, 1.0))
        }
    };
    let squared = |index: usize| {
        let speed = plan.get(index).copied().unwrap_or(0.0);
        speed * speed
    };
    let here = squared(found);
    let rise = path.next(found).map_or(here, squared) - here;
    (here + share * rise, 0.5 * rise / path.segment_length(found))
}

/// The arc length at the end of a section [m]; it continues across the seam.
fn end_of(path: &PathView<'_>, end: usize, segment: usize) -> f64 {
    let arc = path.segment_end(end);
    if end < segment {
        arc + path.length()
    } else {
        arc
    }
}

#[cfg(test)]
mod tests;
