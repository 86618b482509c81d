//! The lateral laws: parameters, states and controllers.

use std::sync::Arc;

use popsteer_core::lateral::{
    BangBang, BangBangParams, BangBangState, Pid, PidParams, PidState, Pop, PopParams, PopState,
    PurePursuit, PurePursuitParams, PurePursuitState, Stanley, StanleyParams, StanleyState,
    pid::ErrorBuffer,
};
use popsteer_core::{InputError, LateralLaw, Path, VehicleState};
use popsteer_sim::Law;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::command::PyCommand;
use crate::errors::OrRaise;
use crate::params::{Count, Field, params, repr};
use crate::path::PyPath;

params! {
    /// Parameters of `Pop`; the paper's Table 1 by default.
    PyPopParams(PopParams) named "PopParams" in "popsteer",
    defaults PopParams::DEFAULT, checked by Pop::new,
    lookahead_gain: f64, "float, default 0.2",
        "Velocity constant k_v [s]: lookahead = min_lookahead + lookahead_gain * speed.";
    min_lookahead: f64, "float, default 6.0",
        "Lookahead at rest ld_min [m]; from the published code, the paper gives none.";
    steer_span: f64, "float, default radians(3)",
        "Optimization range delta_nbd [rad]: candidates lie this far about the last angle.";
    candidate_count: usize, "int, default 21",
        "Optimization resolution: the number of candidates, odd.";
    lookahead_tolerance: f64, "float, default 0.01",
        "Threshold epsilon of the lookahead search [m].";
    window_ahead: f64, "float, default 20.0",
        "Arc ahead of the vehicle that is searched [m].";
    grid_spacing: f64, "float, default 0.01",
        "Greatest distance of neighbours on the re-discretised path [m].";
    wheelbase: f64, "float, default 3.0",
        "Distance of the axles [m].";
    reference_offset: Option<f64>, "float, optional",
        "Reference point ahead of the rear axle [m]; the front axle by default.";
    max_steer: f64, "float, default 1.22",
        "Steering limit delta_max [rad].";
}

params! {
    /// Parameters of `Pid`; the paper's Table 1 by default.
    PyPidParams(PidParams) named "PidParams" in "popsteer",
    defaults PidParams::DEFAULT, checked by Pid::new,
    kp: f64, "float, default 0.25",
        "Proportional gain k_P [rad/m].";
    ki: f64, "float, default 0.01",
        "Integral gain k_I [rad/(m s)]; [rad/m] without integral_with_dt.";
    kd: f64, "float, default 0.2",
        "Derivative gain k_D [rad s/m].";
    buffer_length: usize, "int, default 500",
        "How many of the last errors the integral sums, against wind-up.";
    integral_with_dt: bool, "bool, default True",
        "Whether the integral weighs each error with its dt; the paper's equation does not.";
    wheelbase: f64, "float, default 3.0",
        "Distance of the axles [m].";
    reference_offset: Option<f64>, "float, optional",
        "Reference point ahead of the rear axle [m]; the front axle by default.";
    max_steer: f64, "float, default 1.22",
        "Steering limit delta_max [rad].";
}

params! {
    /// Parameters of `PurePursuit`; the paper's Table 1, with the published code's least lookahead.
    PyPurePursuitParams(PurePursuitParams) named "PurePursuitParams" in "popsteer",
    defaults PurePursuitParams::DEFAULT, checked by PurePursuit::new,
    lookahead_gain: f64, "float, default 0.9",
        "Velocity constant k_v [s]: lookahead = max(min_lookahead, lookahead_gain * speed).";
    min_lookahead: f64, "float, default 10.0",
        "Least lookahead [m]; the paper's equation has 0.";
    alpha_by_arccos: bool, "bool, default False",
        "Whether alpha is acos(heading . line / lookahead), as in the published code.";
    lookahead_tolerance: f64, "float, default 0.01",
        "Threshold epsilon of the lookahead search [m].";
    window_ahead: f64, "float, default 20.0",
        "Arc ahead of the vehicle that is searched [m].";
    grid_spacing: f64, "float, default 0.01",
        "Greatest distance of neighbours on the re-discretised path [m].";
    wheelbase: f64, "float, default 3.0",
        "Distance of the axles L [m].";
    reference_offset: Option<f64>, "float, optional",
        "Reference point ahead of the rear axle [m]; the rear axle by default.";
    max_steer: f64, "float, default 1.22",
        "Steering limit delta_max [rad].";
}

