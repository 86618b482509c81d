//! The lateral laws: controllers, with their parameters and states.

mod params;
mod state;
mod tail;

pub(crate) use params::{
    PyBangBangParams, PyPidParams, PyPopParams, PyPreviewPopParams, PyPurePursuitParams,
    PyStanleyParams,
};
pub(crate) use state::{
    PyBangBangState, PyPidState, PyPopState, PyPreviewPopState, PyPurePursuitState, PyStanleyState,
    StateClass,
};

use std::sync::Arc;

use popsteer_core::lateral::{
    BangBang, Pid, Pop, PreviewPop, PurePursuit, Stanley, Tracker, TrackerState,
};
use popsteer_core::vehicle::Actuator;
use popsteer_core::{LateralLaw, LateralState, Path, VehicleState};
use popsteer_sim::Law;
use pyo3::prelude::*;

use self::state::as_given;
use crate::actuator::PyActuator;
use crate::command::PyCommand;
use crate::errors::{IntoPyErr, OrRaise};
use crate::path::PyPath;

/// A law, its path and its state, as a batch takes them.
pub(crate) type Vehicle<L> = (
    Tracker<L>,
    Arc<Path>,
    TrackerState<<L as LateralLaw>::State>,
);

/// A controller: a law of the core, its state, and the path it follows.
macro_rules! controller {
    (
        $(#[doc = $about:literal])+
        $class:ident($core:ident) named $name:literal,
        params $params:ident, state $state:ident
        $(, extra { $($extra:item)* })?
    ) => {
        $(#[doc = $about])+
        #[pyclass(name = $name, module = "popsteer")]
        #[derive(Debug)]
        pub(crate) struct $class {
            law: Tracker<$core>,
            state: TrackerState<<$core as LateralLaw>::State>,
            path: Arc<Path>,
            owner: Py<PyPath>,
            params: Py<$params>,
            actuator: Option<Py<PyActuator>>,
        }

        impl $class {
            /// The law as the closed loop takes it, and its path.
            pub(crate) fn law(&self) -> (Tracker<Law>, Arc<Path>) {
                (self.law.map(Law::from), Arc::clone(&self.path))
            }

            /// The law, its path and the present state, as a batch takes them.
            pub(crate) fn vehicle(&self) -> Vehicle<$core> {
                (self.law, Arc::clone(&self.path), self.state.clone())
            }
        }

        #[pymethods]
        impl $class {
            #[new]
            #[pyo3(signature = (path, params=None, *, actuator=None))]
            fn new(
                py: Python<'_>,
                path: Py<PyPath>,
                params: Option<Py<$params>>,
                actuator: Option<Py<PyActuator>>,
            ) -> PyResult<Self> {
                let params = match params {
                    Some(params) => params,
                    None => Py::new(py, $params(Default::default()))?,
                };
                let law = $core::new(params.get().0).or_raise(py)?;
                let chain = match &actuator {
                    None => None,
                    Some(actuator) => Some(Actuator::new(actuator.get().0).or_raise(py)?),
                };
                let law = Tracker::new(law, chain);
                Ok(Self {
                    law,
                    state: law.initial_state(),
                    path: Arc::clone(&path.get().0),
                    owner: path,
                    params,
                    actuator,
                })
            }

            /// Take one control step.
            ///
            /// Parameters
            /// ----------
            /// x, y : float
            ///     Position of the rear axle [m].
            /// yaw : float
            ///     Heading [rad], counter-clockwise from x.
            /// speed : float
            ///     Speed [m/s], negative while rolling backwards.
            /// dt : float
            ///     Time since the last step [s], 1e-6 to 1e3.
            ///
            /// Returns
            /// -------
            /// Command
            ///     Angle, errors, target and status.
            ///
            /// Raises
            /// ------
            /// InputError
            ///     If a number is not finite or beyond its bound; the state is then unchanged.
            #[inline]
            fn step(
                &mut self,
                py: Python<'_>,
                x: f64,
                y: f64,
                yaw: f64,
                speed: f64,
                dt: f64,
            ) -> PyResult<PyCommand> {
                let vehicle = VehicleState { x, y, yaw, speed };
                self.law
                    .step(&self.path.view(), &mut self.state, vehicle, dt)
                    .map(PyCommand)
                    .or_raise(py)
            }

            /// Take one control step and give the angle alone, for tight loops.
            ///
            /// Parameters
            /// ----------
            /// x, y : float
            ///     Position of the rear axle [m].
            /// yaw : float
            ///     Heading [rad], counter-clockwise from x.
            /// speed : float
            ///     Speed [m/s], negative while rolling backwards.
            /// dt : float
            ///     Time since the last step [s], 1e-6 to 1e3.
            ///
            /// Returns
            /// -------
            /// float
            ///     Angle of the front wheels [rad]: ``step(...).steer``, bit for bit.
            ///
            /// Raises
            /// ------
            /// InputError
            ///     If a number is not finite or beyond its bound; the state is then unchanged.
            #[pyo3(signature = (x, y, yaw, speed, dt, /))]
            fn steer(
                &mut self,
                py: Python<'_>,
                x: f64,
                y: f64,
                yaw: f64,
                speed: f64,
                dt: f64,
            ) -> PyResult<f64> {
                let vehicle = VehicleState { x, y, yaw, speed };
                self.law.steer(&self.path.view(), &mut self.state, vehicle, dt).or_raise(py)
            }

            /// Take one control step, and answer whatever comes in.
            ///
            /// Where `step` would raise `InputError`, the last angle is held. Errors and target of
            /// such a command are 0, and the rest of the state stays.
            ///
            /// Parameters
            /// ----------
            /// x, y : float
            ///     Position of the rear axle [m].
            /// yaw : float
            ///     Heading [rad], counter-clockwise from x.
            /// speed : float
            ///     Speed [m/s], negative while rolling backwards.
            /// dt : float
            ///     Time since the last step [s], 1e-6 to 1e3.
            /// hold_limit : int, default 10
            ///     How many inputs in a row are held with ``Status.INPUT_HELD``; beyond, the status
            ///     is the fault ``Status.INPUT_LOST``.
            ///
            /// Returns
            /// -------
            /// Command
            ///     Always one of finite numbers.
            #[pyo3(signature = (x, y, yaw, speed, dt, hold_limit=10))]
            fn step_or_hold(
                &mut self,
                x: f64,
                y: f64,
                yaw: f64,
                speed: f64,
                dt: f64,
                hold_limit: i64,
            ) -> PyCommand {
                let vehicle = VehicleState { x, y, yaw, speed };
                let limit = usize::try_from(hold_limit).unwrap_or(0);
                let path = self.path.view();
                PyCommand(self.law.step_or_hold(&path, &mut self.state, vehicle, dt, limit))
            }

            /// Find the vehicle's place on the path anew, after a jump.
            ///
            /// A step looks for the vehicle near its last place. After a jump, of the vehicle, of
            /// its localisation or along the path, this puts the remembered waypoint to
            /// ``path.relocalise(x, y, yaw)``, and the next step goes on from there. The rest of
            /// the state stays.
            ///
            /// Parameters
            /// ----------
            /// x, y : float
            ///     Position of the rear axle [m].
            /// yaw : float
            ///     Heading [rad]; tells branches apart that cross or lie alongside.
            ///
            /// Raises
            /// ------
            /// InputError
            ///     If a number is not finite or beyond its bound; the state is then unchanged.
            fn relocalise(&mut self, py: Python<'_>, x: f64, y: f64, yaw: f64) -> PyResult<()> {
                self.law
                    .relocalise(&self.path.view(), &mut self.state, x, y, yaw)
                    .or_raise(py)
            }

            /// Forget all steps taken so far.
            ///
            /// Parameters
            /// ----------
            /// steer : float, optional
            ///     The angle of the wheels as a driver leaves them [rad], from which the next steps
            ///     go on without a jump; POP goes on in its neighbourhood, of other laws the
            ///     difference fades within a second. By default the wheels count as straight, and
            ///     nothing fades.
            ///
            /// Raises
            /// ------
            /// InputError
            ///     If the angle is not within the law's `max_steer`; the state is then unchanged.
            #[pyo3(signature = (*, steer=None))]
            fn reset(&mut self, py: Python<'_>, steer: Option<f64>) -> PyResult<()> {
                self.state = match steer {
                    None => self.law.initial_state(),
                    Some(steer) => self.law.state_from(steer).or_raise(py)?,
                };
                Ok(())
            }

            /// Follow another path from the next step on, without a jump of the angle.
            ///
            /// The vehicle is looked for on the whole of it; what was measured against the old one
            /// is forgotten. The angle goes on from the last one, as after ``reset(steer=...)``.
            ///
            /// Parameters
            /// ----------
            /// path : Path
            ///     The path to follow.
            fn set_path(&mut self, path: Py<PyPath>) {
                self.path = Arc::clone(&path.get().0);
                self.owner = path;
                self.state.leave_path();
            }

            /// What the law remembers; a copy, which can be compared, saved and set again.
            #[getter]
            fn state(&self) -> $state {
                $state::from_core(&self.state)
            }

            #[setter]
            fn set_state(&mut self, py: Python<'_>, state: PyRef<'_, $state>) -> PyResult<()> {
                let restored = state.to_core(&self.law).and_then(|restored| {
                    self.law.check_state(&self.path.view(), &restored).map(|()| restored)
                });
                match restored {
                    Ok(restored) => {
                        self.state = restored;
                        Ok(())
                    }
                    Err(error) => {
                        Err(as_given(error, &state.as_dict(py)?)?.into_py_err(py))
                    }
                }
            }

            /// The parameters.
            #[getter]
            fn params(&self, py: Python<'_>) -> Py<$params> {
                self.params.clone_ref(py)
            }

            /// What the commands go through on their way to the wheels; None for nothing.
            #[getter]
            fn actuator(&self, py: Python<'_>) -> Option<Py<PyActuator>> {
                self.actuator.as_ref().map(|actuator| actuator.clone_ref(py))
            }

            /// The path followed.
            #[getter]
            fn path(&self, py: Python<'_>) -> Py<PyPath> {
                self.owner.clone_ref(py)
            }

            /// How far ahead of the rear axle the law's reference point lies [m]; where the path is
            /// driven backwards, how far behind it.
            #[getter]
            fn reference_offset(&self) -> f64 {
                self.law.reference_offset()
            }

            fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
                let path = self.owner.bind(py).repr()?;
                let params = self.params.bind(py).repr()?;
                Ok(format!("{}({path}, params={params})", $name))
            }

            $($($extra)*)?
        }
    };
}

controller! {
    /// POP: proximally optimal predictive steering, the paper's Algorithm 1.
    ///
    /// Of the angles in the neighbourhood of the last one, chooses the angle whose predicted
    /// location (Equation 6) lies closest to the lookahead point. The last angle wins ties, so a
    /// vehicle at rest keeps its wheels still. Reference point: the front axle.
    ///
    /// Parameters
    /// ----------
    /// path : Path
    ///     The path to follow.
    /// params : PopParams, optional
    ///     By default the paper's.
    /// actuator : Actuator, optional
    ///     What lies between the commands and the wheels; nothing by default.
    ///
    /// Examples
    /// --------
    /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
    /// >>> pop = popsteer.Pop(path)
    /// >>> command = pop.step(0.0, 0.5, 0.0, 5.0, 0.05)
    /// >>> command.steer < 0.0, command.cross_track_error
    /// (True, 0.5)
    PyPop(Pop) named "Pop", params PyPopParams, state PyPopState,
    extra {
        /// Return at once: what a call of `steer` costs without the step, for the benchmark.
        #[pyo3(signature = (x, y, yaw, speed, dt, /))]
        #[expect(
            unused_variables,
            clippy::unused_self,
            clippy::unnecessary_wraps,
            reason = "the signature is the point"
        )]
        fn _empty_call(
            &mut self,
            py: Python<'_>,
            x: f64,
            y: f64,
            yaw: f64,
            speed: f64,
            dt: f64,
        ) -> PyResult<f64> {
            Ok(yaw)
        }
    }
}

