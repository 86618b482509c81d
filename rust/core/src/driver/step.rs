//! A driver, and its control step.

use super::command::Drive;
use super::signals::{Sensed, Signals, Steered};
use super::state::DriverState;
use crate::bounds::{MAX_DT, MAX_SPEED, MAX_YAW, MIN_DT};
use crate::error::{ConfigError, InputError, input_within};
use crate::laws::LateralLaw;
use crate::params;
use crate::path::{Follow, Located, PathView, Place};
use crate::speed::{self, SpeedCommand, SpeedState, SpeedTracker};
use crate::status::Status;
use crate::tracker::seen::Seen;
use crate::tracker::{Predicted, Reported, Tracker, TrackerState};
use crate::vehicle::past::checked_age;
use crate::vehicle::{Estimate, Fault, Gate, Vehicle, VehicleState};

/// The longest time that counts in one step [s]: what happened in a longer one is not known, and a
/// clock may have jumped. Larger: after such a jump the vehicle is looked for too far along its path.
const LONGEST: f64 = 1.0;
/// How many steps in a row no time may pass before the clock is taken to stand. Smaller: a loop is
/// refused that is so much faster than its clock.
const REPEATS: usize = 100;

params! {
    /// Parameters of [`Driver`].
    pub struct DriverParams {
        /// How long a signal that does not come is replaced by what is expected before that is a
        /// fault [s]. Longer: more gaps are bridged. Shorter: a dead sensor is known sooner.
        hold_time: f64 = 0.5, in [0.0, 1e3];
    }
}

/// Steers and drives a vehicle along a path, and stops it where something is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driver<L> {
    tracker: Tracker<L>,
    speed: SpeedTracker,
    params: DriverParams,
    /// How the rear axle, which stops, follows the path.
    rear: Follow,
}

