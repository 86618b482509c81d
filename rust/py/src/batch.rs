//! Many vehicles, one step at a time: arrays in, arrays out.

use numpy::{PyArray1, PyArrayMethods};
use popsteer_core::VehicleState;
use popsteer_core::error::{ConfigError, Requirement};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyList;

use crate::arrays::column;
use crate::commands::{PyCommandBatch, Row};
use crate::errors::{OrRaise, unknown};
use crate::params::Count;
use crate::vehicles::{Vehicles, each};

/// More copies of one controller than this are a mistake, not a batch.
const MAX_COUNT: usize = 10_000_000;

/// Many vehicles under one law, stepped together on all cores.
///
/// Each vehicle has the parameters, the path and the present state of its controller; the state
/// is a copy, and the controllers are left alone. A vehicle's answers are those of its
/// controller, bit for bit. The interpreter's lock is released meanwhile; batches of up to 256
/// vehicles stay on the calling thread. The environment variable RAYON_NUM_THREADS, read at the
/// first large batch, limits the number of threads. One thread at a time may use a batch.
///
/// Parameters
/// ----------
/// controllers : sequence of Pop, PreviewPop, Pid, PurePursuit, Stanley or BangBang, or one of them
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
/// >>> batch = popsteer.Batch([popsteer.Pid(path, params) for params in gains])
/// >>> batch.step(x, y, yaw, speed, 0.05).status
/// array([0, 0, 0], dtype=uint8)
#[pyclass(name = "Batch", module = "popsteer")]
#[derive(Debug)]
pub(crate) struct PyBatch {
    vehicles: Vehicles,
    /// Kept from step to step, to spare its allocation.
    inputs: Vec<VehicleState>,
}

#[pymethods]
impl PyBatch {
    #[new]
    #[pyo3(signature = (controllers, count=None))]
    fn new(py: Python<'_>, controllers: &Bound<'_, PyAny>, count: Option<Count>) -> PyResult<Self> {
        let vehicles = if let Ok(several) = controllers.try_iter() {
            if count.is_some() {
                return Err(PyTypeError::new_err(
                    "count goes with a single controller, not with a sequence",
                ));
            }
            let several = several.collect::<PyResult<Vec<_>>>()?;
            Vehicles::gather(&several, 1)?
        } else {
            let count = checked_count(count).or_raise(py)?;
            Vehicles::gather(std::slice::from_ref(controllers), count)?
        };
        Ok(Self {
            vehicles,
            inputs: Vec::new(),
        })
    }

