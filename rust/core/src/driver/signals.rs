//! What a step is given, and what stands in for a signal that does not come or is not believed.
//!
//! # Equations
//!
//! From one step to the next the vehicle is expected to go where its wheels and its drive take it
//! (dead reckoning): with the wheels by the commands in flight, and the acceleration `a` that was
//! commanded last,
//!
//! ```text
//! expected = rollout(believed, wheels, a, dt)
//! ```
//!
//! A signal that is missing, or that a fault names, has its expected value. The speed is then corrected
//! by the poses, if these come: with the distance `e` that they went farther along the heading than
//! expected, `T` after the last one,
//!
//! ```text
//! speed = expected speed + β e / T,      β = 1 - exp(-T / SPEED_TIME)
//! ```
//!
//! which is an α-β filter (Kalata 1984) with `α = 1`: poses that pass are not smoothed. Once a fault is
//! known, so is a heading that does not come: by the distance `f` that they are left of the expected
//! place, after the distance `d`,
//!
//! ```text
//! heading = expected heading + β f / d,      β = 1 - exp(-|d| / reach),   reach = REACH (wheelbase, σ)
//! ```
//!
//! with the noise `σ` of the position. Before, the wheels turn the expected heading: of one found in noise
//! the monitor would think that they do not.

use crate::bounds::{MAX_COORDINATE, MAX_DT, MAX_SPEED, MAX_YAW, MIN_DT};
use crate::error::{InputError, input_in_range, input_within};
use crate::geometry::Point;
use crate::math::{cos, decay, saturate, sin, tan};
use crate::tracker::Reported;
use crate::vehicle::bicycle::{Rollout, advance};
use crate::vehicle::past::MAX_POSE_AGE;
use crate::vehicle::timed::clipped;
use crate::vehicle::{Estimate, Fault, InFlight, Vehicle, VehicleState};

/// Time constant of a speed that is found by the poses [s]. Larger: it is learnt later that brakes act
/// otherwise than commanded. Smaller: it has the noise of the poses.
const SPEED_TIME: f64 = 0.3;
/// The distance over which a heading is found, in wheelbases and in standard deviations of the position's
/// noise. Larger: one that was askew is put right later. Smaller: it is as noisy as the poses.
const REACH: (f64, f64) = (0.2, 20.0);

/// What is given to a step; a number that is not finite, or beyond its bound, has not come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensed {
    /// Pose of the vehicle's point, and speed.
    pub vehicle: VehicleState,
    /// What the vehicle reports besides.
    pub reported: Reported,
    /// The gear that is in, whether reverse; None where the vehicle does not report it.
    pub gear: Option<bool>,
}

impl From<VehicleState> for Sensed {
    fn from(vehicle: VehicleState) -> Self {
        Self {
            vehicle,
            reported: Reported::NOTHING,
            gear: None,
        }
    }
}

/// How long each signal has been missing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Signals {
    /// The vehicle as it was believed to be at the last step; None before the first.
    pub believed: Option<VehicleState>,
    /// For how long its position has been missing [s].
    pub position: f64,
    /// The same of its heading.
    pub heading: f64,
    /// The same of its speed.
    pub speed: f64,
    /// The heading [rad] and the speed [m/s] that came last; None where none has.
    pub last: (Option<f64>, Option<f64>),
    /// The position that came last [m]; None where none has.
    pub place: Option<Point>,
    /// How many steps in a row no time has passed.
    pub repeats: usize,
}

/// The wheels as they are steered meanwhile.
pub(super) struct Steered<'a> {
    pub(super) car: &'a Vehicle,
    /// Standard deviation of the position's noise [m].
    pub(super) noise: f64,
    pub(super) in_flight: Option<&'a InFlight>,
    /// The last command [rad].
    pub(super) steer: f64,
    /// The estimates, with the acceleration that was commanded.
    pub(super) estimate: Estimate,
}