impl<L: LateralLaw> Driver<L> {
    /// A driver whose `tracker` steers and whose law of the `speed` drives the same vehicle.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn new(
        tracker: Tracker<L>,
        speed: SpeedTracker,
        params: DriverParams,
    ) -> Result<Self, ConfigError> {
        Ok(Self {
            tracker: tracker.driving(),
            speed,
            params: params.checked()?,
            rear: *speed.follow(),
        })
    }

    /// What steers.
    pub fn tracker(&self) -> &Tracker<L> {
        &self.tracker
    }

    /// What drives.
    pub fn speed(&self) -> &SpeedTracker {
        &self.speed
    }

    /// The vehicle.
    pub fn vehicle(&self) -> &Vehicle {
        self.tracker.vehicle()
    }

    /// The parameters.
    pub fn params(&self) -> &DriverParams {
        &self.params
    }

    /// The state before the first step, with straight wheels.
    pub fn initial_state(&self) -> DriverState<L::State> {
        Self::starting(self.tracker.initial_state())
    }

    /// The state before the first step of a vehicle whose wheels are at the angle `steer` [rad].
    ///
    /// # Errors
    ///
    /// [`InputError`] where `steer` is not within `max_steer`.
    pub fn state_from(&self, steer: f64) -> Result<DriverState<L::State>, InputError> {
        self.tracker.state_from(steer).map(Self::starting)
    }

    fn starting(tracker: TrackerState<L::State>) -> DriverState<L::State> {
        DriverState {
            tracker,
            speed: SpeedState::default(),
            heard: None,
            signals: Signals::default(),
            pace: None,
            fault: None,
            held: false,
            doubt: None,
        }
    }

    /// One control step on `path`, whose planned speeds are `plan` [m/s]: what was `sensed` `dt` [s]
    /// after the last step.
    ///
    /// Never fails. A number that is not finite or beyond its bound has not come; a `dt` that
    /// is none, as of a stamp that repeats or of a clock that goes back, is no time, and one over
    /// 1 s counts as that.
    pub fn step(
        &self,
        path: &PathView<'_>,
        plan: &[f64],
        state: &mut DriverState<L::State>,
        sensed: Sensed,
        dt: f64,
    ) -> Drive {
        // Clock: the time that passes is what is given.
        let Some(dt) = clock(&mut state.signals, dt) else {
            return self.repeat(state);
        };
        // Belief: what came, and what is expected where it did not, or is not believed.
        let Some((vehicle, reported)) = self.complete(state, &sensed, dt) else {
            return self.repeat(state);
        };
        // Place: where on the path that is. From an old pose it is where the drive has moved it since.
        let comes = state.signals.has_pose();
        let TrackerState { tracking, model } = &mut state.tracker;
        let (law, age) = (self.speed.law(), reported.pose_age);
        let moved = |speed| Some(law.moved(&state.speed, speed, age, dt));
        let came = (reported, comes, moved);
        let seen = self.tracker.see(path, tracking, model, vehicle, dt, came);
        state.signals.believed = Some(seen.here);
        self.judge(state, &seen);
        // Speed law: what do the pedals do? It stops for a fault as for its operator.
        let travelled = seen.here.speed.abs() * dt;
        let rear = self.rear.offset(path, &seen.located, seen.here, travelled);
        let speed = self
            .tracker
            .estimate(&state.tracker)
            .speed_of(vehicle.speed);
        let pace = self.pace(
            path,
            plan,
            state,
            &rear,
            (speed, sensed.gear, reported.pose_age),
        );
        // Steering law and limits: which angle, as far as the wheels can.
        let straight = state.fault.is_some_and(|fault| !fault.steers());
        let tracking = &mut state.tracker.tracking;
        let status = self.tracker.turn(path, tracking, &seen, straight);
        if let Some(segment) = state.speed.passes {
            // It stands at a cusp, and goes on behind it.
            tracking.place = Place::at(path, segment);
        }
        let held = Status::INPUT_HELD.when(state.signals.is_incomplete());
        Drive::of(&tracking.command(status | held), &pace, state.fault)
    }

    /// What the pedals do, for a vehicle whose rear axle is located, its `speed` [m/s] believed, its gear
    /// reported or not, and both an age [s] old.
    fn pace(
        &self,
        path: &PathView<'_>,
        plan: &[f64],
        state: &mut DriverState<L::State>,
        rear: &Located,
        (speed, reverse_gear, age): (f64, Option<bool>, f64),
    ) -> SpeedCommand {
        let law = self.speed.law();
        let noise = Gate::noise_of(state.tracker.tracking.gate.as_ref());
        let last = state.heard.replace(speed);
        let sensed = speed::Sensed {
            speed: law.hear(&state.speed, speed, last, (noise.1, rear.dt)),
            age,
            noise,
            reverse_gear,
            stop: self.halts(state),
        };
        let command = law.step(path, plan, &mut state.speed, rear, sensed);
        // One value alone that is wrong is a glitch: what it would mean waits for the next.
        let doubt = command.cannot_stop.then_some(Fault::CannotStop);
        let found = doubt.filter(|_| doubt == state.doubt);
        state.doubt = doubt;
        state.fault = state.fault.or(found);
        *state.pace.insert(command)
    }

    /// The vehicle of a step and what it reports; None before anything is known of it.
    fn complete(
        &self,
        state: &mut DriverState<L::State>,
        sensed: &Sensed,
        dt: f64,
    ) -> Option<(VehicleState, Reported)> {
        let car = self.vehicle();
        let usable = |angle: &f64| angle.abs() <= core::f64::consts::FRAC_PI_2;
        let given = sensed.reported;
        let age = checked_age(given.pose_age);
        let antenna = match age {
            Ok(_) => sensed.vehicle,
            // A pose of no age that can be is none.
            Err(_) => VehicleState {
                x: f64::NAN,
                y: f64::NAN,
                yaw: f64::NAN,
                speed: f64::NAN,
            },
        };
        let reported = Reported {
            applied_steer: given.applied_steer.filter(usable),
            measured_steer: given.measured_steer.filter(usable),
            pose_age: age.unwrap_or(0.0),
            roll: Some(given.roll).filter(usable).unwrap_or(0.0),
        };
        let reported = reported.checked(car).unwrap_or(Reported::NOTHING);
        let DriverState {
            tracker,
            speed,
            signals,
            ..
        } = state;
        let begun = signals.believed.is_some();
        let before = signals.believed.map_or(0.0, |last| last.speed);
        let known = tracker.model.estimator.estimate;
        let quicker = known.quicker(car);
        // Made only where something is missing: the commands in flight are many.
        let steered = || {
            let expected = self.speed.law().expected(speed, before, dt);
            Steered {
                car: quicker.as_ref().unwrap_or(car),
                noise: Gate::noise_of(tracker.tracking.gate.as_ref()).0,
                in_flight: tracker.model.in_flight.as_ref(),
                steer: tracker.tracking.steer,
                estimate: Estimate {
                    acceleration: expected,
                    ..known
                },
            }
        };
        let last = signals.believed;
        let vehicle = located(car, antenna, last, reported.roll);
        let (age, fault) = (reported.pose_age, state.fault);
        let mut vehicle = signals.complete(steered, vehicle, (age, fault), dt);
        if signals.speed > 0.0 {
            // What the signal would say of the expected speed.
            vehicle = known.told(vehicle).bounded();
        }
        (begun || !state.signals.is_incomplete()).then_some((vehicle, reported))
    }

    /// Notes what is wrong: the first fault stays.
    fn judge(&self, state: &mut DriverState<L::State>, seen: &Seen) {
        if state.fault.is_some() {
            return;
        }
        let signal = state.tracker.tracking.fault(self.vehicle());
        let missing = state.signals.fault(self.params.hold_time);
        let is = |status, fault| seen.status.contains(status).then_some(fault);
        let off = is(Status::DEVIATING, Fault::Deviation).or(is(Status::OFF_PATH, Fault::Path));
        state.fault = signal.or(missing).or(off);
        let gate = state.tracker.tracking.gate.as_ref();
        if let (Some(Fault::Speed), Some(gate), Some(believed)) =
            (state.fault, gate, &mut state.signals.believed)
        {
            // What the poses show goes on from the speed that they showed last.
            believed.speed = gate.believed.speed;
        }
    }

    /// The last answer once more, where no time passes or nothing is known: at rest before the first.
    fn repeat(&self, state: &mut DriverState<L::State>) -> Drive {
        let stopped = state.signals.repeats > REPEATS;
        let mut pace = SpeedCommand::WAITING;
        if let Some(last) = state.pace {
            pace = last;
            let missing = state.signals.fault(self.params.hold_time);
            state.fault = state.fault.or(stopped.then_some(Fault::Input)).or(missing);
            if stopped || state.signals.believed.is_none() {
                // Without a clock, or anything known after a release, there is no other way to stop.
                pace.acceleration = -self.vehicle().comfort_braking();
                pace.speed = 0.0;
            }
        }
        let command = state.tracker.tracking.command(Status::INPUT_HELD);
        Drive::of(&command, &pace, state.fault)
    }

    /// Forgets the fault for which the vehicle stopped, and looks for it anew about its last place.
    /// Gives the fault.
    pub fn release(&self, state: &mut DriverState<L::State>) -> Option<Fault> {
        let fault = state.fault.take();
        if fault.is_some() {
            let place = state.tracker.tracking.place.lost();
            state.tracker.jump_to(place);
            state.signals = Signals {
                believed: None,
                ..Signals::default()
            };
            state.doubt = None;
        }
        fault
    }

    /// The path `new` replaces `old`; its plan replaces the old one. As
    /// [`Tracker::set_path`]; the stop of a vehicle at rest goes on until the path does.
    pub fn set_path(
        &self,
        state: &mut DriverState<L::State>,
        old: &PathView<'_>,
        new: &PathView<'_>,
    ) {
        let tracking = &mut state.tracker.tracking;
        let before = tracking.place.segment();
        self.tracker.set_path(tracking, old, new);
        if let (Some(from), Some(to)) = (before, tracking.place.segment()) {
            let law = self.speed.law();
            law.set_path(&mut state.speed, (old, old.segment_at(from)), (new, to));
        }
    }

    /// The trajectory that the vehicle is to take, as [`Tracker::predict`], at the speeds by the law: a copy of
    /// this driver drives the estimated vehicle, whose drive has its delay and lag.
    ///
    /// # Errors
    ///
    /// [`InputError`] where `dt` is no control period.
    pub fn predict(
        &self,
        path: &PathView<'_>,
        plan: &[f64],
        state: &DriverState<L::State>,
        dt: f64,
        out: &mut [Predicted],
    ) -> Result<usize, InputError> {
        let (law, mut speed) = (self.speed.law(), state.speed);
        let straight = state.fault.is_some_and(|fault| !fault.steers());
        let noise = Gate::noise_of(state.tracker.tracking.gate.as_ref());
        let stop = self.halts(state);
        let drive = |vehicle: VehicleState, seen: Option<&Seen>| {
            let mut passes = None;
            if let Some(seen) = seen {
                let travelled = vehicle.speed.abs() * dt;
                let rear = self.rear.offset(path, &seen.located, vehicle, travelled);
                let sensed = speed::Sensed {
                    speed: vehicle.speed,
                    age: 0.0,
                    noise,
                    reverse_gear: Some(rear.reverse),
                    stop,
                };
                law.step(path, plan, &mut speed, &rear, sensed);
                passes = speed.passes;
            }
            Some((law.expected(&speed, vehicle.speed, dt), passes))
        };
        self.tracker
            .predict_driven(path, &state.tracker, dt, out, straight, drive)
    }

    /// The deceleration with which the vehicle is to stop [m/s²], for its fault or its operator.
    fn halts(&self, state: &DriverState<L::State>) -> Option<f64> {
        match state.fault {
            Some(fault) if fault.is_urgent() => Some(self.vehicle().strongest_braking()),
            fault => (state.held || fault.is_some()).then(|| self.vehicle().comfort_braking()),
        }
    }

    /// Whether `state` is one that this driver could have on `path`.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the field that is not.
    pub fn check_state(
        &self,
        path: &PathView<'_>,
        state: &DriverState<L::State>,
    ) -> Result<(), InputError> {
        self.tracker.check_state(path, &state.tracker)?;
        self.speed.law().check_state(path, &state.speed)?;
        state.pace.as_ref().map(SpeedCommand::check).transpose()?;
        input_within("heard", state.heard.unwrap_or(0.0), MAX_SPEED)?;
        state.signals.checked()
    }
}

/// The pose of the vehicle's point by that of its antenna; where no heading comes, by the `last` one.
fn located(
    car: &Vehicle,
    antenna: VehicleState,
    last: Option<VehicleState>,
    roll: f64,
) -> VehicleState {
    let known = last.map_or(0.0, |last| last.yaw);
    let yaw = if antenna.yaw.abs() <= MAX_YAW {
        antenna.yaw
    } else {
        known
    };
    match (VehicleState {
        yaw,
        speed: 0.0,
        ..antenna
    })
    .checked()
    {
        Ok(given) => {
            let VehicleState { x, y, .. } = given.left(-car.antenna_offset(roll));
            VehicleState { x, y, ..antenna }
        }
        // No position has come.
        Err(_) => antenna,
    }
}

/// The time that a step counts [s]; None where no time has passed.
fn clock(signals: &mut Signals, dt: f64) -> Option<f64> {
    if !(MIN_DT..=MAX_DT).contains(&dt) {
        signals.repeats = signals.repeats.saturating_add(1);
        return None;
    }
    signals.repeats = 0;
    Some(if dt < LONGEST { dt } else { LONGEST })
}
