//! The one closed loop: a driver, the pedals and a simulation.

use popsteer_core::tracker::TrackerState;
use popsteer_core::{
    InputError, LateralLaw, PathView, Point, Reported, Status, Tracker, VehicleState,
};

use crate::longitudinal::{Longitudinal, Pedalling};
use crate::noise::Perception;
use crate::simulation::Simulation;

/// What a driver answers to one measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriverAnswer {
    /// Steering angle to command [rad].
    pub steer: f64,
    /// Whether to drive backwards.
    pub reverse: bool,
    /// The point aimed at [m]; not a number where there is none.
    pub target: Point,
    /// How the step went.
    pub status: Status,
}

/// What steers a simulated vehicle.
pub trait Driver {
    /// The answer to a measured vehicle, `dt` [s] after the last one; `reverse` says whether the
    /// path is driven backwards where the rear axle is. None ends the run.
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
    ) -> Result<Option<DriverAnswer>, InputError>;
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

    /// What the controller remembers by now.
    pub fn state(&self) -> &TrackerState<L::State> {
        &self.state
    }
}

impl<L: LateralLaw> Driver for Controller<'_, L> {
    fn answer(
        &mut self,
        path: &PathView<'_>,
        vehicle: VehicleState,
        dt: f64,
        _reverse: bool,
    ) -> Result<Option<DriverAnswer>, InputError> {
        let (tracker, state) = (self.tracker, &mut self.state);
        let command = tracker.step(path, state, vehicle, dt, Reported::NOTHING)?;
        Ok(Some(DriverAnswer {
            steer: command.steer,
            reverse: command.reverse,
            target: command.target,
            status: command.status,
        }))
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
        let vehicle = perception.of(simulation.vehicle());
        let Some(answer) = driver.answer(&path.view(), vehicle, dt, simulation.reverse())? else {
            break;
        };
        let control = pedals.control(simulation, vehicle, answer.steer, answer.reverse)?;
        simulation.step(control, answer.target, answer.status)?;
        if !go_on(simulation) {
            break;
        }
    }
    Ok(())
}
