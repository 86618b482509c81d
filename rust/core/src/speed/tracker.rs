//! The speed alone: the law of the speed for a vehicle that is measured, around it what a
//! [`Driver`](crate::tracker) has besides. It gates the poses, rolls them forward by their age, and locates
//! the vehicle on its path.
//!
//! - A **speed** that one message alone says is not believed: a signal counts as far as accelerations reach
//!   from the last signal or from the expected speed.
//! - A **pose** passes the [`Gate`]. One that is a fault (a frozen position, a dead speed signal) is
//!   not driven by: the vehicle brakes until it has ended, and the status says so.
//! - The **place** goes on into the section behind a cusp once the vehicle stands there.

use crate::bounds::MAX_SPEED;
use crate::error::{ConfigError, InputError, input_within};
use crate::math::{decay, wrap};
use crate::path::carry::{Progress, carry_over, goes_on};
use crate::path::{Follow, PathView, STEP_BUDGET};
use crate::speed::law::{Sensed, SpeedCommand, SpeedLaw, SpeedState, SpeedTrackerParams};
use crate::status::{HOLD_LIMIT, Status};
use crate::vehicle::gate::rolled;
use crate::vehicle::past::checked_age;
use crate::vehicle::state::period;
use crate::vehicle::{Gate, Vehicle, VehicleState};

/// Farther from the path than this, in wheelbases, the vehicle is searched for on the whole path.
/// Less: a jump of the localisation may find another branch. More: it follows a wrong one for longer.
const LOST: f64 = 10.0;
/// On a new path, a place elsewhere counts only if it is nearer by more than this, in wheelbases.
const NEARER: f64 = 0.1;
/// Share of the jerk that plans use; the rest is for the law to correct errors.
#[cfg(feature = "alloc")]
const JERK_SHARE: f64 = 0.8;
/// Bound of the bend of a state [1/m].
const MAX_BEND: f64 = 1e6;
/// Travel in a period that tells how the vehicle turns, in wheelbases; in less its bend is kept.
const LEAST_TRAVEL: f64 = 0.02;
/// Time constant of the bend [s].
const BEND_TIME: f64 = 0.2;

/// What [`SpeedTracker`] remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SpeedTrackerState {
    /// Where the segment beside the rear axle starts; None before the first step.
    pub waypoint: Option<usize>,
    /// What the law remembers.
    pub law: SpeedState,
    /// The poses that are believed; None before the first step.
    pub gate: Option<Gate>,
    /// Curvature of the vehicle's trajectory by its last poses [1/m].
    pub bend: f64,
    /// The last speed signal [m/s], believed or not; None before the first step.
    pub heard: Option<f64>,
    /// The last command; None before the first step.
    pub command: Option<SpeedCommand>,
    /// How many steps in a row it was held.
    pub held: usize,
}

impl SpeedTrackerState {
    /// The last command once more; before the first the vehicle is to stand.
    fn hold(&mut self) -> SpeedCommand {
        self.held = self.held.saturating_add(1);
        SpeedCommand {
            status: Status::held(self.held, HOLD_LIMIT),
            ..self.command.unwrap_or(SpeedCommand::WAITING)
        }
    }
}

/// Optional inputs of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Told {
    /// How long before the step pose and speed were measured [s], from 0 to
    /// [`MAX_POSE_AGE`](crate::vehicle::past::MAX_POSE_AGE).
    pub pose_age: f64,
    /// Whether the reverse gear is in; None where that is not reported.
    pub reverse_gear: Option<bool>,
    /// Whether the vehicle is to stop where it is, and to stand there.
    pub stop: bool,
}

/// Keeps the speed that a path allows, and stops at its cusps, its end, and where it says 0.
///
/// [`SpeedTracker::plan`] makes the plan; the equations of the step are those of the
/// [law](crate::speed::law).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedTracker {
    law: SpeedLaw,
    follow: Follow,
}

