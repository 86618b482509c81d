//! Any of the core's longitudinal controllers, chosen at run time.

use std::sync::Arc;

use popsteer_core::speed::{
    CoupledLongitudinal, CoupledLongitudinalParams, Pedals, SpeedPid, SpeedPidState, SpeedTracker,
    SpeedTrackerState,
};
use popsteer_core::{InputError, Path, VehicleState};

use crate::plant::{Control, PedalMap};
use crate::simulation::Simulation;

/// Who works the pedals.
#[derive(Clone, Debug, PartialEq)]
pub enum Longitudinal {
    /// The paper's controller, coupled with the steering.
    Coupled(CoupledLongitudinal),
    /// A PID on the path's reference speeds.
    Speed(SpeedPid),
    /// A plan of the speeds, kept.
    Tracked(Arc<Tracked>),
}

/// A [`SpeedTracker`] on its path, and the pedals for its accelerations.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracked {
    /// The controller.
    pub law: SpeedTracker,
    /// The path that it plans on.
    pub path: Arc<Path>,
    /// Its plan: a speed for each waypoint [m/s].
    pub plan: Arc<[f64]>,
    /// What gives its accelerations.
    pub pedals: PedalMap,
}

impl Tracked {
    /// The control of a vehicle whose wheels are commanded to `steer` [rad].
    fn control(
        &self,
        state: &mut SpeedTrackerState,
        vehicle: VehicleState,
        steer: f64,
        dt: f64,
    ) -> Result<Control, InputError> {
        let path = self.path.view();
        let command = self.law.step(&path, &self.plan, state, vehicle, dt)?;
        let gear = if command.reverse { -1.0 } else { 1.0 };
        let (throttle, brake) = self.pedals.of(command.acceleration, gear * vehicle.speed);
        Ok(Control {
            steer,
            throttle,
            brake,
            reverse: command.reverse,
        })
    }
}

impl Default for Longitudinal {
    /// The paper's controller with the paper's Table 2.
    fn default() -> Self {
        let law = CoupledLongitudinal::new(CoupledLongitudinalParams::DEFAULT);
        Self::Coupled(law.expect("the defaults are within their ranges"))
    }
}

/// A longitudinal law on a run, with what it remembers.
#[derive(Clone, Debug)]
pub(crate) struct Pedalling {
    longitudinal: Longitudinal,
    state: SpeedPidState,
    tracked: SpeedTrackerState,
    backwards: bool,
}

impl Pedalling {
    /// At the start of a run.
    pub(crate) fn new(longitudinal: &Longitudinal, simulation: &Simulation) -> Self {
        Self {
            longitudinal: longitudinal.clone(),
            state: SpeedPidState::default(),
            tracked: SpeedTrackerState::default(),
            backwards: simulation.reverse(),
        }
    }

    /// What `simulation` is commanded for the measured `vehicle` with the angle `steer` [rad], in
    /// reverse gear or not; a plan that is kept has the gear, too.
    pub(crate) fn control(
        &mut self,
        simulation: &Simulation,
        vehicle: VehicleState,
        steer: f64,
        reverse: bool,
    ) -> Result<Control, InputError> {
        let dt = simulation.settings().dt;
        if reverse != self.backwards {
            self.backwards = reverse;
            self.state = SpeedPidState::default();
        }
        let gear = if reverse { -1.0 } else { 1.0 };
        let speed = gear * vehicle.speed;
        let pedals: Pedals = match &self.longitudinal {
            Longitudinal::Coupled(law) => law.step(speed, steer)?,
            Longitudinal::Speed(law) => {
                // Without a reference speed it holds the present one.
                let wanted = simulation.stopping_speed().map_or(speed, f64::abs);
                law.step(&mut self.state, speed, wanted, dt)?
            }
            Longitudinal::Tracked(tracked) => {
                return tracked.control(&mut self.tracked, vehicle, steer, dt);
            }
        };
        Ok(Control {
            steer,
            throttle: pedals.throttle,
            brake: pedals.brake,
            reverse,
        })
    }
}
