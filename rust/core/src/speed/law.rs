//! The law of the speed: keeps a plan, and stops where the path says so.
//!
//! # Equations
//!
//! The rear axle has the distance `D` to its next stop, the speed `v` along the path, and the
//! acceleration `a + w` by its drive, by gravity along a path that knows its grade, and by whatever else
//! pushes ([`disturbance`](super::disturbance)). [`Drive`] rolls all of them forward through the commands
//! in flight, to when the command of this step begins to act (a Smith predictor). Then
//!
//! ```text
//! y = D - lag v,   z = v + lag (a + w):      y' = -z,   z' = u + w
//! ```
//!
//! so the lag is gone: `v` and `D` follow `z` and `y` by a first-order response, and where `y` comes down
//! to 0 without undershoot, so does `D`. `z` is led along a curve `z*(y)`, the plan or the speed from
//! which the vehicle still stops, whichever is slower:
//!
//! ```text
//! u = -z dz*/dy + kp (z* - z) - w      so that      d/dt (z - z*) = -kp (z - z*)
//! ```
//!
//! (`kp (z* - z)` within what `max_jerk` takes back in time: `correction`.) The error fades and
//! never changes its sign; on the curve `y' = -z*(y)` ends at 0. That is the
//! proximate time-optimal servomechanism (M. L. Workman, *Adaptive Proximate Time-Optimal
//! Servomechanisms*, Stanford, 1987) with a curve that is jerk-limited at its end:
//!
//! ```text
//! y = J t³ / 6,   z* = J t² / 2,   -z*' = J t                      the last T = b / J before the stop
//! z*² = (b T / 2)² + 2 b (y - b T² / 6),   -z*' = b                before
//! T  = max(b / max_jerk, SOFT (drive_delay + drive_lag + dt))
//! ```
//!
//! with the planned deceleration `b`. A vehicle that `b` would bring to rest at its stop or beyond brakes
//! and is held from then on, whatever the noise says. It goes on where its stop is gone, or farther off
//! than noise explains. `u` stays within the vehicle's accelerations, extended by `reserve`; harder,
//! up to what the brakes can do, only where the vehicle would overrun its stop.

use crate::bounds::{MAX_COORDINATE, MAX_DT};
use crate::error::{ConfigError, InputError, input_in_range, input_within};
use crate::geometry::Point;
use crate::math::{larger, powf, saturate, smaller, sqrt};
use crate::params;
use crate::path::PathView;
use crate::path::follow::Located;
use crate::path::preview::wheel_at_rest;
use crate::speed::defaults::{self, gravity_along};
use crate::speed::disturbance::Observer;
use crate::speed::servo::{Servo, Wanted};
use crate::speed::stops::{Between, Planned};
use crate::status::Status;
use crate::vehicle::{Drive, Motion, Vehicle};

/// Below this speed the vehicle is at rest [m/s]: a step of a speed sensor. Less: it is not seen to
/// stand. More: its gear changes while it rolls.
pub const REST: f64 = 0.03;
/// How far before a stop it may stand [m], and in wheelbases besides. More: it stops less exactly. Less:
/// it creeps up in noise.
const ARRIVED: (f64, f64) = (0.002, 1.0 / 600.0);
/// It leaves its stop where that is farther ahead than this [m], and in wheelbases besides. Less: noise of
/// the position lets it go.
const LEAVES: (f64, f64) = (0.06, 1.0 / 60.0);
/// A distance to the stop that is off the expected one by so many times that is a jump.
const JUMP: f64 = 2.5;
/// How much a pose counts for the distance to a stop, against the distance travelled since the last. Less:
/// a wrong speed shifts the stop. More: noise does.
const POSE_SHARE: f64 = 0.2;
/// The end of a stop takes so many times the drive's delay and lag. Less: a drive that is later than the
/// vehicle says overruns. More: the stop takes longer.
const SOFT: f64 = 1.5;
/// How far beyond its stop it may come to rest before it says so [m], and in wheelbases besides.
const OVERRUN: (f64, f64) = (0.05, 1.0 / 30.0);
/// How long a vehicle stands at a cusp until its gear changes [s], and for a gear that is not reported once
/// it rolled the wrong way. Less: it pulls before the gear is in. More: it waits.
const SHIFT: (f64, f64) = (0.3, 2.0);
/// Slowest plan, in wheelbases a second: beside a start.
pub(super) const CREEP: f64 = 0.1;
/// Share of what the brakes can do that holds a vehicle, and how many times what its slope needs. Less: it
/// rolls back until a drive with a lag has become a brake.
const HOLD: (f64, f64) = (0.5, 2.5);
/// A turn of the wheels that a start does not wait for [rad], and how many lags it waits for a turn.
const TURN: (f64, f64) = (0.02, 3.0);
/// Halvings of the time to rest: to 1e-6 of it.
const HALVINGS: usize = 20;
/// Bounds of the accelerations [m/s²] and the speed [m/s] of a state, beyond what a step can leave there.
const ACCELERATION_BOUND: f64 = 1e4;
const SPEED_BOUND: f64 = 1e8;

