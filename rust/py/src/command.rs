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
#[pyclass(frozen, eq, name = "Command", module = "popsteer")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PyCommand(pub(crate) Command);

#[pymethods]
impl PyCommand {
    #[new]
    #[pyo3(signature = (
        *, steer, cross_track_error, heading_error, predicted_cross_track_error,
        predicted_heading_error, target, reverse, reference_speed, distance_to_stop, status
    ))]
    fn new(
        steer: f64,
        cross_track_error: f64,
        heading_error: f64,
        predicted_cross_track_error: f64,
        predicted_heading_error: f64,
        target: (f64, f64),
        reverse: bool,
        reference_speed: Option<f64>,
        distance_to_stop: f64,
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
            reference_speed,
            distance_to_stop,
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

    /// The path's speed beside the rear axle [m/s], negative where it is driven backwards; None
    /// where the path has no speeds.
    #[getter]
    fn reference_speed(&self) -> Option<f64> {
        self.0.reference_speed
    }

    /// Distance along the path to the next cusp, or to the end [m]; inf where there is neither.
    #[getter]
    fn distance_to_stop(&self) -> f64 {
        self.0.distance_to_stop
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
            reference_speed,
            distance_to_stop,
            status,
        } = self.0;
        let reference_speed =
            reference_speed.map_or_else(|| String::from("None"), |speed| format!("{speed:?}"));
        format!(
            "Command(steer={steer:?}, cross_track_error={cross_track_error:?}, \
             heading_error={heading_error:?}, \
             predicted_cross_track_error={predicted_cross_track_error:?}, \
             predicted_heading_error={predicted_heading_error:?}, target=({:?}, {:?}), \
             reverse={}, reference_speed={reference_speed}, \
             distance_to_stop={distance_to_stop:?}, status={})",
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
        fields.set_item("reference_speed", self.reference_speed())?;
        fields.set_item("distance_to_stop", self.distance_to_stop())?;
        fields.set_item("status", self.status())?;
        Ok((PyTuple::empty(py), fields))
    }
}
