//! Many vehicles, one step at a time: arrays in, arrays out.

use std::sync::Arc;

use numpy::{PyArray1, PyArrayMethods};
use popsteer_core::Command;
use popsteer_core::error::{ConfigError, InputError, Requirement};
use popsteer_core::math::from_count;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

use crate::batch_inputs::{Each, Inputs, on_error_of};
use crate::errors::Raises;
use crate::params::{Count, Number};
use crate::path::PyPath;
use crate::tracker::commands::{Columns, PyCommandBatch};
use crate::vehicles::{Recipe, Vehicles, each};

/// More copies of one controller than this are a mistake, not a batch.
const MAX_COUNT: usize = 10_000_000;

/// Many vehicles under controllers of one class, stepped together on all cores.
///
/// Each vehicle has all that its controller has, the present state as well; that is a copy, and the
/// controllers are left alone. A vehicle's answers are those of its
/// controller, bit for bit. The interpreter's lock is released meanwhile; batches of up to 256
/// vehicles stay on the calling thread. The environment variable RAYON_NUM_THREADS, read at the
/// first large batch, limits the number of threads. One thread at a time may use a batch.
///
/// Parameters
/// ----------
/// controllers : sequence of Pop, PreviewPop, Pid, PurePursuit or Stanley, or one of them
///     The controllers, all of one class; several may share a path.
/// count : int, optional
///     How many copies of a single controller, up to 10,000,000; one by default.
///
/// Raises
/// ------
/// ConfigError
///     If `count` is out of its range.
/// TypeError
///     If a controller is none of popsteer's, or not of the first one's class; names its place.
///     If `count` is given with a sequence.
///
/// Examples
/// --------
/// Three vehicles on one path:
///
/// >>> import numpy as np
/// >>> path = popsteer.Path([(float(x), 0.0) for x in range(100)])
/// >>> batch = popsteer.Batch(popsteer.Pop(path), 3)
/// >>> x, y = np.array([0.0, 5.0, 9.0]), np.array([0.5, 0.0, -0.5])
/// >>> yaw, speed = np.zeros(3), np.full(3, 5.0)
/// >>> np.sign(batch.steer(x, y, yaw, speed, 0.05))
/// array([-1.,  0.,  1.])
///
/// Each with parameters of its own:
///
/// >>> gains = [popsteer.PidParams(kp=kp) for kp in (0.1, 0.2, 0.3)]
/// >>> batch = popsteer.Batch([popsteer.Pid(path, params=params) for params in gains])
/// >>> batch.step(x, y, yaw, speed, 0.05).status
/// array([0, 0, 0], dtype=uint32)
#[pyclass(name = "Batch", module = "popsteer")]
#[derive(Debug)]
pub(crate) struct PyBatch {
    vehicles: Vehicles,
    /// What makes the controllers that the batch was made of.
    recipes: Vec<Recipe>,
    /// How many copies of the one controller, where it was made of one.
    copies: Option<usize>,
    /// The paths that were given since, one a vehicle.
    paths: Vec<Option<Py<PyPath>>>,
    /// The inputs of a step, and its commands: kept to spare their allocation.
    inputs: Inputs,
    commands: Vec<Command>,
}

#[pymethods]
impl PyBatch {
    #[new]
    #[pyo3(signature = (controllers, count=None))]
    fn new(controllers: &Bound<'_, PyAny>, count: Option<Count>) -> Raises<Self> {
        let (gathered, copies) = if let Ok(several) = controllers.try_iter() {
            if count.is_some() {
                let words = "count goes with a single controller, not with a sequence";
                return Err(PyTypeError::new_err(words).into());
            }
            let several = several.collect::<PyResult<Vec<_>>>()?;
            (Vehicles::gather(&several, 1)?, None)
        } else {
            let count = checked_count(count)?;
            let one = std::slice::from_ref(controllers);
            (Vehicles::gather(one, count)?, Some(count))
        };
        let (vehicles, recipes) = gathered;
        Ok(Self {
            vehicles,
            recipes,
            copies,
            paths: Vec::new(),
            inputs: Inputs::default(),
            commands: Vec::new(),
        })
    }