    /// Take one control step with every vehicle and give the angles alone.
    ///
    /// Parameters
    /// ----------
    /// x, y : array of shape (N,)
    ///     Positions of the rear axles [m]. Float64 of any stride is read as it is; what numpy
    ///     calls a safe cast, such as that of float32 and of integers, is converted first.
    /// yaw : array of shape (N,)
    ///     Headings [rad], counter-clockwise from x.
    /// speed : array of shape (N,)
    ///     Forward speeds [m/s].
    /// dt : float
    ///     Time since the last step [s], 1e-6 to 1e3.
    /// on_error : {"raise", "nan"}, default "raise"
    ///     What a number that is not finite or beyond its bound leads to: an error, with no
    ///     vehicle stepped; or NaN for its vehicle, which keeps its state, while the rest go on.
    ///
    /// Returns
    /// -------
    /// ndarray of shape (N,)
    ///     Angles of the front wheels [rad]: ``step(...).steer``, bit for bit.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If an array has another length or no numbers, `dt` is out of its range, or, with
    ///     "raise", a number is; it is named with its place, as ``speed[3]``.
    /// ConfigError
    ///     If `on_error` is neither.
    #[pyo3(signature = (x, y, yaw, speed, dt, *, on_error="raise"))]
    fn steer<'py>(
        &mut self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
        y: &Bound<'py, PyAny>,
        yaw: &Bound<'py, PyAny>,
        speed: &Bound<'py, PyAny>,
        dt: f64,
        on_error: &str,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let skip = skips_refused(py, on_error)?;
        self.read(x, y, yaw, speed)?;
        let angles = PyArray1::<f64>::zeros(py, self.inputs.len(), false);
        {
            let mut writable = angles.try_readwrite()?;
            let out = writable.as_slice_mut()?;
            let inputs = &self.inputs;
            self.vehicles.work(
                py,
                |vehicles| each!(vehicles, batch => batch.steer(inputs, dt, skip, out)),
            )?;
        }
        Ok(angles)
    }

    /// Take one control step with every vehicle.
    ///
    /// Parameters
    /// ----------
    /// x, y : array of shape (N,)
    ///     Positions of the rear axles [m]. Float64 of any stride is read as it is; what numpy
    ///     calls a safe cast, such as that of float32 and of integers, is converted first.
    /// yaw : array of shape (N,)
    ///     Headings [rad], counter-clockwise from x.
    /// speed : array of shape (N,)
    ///     Forward speeds [m/s].
    /// dt : float
    ///     Time since the last step [s], 1e-6 to 1e3.
    /// on_error : {"raise", "nan"}, default "raise"
    ///     As for `steer`; a vehicle refused has the status 255.
    ///
    /// Returns
    /// -------
    /// CommandBatch
    ///     Angles, errors, targets and status.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     As for `steer`.
    /// ConfigError
    ///     As for `steer`.
    #[pyo3(signature = (x, y, yaw, speed, dt, *, on_error="raise"))]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
        y: &Bound<'py, PyAny>,
        yaw: &Bound<'py, PyAny>,
        speed: &Bound<'py, PyAny>,
        dt: f64,
        on_error: &str,
    ) -> PyResult<PyCommandBatch> {
        let skip = skips_refused(py, on_error)?;
        self.read(x, y, yaw, speed)?;
        let mut rows = vec![Row::REFUSED; self.inputs.len()];
        let (inputs, out) = (&self.inputs, rows.as_mut_slice());
        let write = |row: &mut Row, answer| *row = Row::new(answer);
        self.vehicles.work(
            py,
            |vehicles| each!(vehicles, batch => batch.step(inputs, dt, skip, out, write)),
        )?;
        PyCommandBatch::new(py, &rows)
    }

    /// Forget all steps, those of the controllers before the batch was made too.
    fn reset(&mut self) {
        each!(&mut self.vehicles, batch => batch.reset());
    }

    /// What each vehicle's law remembers, as a new ``list`` of copies.
    #[getter]
    fn states<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        self.vehicles.states(py)
    }

    fn __len__(&self) -> usize {
        self.vehicles.len()
    }

    fn __repr__(&self) -> String {
        format!("<Batch of {} vehicles>", self.vehicles.len())
    }
}

impl PyBatch {
    /// Copies the arrays: other threads may write to them while the lock is released.
    fn read(
        &mut self,
        x: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        yaw: &Bound<'_, PyAny>,
        speed: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let count = self.vehicles.len();
        let (x, y) = (column(x, "x", count)?, column(y, "y", count)?);
        let (yaw, speed) = (column(yaw, "yaw", count)?, column(speed, "speed", count)?);
        let (x, y, yaw, speed) = (x.as_array(), y.as_array(), yaw.as_array(), speed.as_array());
        let poses = x.iter().zip(y).zip(yaw).zip(speed);
        self.inputs.clear();
        self.inputs
            .extend(poses.map(|(((&x, &y), &yaw), &speed)| VehicleState { x, y, yaw, speed }));
        Ok(())
    }
}

/// The number of copies that is asked for.
#[expect(
    clippy::cast_precision_loss,
    reason = "shown in an error, where it is out of range"
)]
fn checked_count(count: Option<Count>) -> Result<usize, ConfigError> {
    let Count(count) = count.unwrap_or(Count(1));
    match usize::try_from(count) {
        Ok(copies) if copies <= MAX_COUNT => Ok(copies),
        _ => Err(ConfigError {
            field: "count",
            value: count as f64,
            requirement: Requirement::CountInRange(0, MAX_COUNT),
        }),
    }
}

/// Whether `on_error` says to go on.
fn skips_refused(py: Python<'_>, on_error: &str) -> PyResult<bool> {
    match on_error {
        "raise" => Ok(false),
        "nan" => Ok(true),
        _ => Err(unknown(py, "on_error", on_error, &["raise", "nan"])),
    }
}
