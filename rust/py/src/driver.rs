//! The whole vehicle in one step.

use std::sync::Arc;

use numpy::PyArray1;
use popsteer_core::driver::{Drive, Driver, DriverParams, DriverState, Sensed};
use popsteer_core::laws::{
    Law, LawState, Pid, Pop, PreviewPop, PreviewPopParams, PurePursuit, Stanley,
};
use popsteer_core::speed::{Phase, SpeedTracker, SpeedTrackerParams};
use popsteer_core::tracker::Reported;
use popsteer_core::vehicle::{Fault, Known};
use popsteer_core::{ConfigError, Point, Status, Vehicle, VehicleState};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::Raises;
use crate::laws::{
    PyPidParams, PyPopParams, PyPreviewPopParams, PyPurePursuitParams, PyStanleyParams, all_laws,
};
use crate::params::{Field, NewArgs, Number, params};
use crate::path::{PyPath, fitted};
use crate::record::record;
use crate::speed::tracker::PySpeedTrackerParams;
use crate::tracker::controller::track;
use crate::tracker::monitor::{Monitored, PyMonitorParams};
use crate::tracker::{prediction, state};
use crate::vehicle::{Adapt, PyAdaptParams, PyEstimate, PyVehicle};

popsteer_core::DriverParams! { params {
    /// Parameters of `Driver`.
    PyDriverParams(DriverParams) named "DriverParams" in "popsteer";
} }

/// A fault by its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PyFault(Fault);

impl<'py> FromPyObject<'_, 'py> for PyFault {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let name: String = object.extract()?;
        let found = Fault::ALL.into_iter().find(|fault| fault.name() == name);
        found.map(Self).ok_or_else(|| {
            let names = Fault::ALL.map(Fault::name).join(", ");
            PyValueError::new_err(format!(
                "fault must be one of {names} or None, got {name:?}"
            ))
        })
    }
}

impl<'py> IntoPyObject<'py> for PyFault {
    type Target = pyo3::types::PyString;
    type Output = Bound<'py, Self::Target>;
    type Error = std::convert::Infallible;

    fn into_pyobject(self, py: Python<'py>) -> Result<Self::Output, Self::Error> {
        self.0.name().into_pyobject(py)
    }
}

impl Field for Option<Fault> {
    type Argument = Option<PyFault>;

    fn from_argument(argument: Self::Argument) -> Self {
        argument.map(|fault| fault.0)
    }

    fn argument(self) -> Self::Argument {
        self.map(PyFault)
    }
}

record! {
    /// What a step of `Driver` answers: what to do until the next one.
    ///
    /// Errors and distances are those of the vehicle as it is believed to be now, in the path's frame:
    /// the errors at the point that the controller tracks, the distance at the rear axle.
    PyDrive(Drive) named "Drive",
    steer: f64, "float",
        "Angle to command [rad], positive to the left.";
    acceleration: f64, "float",
        "Acceleration in the direction of driving [m/s^2]; negative brakes.";
    speed: f64, "float",
        "Speed to command in the direction of driving [m/s], for a vehicle that takes a speed in place of an acceleration.";
    reverse: bool, "bool",
        "Whether the vehicle is to be in reverse gear.";
    hold: bool, "bool",
        "Whether the vehicle is to be held where it stands.";
    phase: Phase, "str",
        "What the vehicle does: 'driving', 'stopping', 'standing' at a stop, 'turning' its wheels at rest, 'shifting' its gear, or 'stopped' by its operator or for a fault.";
    fault: Option<Fault>, "str or None",
        "Why the vehicle stops, or has stopped: what the first fault since the last `release` blames. \"position\", \"heading\", \"speed\": that signal; \"steering\": the vehicle turns otherwise than commanded; \"input\": nothing comes; \"deviation\": it is too far off its path; \"path\": the path is not where the vehicle is; \"cannot-stop\": it overruns its stop, however hard it brakes.";
    status: Status, "Status",
        "How the step went.";
    cross_track_error: f64, "float",
        "Offset of the tracked point from the path [m], positive left of it.";
    heading_error: f64, "float",
        "Yaw less direction of the path [rad], in [-pi, pi].";
    predicted_cross_track_error: f64, "float",
        "Cross-track error of the vehicle as it will be when the command reaches the wheels [m].";
    predicted_heading_error: f64, "float",
        "Heading error of that vehicle [rad].";
    target: Point, "tuple of float",
        "The point aimed at, (x, y) [m]: the lookahead point, or the projection onto the path.";
    reference_speed: f64, "float",
        "The planned speed beside the rear axle [m/s], never negative.";
    distance_to_stop: f64, "float",
        "Distance that the rear axle has to go along the path to the next stop [m]; negative past it, ``inf`` if there is none.";
    @examples {
        /// >>> path = popsteer.Path([(0.0, 0.0), (100.0, 0.0)])
        /// >>> drive = popsteer.Driver(path).step(5.0, 0.5, 0.0, 5.0, 0.05)
        /// >>> drive.cross_track_error, drive.fault, drive.hold
        /// (0.5, None, False)
    }
}