params! {
    /// Parameters of [`SpeedTracker`](super::SpeedTracker).
    pub struct SpeedTrackerParams<Scaled> of Vehicle(wheelbase) {
        /// Share of an error of the speed that is corrected in a second [1/s].
        kp: f64 = 1.5, in [0.0, 1e3];
        /// Time constant of the estimate of slope and drag [s]. Shorter: they are known sooner, and a
        /// drive that responds later than the vehicle says is taken for one.
        disturbance_time: f64 = 1.0, in [1e-3, 1e3];
        /// Largest change of the acceleration, of plans and of stops, too [m/s^3].
        max_jerk: Scaled = 60.0 / wheelbase, in [1e-3, 1e6];
        /// Acceleration beyond that of the plan that may correct an error [m/s^2].
        reserve: f64 = 0.4, in [0.0, 1e3];
    }
}

/// What the vehicle does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Phase {
    /// It keeps its plan.
    #[default]
    Driving,
    /// It brakes for a stop.
    Stopping,
    /// It is held at its stop.
    Standing,
    /// It stands until its wheels are turned.
    Turning,
    /// It stands until its gear is in.
    Shifting,
    /// It brakes or stands as it was told to, or for a fault.
    Stopped,
}

impl Phase {
    /// All of them, each at the number that stands for it in C.
    pub const ALL: [Self; 6] = [
        Self::Driving,
        Self::Stopping,
        Self::Standing,
        Self::Turning,
        Self::Shifting,
        Self::Stopped,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Driving => "driving",
            Self::Stopping => "stopping",
            Self::Standing => "standing",
            Self::Turning => "turning",
            Self::Shifting => "shifting",
            Self::Stopped => "stopped",
        }
    }
}

/// What a step of the speed answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedCommand {
    /// Acceleration in the direction of driving [m/s^2]; negative brakes.
    pub acceleration: f64,
    /// Speed to command in the direction of driving [m/s], for a vehicle that takes a speed: never
    /// above the top speed; negative only while the vehicle still rolls the other way.
    pub speed: f64,
    /// Speed that the plan has beside the rear axle [m/s]; at least that to creep with, so never negative.
    pub reference_speed: f64,
    /// Distance along the path to the next stop [m]: a cusp, the end, or a speed of 0, for the vehicle's
    /// `stop_point` at the last two; infinite where there is none, negative where it was overrun.
    pub distance_to_stop: f64,
    /// Whether the vehicle is to drive backwards: while it rolls, the way that it rolls.
    pub reverse: bool,
    /// Whether the vehicle is to be held where it stands.
    pub standing: bool,
    /// Whether it overruns its stop, however hard it brakes, by this step and the last one; or stands
    /// beyond it.
    pub cannot_stop: bool,
    /// What the vehicle does.
    pub phase: Phase,
    /// What is known of the inputs: of the tracker, or of the driver around the law.
    pub status: Status,
}

/// What is believed of the vehicle, and what it was told.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensed {
    /// Speed [m/s], negative backwards.
    pub speed: f64,
    /// How long ago it had that speed [s].
    pub age: f64,
    /// Whether the reverse gear is in; None where that is not reported.
    pub reverse_gear: Option<bool>,
    /// Whether it is to stop here: by the operator, or for a fault.
    pub stop: bool,
}

