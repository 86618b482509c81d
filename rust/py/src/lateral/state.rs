//! The states of the lateral controllers.

use popsteer_core::lateral::{
    BangBang, BangBangState, Pid, PidState, Pop, PopState, PreviewPop, PreviewPopState,
    PurePursuit, PurePursuitState, Stanley, StanleyState, error_buffer::ErrorBuffer,
};
use popsteer_core::lateral::{Tracker, TrackerState};
use popsteer_core::vehicle::{Estimate, Estimator, VehicleState};
use popsteer_core::{InputError, LateralLaw, Point};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::tail::{Answered, Motion, Pairs, Tail, Watched};
use crate::params::{Count, Field, repr};

/// How a state goes between Python and the core.
pub(crate) trait StateClass: Sized {
    /// The core's law.
    type Law: LateralLaw;
    /// The class that shows `state`, with `tail` beside it.
    fn show(state: &<Self::Law as LateralLaw>::State, tail: Tail) -> Self;
    /// The state of `law` that the class shows.
    fn law_state(&self, law: &Self::Law) -> Result<<Self::Law as LateralLaw>::State, InputError>;
    /// What the class shows beside it.
    fn tail(&self) -> Tail;

    /// The class that shows `state`.
    fn from_core(state: &TrackerState<<Self::Law as LateralLaw>::State>) -> Self {
        Self::show(&state.law, Tail::of(state))
    }

    /// The state of `tracker` that the class shows.
    fn to_core(
        &self,
        tracker: &Tracker<Self::Law>,
    ) -> Result<TrackerState<<Self::Law as LateralLaw>::State>, InputError> {
        let law = self.law_state(tracker.law())?;
        self.tail().restore(law, tracker)
    }
}

