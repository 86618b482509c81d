//! What a step answers.

use popsteer_core::{Command, Point, Status};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple};

/// Combinations of the conditions of a [`Status`].
const COMBINATIONS: usize = 1 << Status::NAMES.len();

/// The `popsteer.Status` of each combination that has been asked for.
static STATUSES: [PyOnceLock<Py<PyAny>>; COMBINATIONS] =
    [const { PyOnceLock::new() }; COMBINATIONS];

/// A status as it goes between Python and the core.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PyStatus(pub(crate) Status);

impl<'py> IntoPyObject<'py> for PyStatus {
    type Target = PyAny;
    type Output = Bound<'py, PyAny>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        let bits = self.0.bits();
        let make = || {
            let class = py.import("popsteer.status")?.getattr("Status")?;
            class.call1((bits,)).map(Bound::unbind)
        };
        // The conditions fill the bits from the lowest on.
        match STATUSES.get(bits as usize) {
            Some(made) => Ok(made.get_or_try_init(py, make)?.bind(py).clone()),
            None => Ok(make()?.into_bound(py)),
        }
    }
}

impl<'py> FromPyObject<'_, 'py> for PyStatus {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let bits: u32 = object.extract()?;
        Status::from_bits(bits).map(Self).ok_or_else(|| {
            PyValueError::new_err(format!("{bits} is not made of the conditions of Status"))
        })
    }
}

impl PyStatus {
    /// The status as it is written in Python.
    fn written(self) -> String {
        if self.0 == Status::OK {
            return String::from("Status.OK");
        }
        let member = |name: &str| format!("Status.{}", name.to_uppercase().replace('-', "_"));
        let members: Vec<String> = self.0.names().map(member).collect();
        members.join("|")
    }
}

/// What one step of a controller answers.
///
/// Parameters
/// ----------
/// steer : float
///     Angle to command [rad], positive to the left.
/// cross_track_error : float
///     Offset of the tracked point of the measured vehicle from the path [m], positive left of it.
/// heading_error : float
///     Yaw of the measured vehicle less direction of the path [rad], in [-pi, pi].
/// predicted_cross_track_error : float
///     Cross-track error of the vehicle as it will be when the command reaches the wheels [m]; that
///     of the measured one without a dead time.
/// predicted_heading_error : float
///     Heading error of that vehicle [rad].
/// target : tuple of float
///     The point aimed at, (x, y) [m]: the lookahead point, or the projection onto the path.
/// reverse : bool
///     Whether the path is driven backwards here.
/// status : Status
///     How the step went.
///
/// Examples
/// --------
/// >>> path = popsteer.Path([(0.0, 0.0), (100.0, 0.0)])
/// >>> command = popsteer.Stanley(path).step(5.0, 0.5, 0.0, 5.0, 0.05)
/// >>> command.cross_track_error, command.status.level
/// (0.5, 'ok')
#[pyclass(frozen, eq, name = "Command", module = "popsteer")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PyCommand(pub(crate) Command);

#[pymethods]
impl PyCommand {
    #[new]
    #[pyo3(signature = (
        *, steer, cross_track_error, heading_error, predicted_cross_track_error,
        predicted_heading_error, target, reverse, status
    ))]
    fn new(
        steer: f64,
        cross_track_error: f64,
        heading_error: f64,
        predicted_cross_track_error: f64,
        predicted_heading_error: f64,
        target: (f64, f64),
        reverse: bool,
        status: PyStatus,
    ) -> Self {
        Self(Command {
            steer,
            cross_track_error,
            heading_error,
            predicted_cross_track_error,
            predicted_heading_error,
            target: Point::new(target.0, target.1),
            reverse,
            status: status.0,
        })
    }

    /// Angle to command [rad], positive to the left.
    #[getter]
    fn steer(&self) -> f64 {
        self.0.steer
    }

    /// Offset of the tracked point of the measured vehicle from the path [m], positive left of it.
    #[getter]
    fn cross_track_error(&self) -> f64 {
        self.0.cross_track_error
    }

    /// Yaw of the measured vehicle less direction of the path [rad], in [-pi, pi].
    #[getter]
    fn heading_error(&self) -> f64 {
        self.0.heading_error
    }

    /// Cross-track error of the vehicle as it will be when the command reaches the wheels [m].
    #[getter]
    fn predicted_cross_track_error(&self) -> f64 {
        self.0.predicted_cross_track_error
    }

    /// Heading error of that vehicle [rad].
    #[getter]
    fn predicted_heading_error(&self) -> f64 {
        self.0.predicted_heading_error
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
    fn status(&self) -> PyStatus {
        PyStatus(self.0.status)
    }

    fn __repr__(&self) -> String {
        let Command {
            steer,
            cross_track_error,
            heading_error,
            predicted_cross_track_error,
            predicted_heading_error,
            target,
            reverse,
            status,
        } = self.0;
        format!(
            "Command(steer={steer:?}, cross_track_error={cross_track_error:?}, \
             heading_error={heading_error:?}, \
             predicted_cross_track_error={predicted_cross_track_error:?}, \
             predicted_heading_error={predicted_heading_error:?}, target=({:?}, {:?}), \
             reverse={}, status={})",
            target.x,
            target.y,
            if reverse { "True" } else { "False" },
            PyStatus(status).written()
        )
    }

    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        let fields = PyDict::new(py);
        fields.set_item("steer", self.steer())?;
        fields.set_item("cross_track_error", self.cross_track_error())?;
        fields.set_item("heading_error", self.heading_error())?;
        fields.set_item(
            "predicted_cross_track_error",
            self.predicted_cross_track_error(),
        )?;
        fields.set_item("predicted_heading_error", self.predicted_heading_error())?;
        fields.set_item("target", self.target())?;
        fields.set_item("reverse", self.reverse())?;
        fields.set_item("status", self.status())?;
        Ok((PyTuple::empty(py), fields))
    }
}
