//! What a step of a batch answers.

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use popsteer_core::{Command, InputError};
use pyo3::prelude::*;

use crate::command::status_code;

/// The status of a vehicle that was refused.
const REFUSED: u8 = 255;

/// What a step answers to one vehicle.
#[derive(Clone, Copy)]
pub(crate) struct Row {
    steer: f64,
    cross_track_error: f64,
    heading_error: f64,
    target: [f64; 2],
    reverse: bool,
    status: u8,
}

impl Row {
    /// Of a vehicle that was refused.
    pub(crate) const REFUSED: Self = Self {
        steer: f64::NAN,
        cross_track_error: f64::NAN,
        heading_error: f64::NAN,
        target: [f64::NAN; 2],
        reverse: false,
        status: REFUSED,
    };

    /// The row of an answer.
    pub(crate) fn new(answer: Result<Command, InputError>) -> Self {
        answer.map_or(Self::REFUSED, |command| Self {
            steer: command.steer,
            cross_track_error: command.cross_track_error,
            heading_error: command.heading_error,
            target: [command.target.x, command.target.y],
            reverse: command.reverse,
            status: status_code(command.status),
        })
    }
}

/// What one step of a batch answers: `Command` in columns, an entry a vehicle.
///
/// Attributes
/// ----------
/// steer : ndarray of shape (N,)
///     Angles of the front wheels [rad], positive to the left.
/// cross_track_error : ndarray of shape (N,)
///     Offsets of the law's reference point from the path [m], positive left of it.
/// heading_error : ndarray of shape (N,)
///     Yaw less direction of the path [rad], in [-pi, pi].
/// target : ndarray of shape (N, 2)
///     The points aimed at, (x, y) [m].
/// status : ndarray of shape (N,) of uint8
///     0 ok, 1 lookahead lost, 2 saturated; 255 a vehicle that was refused, whose other entries
///     are NaN.
#[pyclass(frozen, name = "CommandBatch", module = "popsteer")]
#[derive(Debug)]
pub(crate) struct PyCommandBatch {
    steer: Py<PyArray1<f64>>,
    cross_track_error: Py<PyArray1<f64>>,
    heading_error: Py<PyArray1<f64>>,
    target: Py<PyArray2<f64>>,
    reverse: Py<PyArray1<bool>>,
    status: Py<PyArray1<u8>>,
    count: usize,
}

#[pymethods]
impl PyCommandBatch {
    /// Angles of the front wheels [rad], positive to the left.
    #[getter]
    fn steer(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        self.steer.clone_ref(py)
    }

    /// Offsets of the law's reference point from the path [m], positive left of it.
    #[getter]
    fn cross_track_error(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        self.cross_track_error.clone_ref(py)
    }

    /// Yaw less direction of the path [rad], in [-pi, pi].
    #[getter]
    fn heading_error(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        self.heading_error.clone_ref(py)
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

    /// How the steps went: 0 ok, 1 lookahead lost, 2 saturated, 255 refused.
    #[getter]
    fn status(&self, py: Python<'_>) -> Py<PyArray1<u8>> {
        self.status.clone_ref(py)
    }

    fn __len__(&self) -> usize {
        self.count
    }

    fn __repr__(&self) -> String {
        format!("<CommandBatch of {} vehicles>", self.count)
    }
}

impl PyCommandBatch {
    /// The rows in columns.
    pub(crate) fn new(py: Python<'_>, rows: &[Row]) -> PyResult<Self> {
        let column =
            |field: fn(&Row) -> f64| PyArray1::from_iter(py, rows.iter().map(field)).unbind();
        let target = PyArray1::from_iter(py, rows.iter().flat_map(|row| row.target));
        Ok(Self {
            steer: column(|row| row.steer),
            cross_track_error: column(|row| row.cross_track_error),
            heading_error: column(|row| row.heading_error),
            target: target.reshape([rows.len(), 2])?.unbind(),
            reverse: PyArray1::from_iter(py, rows.iter().map(|row| row.reverse)).unbind(),
            status: PyArray1::from_iter(py, rows.iter().map(|row| row.status)).unbind(),
            count: rows.len(),
        })
    }
}
