//! The longitudinal controller that keeps the speed of a plan.

use std::sync::Arc;

use numpy::PyArray1;
use popsteer_core::speed::{
    Phase, SpeedCommand, SpeedTracker, SpeedTrackerParams, SpeedTrackerState, Told,
};
use popsteer_core::vehicle::Vehicle;
use popsteer_core::{Status, VehicleState};
use popsteer_sim::longitudinal::Tracked;
use popsteer_sim::plant::PedalMap;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::errors::Raises;
use crate::params::{Field, Number, number, params};
use crate::path::{PyPath, fitted};
use crate::record::record;
use crate::tracker::state;
use crate::vehicle::PyVehicle;

popsteer_core::SpeedTrackerParams! { params {
    /// Parameters of `SpeedTracker`.
    PySpeedTrackerParams(SpeedTrackerParams) named "SpeedTrackerParams" in "popsteer";
} }

impl PySpeedTracker {
    /// The controller as a run takes it, with the pedals of `map`.
    pub(crate) fn tracked(&self, map: PedalMap) -> Tracked {
        Tracked {
            law: self.law,
            path: Arc::clone(&self.path.get().0),
            plan: Arc::clone(&self.plan),
            pedals: map,
        }
    }
}

/// A phase as it goes between Python and the core: its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PyPhase(Phase);

impl<'py> IntoPyObject<'py> for PyPhase {
    type Target = PyString;
    type Output = Bound<'py, PyString>;
    type Error = std::convert::Infallible;

    fn into_pyobject(self, py: Python<'py>) -> Result<Self::Output, Self::Error> {
        self.0.name().into_pyobject(py)
    }
}

impl<'py> FromPyObject<'_, 'py> for PyPhase {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let name: String = object.extract()?;
        let found = Phase::ALL.into_iter().find(|phase| phase.name() == name);
        found
            .map(Self)
            .ok_or_else(|| PyValueError::new_err(format!("'{name}' is no phase")))
    }
}

impl Field for Phase {
    type Argument = PyPhase;

    fn from_argument(argument: PyPhase) -> Self {
        argument.0
    }

    fn argument(self) -> PyPhase {
        PyPhase(self)
    }
}

record! {
    /// What a step of `SpeedTracker` answers.
    PySpeedCommand(SpeedCommand) named "SpeedCommand",
    acceleration: f64, "float",
        "Acceleration in the direction of driving [m/s^2]; negative brakes.";
    speed: f64, "float",
        "Speed to command in the direction of driving [m/s], for a vehicle that takes a speed: never above the top speed; negative only while it still rolls the other way.";
    reference_speed: f64, "float",
        "Speed that the path allows beside the rear axle [m/s], never negative.";
    distance_to_stop: f64, "float",
        "Distance along the path to the next stop [m]: a cusp, the end, or a speed of 0; infinite where there is none.";
    reverse: bool, "bool",
        "Whether the vehicle is to drive backwards.";
    standing: bool, "bool",
        "Whether the vehicle is to be held where it stands.";
    cannot_stop: bool, "bool",
        "Whether it overruns its stop, however hard it brakes, or stands beyond it.";
    phase: Phase, "str",
        "What the vehicle does: 'driving', 'stopping', 'standing' at a stop, 'turning' its wheels at rest, 'shifting' its gear, or 'stopped' as it was told to or for a fault.";
    status: Status, "Status",
        "What is known of the inputs: a pose that is stale or an outlier, a fault ('implausible': it brakes), a vehicle off its path, a command that is held.";
}

/// Keeps the speed that a path allows, and stops at its cusps and its end.
///
/// The speeds are planned when it is made: as fast as the vehicle's limits allow, and at most the
/// path's own. What the vehicle does not limit is limited to 25 m/s, 4 m/s^2 to the side, 2 m/s^2
/// driving and 3 m/s^2 braking. Bends take 0.9 of the lateral acceleration: the rest is for the
/// steering to correct errors. A step takes the plan's acceleration where the vehicle will be when
/// the command takes effect, and corrects the error of the speed: ``command = a(s + v (drive_delay +
/// drive_lag + dt / 2)) + kp e - gravity - disturbance`` with ``e = target - v``: gravity where the path
/// has a grade, and an estimate of all that neither it nor the commands explain. It stops at cusps,
/// at the end and at each speed of 0, but for the first waypoint's, and stands there until the path
/// goes on. Before a stop it brakes by the remaining distance: with ``max_deceleration`` at the most,
/// and only where it would overrun harder, up to ``brake_deceleration`` (6 m/s^2 where the vehicle
/// does not have it).
///
/// Parameters
/// ----------
/// path : Path
///     The path; its speeds, where it has any, are the most that is driven.
/// vehicle : Vehicle, optional
///     What drives.
/// params : SpeedTrackerParams, optional
///     The parameters.
///
/// Examples
/// --------
/// >>> path = popsteer.Path([(float(x), 0.0) for x in range(101)])
/// >>> tracker = popsteer.SpeedTracker(path)
/// >>> command = tracker.step(50.0, 0.0, 0.0, 10.0, 0.05)
/// >>> command.acceleration, command.distance_to_stop
/// (1.0, 50.0)
#[pyclass(name = "SpeedTracker", module = "popsteer")]
#[derive(Debug)]
pub(crate) struct PySpeedTracker {
    law: SpeedTracker,
    state: SpeedTrackerState,
    /// The path that it was given.
    #[pyo3(get)]
    path: Py<PyPath>,
    plan: Arc<[f64]>,
    /// The vehicle that it believes to drive.
    #[pyo3(get)]
    vehicle: PyVehicle,
    /// The parameters.
    #[pyo3(get)]
    params: PySpeedTrackerParams,
}