/// What the law remembers.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is remembered by itself"
)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SpeedState {
    /// The last command [m/s^2].
    pub acceleration: f64,
    /// The speed along the path [m/s].
    pub speed: f64,
    /// The commands in flight, and the drive; None before the first step.
    pub drive: Option<Drive>,
    /// What else pushes.
    pub observer: Observer,
    /// The waypoint of the next stop, where it lies [m], and the distance to it, as steady as the speed.
    pub stop: Option<(usize, (f64, f64), f64)>,
    /// Whether the vehicle is held at its stop.
    pub standing: bool,
    /// Whether it overruns its stop by the last step.
    pub overruns: bool,
    /// How long it stands until its wheels are turned and its gear is in [s].
    pub waits: (f64, f64),
    /// The wheels' angle before the turn that it is to wait for [rad].
    pub wheels: Option<f64>,
    /// Whether the path is driven backwards; None before the first step.
    pub reverse: Option<bool>,
    /// For how long it has been at rest [s].
    pub still: f64,
    /// Whether it still rolls the way that it drove before.
    pub rolls: bool,
    /// Whether it has not moved since its direction changed.
    pub shifting: bool,
    /// The first segment of the next section, once the vehicle stands at a cusp.
    pub passes: Option<usize>,
    /// The speed command, for a vehicle that takes one.
    pub servo: Servo,
}

/// The law of a vehicle; its equations are those of the [module](self).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLaw {
    pub(super) car: Vehicle,
    pub(super) params: SpeedTrackerParams<f64>,
    /// Largest driving acceleration, and deceleration of a plan [m/s²].
    pub(super) accelerations: (f64, f64),
    /// What the brakes can do [m/s²].
    brakes: f64,
}

/// The vehicle on its plan.
#[derive(Clone, Copy, Debug)]
struct Situation {
    /// `v` [m/s].
    speed: f64,
    /// `w` [m/s²].
    push: f64,
    /// Distance to the next stop as measured, and `D` [m]; infinite if there is none.
    stop: (f64, f64),
    /// The vehicle when the command begins to act.
    then: Motion,
    /// `y` [m] and `z` [m/s].
    y: f64,
    z: f64,
    /// `z*` [m/s] and its change in time [m/s²].
    target: f64,
    change: f64,
    /// Whether the stop binds, not the plan.
    stops: bool,
    /// `sqrt(w(s))`, at least the creeping speed [m/s].
    reference: f64,
}

impl SpeedLaw {
    /// The law of a vehicle.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the field or the parameter that is out of its range.
    pub fn new(car: Vehicle, params: SpeedTrackerParams) -> Result<Self, ConfigError> {
        let car = car.checked()?;
        let driving = car.max_acceleration.unwrap_or(defaults::MAX_ACCELERATION);
        Ok(Self {
            car,
            params: params.checked()?.resolved(&car),
            accelerations: (driving, car.comfort_braking()),
            brakes: defaults::strongest_braking(&car),
        })
    }

    /// The command for a vehicle that is located `at` its place on `path` now, whose planned speeds are
    /// `plan` [m/s], one a waypoint.
    pub fn step(
        &self,
        path: &PathView<'_>,
        plan: &[f64],
        state: &mut SpeedState,
        at: &Located,
        sensed: Sensed,
    ) -> SpeedCommand {
        let dt = at.dt;
        let speed = at.mirror(sensed.speed);
        self.turn_round(path, at, state, speed);
        let planned = self.planned(path, plan, at.closest.segment);
        let now = self.situation(&planned, at, state, (speed, sensed.age));
        self.wait(&planned, state, &now, at, sensed.reverse_gear);
        let held = state.standing || state.waits.0 > 0.0 || state.waits.1 > 0.0;
        let halted = sensed.stop || state.rolls;
        let needed = now.deceleration(OVERRUN.0 + OVERRUN.1 * self.car.wheelbase);
        let lawful = self.lawful(&now);
        let lawful = if state.shifting && sensed.reverse_gear.is_none() {
            // Softly, as the gear may not be in yet.
            smaller(lawful, 0.5 * self.accelerations.0 - now.push)
        } else {
            lawful
        };
        let command = if held || halted {
            smaller(self.hold(&now), lawful)
        } else {
            lawful
        };
        state.acceleration = self.limited(state.acceleration, command, &now, held || halted, dt);
        let before = state.overruns || state.reverse.is_none();
        state.overruns = self.overruns(&planned, &now, needed, state.standing);
        state.reverse = Some(at.reverse);
        let standing = held && !halted || halted && now.speed.abs() < REST;
        let wanted = Wanted {
            acceleration: state.acceleration,
            plan: now.target + larger(now.change, 0.0) * dt,
            standing: standing || halted,
        };
        SpeedCommand {
            acceleration: state.acceleration,
            speed: state.servo.step(&self.car, now.speed, wanted, dt),
            reference_speed: now.reference,
            distance_to_stop: now.stop.0,
            reverse: at.reverse != state.rolls,
            standing,
            cannot_stop: state.overruns && before,
            phase: Self::phase(state, &now, halted),
            status: Status::OK,
        }
    }

