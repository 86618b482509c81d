//! What a call from Python costs by itself, for the benchmark.

use pyo3::prelude::*;

use crate::params::{Number, number};

/// What the benchmark times beside controllers: its `steer` has their signature and does nothing.
#[pyclass(name = "_EmptyCall", module = "popsteer._core")]
pub(crate) struct PyEmptyCall;

#[pymethods]
impl PyEmptyCall {
    #[new]
    fn new() -> Self {
        Self
    }

    /// Nothing was remembered.
    #[expect(clippy::unused_self, reason = "called as a controller's")]
    fn reset(&self) {}

    /// Return at once.
    #[pyo3(signature = (
        x, y, yaw, speed, dt, /, *, applied_steer=None, measured_steer=None, pose_age=0.0, roll=0.0
    ))]
    #[expect(
        unused_variables,
        clippy::unused_self,
        clippy::unnecessary_wraps,
        reason = "the signature is the point"
    )]
    fn steer(
        &mut self,
        x: Number,
        y: Number,
        yaw: Number,
        speed: Number,
        dt: Number,
        applied_steer: Option<Number>,
        measured_steer: Option<Number>,
        #[pyo3(from_py_with = number)] pose_age: f64,
        #[pyo3(from_py_with = number)] roll: f64,
    ) -> PyResult<f64> {
        Ok(yaw.0)
    }
}