macro_rules! tuning {
    ($($law:ident($class:ty, $params:ty)),+) => {
        /// The tuning of a controller, which says what steers.
        #[derive(FromPyObject)]
        pub(crate) enum Tuning {
            $($law(Py<$params>),)+
        }

        impl Tuning {
            fn law(&self, vehicle: Vehicle) -> Result<Law, ConfigError> {
                Ok(match self {
                    $(Self::$law(params) => $law::new(vehicle, params.get().0)?.into(),)+
                })
            }

            fn object<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
                match self {
                    $(Self::$law(params) => params.bind(py).clone().into_any(),)+
                }
            }
        }
    };
}
all_laws!(tuning);

/// Steers and drives a vehicle along a path, and stops it where something is wrong.
///
/// One step goes from the pose to the pedals: what time it is, where the vehicle is believed to be,
/// where on the path that is, which acceleration and which angle follow, and what the vehicle allows of
/// them. It plans its speeds when it is made: as fast as the vehicle's limits allow, and at most the
/// path's own.
///
/// `step` never raises for a number. What does not come, or cannot be used, is replaced by what is
/// expected of the vehicle, for `hold_time`; what stays wrong is a fault, for which it brakes to a stand
/// by what is still believed, and stays there until `release`. See the guide to the loop.
///
/// Parameters
/// ----------
/// path : Path
///     The path to follow; its speeds, where it has any, are the most that is driven, negative where
///     it is driven backwards, and 0 where the vehicle is to stop.
/// vehicle : Vehicle, optional
///     The vehicle, with the position of the point whose pose `step` is given; ``Vehicle()`` by
///     default.
/// controller : PreviewPopParams or StanleyParams or PurePursuitParams or PidParams or PopParams, optional
///     What steers, by its tuning; ``PreviewPopParams()`` by default.
/// speed : SpeedTrackerParams, optional
///     The tuning of the speed law.
/// params : DriverParams, optional
///     The parameters of the driver itself.
/// adapt : AdaptParams or None or "auto", default "auto"
///     As of controllers.
/// monitor : MonitorParams or None or "auto", default "auto"
///     As of controllers.
///
/// Raises
/// ------
/// ConfigError
///     If a default that scales with the vehicle, or a limit of a plan, is out of its range.
///
/// Examples
/// --------
/// >>> path = popsteer.Path([(float(x), 0.0) for x in range(101)])
/// >>> car = popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35, max_speed=8.0)
/// >>> driver = popsteer.Driver(path, car)
/// >>> drive = driver.step(10.0, 0.2, 0.0, 5.0, 0.05)
/// >>> drive.steer < 0.0, drive.acceleration > 0.0, drive.hold, drive.fault
/// (True, True, False, None)
/// >>> for _ in range(20):
/// ...     drive = driver.step(float("nan"), 0.2, 0.0, 5.0, 0.05)
/// >>> drive.fault, drive.acceleration < 0.0
/// ('position', True)
#[pyclass(name = "Driver", module = "popsteer")]
#[derive(Debug)]
pub(crate) struct PyDriver {
    law: Driver<Law>,
    state: DriverState<LawState>,
    /// The path followed.
    #[pyo3(get)]
    path: Py<PyPath>,
    plan: Arc<[f64]>,
    /// The vehicle that is driven.
    #[pyo3(get)]
    vehicle: Py<PyVehicle>,
    /// The tuning of what steers.
    #[pyo3(get)]
    controller: Py<PyAny>,
    /// The tuning of the speed law.
    #[pyo3(get)]
    speed: PySpeedTrackerParams,
    /// The parameters of the driver itself.
    #[pyo3(get)]
    params: PyDriverParams,
    adapt: Adapt,
    monitor: Monitored,
}

