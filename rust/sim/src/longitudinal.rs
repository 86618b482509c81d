//! Any of the core's longitudinal controllers, chosen at run time.

use std::sync::Arc;

use popsteer_core::speed::{
    CoupledLongitudinal, CoupledLongitudinalParams, Pedals, SpeedPid, SpeedPidState, SpeedTracker,
    SpeedTrackerState,
};
use popsteer_core::{Command, InputError, Path, VehicleState};

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

    /// What gives the `acceleration` [m/s^2] that a driver wants with its `answer`; None where the plant
    /// does not say which pedals do.
    pub(crate) fn giving(
        simulation: &Simulation,
        vehicle: VehicleState,
        answer: &Command,
        acceleration: f64,
    ) -> Option<Control> {
        let speed = if answer.reverse {
            -vehicle.speed
        } else {
            vehicle.speed
        };
        let (throttle, brake) = simulation.plant().pedals()?.of(acceleration, speed);
        Some(Control {
            steer: answer.steer,
            throttle,
            brake,
            reverse: answer.reverse,
        })
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
        let gear = |reverse| if reverse { -1.0 } else { 1.0 };
        let (mut reverse, speed) = (reverse, gear(reverse) * vehicle.speed);
        let Pedals { throttle, brake } = match &self.longitudinal {
            Longitudinal::Coupled(law) => law.step(speed, steer)?,
            Longitudinal::Speed(law) => {
                // Without a reference speed it holds the present one.
                let wanted = simulation.stopping_speed().map_or(speed, f64::abs);
                law.step(&mut self.state, speed, wanted, dt)?
            }
            Longitudinal::Tracked(tracked) => {
                let (path, state) = (tracked.path.view(), &mut self.tracked);
                let command = tracked.law.step(&path, &tracked.plan, state, vehicle, dt)?;
                reverse = command.reverse;
                let speed = gear(reverse) * vehicle.speed;
                let (throttle, brake) = tracked.pedals.of(command.acceleration, speed);
                Pedals { throttle, brake }
            }
        };
        Ok(Control {
            steer,
            throttle,
            brake,
            reverse,
        })
    }
}
