//! Many runs on all cores, the same whatever the number of threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use popsteer_core::{Path, Tracker, VehicleState};
use rayon::prelude::*;

use crate::closed_loop::{self, Controller};
use crate::longitudinal::Longitudinal;
use crate::metrics::Metrics;
use crate::noise::Perception;
use crate::plant::Plant;
use crate::simulation::Settings;
use crate::simulation::{Simulation, SimulationError};
use popsteer_core::laws::Law;

/// One run of many.
#[derive(Clone, Debug)]
pub struct Run {
    /// Who steers.
    pub law: Tracker<Law>,
    /// Along which path.
    pub path: Arc<Path>,
    /// Which vehicle.
    pub plant: Arc<dyn Plant>,
    /// From which pose of the vehicle's point, at which speed.
    pub start: VehicleState,
    /// How it sees the vehicle.
    pub perception: Perception,
    /// Who works the pedals.
    pub longitudinal: Longitudinal,
}

/// The progress of [`run_many`], for another thread, and a way to stop it.
#[derive(Debug, Default)]
pub struct Watch {
    done: AtomicUsize,
    stop: AtomicBool,
}

impl Watch {
    /// How many runs are done.
    pub fn done(&self) -> usize {
        self.done.load(Ordering::Relaxed)
    }

    /// Stops the runs, each within a step.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Drives all `runs`, without records; what each came to, in order.
///
/// Each run draws its noise from its own [`Perception`], so the result is the same on any number of
/// threads. A run that is stopped counts as not finished.
///
/// # Errors
///
/// [`SimulationError`] of the first run that is refused.
pub fn run_many(
    runs: &[Run],
    settings: Settings,
    watch: &Watch,
) -> Result<Vec<Metrics>, SimulationError> {
    let settings = Settings {
        keep_records: false,
        ..settings
    }
    .checked()?;
    runs.par_iter()
        .map(|run| {
            let tracked = *run.law.follow();
            let path = Arc::clone(&run.path);
            let plant = Arc::clone(&run.plant);
            let mut simulation = Simulation::new(path, plant, run.start, tracked, settings)?;
            // At every step: a look costs nothing beside one, and a step can take milliseconds.
            let go_on = |_: &Simulation| !watch.is_stopped();
            if !watch.is_stopped() {
                let driver = &mut Controller::new(&run.law);
                let (longitudinal, perception) = (&run.longitudinal, run.perception.clone());
                closed_loop::run(&mut simulation, driver, longitudinal, perception, go_on)?;
            }
            watch.done.fetch_add(1, Ordering::Relaxed);
            Ok(simulation.metrics())
        })
        .collect()
}

#[cfg(test)]
mod tests;