params! {
    /// Parameters of `Stanley`; the paper's Table 1 by default.
    PyStanleyParams(StanleyParams) named "StanleyParams" in "popsteer",
    defaults StanleyParams::DEFAULT, checked by Stanley::new,
    cross_track_gain: f64, "float, default 1.5",
        "Crosstrack error constant k_chi [1/s].";
    speed_gain: f64, "float, default 1.3",
        "Velocity constant k_v.";
    softening: f64, "float, default 1e-5",
        "Softening constant k_s [m/s], which keeps the quotient finite at rest.";
    heading_behind: bool, "bool, default False",
        "Whether the path's heading is that of the segment behind the nearest waypoint, as in the published code.";
    wheelbase: f64, "float, default 3.0",
        "Distance of the axles [m].";
    reference_offset: Option<f64>, "float, optional",
        "Reference point ahead of the rear axle [m]; the front axle by default.";
    max_steer: f64, "float, default 1.22",
        "Steering limit delta_max [rad].";
}

params! {
    /// Parameters of `BangBang`.
    PyBangBangParams(BangBangParams) named "BangBangParams" in "popsteer",
    defaults BangBangParams::DEFAULT, checked by BangBang::new,
    amplitude: f64, "float, default 0.122",
        "The angle that is switched [rad].";
    deadband: f64, "float, default 0.0",
        "Cross-track errors up to this leave the wheels straight [m].";
    wheelbase: f64, "float, default 3.0",
        "Distance of the axles [m].";
    reference_offset: Option<f64>, "float, optional",
        "Reference point ahead of the rear axle [m]; the front axle by default.";
    max_steer: f64, "float, default 1.22",
        "Steering limit delta_max [rad].";
}

/// How a state goes between Python and the core.
trait StateClass: Sized {
    /// The core's law.
    type Law: LateralLaw;
    /// The class that shows `state`.
    fn from_core(state: &<Self::Law as LateralLaw>::State) -> Self;
    /// The state of `law` that the class shows.
    fn to_core(&self, law: &Self::Law) -> Result<<Self::Law as LateralLaw>::State, InputError>;
}

fn from_waypoint(waypoint: Option<usize>) -> Option<Count> {
    waypoint.map(Field::argument)
}

/// A waypoint from Python; a negative one becomes one that no path has.
fn to_waypoint(waypoint: Option<Count>) -> Option<usize> {
    waypoint.map(|Count(index)| usize::try_from(index).unwrap_or(usize::MAX))
}

/// A frozen class that shows a state of the core field by field.
macro_rules! state {
    (
        $(#[doc = $about:literal])+
        $class:ident named $name:literal,
        $($field:ident: $kind:ty = $default:expr, $words:literal, $text:literal;)+
    ) => {
        $(#[doc = $about])+
        ///
        /// Parameters
        /// ----------
        $(
            #[doc = concat!(stringify!($field), " : ", $words)]
            #[doc = concat!("    ", $text)]
        )+
        #[pyclass(frozen, eq, name = $name, module = "popsteer")]
        #[derive(Clone, Debug, PartialEq)]
        pub(crate) struct $class {
            $($field: $kind,)+
        }

        #[pymethods]
        impl $class {
            #[new]
            #[pyo3(signature = (*, $($field = $default),+))]
            fn new($($field: $kind),+) -> Self {
                Self { $($field),+ }
            }

            $(
                #[doc = $text]
                #[getter]
                fn $field(&self) -> $kind {
                    self.$field.clone()
                }
            )+

            /// The fields by name, as a new ``dict``.
            fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
                let fields = PyDict::new(py);
                $(fields.set_item(stringify!($field), self.$field.clone())?;)+
                Ok(fields)
            }

            fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
                repr($name, &self.as_dict(py)?)
            }

            fn __getnewargs_ex__<'py>(
                &self,
                py: Python<'py>,
            ) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
                Ok((PyTuple::empty(py), self.as_dict(py)?))
            }
        }
    };
}