controller! {
    /// Preview POP: POP's neighbourhood, judged by where it leads over a horizon.
    ///
    /// Of the angles in the neighbourhood of the last one, chooses the angle with the least cost
    /// over a horizon: ``e^2 + (heading_cost p)^2 + (steer_rate_cost rate)^2`` a step, with the
    /// cross-track error e, the heading error p and the rate of the wheels, predicted by a bicycle
    /// with lag along the curvature of the path ahead. What follows the first step is taken at its
    /// best, so the cost of an angle is a parabola, and its lowest point, brought within the
    /// neighbourhood and the limits, is known in closed form. Reference point: the rear axle, or
    /// rather the point that does not slip; `popsteer.sim.fitted` sets it and the model.
    ///
    /// Parameters
    /// ----------
    /// path : Path
    ///     The path to follow.
    /// params : PreviewPopParams, optional
    ///     By default those of a middling car.
    /// actuator : Actuator, optional
    ///     What lies between the commands and the wheels; nothing by default.
    ///
    /// Examples
    /// --------
    /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
    /// >>> preview = popsteer.PreviewPop(path)
    /// >>> command = preview.step(0.0, 0.5, 0.0, 5.0, 0.05)
    /// >>> command.steer < 0.0, command.cross_track_error
    /// (True, 0.5)
    PyPreviewPop(PreviewPop) named "PreviewPop",
    params PyPreviewPopParams, state PyPreviewPopState
}

