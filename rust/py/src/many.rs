//! Many runs: controllers in, a column for each figure out.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use numpy::PyArray1;
use popsteer_core::VehicleState;
use popsteer_core::math::from_count;
use popsteer_sim::many::{self, Run, Watch};
use popsteer_sim::{Metrics, Perception, Settings};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{Raises, entry_error};
use crate::laws::law_of;
use crate::metrics::figures;
use crate::plants::plant_of;
use crate::pool;
use crate::sim::{PyNoise, PySettings};
use crate::speed::controllers::{GivenPedals, longitudinal_for};

/// How often signals and progress are handled: well within the 100 ms that a person notices.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// A controller, a plant, a start with its speed; how the controller sees the vehicle: the noise,
/// its seed and the stream of that; and the longitudinal controller.
type Asked<'py> = (
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
    [f64; 4],
    (Option<Py<PyNoise>>, u64, u64),
    Option<Bound<'py, PyAny>>,
);

/// Drive many runs; as `popsteer.sim.run_many`, which prepares the arguments.
#[pyfunction]
#[pyo3(signature = (runs, *, pedals, settings, threads, progress))]
pub(crate) fn run_many<'py>(
    py: Python<'py>,
    runs: Vec<Asked<'py>>,
    pedals: Option<GivenPedals>,
    settings: Option<Py<PySettings>>,
    threads: Option<usize>,
    progress: Option<&Bound<'py, PyAny>>,
) -> Raises<Bound<'py, PyDict>> {
    let mut prepared = Vec::with_capacity(runs.len());
    for (index, (law, plant, start, seen, longitudinal)) in runs.into_iter().enumerate() {
        let (noise, seed, stream) = seen;
        let (law, path) = law_of(&law)
            .ok_or_else(|| PyTypeError::new_err("a run needs a controller of popsteer"))?;
        let [x, y, yaw, speed] = start;
        let start = VehicleState { x, y, yaw, speed };
        let plant = plant_of(&plant)?;
        prepared.push(Run {
            longitudinal: longitudinal_for(longitudinal.as_ref(), plant.as_ref(), pedals)?,
            law,
            path,
            plant,
            start: start
                .checked()
                .map_err(|error| entry_error(py, index, error))?,
            perception: noise.map_or(Perception::EXACT, |noise| {
                Perception::new(noise.get().0, seed, stream)
            }),
        });
    }
    let settings = settings.map_or(Settings::DEFAULT, |settings| settings.get().0);
    let pool = match threads {
        None => pool::shared()?,
        Some(count) => pool::of_threads(count)?.into(),
    };
    let watch = Watch::default();
    let work = || {
        let drive_all = || many::run_many(&prepared, settings, &watch);
        pool.install(drive_all)
    };
    let metrics = watched(py, &watch, prepared.len(), progress, work)??;
    Ok(columns(py, &metrics)?)
}

/// What `work` comes to on a thread of its own, while this one handles signals and progress and
/// stops it for an error in them.
fn watched<T: Send>(
    py: Python<'_>,
    watch: &Watch,
    runs: usize,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    let progress = progress.map(|progress| progress.clone().unbind());
    let look = |py: Python<'_>| {
        py.check_signals()?;
        if let Some(progress) = &progress {
            // Of no runs all are done.
            let all = from_count(runs.max(1));
            let done = if runs == 0 {
                all
            } else {
                from_count(watch.done())
            };
            progress.call1(py, (done / all,))?;
        }
        Ok(())
    };
    let (outcome, looked) = py.detach(|| {
        thread::scope(|scope| {
            let (finished, wait) = channel();
            let worker = scope.spawn(move || {
                let outcome = work();
                // Nobody waits any more once a look has failed.
                finished.send(()).unwrap_or_default();
                outcome
            });
            let mut looked: PyResult<()> = Ok(());
            while looked.is_ok() && wait.recv_timeout(LOOK_EVERY) == Err(RecvTimeoutError::Timeout)
            {
                looked = Python::attach(look);
                if looked.is_err() {
                    watch.stop();
                }
            }
            (worker.join(), looked)
        })
    });
    looked?;
    let outcome = outcome.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    look(py)?;
    Ok(outcome)
}

/// A column for each figure, an entry for each run.
fn columns<'py>(py: Python<'py>, metrics: &[Metrics]) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    for (name, figure) in figures() {
        columns.set_item(name, PyArray1::from_iter(py, metrics.iter().map(figure)))?;
    }
    let steps = metrics
        .iter()
        .map(|run| i64::try_from(run.steps).unwrap_or(i64::MAX));
    columns.set_item("steps", PyArray1::from_iter(py, steps))?;
    let finished = metrics.iter().map(|run| run.finished);
    columns.set_item("finished", PyArray1::from_iter(py, finished))?;
    let faults = metrics.iter().map(|run| run.faults.bits());
    columns.set_item("faults", PyArray1::from_iter(py, faults))?;
    Ok(columns)
}