/// A frozen class that shows a state of the core field by field.
macro_rules! state {
    (
        $(#[doc = $about:literal])+
        $class:ident named $name:literal,
        $($field:ident: $kind:ty = $default:expr, $words:literal, $text:literal;)*
    ) => {
        $(#[doc = $about])+
        ///
        /// Parameters
        /// ----------
        $(
            #[doc = concat!(stringify!($field), " : ", $words)]
            #[doc = concat!("    ", $text)]
        )*
        /// waypoint : int, optional
        ///     The segment of the last projection, that of the predicted vehicle; None before the first step.
        /// measured_waypoint : int, optional
        ///     The segment of the last projection of the measured vehicle; None without a dead time.
        /// place : tuple of float, optional
        ///     The last projections: x, y [m] of the predicted vehicle's, x, y [m] of the measured one's; None before the first step and after a jump.
        /// steer : float, default 0.0
        ///     The angle last commanded [rad].
        /// handover_offset : float, optional
        ///     Difference to the angle that was taken over [rad]; None before the first step.
        /// handover_left : float, default 0.0
        ///     How long it goes on fading [s]; 0 without a hand-over.
        /// held : int, default 0
        ///     How many inputs in a row were refused.
        /// held_time : float, default 0.0
        ///     How much time they took, which the next step counts [s].
        /// period : float, default 0.0
        ///     The time that the last step counted [s]; 0 before the first.
        /// wheel : float, optional
        ///     Angle of the wheels by the vehicle's own figures [rad]; None where they are not modelled.
        /// commands_in_flight : tuple of tuple of float, default ()
        ///     Commands that have not reached the wheels, oldest first: angle [rad] and duration [s].
        /// past_angles : tuple of tuple of float, default ()
        ///     Mean angles of the wheels of late, oldest first: angle [rad] and duration [s].
        /// past_wheel : float, optional
        ///     Angle that they end with [rad]; None before the first pose that had an age.
        /// past_since : float, default 0.0
        ///     How long ago the last pose was measured [s].
        /// seen : tuple of float, optional
        ///     Where the no-slip point was last seen: x, y [m], yaw [rad] and speed [m/s].
        /// turn_turn : float, default 0.0
        ///     Turns expected, squared [rad^2].
        /// turn_offset : float, default 0.0
        ///     Turns expected times those of a radian of steering offset [rad].
        /// offset_offset : float, default 0.0
        ///     Turns of a radian of steering offset, squared.
        /// turn_measured : float, default 0.0
        ///     Turns expected times those measured [rad^2].
        /// offset_measured : float, default 0.0
        ///     Turns of a radian of steering offset times those measured [rad].
        /// turn : float, default 0.0
        ///     The turn expected for the last period [rad].
        /// change : float, default 0.0
        ///     Rates at which the expected turns changed, squared [rad^2/s^2].
        /// gain : float, default 1.0
        ///     How many times more the vehicle turns than it was told.
        /// steer_offset : float, default 0.0
        ///     Estimated angle of the wheels at the command 0, beyond the one told [rad].
        /// longer_dead_time : float, default 0.0
        ///     How much longer the dead time is than the one told [s].
        /// slip : float, default 0.0
        ///     Angle of the motion of the no-slip point to the heading, straight on [rad].
        /// slip_length : float, default 0.0
        ///     How much that angle grows with the curvature [m].
        /// acceleration : float, default 0.0
        ///     Acceleration [m/s^2].
        /// answer : tuple, optional
        ///     What the last step answered, for as long as an input is held: cross-track error [m], yaw [rad] and the vector (x, y) along the path [m] of the measured vehicle, the same of the predicted one, the target (x, y) [m], whether it drove backwards, reference speed [m/s] and distance to stop [m], and where the vehicle was: x, y [m], yaw [rad] and speed [m/s].
        ///     What the last step answered, for as long as an input is held: cross-track error [m], yaw [rad] and the vector (x, y) along the path [m] of the measured vehicle, the same of the predicted one, the target (x, y) [m], and whether it drove backwards.
        /// monitor : tuple, optional
        ///     What the monitor remembers; None before the first step: (angle of the wheels [rad], yaw last measured [rad] or None, its residual [rad] or None), the turns of the last second ([rad]: measured, expected, of a slower response; its rate [rad/s]; of a radian of steering offset; excess of large angles [rad]), (time [s] and variance [rad^2] of the noise, sums of the offset [1/s], [rad/s]), how long it goes on being implausible [s], and whether it was within the limit of the deviation.
        #[pyclass(frozen, eq, name = $name, module = "popsteer")]
        #[derive(Clone, Debug, PartialEq)]
        pub(crate) struct $class {
            $($field: $kind,)*
            tail: Tail,
        }

        impl $class {
            fn seen_motion(&self) -> Option<Motion> {
                let seen = self.tail.estimator.seen?;
                Some((seen.x, seen.y, seen.yaw, seen.speed))
            }
        }

        #[pymethods]
        impl $class {
            #[new]
            #[pyo3(signature = (
                *, $($field = $default,)*
                waypoint=None, measured_waypoint=None, place=None, steer=0.0,
                handover_offset=None, handover_left=0.0, held=Count(0), held_time=0.0, period=0.0,
                wheel=None, commands_in_flight=Pairs(Vec::new()), past_angles=Pairs(Vec::new()),
                past_wheel=None, past_since=0.0, seen=None, turn_turn=0.0, turn_offset=0.0,
                offset_offset=0.0, turn_measured=0.0, offset_measured=0.0, turn=0.0, change=0.0,
                gain=1.0, steer_offset=0.0, longer_dead_time=0.0, slip=0.0, slip_length=0.0,
                acceleration=0.0, answer=None, monitor=None
            ))]
            fn new(
                $($field: $kind,)*
                waypoint: Option<Count>,
                measured_waypoint: Option<Count>,
                place: Option<Motion>,
                steer: f64,
                handover_offset: Option<f64>,
                handover_left: f64,
                held: Count,
                held_time: f64,
                period: f64,
                wheel: Option<f64>,
                commands_in_flight: Pairs,
                past_angles: Pairs,
                past_wheel: Option<f64>,
                past_since: f64,
                seen: Option<Motion>,
                turn_turn: f64,
                turn_offset: f64,
                offset_offset: f64,
                turn_measured: f64,
                offset_measured: f64,
                turn: f64,
                change: f64,
                gain: f64,
                steer_offset: f64,
                longer_dead_time: f64,
                slip: f64,
                slip_length: f64,
                acceleration: f64,
                answer: Option<Answered>,
                monitor: Option<Watched>,
            ) -> Self {
                let estimate = Estimate {
                    gain, steer_offset, longer_dead_time, slip, slip_length, acceleration,
                };
                let seen = seen.map(|(x, y, yaw, speed)| VehicleState { x, y, yaw, speed });
                let estimator = Estimator {
                    seen, turn_turn, turn_offset, offset_offset, turn_measured, offset_measured,
                    turn, change, estimate,
                };
                let tail = Tail {
                    waypoint, measured_waypoint, place, steer, handover_offset, handover_left, held,
                    held_time, period, wheel, commands_in_flight, past_angles, past_wheel,
                    past_since, estimator, answer, monitor,
                };
                Self { $($field,)* tail }
            }

            $(
                #[doc = $text]
                #[getter]
                fn $field(&self) -> $kind {
                    self.$field.clone()
                }
            )*

            /// The segment of the last projection, that of the predicted vehicle; None before the first step.
            #[getter]
            fn waypoint(&self) -> Option<Count> {
                self.tail.waypoint
            }

            /// The segment of the last projection of the measured vehicle; None without a dead time.
            #[getter]
            fn measured_waypoint(&self) -> Option<Count> {
                self.tail.measured_waypoint
            }

            /// The last projections: x, y [m] of the predicted vehicle's, x, y [m] of the measured one's; None before the first step and after a jump.
            #[getter]
            fn place(&self) -> Option<Motion> {
                self.tail.place
            }

            /// The angle last commanded [rad].
            #[getter]
            fn steer(&self) -> f64 {
                self.tail.steer
            }

            /// Difference to the angle that was taken over [rad]; None before the first step.
            #[getter]
            fn handover_offset(&self) -> Option<f64> {
                self.tail.handover_offset
            }

            /// How long it goes on fading [s]; 0 without a hand-over.
            #[getter]
            fn handover_left(&self) -> f64 {
                self.tail.handover_left
            }

            /// How many inputs in a row were refused.
            #[getter]
            fn held(&self) -> Count {
                self.tail.held
            }

            /// How much time the refused inputs took, which the next step counts [s].
            #[getter]
            fn held_time(&self) -> f64 {
                self.tail.held_time
            }

            /// The time that the last step counted [s]; 0 before the first.
            #[getter]
            fn period(&self) -> f64 {
                self.tail.period
            }

            /// Angle of the wheels by the vehicle's own figures [rad]; None where they are not modelled.
            #[getter]
            fn wheel(&self) -> Option<f64> {
                self.tail.wheel
            }

            /// Commands that have not reached the wheels, oldest first: angle [rad] and duration [s].
            #[getter]
            fn commands_in_flight(&self) -> Pairs {
                self.tail.commands_in_flight.clone()
            }

            /// Mean angles of the wheels of late, oldest first: angle [rad] and duration [s].
            #[getter]
            fn past_angles(&self) -> Pairs {
                self.tail.past_angles.clone()
            }

            /// Angle that they end with [rad]; None before the first pose that had an age.
            #[getter]
            fn past_wheel(&self) -> Option<f64> {
                self.tail.past_wheel
            }

            /// How long ago the last pose was measured [s].
            #[getter]
            fn past_since(&self) -> f64 {
                self.tail.past_since
            }

            /// Where the no-slip point was last seen: x, y [m], yaw [rad] and speed [m/s].
            #[getter]
            fn seen(&self) -> Option<Motion> {
                self.seen_motion()
            }

            /// Turns expected, squared [rad^2].
            #[getter]
            fn turn_turn(&self) -> f64 {
                self.tail.estimator.turn_turn
            }

            /// Turns expected times those of a radian of steering offset [rad].
            #[getter]
            fn turn_offset(&self) -> f64 {
                self.tail.estimator.turn_offset
            }

            /// Turns of a radian of steering offset, squared.
            #[getter]
            fn offset_offset(&self) -> f64 {
                self.tail.estimator.offset_offset
            }

            /// Turns expected times those measured [rad^2].
            #[getter]
            fn turn_measured(&self) -> f64 {
                self.tail.estimator.turn_measured
            }

            /// Turns of a radian of steering offset times those measured [rad].
            #[getter]
            fn offset_measured(&self) -> f64 {
                self.tail.estimator.offset_measured
            }

            /// The turn expected for the last period [rad].
            #[getter]
            fn turn(&self) -> f64 {
                self.tail.estimator.turn
            }

            /// Rates at which the expected turns changed, squared [rad^2/s^2].
            #[getter]
            fn change(&self) -> f64 {
                self.tail.estimator.change
            }

            /// How many times more the vehicle turns than it was told.
            #[getter]
            fn gain(&self) -> f64 {
                self.tail.estimator.estimate.gain
            }

            /// Estimated angle of the wheels at the command 0, beyond the one told [rad].
            #[getter]
            fn steer_offset(&self) -> f64 {
                self.tail.estimator.estimate.steer_offset
            }

            /// How much longer the dead time is than the one told [s].
            #[getter]
            fn longer_dead_time(&self) -> f64 {
                self.tail.estimator.estimate.longer_dead_time
            }

            /// Angle of the motion of the no-slip point to the heading, straight on [rad].
            #[getter]
            fn slip(&self) -> f64 {
                self.tail.estimator.estimate.slip
            }

            /// How much that angle grows with the curvature [m].
            #[getter]
            fn slip_length(&self) -> f64 {
                self.tail.estimator.estimate.slip_length
            }

            /// Acceleration [m/s^2].
            #[getter]
            fn acceleration(&self) -> f64 {
                self.tail.estimator.estimate.acceleration
            }

            /// What the last step answered, for as long as an input is held: cross-track error [m], yaw [rad] and the vector (x, y) along the path [m] of the measured vehicle, the same of the predicted one, the target (x, y) [m], whether it drove backwards, reference speed [m/s] and distance to stop [m], and where the vehicle was: x, y [m], yaw [rad] and speed [m/s].
            #[getter]
            fn answer(&self) -> Option<Answered> {
                self.tail.answer
            }

            /// What the monitor remembers; None before the first step: (angle of the wheels [rad], yaw last measured [rad] or None, its residual [rad] or None), the turns of the last second ([rad]: measured, expected, of a slower response; its rate [rad/s]; of a radian of steering offset; excess of large angles [rad]), (time [s] and variance [rad^2] of the noise, sums of the offset [1/s], [rad/s]), how long it goes on being implausible [s], and whether it was within the limit of the deviation.
            #[getter]
            fn monitor(&self) -> Option<Watched> {
                self.tail.monitor
            }

            /// The fields by name, as a new ``dict``.
            pub(crate) fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
                let fields = PyDict::new(py);
                $(fields.set_item(stringify!($field), self.$field.clone())?;)*
                fields.set_item("waypoint", self.waypoint())?;
                fields.set_item("measured_waypoint", self.measured_waypoint())?;
                fields.set_item("place", self.place())?;
                fields.set_item("steer", self.steer())?;
                fields.set_item("handover_offset", self.handover_offset())?;
                fields.set_item("handover_left", self.handover_left())?;
                fields.set_item("held", self.held())?;
                fields.set_item("held_time", self.held_time())?;
                fields.set_item("period", self.period())?;
                fields.set_item("wheel", self.wheel())?;
                fields.set_item("commands_in_flight", self.commands_in_flight())?;
                fields.set_item("past_angles", self.past_angles())?;
                fields.set_item("past_wheel", self.past_wheel())?;
                fields.set_item("past_since", self.past_since())?;
                fields.set_item("seen", self.seen())?;
                fields.set_item("turn_turn", self.turn_turn())?;
                fields.set_item("turn_offset", self.turn_offset())?;
                fields.set_item("offset_offset", self.offset_offset())?;
                fields.set_item("turn_measured", self.turn_measured())?;
                fields.set_item("offset_measured", self.offset_measured())?;
                fields.set_item("turn", self.turn())?;
                fields.set_item("change", self.change())?;
                fields.set_item("gain", self.gain())?;
                fields.set_item("steer_offset", self.steer_offset())?;
                fields.set_item("longer_dead_time", self.longer_dead_time())?;
                fields.set_item("slip", self.slip())?;
                fields.set_item("slip_length", self.slip_length())?;
                fields.set_item("acceleration", self.acceleration())?;
                fields.set_item("answer", self.answer())?;
                fields.set_item("monitor", self.monitor())?;
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
    previous_steer: f64 = 0.0, "float, default 0.0",
        "The last angle delta_prev [rad].";
}

state! {
    /// What `PreviewPop` remembers from one step to the next.
    PyPreviewPopState named "PreviewPopState",
    previous_steer: f64 = 0.0, "float, default 0.0",
        "The last angle delta_prev [rad].";
    reached_limits: u64 = 0, "int, default 0",
        "The limits that the last plan reaches, three bits a step.";
}

state! {
    /// What `Pid` remembers from one step to the next.
    PyPidState named "PidState",
    previous_error: Option<f64> = None, "float, optional",
        "The last cross-track error [m]; None before the first step.";
    previous_position: Option<(f64, f64)> = None, "tuple of float, optional",
        "Where the front axle was at the last step [m]; None before the first, and without a smoothing_length.";
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
    previous_alpha: f64 = 0.0, "float, default 0.0",
        "The last bearing of the lookahead point [rad]; 0 without alpha_by_arccos.";
}

state! {
    /// What `Stanley` remembers from one step to the next.
    PyStanleyState named "StanleyState",
}

state! {
    /// What `BangBang` remembers from one step to the next.
    PyBangBangState named "BangBangState",
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

/// [`StateClass`] for a state whose fields go over as they are.
macro_rules! as_it_is {
    ($class:ident of $law:ident, $state:ident { $($field:ident),* }) => {
        impl StateClass for $class {
            type Law = $law;

            fn show(state: &$state, tail: Tail) -> Self {
                let $state { $($field),* } = *state;
                Self { $($field,)* tail }
            }

            fn tail(&self) -> Tail {
                self.tail.clone()
            }

            fn law_state(&self, _law: &$law) -> Result<$state, InputError> {
                Ok($state { $($field: self.$field),* })
            }
        }
    };
}

as_it_is!(PyPopState of Pop, PopState { previous_steer });
as_it_is!(PyPreviewPopState of PreviewPop, PreviewPopState { previous_steer, reached_limits });
as_it_is!(PyPurePursuitState of PurePursuit, PurePursuitState { previous_alpha });
as_it_is!(PyStanleyState of Stanley, StanleyState {});
as_it_is!(PyBangBangState of BangBang, BangBangState {});

impl StateClass for PyPidState {
    type Law = Pid;

    fn show(state: &PidState, tail: Tail) -> Self {
        Self {
            previous_error: state.previous_error,
            previous_position: state.previous_position.map(|at| (at.x, at.y)),
            terms: Terms(state.buffer.terms().collect()),
            next: state.buffer.next().argument(),
            sum: state.buffer.sum(),
            tail,
        }
    }

    fn tail(&self) -> Tail {
        self.tail.clone()
    }

    fn law_state(&self, law: &Pid) -> Result<PidState, InputError> {
        let length = law.initial_state().buffer.length();
        let next = usize::try_from(self.next.0).unwrap_or(usize::MAX);
        Ok(PidState {
            previous_error: self.previous_error,
            previous_position: self.previous_position.map(|(x, y)| Point::new(x, y)),
            buffer: ErrorBuffer::restore(length, &self.terms.0, next, self.sum)?,
        })
    }
}

/// `error` with the count as Python gave it: the core has no negative ones.
#[expect(clippy::cast_precision_loss, reason = "shown in an error")]
pub(crate) fn as_given(mut error: InputError, fields: &Bound<'_, PyDict>) -> PyResult<InputError> {
    if let Some(field) = fields.get_item(error.field)?
        && let Ok(count) = field.extract::<i64>()
    {
        error.value = count as f64;
    }
    Ok(error)
}