state! {
    /// What `Pop` remembers from one step to the next.
    PyPopState named "PopState",
    waypoint: Option<Count> = None, "int, optional",
        "The waypoint nearest at the last step; None before the first.";
    previous_steer: f64 = 0.0, "float, default 0.0",
        "The last angle delta_prev [rad].";
}

state! {
    /// What `Pid` remembers from one step to the next.
    PyPidState named "PidState",
    waypoint: Option<Count> = None, "int, optional",
        "The waypoint nearest at the last step; None before the first.";
    previous_error: Option<f64> = None, "float, optional",
        "The last cross-track error [m]; None before the first step.";
    terms: Terms = Terms(Vec::new()), "tuple of float, default ()",
        "The terms of the integral, oldest first.";
    next: Count = Count(0), "int, default 0",
        "The place of the next term in the buffer.";
    sum: f64 = 0.0, "float, default 0.0",
        "The sum of the terms as carried along.";
}

state! {
    /// What `PurePursuit` remembers from one step to the next.
    PyPurePursuitState named "PurePursuitState",
    waypoint: Option<Count> = None, "int, optional",
        "The waypoint nearest at the last step; None before the first.";
    previous_alpha: f64 = 0.0, "float, default 0.0",
        "The last bearing of the lookahead point [rad].";
}

state! {
    /// What `Stanley` remembers from one step to the next.
    PyStanleyState named "StanleyState",
    waypoint: Option<Count> = None, "int, optional",
        "The waypoint nearest at the last step; None before the first.";
}

state! {
    /// What `BangBang` remembers from one step to the next.
    PyBangBangState named "BangBangState",
    waypoint: Option<Count> = None, "int, optional",
        "The waypoint nearest at the last step; None before the first.";
}

/// Numbers that Python sees as a tuple.
#[derive(Clone, Debug, PartialEq)]
struct Terms(Vec<f64>);

impl<'py> FromPyObject<'_, 'py> for Terms {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        object.extract().map(Self)
    }
}

impl<'py> IntoPyObject<'py> for Terms {
    type Target = PyTuple;
    type Output = Bound<'py, PyTuple>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        PyTuple::new(py, self.0)
    }
}

impl StateClass for PyPopState {
    type Law = Pop;

    fn from_core(state: &PopState) -> Self {
        Self {
            waypoint: from_waypoint(state.waypoint),
            previous_steer: state.previous_steer,
        }
    }

    fn to_core(&self, _law: &Pop) -> Result<PopState, InputError> {
        Ok(PopState {
            waypoint: to_waypoint(self.waypoint),
            previous_steer: self.previous_steer,
        })
    }
}

impl StateClass for PyPidState {
    type Law = Pid;

    fn from_core(state: &PidState) -> Self {
        Self {
            waypoint: from_waypoint(state.waypoint),
            previous_error: state.previous_error,
            terms: Terms(state.buffer.terms().collect()),
            next: state.buffer.next().argument(),
            sum: state.buffer.sum(),
        }
    }

    fn to_core(&self, law: &Pid) -> Result<PidState, InputError> {
        let length = law.initial_state().buffer.length();
        let next = usize::try_from(self.next.0).unwrap_or(usize::MAX);
        Ok(PidState {
            waypoint: to_waypoint(self.waypoint),
            previous_error: self.previous_error,
            buffer: ErrorBuffer::restore(length, &self.terms.0, next, self.sum)?,
        })
    }
}

impl StateClass for PyPurePursuitState {
    type Law = PurePursuit;

    fn from_core(state: &PurePursuitState) -> Self {
        Self {
            waypoint: from_waypoint(state.waypoint),
            previous_alpha: state.previous_alpha,
        }
    }

