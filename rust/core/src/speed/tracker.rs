//! Keeps the speed that a path allows, and stops where it has to.

use crate::bounds::MAX_SPEED;
use crate::error::{ConfigError, InputError, input_within};
use crate::math::{saturate, smaller, sqrt};
use crate::params;
use crate::path::{Follow, PathView};
use crate::vehicle::state::checked_dt;
use crate::vehicle::{Vehicle, VehicleState};

/// What stands for a top speed that the vehicle does not say [m/s].
#[cfg(feature = "alloc")]
const TOP_SPEED: f64 = 25.0;
/// The same of the lateral acceleration [m/s^2].
#[cfg(feature = "alloc")]
const LATERAL: f64 = 4.0;
/// Share of the lateral acceleration that bends may take; the rest corrects the steering. More: a
/// vehicle that is off in a bend is steered no tighter, and comes back behind it.
#[cfg(feature = "alloc")]
const BENDS: f64 = 0.9;
/// What stands for a driving acceleration that the vehicle does not say [m/s^2].
const DRIVING: f64 = 2.0;
/// The same of the braking deceleration [m/s^2].
const BRAKING: f64 = 3.0;
/// Length over which the curvature is smoothed, in wheelbases.
#[cfg(feature = "alloc")]
const SMOOTHING: f64 = 2.0 / 3.0;
/// Speed of the last stretch before a stop, in wheelbases a second. More: the vehicle arrives
/// faster, and stops less exactly.
const CREEP: f64 = 0.1;
/// The vehicle has come to a stop when it is this near, in wheelbases.
const ARRIVED: f64 = 1.0 / 120.0;
/// It goes on the other way when it is this near to a cusp, in wheelbases.
const TURNING: f64 = 1.0 / 100.0;
/// The last stretch before a stop, in wheelbases.
const LAST: f64 = 1.0 / 15.0;
/// How far before a stop braking aims, in wheelbases: what brakes late does not pass it.
const MARGIN: f64 = 1.0 / 60.0;
/// From this share of the deceleration on, braking for a stop is by what remains of the way: it
/// stops there whatever the brakes do. Less: it would begin before the plan brakes.
const STEEP: f64 = 0.8;
/// Share of the deceleration that holds a vehicle where it stands.
const HOLD: f64 = 0.5;
/// Farther off the speed than this the integral rests, so that it does not wind up, in wheelbases a
/// second.
const NEAR: f64 = 1.0 / 6.0;
/// Bound of the integral's share [m/s^2].
const MOST_INTEGRAL: f64 = 1.0;

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
pub struct SpeedTrackerState {
    /// Where the segment beside the rear axle starts; none before the first step.
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
/// Before a stop it brakes by what remains of the way. [`SpeedTracker::plan`] makes the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedTracker {
    vehicle: Vehicle,
    params: SpeedTrackerParams,
    driving: f64,
    braking: f64,
    follow: Follow,
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
            driving: car.max_acceleration.unwrap_or(DRIVING),
            braking: car.max_deceleration.unwrap_or(BRAKING),
            follow: Follow {
                lost_distance: 10.0 * car.wheelbase,
                arrival_distance: TURNING * car.wheelbase,
                ..Follow::of(&car, car.rear_axle, 0.0)
            },
        })
    }

    /// The greatest speed at each waypoint of `path` within the vehicle's limits and at most the
    /// path's own [m/s], never negative. What the vehicle does not limit is limited to 25 m/s, 4 m/s^2
    /// to the side, 2 m/s^2 driving and 3 m/s^2 braking. Bends take 0.9 of the lateral acceleration:
    /// the rest is for the steering to correct errors.
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
        let mut cusps = vec![false; path.len()];
        for segment in 0..segments {
            if let Some(next) = path.next_segment(segment)
                && path.is_reverse(next) != path.is_reverse(segment)
                && let Some(cusp) = cusps.get_mut(next)
            {
                *cusp = true;
            }
        }
        let bounds = path.speed();
        let bounds: Option<Vec<f64>> = bounds.map(|all| all.iter().map(|v| v.abs()).collect());
        let car = self.vehicle;
        let curvature = path_curvature(path, SMOOTHING * car.wheelbase);
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
            max_speed: car.max_speed.unwrap_or(TOP_SPEED),
            max_lateral_acceleration: BENDS * car.max_lateral_acceleration.unwrap_or(LATERAL),
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
        let (params, car) = (&self.params, &self.vehicle);
        let at = self.follow.locate(path, state.waypoint, vehicle, dt);
        let segment = at.closest.segment;
        let arc = at.closest.arc_length(path);
        let end = path.section_end(segment);
        let stop = end.map_or(f64::INFINITY, |end| end_of(path, end, segment));
        let left = stop - arc;
        let forward = at.vehicle.speed;
        // When the command takes effect, in the middle of the time that it is held.
        let later = params.drive_delay + car.drive_lag + 0.5 * dt;
        let moving = if forward > 0.0 { forward } else { 0.0 };
        let (here, rise) = lookup(path, plan, arc, segment, end);
        let (_, mut wanted) = lookup(path, plan, arc + moving * later, segment, end);
        let mut reference = sqrt(here);
        let creep = CREEP * car.wheelbase;
        let room = if left > 0.0 { left } else { 0.0 };
        let nearing = sqrt(self.braking * room);
        // Where the path says 0 from here on the vehicle stands; it creeps away from a start, past a
        // single 0, and up to a stop.
        let stands = here <= 0.0 && rise <= 0.0;
        let slowest = if stands { 0.0 } else { smaller(creep, nearing) };
        if reference < slowest {
            reference = slowest;
        }
        // The last stretch is crept along, whatever the plan still allows there.
        let target = if room < LAST * car.wheelbase {
            slowest
        } else {
            reference
        };
        let error = target - forward;
        if forward < slowest && wanted < 0.0 {
            wanted = 0.0;
        }
        let (last, mut integral) = if at.direction_changed {
            (0.0, 0.0)
        } else {
            (state.acceleration, state.integral)
        };
        let arrived = left <= ARRIVED * car.wheelbase && end.is_some();
        let standing = (arrived || stands) && forward < creep;
        let mut command;
        if standing {
            command = -HOLD * self.braking;
            integral = 0.0;
        } else {
            if error.abs() <= NEAR * car.wheelbase {
                integral += params.ki * error * dt;
                integral = saturate(integral, -MOST_INTEGRAL, MOST_INTEGRAL);
            }
            command = wanted + params.kp * error + integral;
            let mut arriving = forward + last * later;
            if arriving < 0.0 {
                arriving = 0.0;
            }
            let rest = left - MARGIN * car.wheelbase - 0.5 * (forward + arriving) * later;
            let needed = if rest > 1e-3 {
                arriving * arriving / (2.0 * rest)
            } else {
                f64::INFINITY
            };
            if needed >= STEEP * self.braking && forward > slowest && left < f64::INFINITY {
                command = -needed;
            }
        }
        command = saturate(
            command,
            -self.braking - params.reserve,
            self.driving + params.reserve,
        );
        let change = params.max_jerk * dt;
        command = saturate(command, last - change, last + change);
        *state = SpeedTrackerState {
            waypoint: Some(segment),
            acceleration: command,
            integral,
        };
        Ok(SpeedCommand {
            acceleration: command,
            reference_speed: reference,
            distance_to_stop: left,
            reverse: at.reverse,
            standing,
        })
    }

    /// The path `new` replaces `old`; its own plan replaces the old one.
    ///
    /// The command and the integral continue. So does the place, if the segment beside the vehicle
    /// is the same; else the next step finds it on the whole of the new path.
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
        input_within("integral", state.integral, MOST_INTEGRAL)?;
        Ok(())
    }
}

/// The square of the planned speed at `arc` [m], and the acceleration there.
///
/// `arc` is counted on across the seam of a closed path; `segment` is where the vehicle is, and
/// `end` the last segment of its section.
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

/// The arc length at the end of a section [m], counted on across the seam.
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
