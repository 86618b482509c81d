//! What a step answers.

use popsteer_core::{Command, Point, Status};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use crate::params::Field;
use crate::record::record;

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

impl Field for Status {
    type Argument = PyStatus;

    fn from_argument(argument: PyStatus) -> Self {
        argument.0
    }

    fn argument(self) -> PyStatus {
        PyStatus(self)
    }

    fn written(argument: &Bound<'_, PyAny>) -> PyResult<String> {
        Ok(argument.extract::<PyStatus>()?.written())
    }
}

record! {
    /// What one step of a controller answers.
    PyCommand(Command) named "Command",
    steer: f64, "float",
        "Angle to command [rad], positive to the left.";
    cross_track_error: f64, "float",
        "Offset of the tracked point of the measured vehicle from the path [m], positive left of it.";
    heading_error: f64, "float",
        "Yaw of the measured vehicle less direction of the path [rad], in [-pi, pi].";
    predicted_cross_track_error: f64, "float",
        "Cross-track error of the vehicle as it will be when the command reaches the wheels [m]; that of the measured one without a dead time.";
    predicted_heading_error: f64, "float",
        "Heading error of that vehicle [rad].";
    target: Point, "tuple of float",
        "The point aimed at, (x, y) [m]: the lookahead point, or the projection onto the path.";
    reverse: bool, "bool",
        "Whether the path is driven backwards here.";
    reference_speed: Option<f64>, "float or None",
        "The path's speed beside the rear axle [m/s], negative where it is driven backwards; None where the path has no speeds. Its square is linear between waypoints; a speed of 0 at a cusp or at an end counts as a tenth of the wheelbase a second, so that no vehicle stands still before it: where to stop is what `distance_to_stop` says.";
    distance_to_stop: f64, "float",
        "Distance that the rear axle has to go along the path to the next cusp, or to the end [m]; negative past the end, ``inf`` on a closed path without cusps.";
    status: Status, "Status",
        "How the step went.";
    @examples {
        /// >>> path = popsteer.Path([(0.0, 0.0), (100.0, 0.0)])
        /// >>> command = popsteer.Stanley(path).step(5.0, 0.5, 0.0, 5.0, 0.05)
        /// >>> command.cross_track_error, command.status.level
        /// (0.5, 'ok')
    }
}
