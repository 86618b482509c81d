//! The states of the lateral controllers.

use popsteer_core::laws::pid::error_buffer::ErrorBuffer;
use popsteer_core::laws::{
    Pid, PidState, Pop, PopState, PreviewPop, PreviewPopState, PurePursuit, PurePursuitState,
    Stanley, StanleyState,
};
use popsteer_core::tracker::{Tracker, TrackerState};
use popsteer_core::{InputError, LateralLaw, PathView};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::state_class::{state, state_class};
use super::tail::{Answered, MonitorMemory, Motion, Row, Tail};
use crate::errors::IntoPyErr;
use crate::params::{Count, Field, NewArgs, repr};

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
    /// All that the class shows, by name.
    fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>>;

    /// The class that shows `state`.
    fn from_core(state: &TrackerState<<Self::Law as LateralLaw>::State>) -> Self {
        Self::show(&state.law, Tail::of(state))
    }

    /// The state of `tracker`, on its path, that the class shows.
    fn restored(
        &self,
        py: Python<'_>,
        tracker: &Tracker<Self::Law>,
        path: &PathView<'_>,
    ) -> PyResult<TrackerState<<Self::Law as LateralLaw>::State>> {
        let law = self.law_state(tracker.law());
        let restored = law.and_then(|law| self.tail().restore(law, tracker));
        let checked = restored.and_then(|state| tracker.check_state(path, &state).map(|()| state));
        match checked {
            Ok(state) => Ok(state),
            Err(error) => Err(as_given(error, &self.fields(py)?)?.into_py_err(py)),
        }
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
    terms: Row<f64> = [Row(Vec::new())], "tuple of float, default ()",
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

            fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
                self.as_dict(py)
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

impl StateClass for PyPidState {
    type Law = Pid;

    fn show(state: &PidState, tail: Tail) -> Self {
        Self {
            previous_error: state.previous_error,
            previous_position: state.previous_position.map(Field::argument),
            terms: Row(state.buffer.terms().collect()),
            next: state.buffer.next().argument(),
            sum: state.buffer.sum(),
            tail,
        }
    }

    fn tail(&self) -> Tail {
        self.tail.clone()
    }

    fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.as_dict(py)
    }

    fn law_state(&self, law: &Pid) -> Result<PidState, InputError> {
        let length = law.initial_state().buffer.length();
        let next = usize::try_from(self.next.0).unwrap_or(usize::MAX);
        Ok(PidState {
            previous_error: self.previous_error,
            previous_position: self.previous_position.map(Field::from_argument),
            buffer: ErrorBuffer::restore(length, &self.terms.0, next, self.sum)?,
        })
    }
}

/// `error` with the count as Python gave it: the core has no negative ones.
fn as_given(mut error: InputError, fields: &Bound<'_, PyDict>) -> PyResult<InputError> {
    if let Some(field) = fields.get_item(error.field)?
        && let Ok(count) = field.extract::<i64>()
    {
        error.value = Count(count).shown();
    }
    Ok(error)
}
