//! The states of the lateral laws.

use popsteer_core::lateral::{
    BangBang, BangBangState, Pid, PidState, Pop, PopState, PreviewPop, PreviewPopState,
    PurePursuit, PurePursuitState, Stanley, StanleyState, pid::ErrorBuffer,
};
use popsteer_core::lateral::{Tracker, TrackerState};
use popsteer_core::{InputError, LateralLaw};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::tail::{Lesson, Pairs, Tail};
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
        self.tail().restore(law, tracker.actuator())
    }
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
        /// steer : float, default 0.0
        ///     The angle last commanded [rad].
        /// handover_offset : float, optional
        ///     Difference to the angle that was taken over [rad]; None before the first step.
        /// handover_left : float, default 0.0
        ///     How long it fades on [s]; 0 without a hand-over.
        /// held : int, default 0
        ///     How many inputs in a row were refused.
        /// wheel : float, optional
        ///     Angle of the wheels [rad]; None without an actuator.
        /// under_way : tuple of tuple of float, default ()
        ///     Commands on their way to the wheels, oldest first: angle [rad] and duration [s].
        /// seen : tuple of float, optional
        ///     Heading [rad] and speed [m/s] at the last step, where the actuator learns.
        /// learnt : tuple of float, default (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        ///     What the actuator has learnt: acceleration [m/s^2]; squares of the turns expected, and
        ///     these turns times those measured [rad^2]; the last turn expected [rad]; squares of the
        ///     rates at which they changed [rad^2/s^2]; how much longer the dead time is [s].
        #[pyclass(frozen, eq, name = $name, module = "popsteer")]
        #[derive(Clone, Debug, PartialEq)]
        pub(crate) struct $class {
            $($field: $kind,)+
            tail: Tail,
        }

        #[pymethods]
        impl $class {
            #[new]
            #[pyo3(signature = (
                *, $($field = $default,)+ steer=0.0, handover_offset=None, handover_left=0.0,
                held=Count(0), wheel=None, under_way=Pairs(Vec::new()), seen=None,
                learnt=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
            ))]
            fn new(
                $($field: $kind,)+
                steer: f64,
                handover_offset: Option<f64>,
                handover_left: f64,
                held: Count,
                wheel: Option<f64>,
                under_way: Pairs,
                seen: Option<(f64, f64)>,
                learnt: Lesson,
            ) -> Self {
                let tail = Tail {
                    steer, handover_offset, handover_left, held, wheel, under_way, seen, learnt,
                };
                Self { $($field,)+ tail }
            }

            $(
                #[doc = $text]
                #[getter]
                fn $field(&self) -> $kind {
                    self.$field.clone()
                }
            )+

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

            /// How long it fades on [s]; 0 without a hand-over.
            #[getter]
            fn handover_left(&self) -> f64 {
                self.tail.handover_left
            }

            /// How many inputs in a row were refused.
            #[getter]
            fn held(&self) -> Count {
                self.tail.held
            }

            /// Angle of the wheels [rad]; None without an actuator.
            #[getter]
            fn wheel(&self) -> Option<f64> {
                self.tail.wheel
            }

            /// Commands on their way to the wheels, oldest first: angle [rad] and duration [s].
            #[getter]
            fn under_way(&self) -> Pairs {
                self.tail.under_way.clone()
            }

            /// Heading [rad] and speed [m/s] at the last step, where the actuator learns.
            #[getter]
            fn seen(&self) -> Option<(f64, f64)> {
                self.tail.seen
            }

            /// What the actuator has learnt: acceleration [m/s^2]; squares of the turns expected, and
            /// these turns times those measured [rad^2]; the last turn expected [rad]; squares of the
            /// rates at which they changed [rad^2/s^2]; how much longer the dead time is [s].
            #[getter]
            fn learnt(&self) -> Lesson {
                self.tail.learnt
            }

            /// The fields by name, as a new ``dict``.
            pub(crate) fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
                let fields = PyDict::new(py);
                $(fields.set_item(stringify!($field), self.$field.clone())?;)+
                fields.set_item("steer", self.steer())?;
                fields.set_item("handover_offset", self.handover_offset())?;
                fields.set_item("handover_left", self.handover_left())?;
                fields.set_item("held", self.held())?;
                fields.set_item("wheel", self.wheel())?;
                fields.set_item("under_way", self.under_way())?;
                fields.set_item("seen", self.seen())?;
                fields.set_item("learnt", self.learnt())?;
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
        "The waypoint at which the segment of the last foot starts; None before the first step.";
    previous_steer: f64 = 0.0, "float, default 0.0",
        "The last angle delta_prev [rad].";
    model_steer: f64 = 0.0, "float, default 0.0",
        "With a horizon, the angle of the wheels by the model [rad].";
}

state! {
    /// What `PreviewPop` remembers from one step to the next.
    PyPreviewPopState named "PreviewPopState",
    waypoint: Option<Count> = None, "int, optional",
        "The waypoint at which the segment of the last foot starts; None before the first step.";
    previous_steer: f64 = 0.0, "float, default 0.0",
        "The last angle delta_prev [rad].";
    curvature: f64 = 0.0, "float, default 0.0",
        "Curvature that the vehicle drives by now, by the model [1/m].";
    previous_x: f64 = 0.0, "float, default 0.0",
        "Where the vehicle was seen at the last step, along x [m].";
    previous_y: f64 = 0.0, "float, default 0.0",
        "Where the vehicle was seen at the last step, along y [m].";
    previous_yaw: f64 = 0.0, "float, default 0.0",
        "Its heading then [rad].";
    travel: f64 = 0.0, "float, default 0.0",
        "How far it was to come since then [m]; 0 where nothing is to be learnt from it.";
    turn: f64 = 0.0, "float, default 0.0",
        "How much it was to turn since then by the model [rad].";
    turn_offset: f64 = 0.0, "float, default 0.0",
        "How much more the vehicle turns than the model says, as learnt [1/m].";
    slip: f64 = 0.0, "float, default 0.0",
        "Angle of the way it travels to its heading, straight on, as learnt [rad].";
    slip_length: f64 = 0.0, "float, default 0.0",
        "How much that angle grows with the curvature, as learnt [m].";
}