    /// Take one control step with every vehicle and give the angles alone.
    ///
    /// Parameters
    /// ----------
    /// x, y : array of shape (N,)
    ///     Positions of the vehicles' points [m]. Float64 of any stride is read as it is; what
    ///     numpy calls a safe cast, such as that of float32 and of integers, is converted first.
    /// yaw : array of shape (N,)
    ///     Headings [rad], counter-clockwise from x.
    /// speed : array of shape (N,)
    ///     Speeds [m/s], negative while rolling backwards.
    /// dt : float
    ///     Time since the last step [s], 1e-6 to 1e3. Any other finite number counts as no time and
    ///     holds the last commands, as in `step` of a controller.
    /// on_error : {"raise", "nan", "hold"}, default "raise"
    ///     What a number that is not finite or beyond its bound leads to: an error, with no vehicle
    ///     stepped; or NaN for its vehicle, which keeps its state; or the last command of its
    ///     vehicle, as `step_or_hold` of a controller. The rest go on. With "nan" and "hold" the
    ///     vehicle's next step counts the time that has passed.
    /// hold_limit : int, default 10
    ///     With "hold", how many inputs in a row are held with ``Status.INPUT_HELD``; beyond, the
    ///     status is the fault ``Status.INPUT_LOST``.
    /// applied_steer : array of shape (N,), optional
    ///     The commands that were applied since the last step where those were not the batch's
    ///     [rad]; see `step` of a controller.
    /// measured_steer : array of shape (N,), optional
    ///     The measured angles of the wheels [rad]; see `step` of a controller.
    /// pose_age : float or array of shape (N,), default 0.0
    ///     How long ago poses and speeds were measured [s], 0 to 1.
    /// roll : float or array of shape (N,), default 0.0
    ///     How far the vehicles are rolled to their right [rad]; see `step` of a controller.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (N,)
    ///     Angles of the front wheels [rad]: ``step(...).steer``, bit for bit.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If an array has another length or no numbers; if `dt` is not finite, except with
    ///     "hold"; or, with "raise", if a number is, named with its place, as ``speed[3]``.
    /// ConfigError
    ///     If `on_error` is none of them.
    #[pyo3(
        signature = (
            x, y, yaw, speed, dt, *, on_error="raise", hold_limit=Count(10),
            applied_steer=None, measured_steer=None, pose_age=Each::Same(0.0), roll=Each::Same(0.0)
        ),
        text_signature = "($self, x, y, yaw, speed, dt, *, on_error='raise', hold_limit=10, applied_steer=None, measured_steer=None, pose_age=0.0, roll=0.0)"
    )]
    fn steer<'py>(
        &mut self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
        y: &Bound<'py, PyAny>,
        yaw: &Bound<'py, PyAny>,
        speed: &Bound<'py, PyAny>,
        dt: Number,
        on_error: &str,
        hold_limit: Count,
        applied_steer: Option<Bound<'py, PyAny>>,
        measured_steer: Option<Bound<'py, PyAny>>,
        pose_age: Each<'py>,
        roll: Each<'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (dt, on_error) = (dt.0, on_error_of(py, on_error, hold_limit)?);
        let count = self.vehicles.len();
        let steers = [applied_steer.as_ref(), measured_steer.as_ref()];
        self.inputs
            .read(count, [x, y, yaw, speed], steers, [&pose_age, &roll])?;
        let angles = PyArray1::<f64>::zeros(py, count, false);
        {
            let mut writable = angles.try_readwrite()?;
            let out = writable.as_slice_mut()?;
            let (inputs, reported) = (&self.inputs.vehicles, &self.inputs.reported);
            self.vehicles.work(
                py,
                |vehicles| each!(vehicles, batch => batch.steer(inputs, dt, on_error, reported, out)),
            )?;
        }
        Ok(angles)
    }

    /// Take one control step with every vehicle.
    ///
    /// Parameters and errors as `steer`. With "nan" a vehicle refused has ``Status.INPUT_HELD`` and
    /// the direction of its last command, and NaN for all else.
    ///
    /// Returns
    /// -------
    /// CommandBatch
    ///     Angles, errors, targets and status.
    #[pyo3(
        signature = (
            x, y, yaw, speed, dt, *, on_error="raise", hold_limit=Count(10),
            applied_steer=None, measured_steer=None, pose_age=Each::Same(0.0), roll=Each::Same(0.0)
        ),
        text_signature = "($self, x, y, yaw, speed, dt, *, on_error='raise', hold_limit=10, applied_steer=None, measured_steer=None, pose_age=0.0, roll=0.0)"
    )]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
        y: &Bound<'py, PyAny>,
        yaw: &Bound<'py, PyAny>,
        speed: &Bound<'py, PyAny>,
        dt: Number,
        on_error: &str,
        hold_limit: Count,
        applied_steer: Option<Bound<'py, PyAny>>,
        measured_steer: Option<Bound<'py, PyAny>>,
        pose_age: Each<'py>,
        roll: Each<'py>,
    ) -> PyResult<PyCommandBatch> {
        let (dt, on_error) = (dt.0, on_error_of(py, on_error, hold_limit)?);
        let count = self.vehicles.len();
        let steers = [applied_steer.as_ref(), measured_steer.as_ref()];
        self.inputs
            .read(count, [x, y, yaw, speed], steers, [&pose_age, &roll])?;
        self.commands.resize(count, Command::NONE);
        let (inputs, reported) = (&self.inputs.vehicles, &self.inputs.reported);
        let out = self.commands.as_mut_slice();
        let write = |place: &mut Command, command| *place = command;
        let mut columns = Columns::default();
        self.vehicles.work(py, |vehicles| {
            each!(vehicles, batch => batch.step(inputs, dt, on_error, reported, out, write))?;
            columns = Columns::of(out);
            Ok(())
        })?;
        columns.shown(py)
    }

    /// Have vehicles follow other paths from the next step on, as `set_path` of a controller.
    ///
    /// Parameters
    /// ----------
    /// path : Path or sequence of Path
    ///     One for all of the vehicles, or one for each of them.
    /// vehicles : sequence of int, optional
    ///     Which vehicles, by their places in the batch; by default all of them, in order.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If there are not as many paths as vehicles, or a place is none of the batch; no vehicle
    ///     has another path then.
    ///
    /// Examples
    /// --------
    /// >>> ahead = popsteer.Path([(0.0, 0.0), (50.0, 0.0)])
    /// >>> aside = popsteer.Path([(0.0, 3.0), (50.0, 3.0)])
    /// >>> batch = popsteer.Batch(popsteer.Pop(ahead), 3)
    /// >>> batch.set_path(aside)  # all
    /// >>> batch.set_path([ahead, aside], vehicles=[0, 2])
    #[pyo3(signature = (path, *, vehicles=None))]
    fn set_path(&mut self, path: &Bound<'_, PyAny>, vehicles: Option<Vec<Count>>) -> Raises<()> {
        let count = self.vehicles.len();
        let places: Vec<usize> = match vehicles {
            None => (0..count).collect(),
            Some(given) => given
                .into_iter()
                .map(|place| place.below(count, "vehicles"))
                .collect::<Result<_, _>>()?,
        };
        let paths: Vec<Py<PyPath>> = match path.cast::<PyPath>() {
            Ok(one) => places.iter().map(|_| one.clone().unbind()).collect(),
            Err(_) => path.extract()?,
        };
        if paths.len() != places.len() {
            return Err(InputError {
                field: "path",
                value: from_count(paths.len()),
                requirement: Requirement::CountInRange(places.len(), places.len()),
            }
            .into());
        }
        self.paths.resize_with(count, || None);
        for (place, path) in places.into_iter().zip(paths) {
            let shared = Arc::clone(&path.get().0);
            each!(&mut self.vehicles, batch => batch.set_path(place, shared));
            if let Some(kept) = self.paths.get_mut(place) {
                *kept = Some(path);
            }
        }
        Ok(())
    }

    /// Forget all steps, those of the controllers before the batch was made too.
    fn reset(&mut self) {
        each!(&mut self.vehicles, batch => batch.reset());
    }

    /// What each vehicle's controller remembers, as a new ``list`` of copies.
    #[getter]
    fn states<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        self.vehicles.states(py)
    }

    fn __len__(&self) -> usize {
        self.vehicles.len()
    }

    /// The controllers that it was made of, before their first steps; and how many copies.
    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let mut controllers = self.recipes.iter().map(|recipe| recipe.make(py));
        match (self.copies, controllers.next()) {
            (Some(copies), Some(one)) => (one?, copies).into_pyobject(py),
            (_, first) => {
                let all = first.into_iter().chain(controllers);
                (PyList::new(py, all.collect::<PyResult<Vec<_>>>()?)?,).into_pyobject(py)
            }
        }
    }

    /// The states, and the paths that were given since it was made.
    fn __getstate__<'py>(&self, py: Python<'py>) -> PyResult<Kept<'py>> {
        let paths = self
            .paths
            .iter()
            .map(|path| Some(path.as_ref()?.clone_ref(py)));
        Ok((self.states(py)?, paths.collect()))
    }

    fn __setstate__(&mut self, kept: Kept<'_>) -> PyResult<()> {
        let (states, paths) = kept;
        for (place, path) in paths.iter().enumerate() {
            if let Some(path) = path {
                let shared = Arc::clone(&path.get().0);
                each!(&mut self.vehicles, batch => batch.set_path(place, shared));
            }
        }
        self.paths = paths;
        Ok(self.vehicles.set_states(&states)?)
    }

    fn __repr__(&self) -> String {
        format!("<Batch of {} vehicles>", self.vehicles.len())
    }
}

/// What a pickled batch keeps.
type Kept<'py> = (Bound<'py, PyList>, Vec<Option<Py<PyPath>>>);

/// The number of copies that is asked for.
fn checked_count(count: Option<Count>) -> Result<usize, ConfigError> {
    let count = count.unwrap_or(Count(1));
    match usize::try_from(count.0) {
        Ok(copies) if copies <= MAX_COUNT => Ok(copies),
        _ => Err(ConfigError {
            field: "count",
            value: count.shown(),
            requirement: Requirement::CountInRange(0, MAX_COUNT),
        }),
    }
}
