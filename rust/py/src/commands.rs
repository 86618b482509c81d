//! What a step of a batch answers.

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use popsteer_core::Command;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

type Column = Py<PyArray1<f64>>;

/// What one step of a batch answers: `Command` in columns, an entry a vehicle.
///
/// Parameters
/// ----------
/// steer : ndarray of shape (N,)
///     Angles to command [rad], positive to the left.
/// cross_track_error : ndarray of shape (N,)
///     Offsets of the tracked points from the path [m], positive left of it.
/// heading_error : ndarray of shape (N,)
///     Yaw less direction of the path [rad], in [-pi, pi].
/// predicted_cross_track_error : ndarray of shape (N,)
///     Cross-track errors of the vehicles as they will be when the commands reach the wheels [m].
/// predicted_heading_error : ndarray of shape (N,)
///     Heading errors of those [rad].
/// target : ndarray of shape (N, 2)
///     The points aimed at, (x, y) [m].
/// reverse : ndarray of shape (N,) of bool
///     Whether the path is driven backwards there.
/// reference_speed : ndarray of shape (N,)
///     The paths' speeds beside the rear axles [m/s]; NaN where a path has no speeds.
/// distance_to_stop : ndarray of shape (N,)
///     Distances along the paths to the next cusp, or to the end [m]; inf where there is neither.
/// status : ndarray of shape (N,) of uint32
///     How the steps went, as the bits of `Status`.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> path = popsteer.Path([(0.0, 0.0), (100.0, 0.0)])
/// >>> batch = popsteer.Batch(popsteer.BangBang(path), 2)
/// >>> x, y = np.array([5.0, 99.0]), np.array([0.5, -0.5])
/// >>> commands = batch.step(x, y, np.zeros(2), np.full(2, 5.0), 0.05)
/// >>> commands.steer, (commands.status & popsteer.Status.END_OF_PATH) > 0
/// (array([-0.122,  0.122]), array([False,  True]))
#[pyclass(frozen, name = "CommandBatch", module = "popsteer")]
#[derive(Debug)]
pub(crate) struct PyCommandBatch {
    steer: Column,
    cross_track_error: Column,
    heading_error: Column,
    predicted_cross_track_error: Column,
    predicted_heading_error: Column,
    target: Py<PyArray2<f64>>,
    reverse: Py<PyArray1<bool>>,
    reference_speed: Column,
    distance_to_stop: Column,
    status: Py<PyArray1<u32>>,
    count: usize,
}

