//! Any of the core's longitudinal controllers, chosen at run time.

use popsteer_core::InputError;
use popsteer_core::longitudinal::{
    CoupledLongitudinal, CoupledLongitudinalParams, Pedals, SpeedPid, SpeedPidState,
};

/// Who works the pedals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// The paper's controller, coupled with the steering.
    Coupled(CoupledLongitudinal),
    /// A PID on the path's reference speeds.
    Speed(SpeedPid),
}

impl Default for Drive {
    /// The paper's controller with the paper's Table 2.
    fn default() -> Self {
        let law = CoupledLongitudinal::new(CoupledLongitudinalParams::DEFAULT);
        Self::Coupled(law.expect("the defaults are within their ranges"))
    }
}

impl Drive {
    /// The pedals at `speed` [m/s], with the commanded angle `steer` [rad] and the path's
    /// reference speed [m/s]; without one the PID holds the present speed.
    pub(crate) fn step(
        &self,
        state: &mut SpeedPidState,
        speed: f64,
        steer: f64,
        reference_speed: Option<f64>,
        dt: f64,
    ) -> Result<Pedals, InputError> {
        match self {
            Self::Coupled(law) => law.step(speed, steer),
            Self::Speed(law) => law.step(state, speed, reference_speed.unwrap_or(speed), dt),
        }
    }

    /// Whether the path has to carry reference speeds.
    pub fn needs_reference_speed(&self) -> bool {
        matches!(self, Self::Speed(_))
    }
}