controller! {
    /// PID on the cross-track error at the front axle, the paper's Equation 1.
    ///
    /// ``steer = -(kp e + ki sum(e dt) + kd (e - e_previous) / dt)``, the sum over the last
    /// `buffer_length` steps.
    ///
    /// Parameters
    /// ----------
    /// path : Path
    ///     The path to follow.
    /// params : PidParams, optional
    ///     By default the paper's.
    /// actuator : Actuator, optional
    ///     What lies between the commands and the wheels; nothing by default.
    ///
    /// Examples
    /// --------
    /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
    /// >>> popsteer.Pid(path).steer(0.0, 0.5, 0.0, 5.0, 0.05)
    /// -0.12525
    PyPid(Pid) named "Pid", params PyPidParams, state PyPidState
}

controller! {
    /// Adaptive Pure-Pursuit, the paper's Equation 2.
    ///
    /// ``steer = atan(2 wheelbase sin(alpha) / lookahead)`` with ``lookahead =
    /// max(min_lookahead, lookahead_gain speed)`` and ``alpha`` the bearing of the lookahead
    /// point off the heading. Reference point: the rear axle.
    ///
    /// Parameters
    /// ----------
    /// path : Path
    ///     The path to follow.
    /// params : PurePursuitParams, optional
    ///     By default the paper's, with the published code's least lookahead.
    /// actuator : Actuator, optional
    ///     What lies between the commands and the wheels; nothing by default.
    ///
    /// Examples
    /// --------
    /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
    /// >>> round(popsteer.PurePursuit(path).steer(0.0, 0.5, 0.0, 5.0, 0.05), 4)
    /// -0.03
    PyPurePursuit(PurePursuit) named "PurePursuit",
    params PyPurePursuitParams, state PyPurePursuitState
}