    /// The acceleration by the law, within the vehicle's, and harder where it would overrun its stop [m/s²].
    fn lawful(&self, now: &Situation) -> f64 {
        let (driving, braking) = self.accelerations;
        let reserve = self.params.reserve;
        let wanted = now.change + self.correction(now.target - now.z);
        let passing = if now.z > CREEP * self.car.wheelbase {
            now.deceleration(self.arrived())
        } else {
            0.0
        };
        let wanted = if passing > braking {
            smaller(wanted, -passing)
        } else {
            wanted
        };
        saturate(
            wanted,
            -larger(braking + reserve, passing),
            driving + reserve,
        ) - now.push
    }

    /// The `command` within the jerk of the `last` one, and what the brakes can do [m/s²]. At rest brakes that
    /// are applied jerk nothing, nor does what holds the vehicle against its slope.
    fn limited(&self, last: f64, command: f64, now: &Situation, held: bool, dt: f64) -> f64 {
        let jerk = self.params.max_jerk * dt;
        let (mut low, mut high) = (last - jerk, last + jerk);
        if now.speed.abs() < REST {
            low = if held { -self.brakes } else { low };
            high = larger(last, -now.push) + jerk;
        }
        saturate(larger(command, -self.brakes), low, larger(high, low))
    }

    /// The acceleration that corrects an `error` of the speed [m/s]: `kp` times it, and of a large one no more
    /// than the jerk takes back in time, `sqrt(2 J (|e| - J / 2 kp²))` where `kp² |e| > J`.
    fn correction(&self, error: f64) -> f64 {
        let (gain, jerk) = (self.params.kp, self.params.max_jerk);
        let linear = gain * error;
        if gain * linear.abs() <= jerk {
            return linear;
        }
        let most = sqrt(2.0 * jerk * (error.abs() - 0.5 * jerk / (gain * gain)));
        saturate(linear, -most, most)
    }

    fn phase(state: &SpeedState, now: &Situation, halted: bool) -> Phase {
        if state.rolls {
            Phase::Shifting
        } else if halted {
            Phase::Stopped
        } else if state.standing {
            Phase::Standing
        } else if state.waits.1 > 0.0 {
            Phase::Shifting
        } else if state.waits.0 > 0.0 {
            Phase::Turning
        } else if now.stops {
            Phase::Stopping
        } else {
            Phase::Driving
        }
    }

    pub(super) fn planned<'a, 'b>(
        &self,
        path: &'a PathView<'b>,
        speeds: &'a [f64],
        segment: usize,
    ) -> Planned<'a, 'b> {
        Planned {
            path,
            speeds,
            segment,
            end: path.section_end(segment),
            between: Between {
                accelerations: self.accelerations,
                most: self.car.max_speed.unwrap_or(defaults::MAX_SPEED),
            },
        }
    }

    /// How far a vehicle goes along its path in `age` [s] until the end of the period `dt` [s] that this
    /// step ends, after the `speed` [m/s] along it [m].
    pub fn gone(&self, state: &SpeedState, speed: f64, age: f64, dt: f64) -> f64 {
        let push = state.observer.disturbance;
        let Some(mut drive) = state.drive else {
            return speed * age;
        };
        drive.elapse(&self.car, state.acceleration, dt, age);
        drive.since(&self.car, speed, push, age).travelled
    }

    /// What is believed of a `speed` signal [m/s] `dt` [s] after the `last`: at most what the brakes make
    /// of the expected speed or of the last signal. So two messages can say anything, and one alone can not.
    pub(crate) fn hear(&self, state: &SpeedState, speed: f64, last: Option<f64>, dt: f64) -> f64 {
        let Some(last) = last else {
            return speed;
        };
        let along = state.observer.speed.unwrap_or(last);
        let expected = if state.reverse == Some(true) {
            -along
        } else {
            along
        };
        let most = self.brakes * dt;
        let (low, high) = (smaller(last, expected), larger(last, expected));
        saturate(speed, low - most, high + most)
    }

