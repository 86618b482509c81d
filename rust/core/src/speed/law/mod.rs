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

mod curve;
mod limits;
mod situation;
mod state;
mod stop;
mod wait;

use crate::bounds::{MAX_COORDINATE, MAX_DT};
use crate::error::{InputError, input_in_range, input_within};
use crate::math::{larger, saturate, smaller, sqrt};
use crate::path::PathView;
use crate::path::follow::Located;
use crate::speed::defaults::gravity_along;
use crate::speed::servo::Wanted;
use crate::speed::stops::Planned;
use crate::status::Status;

pub(super) use limits::CREEP;
pub use limits::{REST, SpeedLaw, SpeedTrackerParams};
use situation::Situation;
use state::{ACCELERATION_BOUND, SPEED_BOUND};
pub use state::{Phase, Sensed, SpeedCommand, SpeedState};

/// Share of what the brakes can do that holds a vehicle, and how many times what its slope needs. Less: it
/// rolls back until a drive with a lag has become a brake.
const HOLD: (f64, f64) = (0.5, 2.5);

impl SpeedLaw {
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
        let now = self.situation(&planned, at, state, (speed, sensed.age, sensed.noise));
        let told = (sensed.reverse_gear, sensed.stop.is_some());
        self.wait(&planned, state, &now, at, told);
        let held = state.is_held();
        let halted = sensed.stop.is_some() || state.rolls;
        let lawful = self.lawful(&now);
        let lawful = if state.shifting && sensed.reverse_gear.is_none() {
            // Softly, as the gear may not be in yet.
            smaller(lawful, 0.5 * self.accelerations.0 - now.answer.push)
        } else {
            lawful
        };
        let command = if held || halted {
            let braking = sensed.stop.unwrap_or(self.accelerations.1);
            smaller(self.hold(&now, braking), lawful)
        } else {
            lawful
        };
        state.acceleration = self.limited(state.acceleration, command, &now, held || halted, dt);
        let before = state.overruns || state.reverse.is_none();
        state.overruns = self.overruns(&planned, &now, sensed.noise.0, state);
        state.reverse = Some(at.reverse);
        // A drive that takes accelerations for what they are passes rest within a period.
        let passed = -now.rest - larger(-state.acceleration, 0.0) * dt;
        let rests = (passed..now.rest).contains(&now.speed);
        let standing = held && !halted || halted && (rests || state.still > 0.0);
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
            phase: Self::phase(state, halted),
            status: Status::OK,
        }
    }

    /// The acceleration by the law, within the vehicle's, and harder where it would overrun its stop [m/s²].
    fn lawful(&self, now: &Situation) -> f64 {
        let (driving, braking) = self.accelerations;
        let reserve = self.params.reserve;
        let wanted = now.change + self.correction(now.target - now.z);
        // Slower, what noise moves the stop by would be taken for an overrun.
        let slow = sqrt(2.0 * braking * self.arrived());
        let passing = if now.z > smaller(CREEP * self.car.wheelbase, slow) {
            now.deceleration(self.arrived())
        } else {
            0.0
        };
        let wanted = if passing > braking {
            smaller(wanted, -passing)
        } else {
            wanted
        };
        let most = smaller(
            -braking - reserve - now.answer.push,
            now.answer.command(-passing),
        );
        saturate(
            now.answer.command(wanted),
            most,
            driving + reserve - now.answer.push,
        )
    }

    /// The `command` within the jerk of the `last` one, and what the brakes can do [m/s²]. At rest brakes that
    /// are applied jerk nothing, nor does what holds the vehicle against its slope.
    fn limited(&self, last: f64, command: f64, now: &Situation, held: bool, dt: f64) -> f64 {
        let jerk = self.params.max_jerk * dt;
        let (mut low, mut high) = (last - jerk, last + jerk);
        if now.speed.abs() < now.rest {
            low = if held { -self.brakes } else { low };
            high = larger(last, -now.answer.push) + jerk;
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

    fn phase(state: &SpeedState, halted: bool) -> Phase {
        if state.rolls {
            Phase::Shifting
        } else if halted {
            Phase::Stopped
        } else if state.standing && state.still > 0.0 {
            Phase::Standing
        } else if state.waits.1 > 0.0 {
            Phase::Shifting
        } else if state.waits.0 > 0.0 {
            Phase::Turning
        } else if state.stopping || state.standing {
            Phase::Stopping
        } else {
            Phase::Driving
        }
    }

    /// The acceleration that brings the vehicle to rest by `braking` and holds it [m/s²].
    fn hold(&self, now: &Situation, braking: f64) -> f64 {
        if now.speed > now.rest {
            now.answer.command(-braking)
        } else if now.speed < -now.rest {
            // Along the way that it rolls.
            -braking + now.answer.push
        } else {
            -larger(HOLD.0 * self.brakes, HOLD.1 * now.answer.push.abs())
        }
    }

    /// Whether the vehicle overruns its stop with all that its brakes do, or cannot stay there.
    fn overruns(
        &self,
        planned: &Planned<'_, '_>,
        now: &Situation,
        noise: f64,
        state: &SpeedState,
    ) -> bool {
        let (_, distance) = now.stop;
        if distance == f64::INFINITY {
            return false;
        }
        let beyond = self.overrun() + stop::STEADY_NOISE * noise;
        let needed = now.deceleration(beyond);
        let at = planned.path.arc(planned.segment) + larger(distance, 0.0);
        let grade = planned.at(at).grade;
        let slips = state.stopping && gravity_along(grade).abs() > self.brakes;
        let moves = now.speed > now.rest
            && now.z > 0.0
            && needed > self.brakes * now.answer.brakes - now.answer.push;
        moves || slips || (state.standing && distance < -beyond)
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
            input_within("stop", distance, f64::MAX)?;
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
