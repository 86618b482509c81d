//! Many vehicles that are steered from outside: actions in, arrays out.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use popsteer_core::VehicleState;
use popsteer_core::path::Follow;
use popsteer_sim::episodes::{Episode, FIGURES, INFO, PREVIEW_BOUND, Terms};
use popsteer_sim::{Episodes, Settings, Simulation, Weights};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use pyo3::{PyTraverseError, PyVisit};

use crate::errors::{Raises, entry_error};
use crate::path::PyPath;
use crate::plants::{any_plant, python_plant};
use crate::pool;
use crate::python_plant::{PythonPlant, limit_of};
use crate::sim::PySettings;
use crate::speed::controllers::longitudinal_of;

/// Observations, rewards, whether the episodes are terminated, whether they are truncated, info.
type StepArrays<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray2<f64>>,
);

/// Many vehicles on episodes of their own, as `popsteer.adapters.gymnasium` steps them.
///
/// Vehicles of the core's plants are stepped on all cores with the interpreter's lock released; as
/// soon as one is a plant in Python, all are stepped one by one.
///
/// `count` vehicles, none of which has begun; `preview`, how far ahead along the path the points lie
/// that are observed [m]; `weights` of progress, cross_track_error, heading_error, steer_rate and
/// off_path; `longitudinal`, which works the pedals, or else the actions do; `stall_time` [s], after
/// which an episode is truncated that gets no farther along its path. Raises ConfigError where a
/// weight is out of its range.
#[pyclass(name = "Episodes", module = "popsteer._core")]
#[derive(Debug)]
pub(crate) struct PyEpisodes {
    episodes: Episodes,
    settings: Settings,
    /// What kept the vehicles that are plants in Python from going on.
    limits: Vec<Option<String>>,
}

#[pymethods]
impl PyEpisodes {
    #[new]
    #[pyo3(signature = (count, preview, weights, *, longitudinal=None, settings=None, stall_time=None))]
    fn new(
        count: usize,
        preview: Vec<f64>,
        weights: (f64, f64, f64, f64, f64),
        longitudinal: Option<&Bound<'_, PyAny>>,
        settings: Option<Py<PySettings>>,
        stall_time: Option<f64>,
    ) -> Raises<Self> {
        let longitudinal = match longitudinal {
            None => None,
            Some(longitudinal) => Some(longitudinal_of(longitudinal).ok_or_else(|| {
                PyTypeError::new_err("longitudinal must be a CoupledLongitudinal or a SpeedPid")
            })?),
        };
        let (progress, cross_track_error, heading_error, steer_rate, off_path) = weights;
        let weights = Weights {
            progress,
            cross_track_error,
            heading_error,
            steer_rate,
            off_path,
        };
        let terms = Terms {
            longitudinal,
            preview,
            weights,
            stall_time: stall_time.unwrap_or(f64::INFINITY),
        };
        let settings = settings.map_or(Settings::DEFAULT, |settings| settings.get().0);
        Ok(Self {
            episodes: Episodes::new(count, terms)?,
            settings: Settings {
                keep_records: false,
                ..settings
            },
            limits: vec![None; count],
        })
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.python_plants()
            .try_for_each(|plant| plant.traverse(&visit))
    }

    fn __clear__(&mut self) {
        self.python_plants().for_each(PythonPlant::clear);
    }

    fn __len__(&self) -> usize {
        self.episodes.len()
    }

    /// Begin a new episode with the vehicle at a place: `start` is the pose of its point, (x, y, yaw)
    /// [m, m, rad], `speed` its speed [m/s].
    ///
    /// Raises ConfigError where the plant is not known, InputError where the start is not finite or
    /// beyond its bound, or the plant cannot start like that, and PathError where the path is driven
    /// backwards in places and the plant does not reverse.
    #[pyo3(signature = (vehicle, path, plant, start, speed, /))]
    fn begin(
        &mut self,
        py: Python<'_>,
        vehicle: usize,
        path: Py<PyPath>,
        plant: &Bound<'_, PyAny>,
        start: (f64, f64, f64),
        speed: f64,
    ) -> Raises<()> {
        let plant = any_plant(plant)?;
        let (x, y, yaw) = start;
        let start = VehicleState { x, y, yaw, speed };
        let car = plant.vehicle();
        let tracked = Follow::of(car, car.rear_axle, 0.0);
        let path = Arc::clone(&path.get().0);
        let simulation = Simulation::new(path, plant, start, tracked, self.settings)?;
        if let Some(plant) = python_plant(&simulation) {
            plant.reset(py, start)?;
        }
        self.episodes.begin(vehicle, simulation);
        if let Some(limit) = self.limits.get_mut(vehicle) {
            *limit = None;
        }
        Ok(())
    }