#[pymethods]
impl PySpeedTracker {
    #[new]
    #[pyo3(signature = (path, vehicle=None, params=None))]
    fn new(
        py: Python<'_>,
        path: Py<PyPath>,
        vehicle: Option<&PyVehicle>,
        params: Option<&PySpeedTrackerParams>,
    ) -> Raises<Self> {
        let vehicle = vehicle.copied().unwrap_or(PyVehicle(Vehicle::DEFAULT));
        let usual = PySpeedTrackerParams(SpeedTrackerParams::DEFAULT);
        let params = params.copied().unwrap_or(usual);
        let law = SpeedTracker::new(vehicle.0, params.0)?;
        let path = fitted(py, path, &vehicle.0)?;
        Ok(Self {
            law,
            state: SpeedTrackerState::default(),
            plan: law.plan(&path.get().view())?.into(),
            path,
            vehicle,
            params,
        })
    }

    /// Take one control step.
    ///
    /// Parameters
    /// ----------
    /// x, y, yaw : float
    ///     Pose of the vehicle's point [m, m, rad].
    /// speed : float
    ///     Speed [m/s]; negative backwards.
    /// dt : float
    ///     Time since the last step [s], 1e-6 to 1e3. Any other finite number, of a clock that was set or
    ///     repeats a stamp, counts as no time: the last command is held, with ``Status.INPUT_HELD`` and,
    ///     beyond 10 in a row, ``Status.INPUT_LOST``; before the first the vehicle is to stand.
    /// pose_age : float, default 0.0
    ///     How long before this step pose and speed were measured [s], at most 1: they are rolled forward.
    /// reverse_gear : bool, optional
    ///     Whether the reverse gear is in; the vehicle stands until its gear is in. If None, it is taken
    ///     to shift while the vehicle stands.
    /// stop : bool, default False
    ///     Whether to stop here and to stand, as long as it is told.
    ///
    /// Returns
    /// -------
    /// SpeedCommand
    ///     The acceleration, and why.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If a number is not finite or, but for `dt`, beyond its bound; the state is then unchanged.
    #[pyo3(signature = (x, y, yaw, speed, dt, *, pose_age=0.0, reverse_gear=None, stop=false))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
    fn step(
        &mut self,
        x: Number,
        y: Number,
        yaw: Number,
        speed: Number,
        dt: Number,
        #[pyo3(from_py_with = number)] pose_age: f64,
        reverse_gear: Option<bool>,
        stop: bool,
    ) -> Raises<PySpeedCommand> {
        let vehicle = VehicleState {
            x: x.0,
            y: y.0,
            yaw: yaw.0,
            speed: speed.0,
        };
        let (path, law, state) = (self.path.get().view(), &self.law, &mut self.state);
        let told = Told {
            pose_age,
            reverse_gear,
            stop,
        };
        let command = law.step_told(&path, &self.plan, state, vehicle, dt.0, told);
        Ok(PySpeedCommand(command?))
    }

    /// Keep the speeds of another path from the next step on, planned at once.
    ///
    /// The command and the estimate continue. So does the place, if the segment beside the vehicle
    /// is the same; else the next step finds it on the whole of the new path.
    ///
    /// Parameters
    /// ----------
    /// path : Path
    ///     The new path; its speeds, where it has any, are the most that is driven.
    ///
    /// Raises
    /// ------
    /// ConfigError
    ///     If a limit of the vehicle is out of the range of a plan; nothing has changed then.
    ///
    /// Examples
    /// --------
    /// >>> path = popsteer.Path([(float(x), 0.0) for x in range(101)])
    /// >>> tracker = popsteer.SpeedTracker(path)
    /// >>> tracker.set_path(popsteer.Path([(float(x), 0.0) for x in range(51)]))
    /// >>> tracker.step(20.0, 0.0, 0.0, 9.0, 0.05).distance_to_stop
    /// 30.0
    fn set_path(&mut self, py: Python<'_>, path: Py<PyPath>) -> Raises<()> {
        let path = fitted(py, path, &self.vehicle.0)?;
        let (old, new) = (self.path.get().view(), path.get().view());
        self.plan = self.law.plan(&new)?.into();
        self.law.set_path(&mut self.state, &old, &new);
        self.path = path;
        Ok(())
    }

    /// Forget all steps taken so far.
    fn reset(&mut self) {
        self.state = SpeedTrackerState::default();
    }

    /// What the controller remembers; a copy, which can be compared, saved and set again.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        state::shown(py, "SpeedTracker", &self.state)
    }

    #[setter]
    fn set_state(&mut self, state: &Bound<'_, PyAny>) -> Raises<()> {
        let restored = state::restored("SpeedTracker", state)?;
        self.law.check_state(&self.path.get().view(), &restored)?;
        self.state = restored;
        Ok(())
    }

    /// The planned speed at each waypoint, a new array of shape (N,) [m/s], never negative.
    #[getter]
    fn plan<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.plan)
    }

    fn __getnewargs__(&self, py: Python<'_>) -> (Py<PyPath>, PyVehicle, PySpeedTrackerParams) {
        (self.path.clone_ref(py), self.vehicle, self.params)
    }

    fn __getstate__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.state(py)
    }

    fn __setstate__(&mut self, state: &Bound<'_, PyAny>) -> Raises<()> {
        self.set_state(state)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let params = Bound::new(py, self.params)?;
        Ok(format!("SpeedTracker({})", params.repr()?))
    }
}