/// A number, NaN for None.
fn or_nan(number: Option<Number>) -> f64 {
    number.map_or(f64::NAN, |number| number.0)
}

#[pymethods]
impl PyDriver {
    #[new]
    #[pyo3(
        signature = (path, vehicle=None, controller=None, *, speed=None, params=None, adapt=Adapt::Usual, monitor=Monitored::Usual),
        text_signature = "(path, vehicle=None, controller=None, *, speed=None, params=None, adapt='auto', monitor='auto')"
    )]
    fn new(
        py: Python<'_>,
        path: Py<PyPath>,
        vehicle: Option<Py<PyVehicle>>,
        controller: Option<Tuning>,
        speed: Option<&PySpeedTrackerParams>,
        params: Option<&PyDriverParams>,
        adapt: Adapt,
        monitor: Monitored,
    ) -> Raises<Self> {
        let vehicle = vehicle.map_or_else(|| Py::new(py, PyVehicle(Vehicle::DEFAULT)), Ok)?;
        let controller = match controller {
            Some(tuning) => tuning,
            None => Tuning::PreviewPop(Py::new(py, PyPreviewPopParams(PreviewPopParams::DEFAULT))?),
        };
        let speed = speed
            .copied()
            .unwrap_or(PySpeedTrackerParams(SpeedTrackerParams::DEFAULT));
        let params = params
            .copied()
            .unwrap_or(PyDriverParams(DriverParams::DEFAULT));
        let car = vehicle.get().0;
        let path = fitted(py, path, &car)?;
        let tracker = track(controller.law(car)?, &adapt, &monitor)?;
        let law = Driver::new(tracker, SpeedTracker::new(car, speed.0)?, params.0)?;
        Ok(Self {
            state: law.initial_state(),
            plan: law.speed().plan(&path.get().view())?.into(),
            controller: controller.object(py).unbind(),
            law,
            path,
            vehicle,
            speed,
            params,
            adapt,
            monitor,
        })
    }

    /// Take one control step.
    ///
    /// Parameters
    /// ----------
    /// x, y : float or None
    ///     Position of the vehicle's point [m]; None or nan where it is not known.
    /// yaw : float or None
    ///     Heading [rad], counter-clockwise from x.
    /// speed : float or None
    ///     Speed [m/s], negative while rolling backwards.
    /// dt : float
    ///     Time since the last step [s]. One that is none, as of a stamp that repeats or of a clock that
    ///     goes back, counts as no time, and one over 1 s as that.
    /// applied_steer : float, optional
    ///     The command that was applied since the last step where that was not the driver's [rad].
    /// measured_steer : float, optional
    ///     The angle of the wheels now, as a sensor measured it [rad].
    /// pose_age : float, default 0.0
    ///     How long ago pose and speed were measured [s], 0 to 1; older ones have not come.
    /// roll : float, default 0.0
    ///     How far the vehicle is rolled to its right [rad], positive where its right side is lower: an
    ///     antenna above ground (`Vehicle.antenna_height`) is then not where the vehicle stands. One
    ///     that is not finite counts as level.
    /// gear : bool, optional
    ///     Whether reverse gear is in; the vehicle is held until the wanted one is. Without it, it is
    ///     taken to be in once the vehicle stands.
    ///
    /// Returns
    /// -------
    /// Drive
    ///     Always one of finite numbers, but for the distance to stop where there is none. Before
    ///     anything is known of the vehicle it is to be held.
    #[pyo3(signature = (
        x, y, yaw, speed, dt, *, applied_steer=None, measured_steer=None, pose_age=0.0,
        roll=0.0, gear=None
    ))]
    fn step(
        &mut self,
        x: Option<Number>,
        y: Option<Number>,
        yaw: Option<Number>,
        speed: Option<Number>,
        dt: Option<Number>,
        applied_steer: Option<Number>,
        measured_steer: Option<Number>,
        #[pyo3(from_py_with = crate::params::number)] pose_age: f64,
        #[pyo3(from_py_with = crate::params::number)] roll: f64,
        gear: Option<bool>,
    ) -> PyDrive {
        let sensed = Sensed {
            vehicle: VehicleState {
                x: or_nan(x),
                y: or_nan(y),
                yaw: or_nan(yaw),
                speed: or_nan(speed),
            },
            reported: Reported {
                applied_steer: applied_steer.map(|steer| steer.0),
                measured_steer: measured_steer.map(|steer| steer.0),
                pose_age,
                roll,
            },
            gear,
        };
        let path = self.path.get().view();
        PyDrive(
            self.law
                .step(&path, &self.plan, &mut self.state, sensed, or_nan(dt)),
        )
    }

    /// Forget all steps taken so far.
    ///
    /// Parameters
    /// ----------
    /// steer : float, optional
    ///     The angle of the wheels as a driver leaves them [rad]; by default they count as straight.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If the angle is not within the vehicle's `max_steer`; the state is then unchanged.
    #[pyo3(signature = (*, steer=None))]
    fn reset(&mut self, steer: Option<Number>) -> Raises<()> {
        self.state = match steer {
            None => self.law.initial_state(),
            Some(steer) => self.law.state_from(steer.0)?,
        };
        Ok(())
    }

    /// Follow another path from the next step on, which may be at every step.
    ///
    /// The place on the new path is that of the last step, angle and estimates go on without a jump,
    /// and its speeds are planned anew.
    ///
    /// Parameters
    /// ----------
    /// path : Path
    ///     The path to follow.
    ///
    /// Raises
    /// ------
    /// ConfigError
    ///     If a limit of its plan is out of its range; the present path is then kept.
    fn set_path(&mut self, py: Python<'_>, path: Py<PyPath>) -> Raises<()> {
        let path = fitted(py, path, self.law.vehicle())?;
        let plan = self.law.speed().plan(&path.get().view())?;
        let (old, new) = (self.path.get().view(), path.get().view());
        self.law.set_path(&mut self.state, &old, &new);
        self.plan = plan.into();
        self.path = path;
        Ok(())
    }

    /// Brake to a stand in comfort, along the path, and stay there until `go`: the operator's stop.
    fn hold(&mut self) {
        self.state.held = true;
    }

    /// End `hold`.
    fn go(&mut self) {
        self.state.held = false;
    }

    /// Forget the fault for which the vehicle stopped, and drive again.
    ///
    /// The vehicle is looked for about its last place.
    ///
    /// Returns
    /// -------
    /// str or None
    ///     The fault that was forgotten.
    fn release(&mut self) -> Option<PyFault> {
        self.law.release(&mut self.state).map(PyFault)
    }

    /// Predict the trajectory that the vehicle is to take, from the last step on.
    ///
    /// A copy of the driver steers and drives the vehicle as estimated, whose wheels and drive have their
    /// delay and lag: through cusps, and to its stop, or to rest where it stops for a fault.
    ///
    /// Parameters
    /// ----------
    /// time : float, default 1.0
    ///     How far ahead [s].
    /// dt : float, default 0.05
    ///     From one instant to the next [s].
    ///
    /// Returns
    /// -------
    /// Prediction
    ///     As `predict` of controllers.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     If a number is out of its range, or no step was taken before.
    #[pyo3(signature = (time=1.0, dt=0.05))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = crate::params::number)] time: f64,
        #[pyo3(from_py_with = crate::params::number)] dt: f64,
    ) -> Raises<Bound<'py, PyAny>> {
        let mut out = prediction::room(time, dt)?;
        let path = self.path.get().view();
        let count = self
            .law
            .predict(&path, &self.plan, &self.state, dt, &mut out)?;
        Ok(prediction::shown(py, out.get(..count).unwrap_or_default())?)
    }

    /// The planned speed at each waypoint of the path [m/s], shape (N,).
    #[getter]
    fn plan<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.plan)
    }

    /// The fault for which the vehicle stops, or has stopped; None if it drives.
    #[getter]
    fn fault(&self) -> Option<PyFault> {
        self.state.fault.map(PyFault)
    }

    /// The present estimate of the vehicle.
    #[getter]
    fn estimate(&self) -> PyEstimate {
        let tracker = self.law.tracker();
        PyEstimate(Known::of(
            tracker.vehicle(),
            &tracker.estimate(&self.state.tracker),
        ))
    }

    /// How far ahead of the vehicle's point the tracked point lies [m], driving forward: the point
    /// whose errors a `Drive` has.
    #[getter]
    fn tracked_point(&self) -> f64 {
        self.law.tracker().tracked_point()
    }

    /// How it adapts to its vehicle; None where it does not.
    #[getter]
    fn adapt(&self, py: Python<'_>) -> PyResult<Option<Py<PyAdaptParams>>> {
        self.adapt
            .or(py, self.law.tracker().adapt().copied().map(PyAdaptParams))
    }

    /// The thresholds beyond which a step reports a fault; None without a monitor.
    #[getter]
    fn monitor(&self, py: Python<'_>) -> PyResult<Option<Py<PyMonitorParams>>> {
        self.monitor.or(
            py,
            self.law.tracker().monitor().copied().map(PyMonitorParams),
        )
    }

    /// What the driver remembers; a copy, which can be compared, saved and set again.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        state::shown(py, "Driver", &self.state)
    }

    #[setter]
    fn set_state(&mut self, given: &Bound<'_, PyAny>) -> Raises<()> {
        macro_rules! restored {
            ($($law:ident($class:ty, $params:ty)),+) => {
                match self.law.tracker().law() {
                    $(Law::$law(_) => state::restored::<DriverState<_>>("Driver", given)?.map(LawState::$law),)+
                }
            };
        }
        let restored = all_laws!(restored);
        self.law.check_state(&self.path.get().view(), &restored)?;
        self.state = restored;
        Ok(())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let path = self.path.bind(py).repr()?;
        let vehicle = self.vehicle.bind(py).repr()?;
        let controller = self.controller.bind(py).repr()?;
        Ok(format!("Driver({path}, {vehicle}, {controller})"))
    }

    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<NewArgs<'py>> {
        let options = PyDict::new(py);
        options.set_item("speed", self.speed)?;
        options.set_item("params", self.params)?;
        self.adapt.put(&options, "adapt")?;
        self.monitor.put(&options, "monitor")?;
        Ok((
            (&self.path, &self.vehicle, &self.controller).into_pyobject(py)?,
            options,
        ))
    }

    fn __getstate__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.state(py)
    }

    fn __setstate__(&mut self, state: &Bound<'_, PyAny>) -> Raises<()> {
        self.set_state(state)
    }
}