    /// Move every vehicle by one control step, but for those that `rest`; the answer is that of `look`.
    ///
    /// `actions`, shape (N, 1) or (N, 2), are the steering as a share of the largest angle, and the
    /// pedals where nothing else works them, throttle above 0 and brake below; beyond -1 and 1 they
    /// count as those. Raises InputError where one is not finite, named with its vehicle, as
    /// ``action[3]``; nothing has moved then.
    #[pyo3(signature = (actions, rest, /))]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        actions: PyReadonlyArray2<'py, f64>,
        rest: PyReadonlyArray1<'py, bool>,
    ) -> PyResult<StepArrays<'py>> {
        // Copied: other threads may write to them while the lock is released.
        let actions: Vec<f64> = actions.as_array().iter().copied().collect();
        let rest: Vec<bool> = rest.as_array().iter().copied().collect();
        let width = self.episodes.terms().actions();
        if actions.len() != width * self.episodes.len() || rest.len() != self.episodes.len() {
            return Err(PyTypeError::new_err("actions and rest: an entry a vehicle"));
        }
        let in_python = self.python_plants().next().is_some();
        let episodes = &mut self.episodes;
        let stepped = if in_python {
            episodes.step(&actions, &rest, false)
        } else {
            let pool = pool::shared()?;
            py.detach(|| {
                if episodes.len() <= popsteer_sim::episodes::CHUNK {
                    episodes.step(&actions, &rest, false)
                } else {
                    pool.install(|| episodes.step(&actions, &rest, true))
                }
            })
        };
        stepped.map_err(|refused| entry_error(py, refused.vehicle, refused.error))?;
        self.look_at_plants(py)?;
        Ok(self.look(py))
    }

    /// See the vehicles as they are, without a step: observations, shape (N, D) of float32; the
    /// rewards of the last step, shape (N,); whether the episodes are terminated, and whether they
    /// are truncated, shape (N,) of bool; a column for each of the names of `info_names`.
    fn look<'py>(&self, py: Python<'py>) -> StepArrays<'py> {
        let (count, width) = (self.episodes.len(), self.episodes.terms().observations());
        let mut observations = Vec::with_capacity(count * width);
        let mut info = Vec::with_capacity(count * INFO.len());
        for episode in self.episodes.episodes() {
            if let Some(episode) = episode {
                observations.extend_from_slice(&episode.observation);
                info.extend_from_slice(&episode.info);
            } else {
                observations.resize(observations.len() + width, 0.0);
                info.resize(info.len() + INFO.len(), 0.0);
            }
        }
        let each = || self.episodes.episodes();
        let flags = |flag: fn(&Episode) -> bool| {
            PyArray1::from_iter(py, each().map(|one| one.is_some_and(flag)))
        };
        let rewards = each().map(|one| one.map_or(0.0, |one| one.reward));
        let rows = |width| [count, width];
        let observations = PyArray1::from_vec(py, observations).reshape(rows(width));
        let info = PyArray1::from_vec(py, info).reshape(rows(INFO.len()));
        (
            observations.expect("as many numbers as were gathered"),
            PyArray1::from_iter(py, rewards),
            flags(Episode::is_terminated),
            flags(Episode::is_truncated),
            info.expect("as many numbers as were gathered"),
        )
    }

    /// How the episode of a vehicle ended: "finished", "off the path", "no progress", "time limit",
    /// "plant limit: WHICH"; None while it goes on, and of a vehicle that has not begun.
    #[pyo3(signature = (vehicle, /))]
    fn ending(&self, vehicle: usize) -> Option<String> {
        if let Some(Some(limit)) = self.limits.get(vehicle) {
            return Some(format!("plant limit: {limit}"));
        }
        let episode = self.episodes.episodes().nth(vehicle)??;
        let ending = if episode.simulation().is_finished() {
            "finished"
        } else if episode.is_terminated() {
            "off the path"
        } else if episode.is_truncated() && episode.is_stalled() {
            "no progress"
        } else if episode.is_truncated() {
            "time limit"
        } else {
            return None;
        };
        Some(ending.to_owned())
    }

    /// What an observation begins with, and the bound of each number; two coordinates for each
    /// distance of the preview follow, within the bound under "preview".
    #[staticmethod]
    fn figures(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let preview = [("preview", PREVIEW_BOUND)];
        FIGURES.into_iter().chain(preview).into_py_dict(py)
    }

    /// The names of the columns of info.
    #[staticmethod]
    fn info_names() -> Vec<&'static str> {
        INFO.to_vec()
    }
}

impl PyEpisodes {
    /// The vehicles that are plants in Python.
    fn python_plants(&self) -> impl Iterator<Item = &PythonPlant> {
        let begun = self.episodes.episodes().flatten();
        begun.filter_map(|episode| python_plant(episode.simulation()))
    }

    /// Raises what a plant in Python raised; a limit of it ends its episode instead.
    fn look_at_plants(&mut self, py: Python<'_>) -> PyResult<()> {
        for vehicle in 0..self.episodes.len() {
            let episode = self.episodes.episodes().nth(vehicle).flatten();
            let plant = episode.and_then(|episode| python_plant(episode.simulation()));
            let Some(error) = plant.and_then(PythonPlant::take_fault) else {
                continue;
            };
            let Some(limit) = limit_of(py, &error)? else {
                return Err(error);
            };
            self.episodes.fail(vehicle);
            if let Some(place) = self.limits.get_mut(vehicle) {
                *place = Some(limit);
            }
        }
        Ok(())
    }
}
