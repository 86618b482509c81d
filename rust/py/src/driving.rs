//! A controller that drives a simulation until the run is over.

use std::time::{Duration, Instant};

use popsteer_core::InputError;
use popsteer_sim::{Controller, Longitudinal, Perception, Simulation, closed_loop};
use pyo3::prelude::*;

use crate::errors::Raises;
use crate::laws::law_of;
use crate::plants::python_plant;
use crate::python_driver::PythonDriver;
use crate::python_plant::PythonPlant;

/// How often signals and progress are handled, however long a step takes.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// Drives; gives what a plant in Python raised. The interpreter's lock is released meanwhile.
pub(crate) fn driven(
    py: Python<'_>,
    simulation: &mut Simulation,
    controller: &Bound<'_, PyAny>,
    longitudinal: &Longitudinal,
    perception: Perception,
    progress: Option<&Bound<'_, PyAny>>,
) -> Raises<Option<PyErr>> {
    let progress = progress.map(|progress| progress.clone().unbind());
    let mut fault = None;
    let mut interrupted: PyResult<()> = Ok(());
    let mut looked = Instant::now();
    let go_on = |simulation: &Simulation| {
        fault = python_plant(simulation).and_then(PythonPlant::take_fault);
        if fault.is_some() {
            return false;
        }
        if looked.elapsed() < LOOK_EVERY {
            return true;
        }
        interrupted = Python::attach(|py| {
            py.check_signals()?;
            if let Some(progress) = &progress {
                progress.call1(py, (simulation.progress(),))?;
            }
            Ok(())
        });
        looked = Instant::now();
        interrupted.is_ok()
    };
    let outcome: Result<(), InputError> = if let Some((tracker, _)) = law_of(controller) {
        py.detach(|| {
            simulation.track(*tracker.follow());
            let mut driver = Controller::new(&tracker);
            closed_loop::run(simulation, &mut driver, longitudinal, perception, go_on)
        })
    } else {
        let mut driver = PythonDriver::of(controller)?;
        let run = || closed_loop::run(simulation, &mut driver, longitudinal, perception, go_on);
        let outcome = py.detach(run);
        driver.take_fault().map_or(Ok(outcome), Err)?
    };
    interrupted?;
    outcome?;
    Ok(fault)
}
