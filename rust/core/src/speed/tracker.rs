//! Keeps the speed that a path allows, and stops where it has to: a plan fed forward, a proportional
//! controller of the speed, an estimate of what else pushes the vehicle, and a stop of its own.
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
//! wanted  = a(s + v T) + kp e               what the vehicle is to do
//! command = wanted - g(s + v T) - d         what the drive has to give for that
//! ```
//!
//! with gravity `g` along a path that knows its grade, and the estimate `d` of all other
//! accelerations ([`disturbance`](super::disturbance)). Where the path ends, changes its direction
//! or says 0 the vehicle stops, and errors of the speed must not shift the place. The distance `D` to
//! the stop follows the measured one with a share `α`, so that noise of the pose counts little. What
//! is wanted is a constant deceleration to the stop, with the planned deceleration `b` of the vehicle:
//!
//! ```text
//! D'      = last D - v dt                           by the speed
//! D       = D' + α (measured D - D')                but the measured one after a jump
//! c       = min(creep, sqrt(b D))                   the speed to creep with
//! a       = last command + g + d                    acceleration until the command takes effect
//! R       = T + max(a + b, 0) (1 / max_jerk - 1 / 20) / 2     where `max_jerk` is less than 20 m/s³
//! v_T     = max(v + a R, 0)                         speed when the command takes effect
//! D_T     = D - margin - R (v + v_T) / 2            distance that remains then
//! stop    = -(v_T² - c²) / (2 D_T)                  once that is near `-b`
//! wanted  = min(stop, the wanted of above)
//! ```
//!
//! `wanted` is kept within the vehicle's accelerations, extended by `reserve`. Only where the vehicle
//! would overrun its stop it brakes harder, up to what its brakes can do, and `cannot_stop` says when
//! even that is not enough. The command changes by at most `max_jerk * dt`: braking that grows to `b`
//! acts as if it came whole after half of that time. `R` has what that exceeds the default jerk's by:
//! the constants below were found with that.
//!
//! A vehicle that has arrived stands, until the stop is farther off than noise can explain.
//!
//! The feedforward with a disturbance observer is the usual one; the rules of a stop, with the
//! constants below, were found by driving and follow no publication.

use crate::bounds::{MAX_COORDINATE, MAX_DT, MAX_SPEED};
use crate::error::{ConfigError, InputError, input_in_range, input_within};
use crate::math::{decay, larger, saturate, smaller, sqrt, wrap};
use crate::params;
use crate::path::carry::{Progress, carry_over, goes_on};
use crate::path::follow::Located;
use crate::path::preview::wheel_at_rest;
use crate::path::{Follow, PathView, STEP_BUDGET};
use crate::speed::defaults::{self, gravity_along};
use crate::speed::disturbance::{MAX_DISTURBANCE, SpeedTrackerState};
use crate::speed::servo::Wanted;
use crate::speed::stops::Planned;
use crate::status::Status;
use crate::vehicle::gate::rolled;
use crate::vehicle::past::checked_age;
use crate::vehicle::state::checked_dt;
use crate::vehicle::{Gate, Vehicle, VehicleState};

