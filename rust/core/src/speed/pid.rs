//! PID that tracks a reference speed.

use crate::bounds::MAX_SPEED;
use crate::error::{ConfigError, InputError, input_within};
use crate::math::saturate;
use crate::params;
use crate::speed::Pedals;
use crate::vehicle::state::period;

params! {
    /// Parameters of [`SpeedPid`].
    pub struct SpeedPidParams {
        /// Proportional gain [s/m].
        kp: f64 = 0.5, in [0.0, 1e6];
        /// Integral gain [1/m].
        ki: f64 = 0.1, in [0.0, 1e6];
        /// Derivative gain [s^2/m].
        kd: f64 = 0.0, in [0.0, 1e6];
    }
}

/// What [`SpeedPid`] remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SpeedPidState {
    /// The integral's share of the command, within -1 to 1.
    pub integral: f64,
    /// The last speed error [m/s]; None before the first step.
    pub previous_error: Option<f64>,
}

/// `command = kp e + ki integral(e) + kd de/dt` on `e = target_speed - speed`.
///
/// The integral's share is held within the range of the command, so it cannot wind up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedPid {
    params: SpeedPidParams,
}

impl SpeedPid {
    /// The controller with these parameters.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn new(params: SpeedPidParams) -> Result<Self, ConfigError> {
        Ok(Self {
            params: params.checked()?,
        })
    }

    /// Pedals at `speed` for `target_speed` [m/s].
    ///
    /// In a `dt` that is no control period, of a clock that was set or repeats a stamp, no time passes:
    /// the integral stays, and there is no derivative.
    ///
    /// # Errors
    ///
    /// [`InputError`] for another number that is not finite or beyond its bound, or a `dt` that is not
    /// finite; `state` is then unchanged.
    #[inline]
    pub fn step(
        &self,
        state: &mut SpeedPidState,
        speed: f64,
        target_speed: f64,
        dt: f64,
    ) -> Result<Pedals, InputError> {
        input_within("speed", speed, MAX_SPEED)?;
        input_within("target_speed", target_speed, MAX_SPEED)?;
        let error = target_speed - speed;
        let Some(dt) = period(dt)? else {
            return Ok(Pedals::from_command(
                self.params.kp * error + state.integral,
            ));
        };
        let rate = state
            .previous_error
            .map_or(0.0, |previous| (error - previous) / dt);
        state.integral = saturate(state.integral + self.params.ki * error * dt, -1.0, 1.0);
        state.previous_error = Some(error);
        Ok(Pedals::from_command(
            self.params.kp * error + state.integral + self.params.kd * rate,
        ))
    }

    /// Whether `state` is one that this controller could have.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the field that is not.
    pub fn check_state(&self, state: &SpeedPidState) -> Result<(), InputError> {
        input_within("integral", state.integral, 1.0)?;
        if let Some(error) = state.previous_error {
            input_within("previous_error", error, 2.0 * MAX_SPEED)?;
        }
        Ok(())
    }
}
