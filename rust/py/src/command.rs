//! What a step answers.

use popsteer_core::{Command, Status};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

static STATUS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

/// The member of `popsteer.Status` for a status of the core.
pub(crate) fn status_member(py: Python<'_>, status: Status) -> PyResult<Bound<'_, PyAny>> {
    let class = STATUS.get_or_try_init(py, || {
        py.import("popsteer.status")?
            .getattr("Status")
            .map(Bound::unbind)
    })?;
    let member = match status {
        Status::Ok => "OK",
        Status::LookaheadLost => "LOOKAHEAD_LOST",
        Status::Saturated => "SATURATED",
        Status::EndOfPath => "END_OF_PATH",
        Status::OffPath => "OFF_PATH",
        Status::InputHeld => "INPUT_HELD",
        Status::InputLost => "INPUT_LOST",
    };
    class.bind(py).getattr(member)
}

/// The status as a number, as arrays hold it.
pub(crate) fn status_code(status: Status) -> u8 {
    match status {
        Status::Ok => 0,
        Status::LookaheadLost => 1,
        Status::Saturated => 2,
        Status::EndOfPath => 3,
        Status::OffPath => 4,
        Status::InputHeld => 5,
        Status::InputLost => 6,
    }
}

/// What one step of a lateral law answers.
///
/// Attributes
/// ----------
/// steer : float
///     Angle of the front wheels [rad], positive to the left.
/// cross_track_error : float
///     Offset of the law's reference point from the path [m], positive left of it.
/// heading_error : float
///     Yaw less direction of the path [rad], in [-pi, pi].
/// target : tuple of float
///     The point aimed at, (x, y) [m]: the lookahead point, or the foot on the path.
/// reverse : bool
///     Whether the path is driven backwards here.
/// status : Status
///     How the step went.
#[pyclass(frozen, eq, name = "Command", module = "popsteer")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PyCommand(pub(crate) Command);

#[pymethods]
impl PyCommand {
    /// Angle of the front wheels [rad], positive to the left.
    #[getter]
    fn steer(&self) -> f64 {
        self.0.steer
    }

    /// Offset of the law's reference point from the path [m], positive left of it.
    #[getter]
    fn cross_track_error(&self) -> f64 {
        self.0.cross_track_error
    }

    /// Yaw less direction of the path [rad], in [-pi, pi].
    #[getter]
    fn heading_error(&self) -> f64 {
        self.0.heading_error
    }

    /// The point aimed at, (x, y) [m].
    #[getter]
    fn target(&self) -> (f64, f64) {
        (self.0.target.x, self.0.target.y)
    }

    /// Whether the path is driven backwards here.
    #[getter]
    fn reverse(&self) -> bool {
        self.0.reverse
    }

    /// How the step went.
    #[getter]
    fn status<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        status_member(py, self.0.status)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let Command {
            steer,
            cross_track_error,
            heading_error,
            target,
            reverse,
            status,
        } = self.0;
        Ok(format!(
            "Command(steer={steer:?}, cross_track_error={cross_track_error:?}, \
             heading_error={heading_error:?}, target=({:?}, {:?}), reverse={}, status={})",
            target.x,
            target.y,
            if reverse { "True" } else { "False" },
            status_member(py, status)?.repr()?
        ))
    }
}
