//! The states of the lateral controllers.

use popsteer_core::lateral::{
    BangBang, BangBangState, Pid, PidState, Pop, PopState, PreviewPop, PreviewPopState,
    PurePursuit, PurePursuitState, Stanley, StanleyState, error_buffer::ErrorBuffer,
};
use popsteer_core::lateral::{Tracker, TrackerState};
use popsteer_core::{InputError, LateralLaw, Point};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use super::state_class::{state, state_class};
use super::tail::{Answered, Motion, Pairs, Tail, Watched};
use crate::params::{Count, Field, repr};

/// How a state goes between Python and the core.
pub(crate) trait StateClass: Sized {
    /// The core's controller.
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

state! {
    /// What `Pop` remembers from one step to the next.
    PyPopState named "PopState",
    previous_steer: f64 = [0.0], "float, default 0.0",
        "The last angle delta_prev [rad].";
}

state! {
    /// What `PreviewPop` remembers from one step to the next.
    PyPreviewPopState named "PreviewPopState",
    previous_steer: f64 = [0.0], "float, default 0.0",
        "The last angle delta_prev [rad].";
    reached_limits: u64 = [0], "int, default 0",
        "The limits that the last plan reaches, three bits a step.";
}

state! {
    /// What `Pid` remembers from one step to the next.
    PyPidState named "PidState",
    previous_error: Option<f64> = [None], "float, optional",
        "The last cross-track error [m]; None before the first step.";
    previous_position: Option<(f64, f64)> = [None], "tuple of float, optional",
        "Where the front axle was at the last step [m]; None before the first, and without a smoothing_length.";
    terms: Terms = [Terms(Vec::new())], "tuple of float, default ()",
        "The terms of the integral, oldest first.";
    next: Count = [Count(0)], "int, default 0",
        "The place of the next term in the buffer.";
    sum: f64 = [0.0], "float, default 0.0",
        "The sum of the terms as carried along.";
}

state! {
    /// What `PurePursuit` remembers from one step to the next.
    PyPurePursuitState named "PurePursuitState",
    previous_alpha: f64 = [0.0], "float, default 0.0",
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