impl SpeedTracker {
    /// The controller of a vehicle.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the field or the parameter that is out of its range.
    pub fn new(vehicle: Vehicle, params: SpeedTrackerParams) -> Result<Self, ConfigError> {
        let law = SpeedLaw::new(vehicle, params)?;
        let car = law.car;
        Ok(Self {
            law,
            follow: Follow {
                lost_distance: LOST * car.wheelbase,
                ..Follow::of(&car, car.rear_axle, 0.0)
            },
        })
    }

    /// The law of the speed.
    pub(crate) fn law(&self) -> &SpeedLaw {
        &self.law
    }

    /// How the rear axle, which stops, follows the path.
    pub(crate) fn follow(&self) -> &Follow {
        &self.follow
    }

    /// The greatest speed at each waypoint of `path` within the vehicle's limits and at most the
    /// path's own [m/s], never negative. For a limit that the vehicle does not have, that of
    /// [`defaults`](crate::speed::defaults) is taken. Plans use 0.9 of the lateral acceleration in bends:
    /// the rest is for the steering to correct errors.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], where a limit of the vehicle is out of the range of a plan.
    #[cfg(feature = "alloc")]
    pub fn plan(&self, path: &PathView<'_>) -> Result<alloc::vec::Vec<f64>, ConfigError> {
        use crate::speed::defaults;
        use crate::speed::jerk::Jerk;
        use crate::speed::law::CREEP;
        use crate::speed::stops::bounds_of;
        use crate::speed::{Course, Limit, OverSpeed, SpeedLimits, path_curvature, plan_speeds};
        use alloc::vec;
        use alloc::vec::Vec;

        let cusps = path.cusps();
        let bounds = bounds_of(path, &cusps, CREEP * self.law.car.wheelbase);
        let car = self.law.car;
        let (driving, braking) = self.law.accelerations;
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
            acceleration: OverSpeed::constant(&driving),
            deceleration: OverSpeed::constant(&braking),
            longitudinal_grip: None,
            exponent: 2.0,
            vehicle: car,
        };
        let mut speed = vec![0.0; path.len()];
        let mut limit = vec![Limit::default(); path.len()];
        plan_speeds(&course, &limits, &mut speed, &mut limit)?;
        let jerk = Jerk {
            spacing: &spacing,
            closed: path.is_closed(),
            accelerations: (driving, braking),
            most: JERK_SHARE * self.law.params.max_jerk,
        };
        jerk.limit(&mut speed);
        Ok(speed)
    }

    /// The command for a vehicle on `path`, whose planned speeds are `plan` [m/s], one a waypoint.
    ///
    /// A `dt` that is no control period, of a clock that was set or repeats a stamp, is no time: the last
    /// command is held, as in a step of a [`Tracker`](crate::Tracker).
    ///
    /// # Errors
    ///
    /// [`InputError`] for another number that is not finite or beyond its bound, or a `dt` that is not
    /// finite; `state` is then unchanged.
    pub fn step(
        &self,
        path: &PathView<'_>,
        plan: &[f64],
        state: &mut SpeedTrackerState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<SpeedCommand, InputError> {
        self.step_told(path, plan, state, vehicle, dt, Told::default())
    }

    /// [`step`](Self::step) for a vehicle of which more is known.
    ///
    /// # Errors
    ///
    /// As `step`.
    pub fn step_told(
        &self,
        path: &PathView<'_>,
        plan: &[f64],
        state: &mut SpeedTrackerState,
        vehicle: VehicleState,
        dt: f64,
        told: Told,
    ) -> Result<SpeedCommand, InputError> {
        let antenna = vehicle.checked()?;
        let age = checked_age(told.pose_age)?;
        let Some(dt) = period(dt)? else {
            return Ok(state.hold());
        };
        // A roll moves it across its path: to a stop that is the same.
        let vehicle = antenna.left(-self.law.car.antenna_offset(0.0));
        let (believed, status) = self.believe(state, vehicle, dt, age);
        let first = state.waypoint.is_none();
        let follow = Follow {
            // The law says when the vehicle has arrived at a cusp.
            arrival_distance: if first {
                self.follow.arrival_distance
            } else {
                f64::NEG_INFINITY
            },
            ..self.follow
        };
        let at = follow.locate(path, state.waypoint, believed, dt);
        state.waypoint = Some(at.closest.segment);
        let sensed = Sensed {
            speed: believed.speed,
            age,
            noise: Gate::noise_of(state.gate.as_ref()),
            reverse_gear: told.reverse_gear,
            stop: (told.stop || status.contains(Status::IMPLAUSIBLE))
                .then_some(self.law.accelerations.1),
        };
        let command = self.law.step(path, plan, &mut state.law, &at, sensed);
        if let Some(next) = state.law.passes {
            state.waypoint = Some(next);
        }
        (state.command, state.held) = (Some(command), 0);
        let status = status | Status::OFF_PATH.when(at.off_path);
        Ok(SpeedCommand { status, ..command })
    }

    /// Where the vehicle is: its pose, or what the [`Gate`] believes in its place, rolled forward by its
    /// age along the bend that the last poses showed; and with what speed it was measured.
    fn believe(
        &self,
        state: &mut SpeedTrackerState,
        vehicle: VehicleState,
        dt: f64,
        age: f64,
    ) -> (VehicleState, Status) {
        let car = &self.law.car;
        let last = state.heard.replace(vehicle.speed);
        if let (Some(gate), Some(last)) = (&mut state.gate, last) {
            gate.listen(car, vehicle.speed - last, dt);
        }
        let noise = Gate::noise_of(state.gate.as_ref()).1;
        let speed = self.law.hear(&state.law, vehicle.speed, last, (noise, dt));
        let vehicle = VehicleState { speed, ..vehicle };
        let mut believed = vehicle;
        let mut status = Status::OK;
        if let Some(gate) = &mut state.gate {
            let (before, since) = (gate.believed, gate.since);
            (status, _) = gate.pass(car, vehicle, state.bend, dt, age);
            let travel = speed * dt;
            if status != Status::OK {
                believed = gate.believed;
            } else if since == 0.0 && travel.abs() > LEAST_TRAVEL * car.wheelbase {
                let bend = wrap(vehicle.yaw - before.yaw) / travel;
                state.bend += (1.0 - decay(dt, BEND_TIME)) * (bend - state.bend);
            }
        } else {
            state.gate = Some(Gate::new(vehicle, age));
        }
        if age > 0.0 {
            let gone = self.law.moved(&state.law, speed, age, dt).travelled;
            believed = rolled(car, believed, (gone, state.bend), speed);
        }
        (VehicleState { speed, ..believed }, status)
    }

    /// The path `new` replaces `old`; its own plan replaces the old one.
    ///
    /// The command and the estimates continue, and so do the place, as in [`carry_over`], and a stop that
    /// both have.
    pub fn set_path(&self, state: &mut SpeedTrackerState, old: &PathView<'_>, new: &PathView<'_>) {
        let Some(last) = state.waypoint.map(|last| old.segment_at(last)) else {
            return;
        };
        if !goes_on(old, new, last) {
            let (point, _) = old.segment(last);
            let progress = Progress {
                segment: last,
                point,
                reach: self.follow.search_distance + old.segment_length(last),
            };
            let opposite = self.follow.opposite_distance;
            let tolerance = NEARER * self.law.car.wheelbase;
            let found = carry_over(old, new, progress, opposite, tolerance, STEP_BUDGET);
            state.waypoint = Some(found.segment);
        }
        let to = state.waypoint.unwrap_or(0);
        self.law.set_path(&mut state.law, (old, last), (new, to));
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
        self.law.check_state(path, &state.law)?;
        input_within("bend", state.bend, MAX_BEND)?;
        input_within("heard", state.heard.unwrap_or(0.0), MAX_SPEED)?;
        state
            .command
            .as_ref()
            .map(SpeedCommand::check)
            .transpose()?;
        state.gate.map_or(Ok(()), |gate| gate.checked().map(|_| ()))
    }
}

#[cfg(test)]
mod tests;
