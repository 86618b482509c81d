//! What all controllers have in common: one macro around a tracker of the core, with the
//! documentation of their methods.

use popsteer_core::tracker::Tracker;
use popsteer_core::{ConfigError, LateralLaw};

use super::monitor::Monitored;
use crate::vehicle::Adapt;

/// The tracker of `law`, with the given adaptation and monitor.
pub(crate) fn track<L: LateralLaw>(
    law: L,
    adapt: &Adapt,
    monitor: &Monitored,
) -> Result<Tracker<L>, ConfigError> {
    let tracker = match adapt {
        Adapt::Usual => Tracker::of(law),
        Adapt::Given(given) => Tracker::new(law, given.as_ref().map(|params| params.get().0))?,
    };
    match monitor {
        Monitored::Usual => Ok(tracker),
        Monitored::Given(given) => tracker.monitored(given.as_ref().map(|params| params.get().0)),
    }
}

/// A controller: a tracker of the core, its state, and the path it follows.
///
/// The texts of the parameters that all of them have, and of their methods, are here.
macro_rules! controller {
    (
        $(#[doc = $about:literal])+
        $class:ident($core:ident) named $name:literal,
        params $params:ident,
        examples { $(#[doc = $example:literal])+ }
    ) => {
        $(#[doc = $about])+
        ///
        /// Parameters
        /// ----------
        /// path : Path
        ///     The path to follow.
        /// vehicle : Vehicle, optional
        ///     The vehicle, with the position of the point whose pose `step` is given;
        ///     ``Vehicle()`` by default. With a dead time the controller steers for the vehicle as
        ///     it will be when its command reaches the wheels.
        #[doc = concat!("params : ", $name, "Params, optional")]
        ///     The tuning; its defaults scale with the vehicle.
        /// adapt : AdaptParams or None or "auto", default "auto"
        ///     How fast the controller adapts to the vehicle; None: not at all. "auto":
        ///     ``AdaptParams()`` for preview POP, and for any controller whose vehicle has a dead
        ///     time; None for the others.
        /// monitor : MonitorParams or None or "auto", default "auto"
        ///     The thresholds beyond which a step has the status ``Status.DEVIATING`` or
        ///     ``Status.IMPLAUSIBLE``; None: never. "auto": ``MonitorParams()``.
        ///
        /// Raises
        /// ------
        /// ConfigError
        ///     If a default that scales with the vehicle is out of its range; names it.
        ///
        /// Examples
        /// --------
        $(#[doc = $example])+
        #[pyclass(name = $name, module = "popsteer")]
        #[derive(Debug)]
        pub(crate) struct $class {
            law: Tracker<$core>,
            state: TrackerState<<$core as LateralLaw>::State>,
            /// The path followed.
            #[pyo3(get)]
            path: Py<PyPath>,
            /// The vehicle that is steered.
            #[pyo3(get)]
            vehicle: Py<PyVehicle>,
            /// Whether the vehicle was given; if not, `popsteer.sim.run` takes the plant's.
            #[pyo3(get)]
            vehicle_given: bool,
            /// The parameters, as they were given.
            #[pyo3(get)]
            params: Py<$params>,
            adapt: Adapt,
            monitor: Monitored,
        }

        impl $class {
            /// The controller, its path and the present state.
            pub(crate) fn member(&self) -> Member<$core> {
                Member {
                    tracker: self.law,
                    path: Arc::clone(&self.path.get().0),
                    state: self.state,
                }
            }
        }

        #[pymethods]
        impl $class {
            #[new]
            #[pyo3(
                signature = (path, vehicle=None, params=None, *, adapt=Adapt::Usual, monitor=Monitored::Usual),
                text_signature = "(path, vehicle=None, params=None, *, adapt='auto', monitor='auto')"
            )]
            fn new(
                py: Python<'_>,
                path: Py<PyPath>,
                vehicle: Option<Py<PyVehicle>>,
                params: Option<Py<$params>>,
                adapt: Adapt,
                monitor: Monitored,
            ) -> Raises<Self> {
                let vehicle_given = vehicle.is_some();
                let vehicle = vehicle.map_or_else(|| Py::new(py, PyVehicle(Vehicle::DEFAULT)), Ok)?;
                let params = params.map_or_else(|| Py::new(py, $params(Default::default())), Ok)?;
                let law = $core::new(vehicle.get().0, params.get().0)?;
                let path = $crate::path::fitted(py, path, &vehicle.get().0)?;
                let law = track(law, &adapt, &monitor)?;
                Ok(Self {
                    law,
                    state: law.initial_state(),
                    path,
                    vehicle,
                    vehicle_given,
                    params,
                    adapt,
                    monitor,
                })
            }

            /// Take one control step.
            ///
            /// The pose is that of the vehicle's point, wherever it is measured: the rear axle's
            /// unless the vehicle's `rear_axle` says otherwise.
            ///
            /// Parameters
            /// ----------
            /// x, y : float
            ///     Position of the vehicle's point [m].
            /// yaw : float
            ///     Heading [rad], counter-clockwise from x.
            /// speed : float
            ///     Speed [m/s], negative while rolling backwards.
            /// dt : float
            ///     Time since the last step that answered [s], 1e-6 to 1e3: after one that was
            ///     refused, or did not take place, all of the time since. Any other finite number,
            ///     of a clock that was set or repeats a stamp, counts as no time: the last command is
            ///     held, with ``Status.INPUT_HELD`` and, beyond 10 in a row, ``Status.INPUT_LOST``.
            /// applied_steer : float, optional
            ///     The command that was applied since the last step where that was not the
            ///     controller's [rad]: a driver's or another controller's; up to a quarter turn, and
            ///     counted as at most `max_steer`. Commands in flight, estimates and limits continue
            ///     from it. Given at each step the controller only watches: its answers do not
            ///     depend on what it answered before.
            /// measured_steer : float, optional
            ///     The angle of the wheels now, as a sensor measured it [rad]; same range, and on
            ///     the scale of the commands: the vehicle's `steer_offset` is not in it. Dead time
            ///     and lag are behind it, so the prediction starts from it in place of the modelled
            ///     angle; nothing else changes.
            /// pose_age : float, default 0.0
            ///     How long ago pose and speed were measured [s], 0 to 1: what the localisation
            ///     takes, which is not the steering's `dead_time`. The vehicle is rolled forward
            ///     through the commands given since, and all errors are those of now.
            /// roll : float, default 0.0
            ///     How far the vehicle is rolled to its right [rad], positive where its right side is
            ///     lower: an antenna above ground (`Vehicle.antenna_height`) is then not where the
            ///     vehicle stands.
            ///
            /// Returns
            /// -------
            /// Command
            ///     Angle, errors, target and status.
            ///
            /// Raises
            /// ------
            /// InputError
            ///     If a number is not finite or, but for `dt`, beyond its bound; the state is then
            ///     unchanged.
            #[inline]
            #[pyo3(signature = (
                x, y, yaw, speed, dt, *, applied_steer=None, measured_steer=None, pose_age=0.0, roll=0.0
            ))]
            fn step(
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
            ) -> Raises<PyCommand> {
                let vehicle = VehicleState { x: x.0, y: y.0, yaw: yaw.0, speed: speed.0 };
                let reported = reported(applied_steer, measured_steer, [pose_age, roll]);
                let (path, state) = (self.path.get().view(), &mut self.state);
                Ok(PyCommand(self.law.step(&path, state, vehicle, dt.0, reported)?))
            }

            /// Take one control step and give the angle alone, for tight loops.
            ///
            /// Parameters and errors as `step`.
            ///
            /// Returns
            /// -------
            /// float
            ///     Angle to command [rad]: ``step(...).steer``, bit for bit.
            #[pyo3(signature = (
                x, y, yaw, speed, dt, /, *, applied_steer=None, measured_steer=None, pose_age=0.0, roll=0.0
            ))]
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
            ) -> Raises<f64> {
                let vehicle = VehicleState { x: x.0, y: y.0, yaw: yaw.0, speed: speed.0 };
                let reported = reported(applied_steer, measured_steer, [pose_age, roll]);
                let (path, state) = (self.path.get().view(), &mut self.state);
                Ok(self.law.steer(&path, state, vehicle, dt.0, reported)?)
            }

            /// Take one control step, and answer whatever comes in.
            ///
            /// Where `step` would raise `InputError`, too, the last command is held: its angle,
            /// direction, errors, target, reference speed and distance to stop. Its time is added
            /// to that of the next step, which is one `step` over all the time that has passed, but
            /// for `max_steer_rate`: while a command is held the wheels do not turn, so the angle
            /// changes by what they turn in the last `dt`. Give the `dt` since the last call here,
            /// and to `step` the time since it last answered.
            ///
            /// Parameters
            /// ----------
            /// x, y : float
            ///     Position of the vehicle's point [m].
            /// yaw : float
            ///     Heading [rad], counter-clockwise from x.
            /// speed : float
            ///     Speed [m/s], negative while rolling backwards.
            /// dt : float
            ///     Time since the last call [s]. One out of 1e-6 to 1e3 counts as no time: after a
            ///     repeated stamp the next one tells all of it.
            /// hold_limit : int, default 10
            ///     How many inputs in a row are held with ``Status.INPUT_HELD``; beyond, the status
            ///     is the fault ``Status.INPUT_LOST``.
            /// applied_steer : float, optional
            ///     The command that was applied since the last step [rad]; see `step`.
            /// measured_steer : float, optional
            ///     The measured angle of the wheels [rad]; see `step`.
            /// pose_age : float, default 0.0
            ///     How long ago pose and speed were measured [s]; see `step`.
            /// roll : float, default 0.0
            ///     The roll to the right [rad]; see `step`.
            ///
            /// Returns
            /// -------
            /// Command
            ///     Always one of finite numbers, but for the distance to stop where there is none.
            ///     Before the first step that is taken its errors, its target and its distance to
            ///     stop are 0.
            #[pyo3(signature = (
                x, y, yaw, speed, dt, hold_limit=10, *,
                applied_steer=None, measured_steer=None, pose_age=0.0, roll=0.0
            ))]
            fn step_or_hold(
                &mut self,
                x: Number,
                y: Number,
                yaw: Number,
                speed: Number,
                dt: Number,
                #[pyo3(from_py_with = count)] hold_limit: usize,
                applied_steer: Option<Number>,
                measured_steer: Option<Number>,
                #[pyo3(from_py_with = number)] pose_age: f64,
                #[pyo3(from_py_with = number)] roll: f64,
            ) -> PyCommand {
                let vehicle = VehicleState { x: x.0, y: y.0, yaw: yaw.0, speed: speed.0 };
                let reported = reported(applied_steer, measured_steer, [pose_age, roll]);
                let (path, state) = (self.path.get().view(), &mut self.state);
                PyCommand(self.law.step_or_hold(&path, state, vehicle, dt.0, hold_limit, reported))
            }

            /// Predict the trajectory that the controller intends, from the last step on.
            ///
            /// A copy of the controller drives the vehicle as it is known by now, lag, dead time,
            /// limits and estimates included, at its present acceleration, and to the next stop at
            /// most. The controller itself stays as it is.
            ///
            /// Parameters
            /// ----------
            /// time : float, default 1.0
            ///     How far ahead [s], 0 to 1000; rounded to whole periods.
            /// dt : float, default 0.05
            ///     From one instant to the next, and the period of the steps to come [s]. The
            ///     period of the controller's own steps is right; ``time / dt`` is at most 100,000.
            ///
            /// Returns
            /// -------
            /// Prediction
            ///     Times, poses of the vehicle's point, speeds and commanded angles, as arrays of
            ///     shape (N,). The first is the last step itself.
            ///
            /// Raises
            /// ------
            /// InputError
            ///     If a number is out of its range, or no step was taken before.
            #[pyo3(signature = (time=1.0, dt=0.05))]
            fn predict<'py>(
                &self,
                py: Python<'py>,
                #[pyo3(from_py_with = number)] time: f64,
                #[pyo3(from_py_with = number)] dt: f64,
            ) -> Raises<Bound<'py, PyAny>> {
                let mut out = prediction::room(time, dt)?;
                let path = self.path.get().view();
                let count = self.law.predict(&path, &self.state, dt, &mut out)?;
                Ok(prediction::shown(py, out.get(..count).unwrap_or_default())?)
            }

            /// Find the vehicle's place on the path anew, after a jump.
            ///
            /// A step searches for the vehicle near its last projection. After a jump of the
            /// vehicle, of its localisation or along the path, this searches the whole path, as
            /// `Path.relocalise` does, and the next step starts from there. The rest of the state
            /// stays.
            ///
            /// Parameters
            /// ----------
            /// x, y : float
            ///     Position of the vehicle's point [m].
            /// yaw : float
            ///     Heading [rad]; tells branches apart that cross or lie alongside.
            ///
            /// Raises
            /// ------
            /// InputError
            ///     If a number is not finite or beyond its bound; the state is then unchanged.
            fn relocalise(&mut self, x: Number, y: Number, yaw: Number) -> Raises<()> {
                let path = self.path.get().view();
                Ok(self.law.relocalise(&path, &mut self.state, x.0, y.0, yaw.0)?)
            }

            /// Forget all steps taken so far.
            ///
            /// Parameters
            /// ----------
            /// steer : float, optional
            ///     The angle of the wheels as a driver leaves them [rad], from which the next steps
            ///     go on without a jump; POP goes on in its neighbourhood, of other controllers the
            ///     difference fades within a second. By default the wheels count as straight, and
            ///     nothing fades.
            ///
            /// Raises
            /// ------
            /// InputError
            ///     If the angle is not within the vehicle's `max_steer`; the state is then
            ///     unchanged.
            #[pyo3(signature = (*, steer=None))]
            fn reset(&mut self, steer: Option<Number>) -> Raises<()> {
                self.state = match steer {
                    None => self.law.initial_state(),
                    Some(steer) => self.law.state_from(steer.0)?,
                };
                Ok(())
            }

            /// Follow another path from the next step on.
            ///
            /// That may be at every step, as a planner gives its paths. The place on the new path
            /// is that of the last step; integral, estimate and commands in flight carry on, and
            /// where the path is the same beside the vehicle, nothing changes. A path that lies
            /// elsewhere, by more than a tenth of the wheelbase or half a radian, is gone over to
            /// from the present angle: the difference to what the controller wants fades within a
            /// second, and in what is left of that second where one such path follows another. POP
            /// goes on in its neighbourhood.
            ///
            /// Parameters
            /// ----------
            /// path : Path
            ///     The path to follow. One that cannot be is refused by `Path` itself, and the
            ///     present one is kept.
            fn set_path(&mut self, py: Python<'_>, path: Py<PyPath>) -> PyResult<()> {
                let path = $crate::path::fitted(py, path, &self.vehicle.get().0)?;
                let (old, new) = (self.path.get().view(), path.get().view());
                self.law.set_path(&mut self.state, &old, &new);
                self.path = path;
                Ok(())
            }

            /// What the controller remembers; a copy, which can be compared, saved and set again.
            #[getter]
            fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                state::shown(py, $name, &self.state)
            }

            #[setter]
            fn set_state(&mut self, state: &Bound<'_, PyAny>) -> Raises<()> {
                let restored = state::restored($name, state)?;
                self.law.check_state(&self.path.get().view(), &restored)?;
                self.state = restored;
                Ok(())
            }

            /// How the controller adapts to its vehicle; None where it does not.
            #[getter]
            fn adapt(&self, py: Python<'_>) -> PyResult<Option<Py<PyAdaptParams>>> {
                self.adapt.or(py, self.law.adapt().copied().map(PyAdaptParams))
            }

            /// The thresholds beyond which a step reports a fault; None without a monitor.
            #[getter]
            fn monitor(&self, py: Python<'_>) -> PyResult<Option<Py<PyMonitorParams>>> {
                self.monitor.or(py, self.law.monitor().copied().map(PyMonitorParams))
            }

            /// Which signal or actuator the last step does not believe: ``"position"``,
            /// ``"heading"``, ``"speed"`` or ``"steering"``; None if nothing is wrong.
            ///
            /// Where there is one, the status of that step has ``Status.IMPLAUSIBLE``. Of several
            /// the first in that order is named.
            #[getter]
            fn fault(&self) -> Option<&'static str> {
                let fault = self.state.fault(self.law.vehicle());
                fault.map(popsteer_core::vehicle::Fault::name)
            }

            /// The present estimate of the controller's vehicle.
            #[getter]
            fn estimate(&self) -> PyEstimate {
                PyEstimate(Known::of(self.law.vehicle(), &self.law.estimate(&self.state)))
            }

            /// How far ahead of the vehicle's point the tracked point lies [m], driving forward:
            /// the point whose errors a command has.
            #[getter]
            fn tracked_point(&self) -> f64 {
                self.law.tracked_point()
            }

            fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
                let path = self.path.bind(py).repr()?;
                let vehicle = self.vehicle.bind(py).repr()?;
                let params = self.params.bind(py).repr()?;
                let adapt = self.adapt.repr(py, "adapt")?;
                let monitor = self.monitor.repr(py, "monitor")?;
                Ok(format!("{}({path}, {vehicle}, {params}{adapt}{monitor})", $name))
            }

            /// What makes an equal controller but for the state.
            pub(crate) fn __getnewargs_ex__<'py>(
                &self,
                py: Python<'py>,
            ) -> PyResult<NewArgs<'py>> {
                let vehicle = self.vehicle_given.then_some(&self.vehicle);
                let options = PyDict::new(py);
                self.adapt.put(&options, "adapt")?;
                self.monitor.put(&options, "monitor")?;
                Ok(((&self.path, vehicle, &self.params).into_pyobject(py)?, options))
            }

            fn __getstate__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                self.state(py)
            }

            fn __setstate__(&mut self, state: &Bound<'_, PyAny>) -> Raises<()> {
                self.set_state(state)
            }
        }
    };
}
pub(crate) use controller;