    /// The mean acceleration [m/s²] in the `dt` [s] since the last step, by what the drive was commanded, of
    /// a vehicle that had the `speed` [m/s] along its path.
    pub(crate) fn expected(&self, state: &SpeedState, speed: f64, dt: f64) -> f64 {
        let Some(mut drive) = state.drive else {
            return 0.0;
        };
        drive.elapse(&self.car, state.acceleration, dt, dt);
        let moved = drive.since(&self.car, speed, state.observer.disturbance, dt);
        (moved.speed - speed) / dt
    }

    /// The largest change of the acceleration [m/s³].
    pub(crate) fn max_jerk(&self) -> f64 {
        self.params.max_jerk
    }

    /// How far before its stop the vehicle may stand [m].
    fn arrived(&self) -> f64 {
        ARRIVED.0 + ARRIVED.1 * self.car.wheelbase
    }

    /// Where the direction of driving changes, or a first step begins: what was commanded and found out
    /// in the other direction counts turned round, or not.
    fn turn_round(&self, path: &PathView<'_>, at: &Located, state: &mut SpeedState, speed: f64) {
        let rolls = speed < -REST;
        state.passes = None;
        match state.reverse {
            Some(before) if before != at.reverse => {
                let observer = state.observer.turned();
                let drive = state.drive.filter(|_| !rolls);
                let wheels = path.section(at.closest.segment).and_then(|(first, _)| {
                    let end = path.previous(first)?;
                    Some(self.wheels(path, end, path.segment_end(end)))
                });
                *state = SpeedState {
                    acceleration: smaller(state.acceleration, 0.0),
                    drive: drive.or(Some(Drive::settled(&self.car, 0.0))),
                    observer,
                    wheels: wheels.or(Some(0.0)),
                    reverse: state.reverse,
                    rolls,
                    shifting: true,
                    servo: state.servo.turned(),
                    ..SpeedState::default()
                };
            }
            Some(_) => {}
            None => {
                state.drive = Some(Drive::settled(&self.car, 0.0));
                state.wheels = Some(0.0);
                state.rolls = rolls;
                state.shifting = rolls;
            }
        }
    }

    /// The wheels' angle with which the vehicle goes on at `arc` [m] of a segment, as it really is [rad].
    fn wheels(&self, path: &PathView<'_>, segment: usize, arc: f64) -> f64 {
        let angle = wheel_at_rest(&self.car, path, segment, arc);
        if path.is_reverse(segment) {
            -angle
        } else {
            angle
        }
    }

    /// Where the vehicle is on its plan, and what the plan wants there; brings the estimates of
    /// `state` up to date.
    fn situation(
        &self,
        planned: &Planned<'_, '_>,
        at: &Located,
        state: &mut SpeedState,
        (measured, age): (f64, f64),
    ) -> Situation {
        let (car, dt) = (&self.car, at.dt);
        let arc = at.closest.arc_length(planned.path);
        let (squared, _, grade) = planned.at(arc);
        let known = gravity_along(grade);
        let mut drive = state.drive.unwrap_or(Drive::settled(car, 0.0));
        let (mean, given) = drive.elapse(car, state.acceleration, dt, age);
        let push = known + state.observer.disturbance;
        let speed = drive.since(car, measured, push, age).speed;
        state.drive = Some(drive);
        // Brakes that hold say nothing.
        let held = state.rolls || (speed.abs() < REST && given.pull <= 0.0);
        let full = state.acceleration + push > 0.5 * self.accelerations.0;
        let model = (
            car.drive_lag,
            self.params.disturbance_time,
            self.accelerations.1,
        );
        let acted = (mean, given, state.acceleration);
        state
            .observer
            .step(speed, known, acted, (held, full), model, dt);

        let stop = self.stop_ahead(planned, at, state, speed);
        let push = known + state.observer.disturbance;
        let then = drive.predict(car, speed, push);
        let lag = car.drive_lag;
        // One that its brakes hold has no acceleration.
        let gains = if then.speed > 0.0 {
            then.pull + push
        } else {
            larger(then.pull + push, 0.0)
        };
        let z = then.speed + lag * gains;
        let ahead = then.travelled + lag * then.speed;
        let y = stop.1 - ahead;
        let (target, change, stops) = self.target(planned, arc + ahead, y, z, dt);
        let creep = CREEP * car.wheelbase;
        Situation {
            speed,
            push: gravity_along(planned.at(arc + ahead).2) + state.observer.disturbance,
            stop,
            then,
            y,
            z,
            target,
            change,
            stops,
            reference: larger(sqrt(squared), smaller(creep, self.curve(stop.1, dt).0)),
        }
    }