#[pymethods]
impl PyCommandBatch {
    #[new]
    #[pyo3(signature = (
        *, steer, cross_track_error, heading_error, predicted_cross_track_error,
        predicted_heading_error, target, reverse, reference_speed, distance_to_stop, status
    ))]
    fn made_of(
        py: Python<'_>,
        steer: Column,
        cross_track_error: Column,
        heading_error: Column,
        predicted_cross_track_error: Column,
        predicted_heading_error: Column,
        target: Py<PyArray2<f64>>,
        reverse: Py<PyArray1<bool>>,
        reference_speed: Column,
        distance_to_stop: Column,
        status: Py<PyArray1<u32>>,
    ) -> PyResult<Self> {
        let count = steer.bind(py).len();
        let lengths = [
            cross_track_error.bind(py).len(),
            heading_error.bind(py).len(),
            predicted_cross_track_error.bind(py).len(),
            predicted_heading_error.bind(py).len(),
            reverse.bind(py).len(),
            reference_speed.bind(py).len(),
            distance_to_stop.bind(py).len(),
            status.bind(py).len(),
        ];
        if lengths != [count; 8] || target.bind(py).shape() != [count, 2] {
            return Err(PyValueError::new_err(
                "the columns of a CommandBatch must be equally long, and the target of shape (N, 2)",
            ));
        }
        Ok(Self {
            steer,
            cross_track_error,
            heading_error,
            predicted_cross_track_error,
            predicted_heading_error,
            target,
            reverse,
            reference_speed,
            distance_to_stop,
            status,
            count,
        })
    }

    /// Angles to command [rad], positive to the left.
    #[getter]
    fn steer(&self, py: Python<'_>) -> Column {
        self.steer.clone_ref(py)
    }

    /// Offsets of the tracked points from the path [m], positive left of it.
    #[getter]
    fn cross_track_error(&self, py: Python<'_>) -> Column {
        self.cross_track_error.clone_ref(py)
    }

    /// Yaw less direction of the path [rad], in [-pi, pi].
    #[getter]
    fn heading_error(&self, py: Python<'_>) -> Column {
        self.heading_error.clone_ref(py)
    }

    /// Cross-track errors of the vehicles as they will be when the commands reach the wheels [m].
    #[getter]
    fn predicted_cross_track_error(&self, py: Python<'_>) -> Column {
        self.predicted_cross_track_error.clone_ref(py)
    }

    /// Heading errors of those [rad].
    #[getter]
    fn predicted_heading_error(&self, py: Python<'_>) -> Column {
        self.predicted_heading_error.clone_ref(py)
    }

    /// The points aimed at, (x, y) [m].
    #[getter]
    fn target(&self, py: Python<'_>) -> Py<PyArray2<f64>> {
        self.target.clone_ref(py)
    }

    /// Whether the path is driven backwards there, shape (N,).
    #[getter]
    fn reverse(&self, py: Python<'_>) -> Py<PyArray1<bool>> {
        self.reverse.clone_ref(py)
    }

    /// The paths' speeds beside the rear axles [m/s]; NaN where a path has no speeds.
    #[getter]
    fn reference_speed(&self, py: Python<'_>) -> Column {
        self.reference_speed.clone_ref(py)
    }

    /// Distances along the paths to the next cusp, or to the end [m]; inf where there is neither.
    #[getter]
    fn distance_to_stop(&self, py: Python<'_>) -> Column {
        self.distance_to_stop.clone_ref(py)
    }

    /// How the steps went, as the bits of `Status`.
    #[getter]
    fn status(&self, py: Python<'_>) -> Py<PyArray1<u32>> {
        self.status.clone_ref(py)
    }

    fn __len__(&self) -> usize {
        self.count
    }

    fn __repr__(&self) -> String {
        format!("<CommandBatch of {} vehicles>", self.count)
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        let columns = PyDict::new(py);
        columns.set_item("steer", &self.steer)?;
        columns.set_item("cross_track_error", &self.cross_track_error)?;
        columns.set_item("heading_error", &self.heading_error)?;
        columns.set_item(
            "predicted_cross_track_error",
            &self.predicted_cross_track_error,
        )?;
        columns.set_item("predicted_heading_error", &self.predicted_heading_error)?;
        columns.set_item("target", &self.target)?;
        columns.set_item("reverse", &self.reverse)?;
        columns.set_item("reference_speed", &self.reference_speed)?;
        columns.set_item("distance_to_stop", &self.distance_to_stop)?;
        columns.set_item("status", &self.status)?;
        Ok((PyTuple::empty(py), columns))
    }
}

impl PyCommandBatch {
    /// The commands in columns.
    pub(crate) fn new(py: Python<'_>, commands: &[Command]) -> PyResult<Self> {
        let column = |field: fn(&Command) -> f64| {
            PyArray1::from_iter(py, commands.iter().map(field)).unbind()
        };
        let targets = commands.iter().map(|command| command.target);
        let target = PyArray1::from_iter(py, targets.flat_map(|target| [target.x, target.y]));
        let reverse = commands.iter().map(|command| command.reverse);
        let status = commands.iter().map(|command| command.status.bits());
        Ok(Self {
            steer: column(|command| command.steer),
            cross_track_error: column(|command| command.cross_track_error),
            heading_error: column(|command| command.heading_error),
            predicted_cross_track_error: column(|command| command.predicted_cross_track_error),
            predicted_heading_error: column(|command| command.predicted_heading_error),
            target: target.reshape([commands.len(), 2])?.unbind(),
            reverse: PyArray1::from_iter(py, reverse).unbind(),
            reference_speed: column(|command| command.reference_speed.unwrap_or(f64::NAN)),
            distance_to_stop: column(|command| command.distance_to_stop),
            status: PyArray1::from_iter(py, status).unbind(),
            count: commands.len(),
        })
    }
}
