//! The paper's longitudinal controller, coupled with the steering angle: Equation 7. To drive a car,
//! take a [`SpeedTracker`](super::SpeedTracker).

use crate::bounds::MAX_SPEED;
use crate::error::{ConfigError, InputError, input_within};
use crate::params;
use crate::speed::Pedals;

params! {
    /// Parameters of [`CoupledLongitudinal`]; the paper's Table 2 by default.
    pub struct CoupledLongitudinalParams {
        /// Cutoff constant `k_tau`, 0 to 1: offset and aggressiveness of the command.
        cutoff: f64 = 0.5, in [0.0, 1.0];
        /// Steering limit `delta_lim` [rad].
        steer_limit: f64 = 1.22, in [1e-3, 1.57];
        /// Speed limit `v_lim` [m/s].
        speed_limit: f64 = 69.44, in [1e-3, 1e4];
    }
}

/// The paper's pedals, which drive towards `speed_limit`: 69.44 m/s by default.
///
/// `command = cutoff + ((speed_limit - speed) / speed_limit - |steer| / steer_limit) (1 -
/// cutoff)`: full throttle from rest, less with speed and in bends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoupledLongitudinal {
    params: CoupledLongitudinalParams,
}

impl CoupledLongitudinal {
    /// The controller with these parameters.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn new(params: CoupledLongitudinalParams) -> Result<Self, ConfigError> {
        Ok(Self {
            params: params.checked()?,
        })
    }

    /// Pedals at `speed` [m/s] with the commanded angle `steer` [rad]. The controller has no
    /// memory.
    ///
    /// # Errors
    ///
    /// [`InputError`] for a number that is not finite or beyond its bound.
    #[inline]
    pub fn step(&self, speed: f64, steer: f64) -> Result<Pedals, InputError> {
        let params = &self.params;
        input_within("speed", speed, MAX_SPEED)?;
        input_within("steer", steer, core::f64::consts::PI)?;
        let slower = (params.speed_limit - speed) / params.speed_limit;
        let reserve = slower - steer.abs() / params.steer_limit;
        let command = params.cutoff + reserve * (1.0 - params.cutoff);
        Ok(Pedals::from_command(command))
    }
}