    fn to_core(&self, _law: &PurePursuit) -> Result<PurePursuitState, InputError> {
        Ok(PurePursuitState {
            waypoint: to_waypoint(self.waypoint),
            previous_alpha: self.previous_alpha,
        })
    }
}

impl StateClass for PyStanleyState {
    type Law = Stanley;

    fn from_core(state: &StanleyState) -> Self {
        Self {
            waypoint: from_waypoint(state.waypoint),
        }
    }

    fn to_core(&self, _law: &Stanley) -> Result<StanleyState, InputError> {
        Ok(StanleyState {
            waypoint: to_waypoint(self.waypoint),
        })
    }
}

impl StateClass for PyBangBangState {
    type Law = BangBang;

    fn from_core(state: &BangBangState) -> Self {
        Self {
            waypoint: from_waypoint(state.waypoint),
        }
    }

    fn to_core(&self, _law: &BangBang) -> Result<BangBangState, InputError> {
        Ok(BangBangState {
            waypoint: to_waypoint(self.waypoint),
        })
    }
}

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
            law: $core,
            state: <$core as LateralLaw>::State,
            path: Arc<Path>,
            owner: Py<PyPath>,
            params: Py<$params>,
        }

        impl $class {
            /// The law as the closed loop takes it, and its path.
            pub(crate) fn law(&self) -> (Law, Arc<Path>) {
                (self.law.into(), Arc::clone(&self.path))
            }
        }

        #[pymethods]
        impl $class {
            #[new]
            #[pyo3(signature = (path, params=None))]
            fn new(
                py: Python<'_>,
                path: Py<PyPath>,
                params: Option<Py<$params>>,
            ) -> PyResult<Self> {
                let params = match params {
                    Some(params) => params,
                    None => Py::new(py, $params(Default::default()))?,
                };
                let law = $core::new(params.get().0).or_raise(py)?;
                Ok(Self {
                    law,
                    state: law.initial_state(),
                    path: Arc::clone(&path.get().0),
                    owner: path,
                    params,
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
            ///     Forward speed [m/s].
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
            ///     Forward speed [m/s].
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

            /// Forget all steps taken so far.
            fn reset(&mut self) {
                self.state = self.law.initial_state();
            }

            /// What the law remembers; a copy, which can be compared, saved and set again.
            #[getter]
            fn state(&self) -> $state {
                $state::from_core(&self.state)
            }

            #[setter]
            fn set_state(&mut self, py: Python<'_>, state: PyRef<'_, $state>) -> PyResult<()> {
                let state = state.to_core(&self.law).or_raise(py)?;
                self.law.check_state(&self.path.view(), &state).or_raise(py)?;
                self.state = state;
                Ok(())
            }

            /// The parameters.
            #[getter]
            fn params(&self, py: Python<'_>) -> Py<$params> {
                self.params.clone_ref(py)
            }

            /// The path followed.
            #[getter]
            fn path(&self, py: Python<'_>) -> Py<PyPath> {
                self.owner.clone_ref(py)
            }

            /// How far ahead of the rear axle the law's reference point lies [m].
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
    ///
    /// Examples
    /// --------
    /// >>> path = popsteer.Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
    /// >>> popsteer.BangBang(path).steer(0.0, 0.5, 0.0, 5.0, 0.05)
    /// -0.122
    PyBangBang(BangBang) named "BangBang", params PyBangBangParams, state PyBangBangState
}

/// Any of the controllers, as the closed loop takes it.
pub(crate) fn law_of(object: &Bound<'_, PyAny>) -> Option<(Law, Arc<Path>)> {
    macro_rules! try_each {
        ($($class:ty),+) => {$(
            if let Ok(controller) = object.cast_exact::<$class>() {
                return controller.try_borrow().ok().map(|controller| controller.law());
            }
        )+};
    }
    try_each!(PyPop, PyPid, PyPurePursuit, PyStanley, PyBangBang);
    None
}
