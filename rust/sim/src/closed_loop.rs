//! A law drives a simulation.

use popsteer_core::longitudinal::SpeedPidState;
use popsteer_core::{InputError, LateralLaw};

use crate::drive::Drive;
use crate::plant::Control;
use crate::simulation::Simulation;

/// Lets `law` and `drive` drive `simulation` until it is over.
///
/// `go_on` is called after every step; `false` ends the run early.
///
/// # Errors
///
/// [`InputError`] where a law refuses the state of the plant.
pub fn run<L: LateralLaw>(
    simulation: &mut Simulation,
    law: &L,
    drive: &Drive,
    mut go_on: impl FnMut(&Simulation) -> bool,
) -> Result<(), InputError> {
    let mut law_state = law.initial_state();
    let mut drive_state = SpeedPidState::default();
    let path = simulation.path().clone();
    let dt = simulation.settings().dt;
    while !simulation.is_over() {
        let vehicle = simulation.vehicle();
        let command = law.step(&path.view(), &mut law_state, vehicle, dt)?;
        let reference_speed = if drive.needs_reference_speed() {
            simulation.reference_speed()
        } else {
            None
        };
        let pedals = drive.step(
            &mut drive_state,
            vehicle.speed,
            command.steer,
            reference_speed,
            dt,
        )?;
        simulation.step(
            Control {
                steer: command.steer,
                throttle: pedals.throttle,
                brake: pedals.brake,
            },
            command.target,
            command.status,
        )?;
        if !go_on(simulation) {
            break;
        }
    }
    Ok(())
}