    /// `z*` and its change in time at `arc` [m], with `y` [m] to the stop, and whether the stop binds.
    fn target(
        &self,
        planned: &Planned<'_, '_>,
        arc: f64,
        y: f64,
        z: f64,
        dt: f64,
    ) -> (f64, f64, bool) {
        // The command holds for a period: in its middle.
        let half = 0.5 * dt * larger(z, 0.0);
        let (squared, _, _) = planned.at(arc);
        let (_, slope, _) = planned.at(arc + half);
        let along = larger(sqrt(squared), CREEP * self.car.wheelbase);
        let (curve, _) = self.curve(y, dt);
        let (_, braking) = self.curve(y - half, dt);
        let (target, change, stops) = if curve < along {
            (curve, -braking, true)
        } else {
            (along, slope, false)
        };
        // dz*/ds z, which a vehicle that is slower than its plan does not brake by.
        let ratio = if change < 0.0 && target > 0.0 {
            saturate(z / target, 0.0, 2.0)
        } else {
            1.0
        };
        (target, change * ratio, stops)
    }

    /// `T`: how long the end of a stop takes, in which the deceleration fades [s].
    fn end_time(&self, dt: f64) -> f64 {
        let response = self.car.drive_delay + self.car.drive_lag + dt;
        larger(self.accelerations.1 / self.params.max_jerk, SOFT * response)
    }

    /// The speed from which the vehicle still stops within `y` [m], and its deceleration.
    fn curve(&self, y: f64, dt: f64) -> (f64, f64) {
        let (braking, time) = (self.accelerations.1, self.end_time(dt));
        let (jerk, end) = (braking / time, braking * time * time / 6.0);
        if y <= 0.0 {
            (0.0, braking)
        } else if y < end {
            let t = powf(6.0 * y / jerk, 1.0 / 3.0);
            (0.5 * jerk * t * t, jerk * t)
        } else {
            let slow = 0.5 * braking * time;
            (sqrt(slow * slow + 2.0 * braking * (y - end)), braking)
        }
    }

    /// The distance to the next stop [m], as measured and as `D`; infinite if there is none. A stop that
    /// is known stays, also where it is overrun, until a path is set without it.
    fn stop_ahead(
        &self,
        planned: &Planned<'_, '_>,
        at: &Located,
        state: &mut SpeedState,
        speed: f64,
    ) -> (f64, f64) {
        let path = planned.path;
        let leaves = LEAVES.0 + LEAVES.1 * self.car.wheelbase;
        let rear = at.closest.arc_length(path);
        let lead = if at.reverse {
            0.0
        } else {
            self.car.stop_offset()
        };
        let from = Planned {
            segment: path
                .segment_by_arc(saturate(rear + lead, 0.0, path.length()), planned.segment),
            ..*planned
        };
        // Cusps are the rear axle's.
        let is_last = |waypoint: usize| {
            planned
                .end_stop(rear)
                .is_some_and(|(end, _)| end == waypoint)
        };
        let ends = |waypoint: usize| waypoint + 1 == path.len() && !path.is_closed();
        let arc = |waypoint: usize| {
            let cusp = is_last(waypoint) && !ends(waypoint);
            rear + if cusp { 0.0 } else { lead }
        };
        let gone = 0.5 * (state.speed + speed) * at.dt;
        let expected = state.stop.map(|(_, _, last)| last - gone);
        state.speed = speed;
        let kept = state
            .stop
            .zip(expected)
            .map(|((waypoint, _, _), expected)| {
                (
                    waypoint,
                    planned.distance(waypoint, arc(waypoint), expected),
                )
            });
        let next = from.next_stop(rear + lead, leaves, self.accelerations.1);
        let next =
            next.map(|(waypoint, distance)| (waypoint, distance + rear + lead - arc(waypoint)));
        let found = match (kept, next) {
            (Some(one), Some(other)) => Some(if one.1 <= other.1 { one } else { other }),
            (one, other) => one.or(other),
        };
        let Some((waypoint, measured)) = found else {
            state.stop = None;
            return (f64::INFINITY, f64::INFINITY);
        };
        let zero = planned.stays_at_zero();
        let measured = if zero {
            smaller(measured, 0.0)
        } else {
            measured
        };
        let same = state.stop.is_some_and(|(known, _, _)| known == waypoint);
        let steady = steady(measured, expected.filter(|_| same), JUMP * leaves);
        let place = path.waypoint(waypoint);
        state.stop = Some((waypoint, (place.x, place.y), steady));
        (measured, steady)
    }