impl Signals {
    /// The vehicle for a step that is `dt` [s] after the last: what was `sensed`, and what is expected
    /// where that is missing or `blamed`. Its pose is `pose_age` [s] old, as the sensed one.
    pub(super) fn complete<'a>(
        &mut self,
        steered: impl FnOnce() -> Steered<'a>,
        sensed: VehicleState,
        (pose_age, blamed): (f64, Option<Fault>),
        dt: f64,
    ) -> VehicleState {
        let within = |value: f64, bound: f64| value.abs() <= bound;
        let has_position = within(sensed.x, MAX_COORDINATE) && within(sensed.y, MAX_COORDINATE);
        let position = has_position && blamed != Some(Fault::Position);
        // A localisation that is frozen repeats its heading and its speed, too.
        let repeats = |last: Option<f64>, now: f64| {
            blamed == Some(Fault::Position)
                && last.is_some_and(|last| last.to_bits() == now.to_bits())
        };
        let (yaw, pace) = (
            Some(sensed.yaw).filter(|yaw| within(*yaw, MAX_YAW)),
            Some(sensed.speed).filter(|speed| within(*speed, MAX_SPEED)),
        );
        let frozen = (
            repeats(self.last.0, sensed.yaw),
            repeats(self.last.1, sensed.speed),
        );
        self.last = (yaw, pace);
        let gone = position.then(|| self.gone(sensed)).flatten();
        let heading = yaw.is_some() && !frozen.0 && blamed != Some(Fault::Heading);
        let speed = pace.is_some() && !frozen.1 && blamed != Some(Fault::Speed);
        let since = saturate(self.position + dt, MIN_DT, MAX_DT);
        let count = |time: &mut f64, comes: bool| {
            *time = if comes {
                0.0
            } else {
                saturate(*time + dt, 0.0, MAX_DT)
            };
        };
        count(&mut self.position, position);
        count(&mut self.heading, heading);
        count(&mut self.speed, speed);
        if position && heading && speed {
            return sensed;
        }
        let Some(believed) = self.believed else {
            // Nothing is known: at rest where what came says.
            let known = |comes: bool, value: f64| if comes { value } else { 0.0 };
            return VehicleState {
                x: known(position, sensed.x),
                y: known(position, sensed.y),
                yaw: known(heading, sensed.yaw),
                speed: known(speed, sensed.speed),
            };
        };
        let steered = steered();
        let now = steered.roll(believed, dt);
        let comes = (position, heading, speed);
        let expected = steered.back(now, pose_age);
        let reach = if blamed.is_some() {
            REACH.0 * steered.car.wheelbase + REACH.1 * steered.noise
        } else {
            f64::INFINITY
        };
        mixed(
            sensed,
            expected,
            comes,
            (believed.speed, since, gone),
            reach,
        )
        .bounded()
    }

    /// How far the positions have gone since the last one [m].
    fn gone(&mut self, sensed: VehicleState) -> Option<Point> {
        let here = Point::new(sensed.x, sensed.y);
        self.place.replace(here).map(|last| here - last)
    }

    /// What has been missing for longer than `hold_time` [s]; all of it is the input.
    pub(super) fn fault(&self, hold_time: f64) -> Option<Fault> {
        let lost = [self.position, self.heading, self.speed].map(|time| time > hold_time);
        match lost {
            [true, true, true] => Some(Fault::Input),
            [true, ..] => Some(Fault::Position),
            [_, true, _] => Some(Fault::Heading),
            [_, _, true] => Some(Fault::Speed),
            _ => None,
        }
    }

    /// Whether position and heading came.
    pub(super) fn has_pose(&self) -> bool {
        self.position <= 0.0 && self.heading <= 0.0
    }

    /// Whether a signal is missing.
    pub(super) fn is_incomplete(&self) -> bool {
        self.position > 0.0 || self.heading > 0.0 || self.speed > 0.0
    }

    /// Whether these are times that signals can have been missing for.
    pub(super) fn checked(&self) -> Result<(), InputError> {
        self.believed
            .map_or(Ok(()), |vehicle| vehicle.checked().map(|_| ()))?;
        let place = self.place.unwrap_or(Point::new(0.0, 0.0));
        for number in [place.x, place.y] {
            input_within("signals.place", number, MAX_COORDINATE)?;
        }
        input_within("signals.last", self.last.0.unwrap_or(0.0), MAX_YAW)?;
        input_within("signals.last", self.last.1.unwrap_or(0.0), MAX_SPEED)?;
        for time in [self.position, self.heading, self.speed] {
            input_in_range("signals", time, 0.0, MAX_DT)?;
        }
        Ok(())
    }
}

