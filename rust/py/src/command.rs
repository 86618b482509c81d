//! What a step answers.

use popsteer_core::{Command, Point, Status};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple};

use crate::record::{Part, record};

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

impl Part for Status {
    type Shown = PyStatus;

    fn shown(self) -> PyStatus {
        PyStatus(self)
    }

    fn taken(shown: PyStatus) -> Self {
        shown.0
    }

    fn written(value: &Bound<'_, PyAny>) -> PyResult<String> {
        Ok(value.extract::<PyStatus>()?.written())
    }
}

record! {
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
    /// reference_speed : float or None
    ///     The path's speed beside the rear axle [m/s], negative where it is driven backwards; None
    ///     where the path has no speeds. Its square is linear between waypoints; a speed of 0 at a cusp
    ///     or at an end counts as a tenth of the wheelbase a second, so that no vehicle stands still
    ///     before it: where to stop is what `distance_to_stop` says.
    /// distance_to_stop : float
    ///     Distance that the rear axle has to go along the path to the next cusp, or to the end [m];
    ///     negative past the end, ``inf`` on a closed path without cusps.
    /// status : Status
    ///     How the step went.
    ///
    /// Examples
    /// --------
    /// >>> path = popsteer.Path([(0.0, 0.0), (100.0, 0.0)])
    /// >>> command = popsteer.Stanley(path).step(5.0, 0.5, 0.0, 5.0, 0.05)
    /// >>> command.cross_track_error, command.status.level
    /// (0.5, 'ok')
    PyCommand(Command) named "Command",
    /// Angle to command [rad], positive to the left.
    steer: f64;
    /// Offset of the tracked point of the measured vehicle from the path [m], positive left of it.
    cross_track_error: f64;
    /// Yaw of the measured vehicle less direction of the path [rad], in [-pi, pi].
    heading_error: f64;
    /// Cross-track error of the vehicle as it will be when the command reaches the wheels [m].
    predicted_cross_track_error: f64;
    /// Heading error of that vehicle [rad].
    predicted_heading_error: f64;
    /// The point aimed at, (x, y) [m].
    target: Point;
    /// Whether the path is driven backwards here.
    reverse: bool;
    /// The path's speed beside the rear axle [m/s], negative where it is driven backwards; None
    /// where the path has no speeds.
    reference_speed: Option<f64>;
    /// Distance along the path to the next cusp, or to the end [m]; inf where there is neither.
    distance_to_stop: f64;
    /// How the step went.
    status: Status;
}
