//! Any of the core's longitudinal controllers, chosen at run time.

use popsteer_core::InputError;
use popsteer_core::longitudinal::{
    CoupledLongitudinal, CoupledLongitudinalParams, Pedals, SpeedPid, SpeedPidState,
};

use crate::plant::Control;
use crate::simulation::Simulation;

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

/// A longitudinal law on a run, with what it remembers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pedalling {
    drive: Drive,
    state: SpeedPidState,
    backwards: bool,
}

impl Pedalling {
    /// At the start of a run.
    pub(crate) fn new(drive: &Drive, simulation: &Simulation) -> Self {
        Self {
            drive: *drive,
            state: SpeedPidState::default(),
            backwards: simulation.reverse(),
        }
    }

    /// What `simulation` is commanded at the measured `speed` [m/s] with the angle `steer` [rad],
    /// in reverse gear or not.
    pub(crate) fn control(
        &mut self,
        simulation: &Simulation,
        speed: f64,
        steer: f64,
        reverse: bool,
    ) -> Result<Control, InputError> {
        let reference_speed = if self.drive.needs_reference_speed() {
            simulation.stopping_speed()
        } else {
            None
        };
        if reverse != self.backwards {
            self.backwards = reverse;
            self.state = SpeedPidState::default();
        }
        let gear = if reverse { -1.0 } else { 1.0 };
        let pedals = self.drive.step(
            &mut self.state,
            gear * speed,
            steer,
            reference_speed.map(f64::abs),
            simulation.settings().dt,
        )?;
        Ok(Control {
            steer,
            throttle: pedals.throttle,
            brake: pedals.brake,
            reverse,
        })
    }
}