controller! {
    /// The Stanley law, the paper's Equation 3.
    ///
    /// ``steer = -(heading_error + atan(cross_track_gain cross_track_error / (softening +
    /// speed_gain speed)))``. Reference point: the front axle.
    ///
    /// Parameters
    /// ----------
    /// path : Path
    ///     The path to follow.
    /// params : StanleyParams, optional
    ///     By default the paper's.
    /// actuator : Actuator, optional
    ///     What lies between the commands and the wheels; nothing by default.
    ///
    /// Examples
    /// --------
    /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
    /// >>> round(popsteer.Stanley(path).steer(0.0, 0.5, 0.0, 5.0, 0.05), 4)
    /// -0.1149
    PyStanley(Stanley) named "Stanley", params PyStanleyParams, state PyStanleyState
}

controller! {
    /// Bang-bang: a fixed angle back towards the path, the floor to measure against.
    ///
    /// ``steer = -amplitude sign(cross_track_error)`` outside the deadband, 0 inside. Reference
    /// point: the front axle.
    ///
    /// Parameters
    /// ----------
    /// path : Path
    ///     The path to follow.
    /// params : BangBangParams, optional
    ///     Parameters.
    /// actuator : Actuator, optional
    ///     What lies between the commands and the wheels; nothing by default.
    ///
    /// Examples
    /// --------
    /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
    /// >>> popsteer.BangBang(path).steer(0.0, 0.5, 0.0, 5.0, 0.05)
    /// -0.122
    PyBangBang(BangBang) named "BangBang", params PyBangBangParams, state PyBangBangState
}

/// Any of the controllers, as the closed loop takes it.
pub(crate) fn law_of(object: &Bound<'_, PyAny>) -> Option<(Tracker<Law>, Arc<Path>)> {
    macro_rules! try_each {
        ($($class:ty),+) => {$(
            if let Ok(controller) = object.cast_exact::<$class>() {
                return controller.try_borrow().ok().map(|controller| controller.law());
            }
        )+};
    }
    try_each!(
        PyPop,
        PyPreviewPop,
        PyPid,
        PyPurePursuit,
        PyStanley,
        PyBangBang
    );
    None
}