    /// Whether the vehicle is held at its stop, or until its wheels are turned and its gear is in.
    fn wait(
        &self,
        planned: &Planned<'_, '_>,
        state: &mut SpeedState,
        now: &Situation,
        at: &Located,
        gear: Option<bool>,
    ) {
        let (car, still) = (&self.car, now.speed.abs() < REST);
        if now.speed >= -REST {
            state.rolls = false;
        }
        if now.speed > REST {
            state.shifting = false;
        }
        if state.shifting && !state.rolls && now.speed < -REST {
            // It still rolls; or the drive moves it the wrong way, as its gear is not in.
            state.rolls = true;
            state.waits.1 = SHIFT.1;
        }
        state.still = if still {
            smaller(state.still + at.dt, MAX_DT)
        } else {
            0.0
        };
        let leaves = LEAVES.0 + LEAVES.1 * car.wheelbase;
        // The distance to the stop at which it would come to rest now.
        let short = now.stop.1 - now.then.travelled - self.way_to_rest(now, state.acceleration);
        let (moves, arrived) = (now.speed > REST, self.arrived());
        let ends = now.then.speed <= 0.5 * self.accelerations.1 * self.end_time(at.dt);
        state.standing = match state.standing {
            true if moves => short <= 2.0 * arrived,
            true => now.stop.1 <= leaves,
            // At the end of the curve: before, what would bring it to rest sooner may yet change.
            false => !state.rolls && ends && now.stop.1.is_finite() && short <= arrived,
        };
        if let Some(angle) = state.wheels {
            let time = if still {
                self.turn_time(planned.path, at, angle)
            } else {
                0.0
            };
            state.waits.0 = larger(state.waits.0, time);
            state.wheels = None;
        } else if still {
            state.waits.0 = larger(state.waits.0 - at.dt, 0.0);
            state.waits.1 = larger(state.waits.1 - at.dt, 0.0);
        } else if now.speed > REST {
            state.waits.0 = 0.0;
        }
        if let Some(reverse) = gear {
            state.waits.1 = if reverse == at.reverse {
                0.0
            } else {
                larger(state.waits.1, at.dt)
            };
        }
        let cusp = planned
            .end
            .zip(planned.end_stop(0.0))
            .filter(|_| state.standing && state.still >= SHIFT.0);
        state.passes = cusp.and_then(|(end, (waypoint, _))| {
            let is_here = state.stop.is_some_and(|(stop, _, _)| stop == waypoint);
            planned.path.next_segment(end).filter(|_| is_here)
        });
    }

    /// How long the wheels take from `angle` [rad] to that with which the path goes on [s].
    fn turn_time(&self, path: &PathView<'_>, at: &Located, angle: f64) -> f64 {
        let car = &self.car;
        if !car.steers_at_rest {
            return 0.0;
        }
        let closest = &at.closest;
        let turn = (self.wheels(path, closest.segment, closest.arc_length(path)) - angle).abs();
        if turn < TURN.0 {
            return 0.0;
        }
        let rate = car.max_steer_rate.unwrap_or(f64::INFINITY);
        smaller(car.dead_time + TURN.1 * car.steer_lag + turn / rate, MAX_DT)
    }