/// Speed at which the vehicle creeps to a stop and starts, and below which it may stand, in wheelbases
/// a second. More: it arrives faster, and stops less exactly.
const CREEP: f64 = 0.1;
/// It creeps when it is this near to the stop, in wheelbases, whatever the plan still allows there.
const CREEP_DISTANCE: f64 = 1.0 / 15.0;
/// It has arrived when it is this near to the stop, in wheelbases, and is then held.
const ARRIVED: f64 = 1.0 / 120.0;
/// It leaves its stop again when that is this far ahead, in wheelbases: 15 cm for a car of 3 m, seven
/// deviations of a position with 2 cm of noise.
const LEAVES: f64 = 1.0 / 20.0;
/// `α`: how much a pose counts for the distance to a stop, against the distance travelled since the
/// last. Noise of 2 cm moves it by less than 1 cm.
const POSE_SHARE: f64 = 0.25;
/// A stop so far behind a vehicle that moves is one that it overran, in wheelbases: it stops at once.
const OVERRUN: f64 = 2.0;
/// It cannot stop in time if it would come to rest farther behind the stop, in wheelbases.
const OVERRUN_TOLERANCE: f64 = 1.0 / 30.0;
/// It goes on in the other direction when it is this near to a cusp, in wheelbases: farther than
/// [`ARRIVED`], so that it always does.
const AT_CUSP: f64 = 1.0 / 100.0;
/// How far before a stop the braking ends, in wheelbases: brakes that respond late do not pass it.
const MARGIN: f64 = 1.0 / 60.0;
/// Room to brake in that counts as none [m]: in less, the deceleration that is needed counts as infinite.
const NO_ROOM: f64 = 1e-3;
/// Farther from the path than this, in wheelbases, the vehicle is searched for on the whole path.
/// Less: a jump of the localisation may find another branch. More: it follows a wrong one for longer.
const LOST: f64 = 10.0;
/// On a new path, a place elsewhere counts only if it is nearer by more than this, in wheelbases.
const NEARER: f64 = 0.1;
/// Bound of the accelerations of a state [m/s²]: beyond every limit that a vehicle may have, extended
/// by `reserve`, and small enough that a step computes finite numbers with it.
const ACCELERATION_BOUND: f64 = 1e4;
/// Once the plan brakes, the stop takes over if it needs this share of the largest deceleration; the
/// vehicle then stops in its place even if the brakes are weaker than they were taken for.
const STOP_SHARE: f64 = 0.8;
/// The same before the plan brakes, for a drive that is later than it was taken for. Less: the
/// vehicle is slower than its plan before a stop.
const EARLY_STOP_SHARE: f64 = 0.95;
/// Share of what the brakes can do that holds a vehicle where it stands.
const HOLD: f64 = 0.5;
/// A vehicle that is to speed up by more than this share of its largest acceleration may be at the end
/// of what its drive gives: that it is slower than expected is then not taken for a slope.
const FULL_DRIVE: f64 = 0.5;
/// Below this share of the creeping speed the vehicle is at rest: the brakes may then hold it with
/// more than the deceleration of a plan.
const AT_REST: f64 = 0.2;
/// A turn of the wheels that a start does not wait for [rad].
const SMALL_TURN: f64 = 0.02;
/// Bound of the bend of a state [1/m].
const MAX_BEND: f64 = 1e6;
/// Travel in a period that tells how the vehicle turns, in wheelbases; in less its bend is kept.
const LEAST_TRAVEL: f64 = 0.02;
/// Time constant of the bend [s].
const BEND_TIME: f64 = 0.2;
/// How many steering lags the wheels are waited for, beside the time at their rate.
const LAGS: f64 = 3.0;

params! {
    /// Parameters of [`SpeedTracker`].
    pub struct SpeedTrackerParams {
        /// Acceleration for an error of the speed [1/s].
        kp: f64 = 1.5, in [0.0, 1e3];
        /// Time constant of the estimate of slope and drag [s]. Shorter: they are known sooner, and a
        /// drive that responds later than the vehicle says is taken for one.
        disturbance_time: f64 = 1.0, in [1e-3, 1e3];
        /// Largest change of the acceleration [m/s^3].
        max_jerk: f64 = 20.0, in [1e-3, 1e6];
        /// Acceleration beyond that of the plan that may correct an error [m/s^2].
        reserve: f64 = 0.4, in [0.0, 1e3];
    }
}

/// What a step of [`SpeedTracker`] answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedCommand {
    /// Acceleration in the direction of driving [m/s^2]; negative brakes.
    pub acceleration: f64,
    /// Speed to command in the direction of driving [m/s], for a vehicle that takes a speed: never
    /// above the top speed; negative only while the vehicle still rolls the other way.
    pub speed: f64,
    /// Speed that the plan has beside the rear axle [m/s]; at least that to creep with, so never negative.
    pub reference_speed: f64,
    /// Distance along the path to the next stop [m]: a cusp, the end, or a speed of 0; infinite where
    /// there is none.
    pub distance_to_stop: f64,
    /// Whether the vehicle is to drive backwards.
    pub reverse: bool,
    /// Whether the vehicle is to be held where it stands.
    pub standing: bool,
    /// Whether it overruns its stop, however hard it brakes, by this step and the last one.
    pub cannot_stop: bool,
}

/// Keeps the speed that a path allows, and stops at its cusps and its end.
///
/// A step takes the acceleration of a plan where the vehicle will be when the command takes effect,
/// and corrects the error of the speed:
///
/// ```text
/// command = a(s + v (drive_delay + drive_lag + dt / 2)) + kp e - gravity - disturbance,   e = target - v
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
    /// Largest braking deceleration of a plan [m/s²].
    braking: f64,
    /// What the brakes can do [m/s²].
    brakes: f64,
    follow: Follow,
}