state! {
    /// What `Pid` remembers from one step to the next.
    PyPidState named "PidState",
    waypoint: Option<Count> = None, "int, optional",
        "The waypoint at which the segment of the last foot starts; None before the first step.";
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
        "The waypoint at which the segment of the last foot starts; None before the first step.";
    previous_alpha: f64 = 0.0, "float, default 0.0",
        "The last bearing of the lookahead point [rad]; 0 without alpha_by_arccos.";
}

state! {
    /// What `Stanley` remembers from one step to the next.
    PyStanleyState named "StanleyState",
    waypoint: Option<Count> = None, "int, optional",
        "The waypoint at which the segment of the last foot starts; None before the first step.";
}

state! {
    /// What `BangBang` remembers from one step to the next.
    PyBangBangState named "BangBangState",
    waypoint: Option<Count> = None, "int, optional",
        "The waypoint at which the segment of the last foot starts; None before the first step.";
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

    fn show(state: &PopState, tail: Tail) -> Self {
        Self {
            waypoint: from_waypoint(state.waypoint),
            previous_steer: state.previous_steer,
            model_steer: state.model_steer,
            tail,
        }
    }

    fn tail(&self) -> Tail {
        self.tail.clone()
    }

    fn law_state(&self, _law: &Pop) -> Result<PopState, InputError> {
        Ok(PopState {
            waypoint: to_waypoint(self.waypoint),
            previous_steer: self.previous_steer,
            model_steer: self.model_steer,
        })
    }
}

impl StateClass for PyPreviewPopState {
    type Law = PreviewPop;

    fn show(state: &PreviewPopState, tail: Tail) -> Self {
        Self {
            waypoint: from_waypoint(state.waypoint),
            previous_steer: state.previous_steer,
            curvature: state.curvature,
            previous_x: state.previous_x,
            previous_y: state.previous_y,
            previous_yaw: state.previous_yaw,
            travel: state.travel,
            turn: state.turn,
            turn_offset: state.turn_offset,
            slip: state.slip,
            slip_length: state.slip_length,
            tail,
        }
    }

    fn tail(&self) -> Tail {
        self.tail.clone()
    }

    fn law_state(&self, _law: &PreviewPop) -> Result<PreviewPopState, InputError> {
        Ok(PreviewPopState {
            waypoint: to_waypoint(self.waypoint),
            previous_steer: self.previous_steer,
            curvature: self.curvature,
            previous_x: self.previous_x,
            previous_y: self.previous_y,
            previous_yaw: self.previous_yaw,
            travel: self.travel,
            turn: self.turn,
            turn_offset: self.turn_offset,
            slip: self.slip,
            slip_length: self.slip_length,
        })
    }
}

impl StateClass for PyPidState {
    type Law = Pid;

    fn show(state: &PidState, tail: Tail) -> Self {
        Self {
            waypoint: from_waypoint(state.waypoint),
            previous_error: state.previous_error,
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
            waypoint: to_waypoint(self.waypoint),
            previous_error: self.previous_error,
            buffer: ErrorBuffer::restore(length, &self.terms.0, next, self.sum)?,
        })
    }
}

impl StateClass for PyPurePursuitState {
    type Law = PurePursuit;

    fn show(state: &PurePursuitState, tail: Tail) -> Self {
        Self {
            waypoint: from_waypoint(state.waypoint),
            previous_alpha: state.previous_alpha,
            tail,
        }
    }

    fn tail(&self) -> Tail {
        self.tail.clone()
    }

    fn law_state(&self, _law: &PurePursuit) -> Result<PurePursuitState, InputError> {
        Ok(PurePursuitState {
            waypoint: to_waypoint(self.waypoint),
            previous_alpha: self.previous_alpha,
        })
    }
}

impl StateClass for PyStanleyState {
    type Law = Stanley;

    fn show(state: &StanleyState, tail: Tail) -> Self {
        Self {
            waypoint: from_waypoint(state.waypoint),
            tail,
        }
    }

    fn tail(&self) -> Tail {
        self.tail.clone()
    }

    fn law_state(&self, _law: &Stanley) -> Result<StanleyState, InputError> {
        Ok(StanleyState {
            waypoint: to_waypoint(self.waypoint),
        })
    }
}

impl StateClass for PyBangBangState {
    type Law = BangBang;

    fn show(state: &BangBangState, tail: Tail) -> Self {
        Self {
            waypoint: from_waypoint(state.waypoint),
            tail,
        }
    }

    fn tail(&self) -> Tail {
        self.tail.clone()
    }

    fn law_state(&self, _law: &BangBang) -> Result<BangBangState, InputError> {
        Ok(BangBangState {
            waypoint: to_waypoint(self.waypoint),
        })
    }
}

/// `error` with the count as Python gave it: the core has no negative ones.
#[expect(clippy::cast_precision_loss, reason = "shown in an error")]
pub(super) fn as_given(mut error: InputError, fields: &Bound<'_, PyDict>) -> PyResult<InputError> {
    if let Some(field) = fields.get_item(error.field)?
        && let Ok(count) = field.extract::<i64>()
    {
        error.value = count as f64;
    }
    Ok(error)
}