/// What was `sensed` where it `comes` (position, heading, speed), else what was `expected`. A speed and a
/// heading that are missing are found by the positions, `since` [s] after the last one, how far these have
/// `gone` [m], at a speed that was `before` [m/s]; the heading over the distance `reach` [m].
fn mixed(
    sensed: VehicleState,
    expected: VehicleState,
    comes: (bool, bool, bool),
    (before, since, gone): (f64, f64, Option<Point>),
    reach: f64,
) -> VehicleState {
    let (position, heading, speed) = comes;
    let mut mixed = expected;
    let mut left = 0.0;
    if position {
        (mixed.x, mixed.y) = (sensed.x, sensed.y);
        let off = Point::new(sensed.x - expected.x, sensed.y - expected.y);
        left = off.y * cos(expected.yaw) - off.x * sin(expected.yaw);
    }
    if heading {
        mixed.yaw = sensed.yaw;
    } else {
        let travel = 0.5 * (before + expected.speed) * since;
        if travel != 0.0 {
            mixed.yaw += (1.0 - decay(travel.abs(), reach)) / travel * left;
        }
    }
    if speed {
        mixed.speed = sensed.speed;
    } else if let Some(gone) = gone {
        // Not where it is expected to be: of a speed that was far off that is far off, too.
        let travel = 0.5 * (before + expected.speed) * since;
        let ahead = gone.x * cos(mixed.yaw) + gone.y * sin(mixed.yaw) - travel;
        let found = mixed.speed + (1.0 - decay(since, SPEED_TIME)) / since * ahead;
        // Noise of the poses turns no vehicle round that comes to rest.
        mixed.speed = if found * before < 0.0 { 0.0 } else { found };
    }
    mixed
}

impl Steered<'_> {
    /// The vehicle `dt` [s] later.
    fn roll(&self, vehicle: VehicleState, dt: f64) -> VehicleState {
        let car = self.car;
        let settled = InFlight::settled(car, self.steer);
        let in_flight = self.in_flight.unwrap_or(&settled);
        let mut rollout = Rollout::new(car, &self.estimate, vehicle.ahead(car.no_slip()));
        let commands = in_flight.commands().chain([(self.steer, dt)]);
        rollout.drive(in_flight.wheel(), clipped(commands, dt));
        rollout.state().bounded().ahead(-car.no_slip()).bounded()
    }

    /// The vehicle `age` [s] earlier.
    fn back(&self, now: VehicleState, age: f64) -> VehicleState {
        if !(MIN_DT..=MAX_POSE_AGE).contains(&age) {
            return now;
        }
        let car = self.car;
        let wheel = self.in_flight.map_or(self.steer, InFlight::wheel);
        let angle = car.at_wheels(wheel + self.estimate.steer_offset);
        let curvature = tan(angle) * self.estimate.gain / car.turning_length(now.speed);
        let point = car.no_slip();
        let speed = now.speed - self.estimate.acceleration * age;
        let travel = -0.5 * (now.speed + speed) * age;
        let then = advance(now.ahead(point), travel, curvature, 0.0).ahead(-point);
        VehicleState { speed, ..then }.bounded()
    }
}

#[cfg(test)]
mod tests;