/// The vehicle on its plan, in a step.
struct Situation {
    /// `v`: speed along the path [m/s], negative if the vehicle rolls the other way.
    speed: f64,
    /// Distance to the next stop as measured [m]; infinite if there is none.
    measured: f64,
    /// `D`: the same without most of the noise [m].
    to_stop: f64,
    /// `T`: time until the command takes effect [s].
    delay: f64,
    /// `sqrt(w(s))`: the planned speed here [m/s], at least `slowest`.
    reference: f64,
    /// The speed to keep here [m/s].
    target: f64,
    /// The least speed to keep here [m/s]: to creep away from a start and up to a stop. 0 if the path
    /// says 0 along this segment.
    slowest: f64,
    /// `a(s + v T)`: the planned acceleration where the command takes effect [m/s²].
    planned: f64,
    /// `g(s + v T) + d`: what accelerates the vehicle besides the drive [m/s²].
    push: f64,
    /// Whether the vehicle is to be held where it stands.
    standing: bool,
}

/// What a stop takes.
struct Braking {
    /// Deceleration to the creeping speed just before the stop [m/s²]: 0 if the vehicle is as slow
    /// already, infinite where no distance remains.
    needed: f64,
    /// Deceleration with which it passes the stop by a margin [m/s²].
    tolerated: f64,
    /// Whether it passes it with all that the brakes can do.
    cannot_stop: bool,
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
            braking: car.comfort_braking(),
            brakes: defaults::strongest_braking(&car),
            follow: Follow {
                lost_distance: LOST * car.wheelbase,
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
        use crate::speed::stops::bounds_of;
        use crate::speed::{Course, Limit, OverSpeed, SpeedLimits, path_curvature, plan_speeds};
        use alloc::vec;
        use alloc::vec::Vec;

        let cusps = path.cusps();
        let bounds = bounds_of(path, &cusps, CREEP * self.vehicle.wheelbase);
        let car = self.vehicle;
        let lateral = car
            .max_lateral_acceleration
            .unwrap_or(defaults::MAX_LATERAL_ACCELERATION);
        let curvature = path_curvature(path, defaults::SMOOTHING * car.wheelbase);
        let sharp = car
            .steers_at_rest
            .then(|| path_curvature(path, defaults::SHARP * car.wheelbase));
        let segments = path.segments();
        let spacing: Vec<f64> = (0..segments).map(|k| path.segment_length(k)).collect();
        let course = Course {
            curvature: &curvature,
            sharp: sharp.as_deref(),
            spacing: &spacing,
            closed: path.is_closed(),
            cusps: Some(&cusps),
            speed_limits: bounds.as_deref(),
            grade: path.grade(),
            start_speed: None,
            end_speed: Some(0.0),
        };
        let limits = SpeedLimits {
            max_speed: car.max_speed.unwrap_or(defaults::MAX_SPEED),
            max_lateral_acceleration: defaults::BEND_SHARE * lateral,
            acceleration: OverSpeed::constant(&self.driving),
            deceleration: OverSpeed::constant(&self.braking),
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
        self.step_aged(path, plan, state, vehicle, dt, 0.0)
    }

    /// [`step`](Self::step) for a pose that was measured `pose_age` [s] before, from 0 to
    /// [`MAX_POSE_AGE`](crate::vehicle::past::MAX_POSE_AGE).
    ///
    /// # Errors
    ///
    /// As `step`.
    pub fn step_aged(
        &self,
        path: &PathView<'_>,
        plan: &[f64],
        state: &mut SpeedTrackerState,
        vehicle: VehicleState,
        dt: f64,
        pose_age: f64,
    ) -> Result<SpeedCommand, InputError> {
        let vehicle = vehicle.checked()?;
        let dt = checked_dt(dt)?;
        let pose_age = checked_age(pose_age)?;
        let mut next = *state;
        let vehicle = self.believe(&mut next, vehicle, dt, pose_age);
        let at = self.follow.locate(path, state.waypoint, vehicle, dt);
        next.waypoint = Some(at.closest.segment);
        if at.direction_changed {
            // What was commanded and found out in the other direction does not count.
            next = SpeedTrackerState {
                waypoint: next.waypoint,
                gate: next.gate,
                heard: next.heard,
                servo: next.servo.turned(),
                ..SpeedTrackerState::default()
            };
        }
        next.turning = self.turning(path, &at, &next, state.waypoint, dt);
        let mut now = self.situation(path, plan, &at, &mut next, dt);
        let braking = self.braking_for(&now, next.acceleration);
        let reserve = self.params.reserve;
        let last = next.acceleration;
        next.standing = now.standing;
        now.standing |= next.turning > 0.0;
        let command = if now.standing {
            self.hold(&now)
        } else {
            let share = if now.planned < 0.0 {
                STOP_SHARE
            } else {
                EARLY_STOP_SHARE
            };
            let tracking = now.planned + self.params.kp * (now.target - now.speed);
            let wanted = if braking.needed >= share * self.braking {
                smaller(-braking.needed, tracking)
            } else {
                tracking
            };
            let most = larger(self.braking + reserve, braking.tolerated);
            let most = smaller(most, self.brakes - now.push);
            saturate(wanted, -most, self.driving + reserve) - now.push
        };
        let change = self.params.max_jerk * dt;
        let command = saturate(larger(command, -self.brakes), last - change, last + change);
        next.acceleration = command;
        let speed = self.speed(path, plan, &at, (&now, command), &mut next);
        next.overruns = braking.cannot_stop;
        // One speed alone that is wrong is a glitch; a first step has no other to compare it with.
        let cannot_stop = next.overruns && (state.overruns || state.gate.is_none());
        *state = next;
        Ok(SpeedCommand {
            acceleration: command,
            speed,
            reference_speed: now.reference,
            distance_to_stop: now.measured,
            reverse: at.reverse,
            standing: now.standing,
            cannot_stop,
        })
    }

    /// Where the vehicle is: its pose, or what the [`Gate`] believes in its place, rolled forward by its
    /// age along the bend that the last poses showed. A pose that the gate calls `IMPLAUSIBLE` is taken as
    /// the new truth: a stop by an expectation alone may be anywhere.
    fn believe(
        &self,
        state: &mut SpeedTrackerState,
        vehicle: VehicleState,
        dt: f64,
        age: f64,
    ) -> VehicleState {
        let car = &self.vehicle;
        let vehicle = VehicleState {
            speed: state.hear(vehicle.speed, self.brakes, dt),
            ..vehicle
        };
        let mut believed = vehicle;
        if let Some(gate) = &mut state.gate {
            let (before, since) = (gate.believed, gate.since);
            let (status, _) = gate.pass(car, vehicle, state.bend, dt, age);
            let travel = vehicle.speed * dt;
            if status.contains(Status::IMPLAUSIBLE) {
                (gate.believed, gate.since) = (vehicle, 0.0);
            } else if status != Status::OK {
                believed = gate.believed;
            } else if since == 0.0 && travel.abs() > LEAST_TRAVEL * car.wheelbase {
                let bend = wrap(vehicle.yaw - before.yaw) / travel;
                state.bend += (1.0 - decay(dt, BEND_TIME)) * (bend - state.bend);
            }
        } else {
            state.gate = Some(Gate::new(vehicle, car, age));
        }
        if age == 0.0 {
            return believed;
        }
        let arc = (vehicle.speed * age, state.bend);
        rolled(car, believed, arc, vehicle.speed)
    }

    /// How long the vehicle goes on standing while its wheels turn [s]: at a start or a cusp, where
    /// they turn at rest, from straight or from the bend before it.
    fn turning(
        &self,
        path: &PathView<'_>,
        at: &Located,
        state: &SpeedTrackerState,
        last: Option<usize>,
        dt: f64,
    ) -> f64 {
        let (car, speed) = (&self.vehicle, at.vehicle.speed);
        let creep = CREEP * car.wheelbase;
        if !car.steers_at_rest || speed > creep {
            return 0.0;
        }
        // Not the first step.
        if state.model_speed.is_some() {
            let still = speed.abs() < AT_REST * creep;
            return larger(state.turning - if still { dt } else { 0.0 }, 0.0);
        }
        let wheel = |segment: usize, arc: f64| {
            let angle = wheel_at_rest(car, path, segment, arc);
            if path.is_reverse(segment) {
                -angle
            } else {
                angle
            }
        };
        let before = match last.and_then(|last| path.section_end(last)) {
            Some(end) if at.direction_changed => wheel(end, path.segment_end(end)),
            _ => 0.0,
        };
        let turn = (wheel(at.closest.segment, at.closest.arc_length(path)) - before).abs();
        if turn < SMALL_TURN {
            return 0.0;
        }
        let rate = car.max_steer_rate.unwrap_or(f64::INFINITY);
        smaller(car.dead_time + LAGS * car.steer_lag + turn / rate, MAX_DT)
    }

    /// Where the vehicle is on its plan, and what the plan wants there; brings the estimate of
    /// `state` up to date.
    fn situation(
        &self,
        path: &PathView<'_>,
        plan: &[f64],
        at: &Located,
        state: &mut SpeedTrackerState,
        dt: f64,
    ) -> Situation {
        let (params, wheelbase) = (&self.params, self.vehicle.wheelbase);
        let segment = at.closest.segment;
        let arc = at.closest.arc_length(path);
        let planned = Planned {
            path,
            speeds: plan,
            segment,
            end: path.section_end(segment),
        };
        let lag = self.vehicle.drive_delay + self.vehicle.drive_lag;
        let delay = lag + 0.5 * dt;
        let speed = at.vehicle.speed;
        let creep = CREEP * wheelbase;
        let (squared, _, grade) = planned.at(arc);
        let (_, ahead, grade_ahead) = planned.at(arc + at.vehicle.forward_speed() * delay);

        // Brakes that hold say nothing; a drive that pulls in vain does.
        let held = state.standing
            || state.turning > 0.0
            || (speed.abs() < AT_REST * creep && state.acceleration <= 0.0);
        let known = gravity_along(grade);
        let model = (lag, params.disturbance_time, wheelbase);
        let wanted = state.acceleration + known + state.disturbance;
        let at_full_drive = wanted > FULL_DRIVE * self.driving;
        state.observe(speed, known, (held, at_full_drive), model, dt);

        let stays_at_zero = planned.stays_at_zero();
        let (measured, to_stop) = self.distance_to_stop(&planned, arc, speed, state, dt);
        let room = larger(to_stop, 0.0);
        let slowest = if stays_at_zero {
            0.0
        } else {
            smaller(creep, sqrt(self.braking * room))
        };
        let reference = larger(sqrt(squared), slowest);
        let stands_until = if state.standing { LEAVES } else { ARRIVED };
        let arrived = to_stop <= stands_until * wheelbase;
        Situation {
            speed,
            measured,
            to_stop,
            delay,
            reference,
            target: if room < CREEP_DISTANCE * wheelbase {
                slowest
            } else {
                reference
            },
            slowest,
            // A vehicle that is slower than it may creep has no speed to lose.
            planned: if speed < slowest && ahead < 0.0 {
                0.0
            } else {
                ahead
            },
            push: gravity_along(grade_ahead) + state.disturbance,
            standing: arrived && (speed < creep || state.standing),
        }
    }

    /// The distance to the next stop [m], as measured and as `D`; infinite if there is none.
    fn distance_to_stop(
        &self,
        planned: &Planned<'_, '_>,
        arc: f64,
        speed: f64,
        state: &mut SpeedTrackerState,
        dt: f64,
    ) -> (f64, f64) {
        let wheelbase = self.vehicle.wheelbase;
        let may_have_overrun = speed > CREEP * wheelbase || state.standing;
        let behind = if may_have_overrun { OVERRUN } else { LEAVES };
        let stop = planned.next_stop(arc, behind * wheelbase, self.braking);
        let measured = if planned.stays_at_zero() {
            smaller(stop - arc, 0.0)
        } else {
            stop - arc
        };
        // D' and D: the speed shows how far the vehicle moved since the last step, the pose where it is.
        let expected = state.to_stop.map(|last| last - speed * dt);
        let to_stop = match expected.map(|expected| (expected, measured - expected)) {
            Some((expected, error)) if error.abs() < LEAVES * wheelbase => {
                expected + POSE_SHARE * error
            }
            _ => measured,
        };
        state.to_stop = to_stop.is_finite().then_some(to_stop);
        (measured, to_stop)
    }

    /// The acceleration that holds the vehicle where it stands [m/s²]; no harder than a plan brakes
    /// until it is at rest.
    fn hold(&self, now: &Situation) -> f64 {
        let hold = -HOLD * self.brakes;
        if now.speed > AT_REST * CREEP * self.vehicle.wheelbase {
            larger(hold, -self.braking) - now.push
        } else {
            hold
        }
    }

    /// The speed to command for a vehicle that takes one [m/s], along the path.
    fn speed(
        &self,
        path: &PathView<'_>,
        plan: &[f64],
        at: &Located,
        (now, acceleration): (&Situation, f64),
        state: &mut SpeedTrackerState,
    ) -> f64 {
        let segment = at.closest.segment;
        let planned = Planned {
            path,
            speeds: plan,
            segment,
            end: path.section_end(segment),
        };
        let time = self.vehicle.drive_delay + self.vehicle.drive_lag;
        let ahead = (larger(now.speed, 0.0) + 0.5 * self.driving * time) * time;
        let (squared, _, _) = planned.at(at.closest.arc_length(path) + ahead);
        let wanted = Wanted {
            acceleration,
            plan: larger(sqrt(squared), now.slowest),
            standing: now.standing,
        };
        state.servo.step(&self.vehicle, now.speed, wanted, at.dt)
    }

    /// What the stop takes, after the `last` command [m/s²].
    fn braking_for(&self, now: &Situation, last: f64) -> Braking {
        let wheelbase = self.vehicle.wheelbase;
        let (speed, acceleration) = (now.speed, last + now.push);
        let slower = 1.0 / self.params.max_jerk - 1.0 / SpeedTrackerParams::DEFAULT.max_jerk;
        let ramp = larger(acceleration + self.braking, 0.0) * larger(slower, 0.0);
        let delay = now.delay + 0.5 * ramp;
        let arriving = larger(speed + acceleration * delay, 0.0);
        let travelled = 0.5 * (speed + arriving) * delay;
        let needed_for = |end: f64, remaining: f64| {
            if arriving <= end {
                0.0
            } else if remaining > NO_ROOM {
                (arriving * arriving - end * end) / (2.0 * remaining)
            } else {
                f64::INFINITY
            }
        };
        let remaining = now.to_stop - travelled;
        let overrunning = |by: f64| needed_for(0.0, remaining + by * wheelbase);
        let moves = smaller(speed, arriving) > CREEP * wheelbase;
        Braking {
            needed: needed_for(now.slowest, remaining - MARGIN * wheelbase),
            tolerated: if moves { overrunning(MARGIN) } else { 0.0 },
            cannot_stop: moves && overrunning(OVERRUN_TOLERANCE) > self.brakes - now.push,
        }
    }

    /// The path `new` replaces `old`; its own plan replaces the old one.
    ///
    /// The command and the estimate continue, and so does the place, as in [`carry_over`].
    pub fn set_path(&self, state: &mut SpeedTrackerState, old: &PathView<'_>, new: &PathView<'_>) {
        let Some(last) = state.waypoint.map(|last| old.segment_at(last)) else {
            return;
        };
        if goes_on(old, new, last) {
            return;
        }
        let (point, _) = old.segment(last);
        let progress = Progress {
            segment: last,
            point,
            reach: self.follow.search_distance + old.segment_length(last),
        };
        let opposite = self.follow.opposite_distance;
        let tolerance = NEARER * self.vehicle.wheelbase;
        let found = carry_over(old, new, progress, opposite, tolerance, STEP_BUDGET);
        state.waypoint = Some(found.segment);
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
        input_within("acceleration", state.acceleration, ACCELERATION_BOUND)?;
        input_within("drive", state.drive, ACCELERATION_BOUND)?;
        input_within("slow_drive", state.slow_drive, ACCELERATION_BOUND)?;
        input_within("model_speed", state.model_speed.unwrap_or(0.0), MAX_SPEED)?;
        let to_stop = state.to_stop.unwrap_or(0.0);
        input_within("to_stop", to_stop, 4.0 * MAX_COORDINATE)?;
        input_in_range("turning", state.turning, 0.0, MAX_DT)?;
        input_within("disturbance", state.disturbance, MAX_DISTURBANCE)?;
        input_within("bend", state.bend, MAX_BEND)?;
        input_within("heard", state.heard.unwrap_or(0.0), MAX_SPEED)?;
        state.servo.checked()?;
        state.gate.map_or(Ok(()), |gate| gate.checked().map(|_| ()))
    }
}

#[cfg(test)]
mod tests;
