//! A law drives a simulation.

use popsteer_core::longitudinal::SpeedPidState;
use popsteer_core::{InputError, LateralLaw, Point, Status, VehicleState};

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
    go_on: impl FnMut(&Simulation) -> bool,
) -> Result<(), InputError> {
    run_perceiving(simulation, law, drive, |vehicle| vehicle, go_on)
}

/// As [`run`], with the laws shown what `perceive` makes of the vehicle.
///
/// # Errors
///
/// As [`run`].
pub fn run_perceiving<L: LateralLaw>(
    simulation: &mut Simulation,
    law: &L,
    drive: &Drive,
    mut perceive: impl FnMut(VehicleState) -> VehicleState,
    mut go_on: impl FnMut(&Simulation) -> bool,
) -> Result<(), InputError> {
    let mut law_state = law.initial_state();
    let mut drive_state = SpeedPidState::default();
    let path = simulation.path().clone();
    let settings = *simulation.settings();
    let turns_round = path.view().reverse().is_some();
    let mut backwards = false;
    while !simulation.is_over() {
        let vehicle = perceive(simulation.vehicle());
        let (steer, reverse, target, status) = if settings.keep_records || turns_round {
            let command = law.step(&path.view(), &mut law_state, vehicle, settings.dt)?;
            (
                command.steer,
                command.reverse,
                command.target,
                command.status,
            )
        } else {
            let steer = law.steer(&path.view(), &mut law_state, vehicle, settings.dt)?;
            (steer, false, Point::new(f64::NAN, f64::NAN), Status::Ok)
        };
        let reference_speed = if drive.needs_reference_speed() {
            simulation.reference_speed()
        } else {
            None
        };
        if reverse != backwards {
            backwards = reverse;
            drive_state = SpeedPidState::default();
        }
        let gear = if reverse { -1.0 } else { 1.0 };
        let pedals = drive.step(
            &mut drive_state,
            gear * vehicle.speed,
            steer,
            reference_speed.map(f64::abs),
            settings.dt,
        )?;
        let control = Control {
            steer,
            throttle: pedals.throttle,
            brake: pedals.brake,
            reverse,
        };
        simulation.step(control, target, status)?;
        if !go_on(simulation) {
            break;
        }
    }
    Ok(())
}
