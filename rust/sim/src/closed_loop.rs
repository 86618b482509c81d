//! The one closed loop: a driver, the pedals and a simulation.

use popsteer_core::driver::{self, DriverState, Sensed};
use popsteer_core::tracker::TrackerState;
use popsteer_core::{Command, InputError, LateralLaw, PathView, Reported, Tracker, VehicleState};

use crate::longitudinal::{Longitudinal, Pedalling};
use crate::noise::Perception;
use crate::simulation::Simulation;

/// What steers a simulated vehicle.
pub trait Driver {
    /// The answer to a measured vehicle, `dt` [s] after the last one; `reverse` says whether the
    /// path is driven backwards where the rear axle is. None ends the run. Of a command its angle,
    /// direction, target and status count.
    ///
    /// # Errors
    ///
    /// [`InputError`] where the driver refuses the measurement.
    fn answer(
        &mut self,
        path: &PathView<'_>,
        vehicle: VehicleState,
        dt: f64,
        reverse: bool,
    ) -> Result<Option<Command>, InputError>;

    /// The acceleration of the last answer, in the direction of driving [m/s^2], where the driver works
    /// the pedals, too; None where it steers alone.
    fn acceleration(&self) -> Option<f64> {
        None
    }
}

/// A controller of the core as a driver, from a fresh state.
#[derive(Clone, Debug)]
pub struct Controller<'a, L: LateralLaw> {
    tracker: &'a Tracker<L>,
    state: TrackerState<L::State>,
}

impl<'a, L: LateralLaw> Controller<'a, L> {
    /// `tracker` before its first step.
    pub fn new(tracker: &'a Tracker<L>) -> Self {
        Self {
            state: tracker.initial_state(),
            tracker,
        }
    }
}

impl<L: LateralLaw> Driver for Controller<'_, L> {
    fn answer(
        &mut self,
        path: &PathView<'_>,
        vehicle: VehicleState,
        dt: f64,
        _reverse: bool,
    ) -> Result<Option<Command>, InputError> {
        let (tracker, state) = (self.tracker, &mut self.state);
        let command = tracker.step(path, state, vehicle, dt, Reported::NOTHING);
        command.map(Some)
    }
}

/// A driver of the core, from a fresh state: it works the pedals, too.
#[derive(Clone, Debug)]
pub struct Driving<'a, L: LateralLaw> {
    driver: &'a driver::Driver<L>,
    plan: &'a [f64],
    state: DriverState<L::State>,
    acceleration: f64,
}

impl<'a, L: LateralLaw> Driving<'a, L> {
    /// `driver` before its first step, with its `plan` of the path's speeds [m/s].
    pub fn new(driver: &'a driver::Driver<L>, plan: &'a [f64]) -> Self {
        Self {
            state: driver.initial_state(),
            acceleration: 0.0,
            driver,
            plan,
        }
    }
}

impl<L: LateralLaw> Driver for Driving<'_, L> {
    fn answer(
        &mut self,
        path: &PathView<'_>,
        vehicle: VehicleState,
        dt: f64,
        _reverse: bool,
    ) -> Result<Option<Command>, InputError> {
        let sensed = Sensed {
            vehicle,
            reported: Reported::NOTHING,
            gear: None,
        };
        let drive = self
            .driver
            .step(path, self.plan, &mut self.state, sensed, dt);
        self.acceleration = drive.acceleration;
        Ok(Some(Command {
            steer: drive.steer,
            target: drive.target,
            reverse: drive.reverse,
            status: drive.status,
            ..Command::NONE
        }))
    }

    fn acceleration(&self) -> Option<f64> {
        Some(self.acceleration)
    }
}

/// Lets `driver` and `longitudinal` drive `simulation` until it is over; both are given the vehicle with
/// the noise of `perception`.
///
/// `go_on` is called after every step; `false` ends the run early.
///
/// # Errors
///
/// [`InputError`] where the state of the plant is refused, or the angle of the driver.
pub fn run(
    simulation: &mut Simulation,
    driver: &mut impl Driver,
    longitudinal: &Longitudinal,
    mut perception: Perception,
    mut go_on: impl FnMut(&Simulation) -> bool,
) -> Result<(), InputError> {
    let mut pedals = Pedalling::new(longitudinal, simulation);
    let path = simulation.path().clone();
    let dt = simulation.settings().dt;
    while !simulation.is_over() {
        let vehicle = perception.of(simulation.measured());
        let Some(answer) = driver.answer(&path.view(), vehicle, dt, simulation.reverse())? else {
            break;
        };
        let own = driver
            .acceleration()
            .and_then(|wanted| Pedalling::giving(simulation, vehicle, &answer, wanted));
        let control = match own {
            Some(control) => control,
            None => pedals.control(simulation, vehicle, answer.steer, answer.reverse)?,
        };
        simulation.step(control, answer.target, answer.status)?;
        if !go_on(simulation) {
            break;
        }
    }
    Ok(())
}