    /// How far the vehicle goes until it rests [m], from when the command begins to act, if it brakes with
    /// the planned deceleration, to which the `last` command [m/s²] changes within the jerk.
    fn way_to_rest(&self, now: &Situation, last: f64) -> f64 {
        let (from, lag) = (now.then, self.car.drive_lag);
        if from.speed <= 0.0 {
            return 0.0;
        }
        let braking = self.accelerations.1;
        let command = -braking - now.push;
        let ramp = 0.5 * larger(last - command, 0.0) / self.params.max_jerk;
        let longest = (from.speed + lag * larger(from.pull - command, 0.0)) / braking;
        let (mut low, mut high) = (0.0, longest);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let rests = from.after(command, now.push, lag, middle).speed <= 0.0;
            (low, high) = if rests { (low, middle) } else { (middle, high) };
        }
        let rest = Motion {
            travelled: 0.0,
            ..from
        }
        .after(command, now.push, lag, low);
        rest.travelled + from.speed * ramp
    }

    /// The acceleration that brings the vehicle to rest and holds it [m/s²].
    fn hold(&self, now: &Situation) -> f64 {
        let (_, braking) = self.accelerations;
        if now.speed > REST {
            -braking - now.push
        } else if now.speed < -REST {
            // Along the way that it rolls.
            -braking + now.push
        } else {
            -larger(HOLD.0 * self.brakes, HOLD.1 * now.push.abs())
        }
    }

    /// Whether the vehicle overruns its stop with all that its brakes do, or cannot stay there.
    fn overruns(
        &self,
        planned: &Planned<'_, '_>,
        now: &Situation,
        needed: f64,
        stands: bool,
    ) -> bool {
        let (_, distance) = now.stop;
        if distance == f64::INFINITY {
            return false;
        }
        let beyond = OVERRUN.0 + OVERRUN.1 * self.car.wheelbase;
        let (_, _, grade) = planned.at(planned.path.arc(planned.segment) + larger(distance, 0.0));
        let slips = now.stops && gravity_along(grade).abs() > self.brakes;
        let moves = now.speed > REST && now.z > 0.0 && needed > self.brakes - now.push;
        moves || slips || (stands && distance < -beyond)
    }

    /// The path `new` replaces `old`, where the vehicle was beside segment `from` and is beside segment
    /// `to`. A stop that `new` has at the same place stays, whatever its waypoint.
    pub fn set_path(
        &self,
        state: &mut SpeedState,
        (old, from): (&PathView<'_>, usize),
        (new, to): (&PathView<'_>, usize),
    ) {
        if state.standing || state.waits.0 > 0.0 {
            state.wheels = Some(self.wheels(old, from, old.segment_end(from)));
        }
        let leaves = LEAVES.0 + LEAVES.1 * self.car.wheelbase;
        let Some((waypoint, (x, y), distance)) = state.stop.take() else {
            return;
        };
        let is_line = |path: &PathView<'_>, index: usize| {
            let speed = path.speed().and_then(|speed| speed.get(index));
            speed.is_some_and(|&speed| speed == 0.0)
        };
        let stays = |&index: &usize| {
            let off = new.waypoint(index) - Point::new(x, y);
            is_line(new, index) && off.dot(&off) <= leaves * leaves
        };
        let near = |&index: &usize| index.abs_diff(to);
        let found = if is_line(old, waypoint) {
            (0..new.len()).filter(stays).min_by_key(near)
        } else {
            None
        };
        state.stop = found.map(|index| (index, (x, y), distance));
        state.standing &= found.is_some();
    }

    /// Whether `state` is one that this law could have on `path`.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the field that is not.
    pub fn check_state(&self, path: &PathView<'_>, state: &SpeedState) -> Result<(), InputError> {
        input_within("acceleration", state.acceleration, ACCELERATION_BOUND)?;
        input_within("speed", state.speed, SPEED_BOUND)?;
        if let Some(drive) = &state.drive {
            drive.check(ACCELERATION_BOUND)?;
        }
        state.observer.check(ACCELERATION_BOUND)?;
        if let Some((waypoint, (x, y), distance)) = state.stop {
            path.check_waypoint("stop", Some(waypoint))?;
            for number in [x, y] {
                input_within("stop", number, MAX_COORDINATE)?;
            }
            input_within("stop", distance, 4.0 * MAX_COORDINATE)?;
        }
        input_in_range("still", state.still, 0.0, MAX_DT)?;
        input_in_range("waits", state.waits.0, 0.0, MAX_DT)?;
        input_in_range("waits", state.waits.1, 0.0, MAX_DT)?;
        let wheels = state.wheels.unwrap_or(0.0);
        input_within("wheels", wheels, core::f64::consts::FRAC_PI_2)?;
        path.check_waypoint("passes", state.passes)?;
        state.servo.checked()
    }
}

/// The distance to a stop [m] without most of the noise: `measured`, and as the speed has it since the last
/// step. Farther off than a `jump` the localisation has jumped.
fn steady(measured: f64, expected: Option<f64>, jump: f64) -> f64 {
    match expected {
        Some(expected) if (measured - expected).abs() < jump => {
            expected + POSE_SHARE * (measured - expected)
        }
        _ => measured,
    }
}

impl Situation {
    /// The deceleration with which the vehicle comes to rest `beyond` its stop [m/s²].
    fn deceleration(&self, beyond: f64) -> f64 {
        let room = self.y + beyond;
        if self.z <= 0.0 {
            0.0
        } else if room <= 0.0 {
            f64::INFINITY
        } else {
            self.z * self.z / (2.0 * room)
        }
    }
}
