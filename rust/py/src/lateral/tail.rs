//! What the states of all laws have in common, on its way between Python and the core.

use popsteer_core::InputError;
use popsteer_core::lateral::{Handover, TrackerState};
use popsteer_core::vehicle::{Actuator, Learnt};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::params::{Count, Field};

/// What all states remember beside the law's own.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tail {
    pub(super) steer: f64,
    pub(super) handover_offset: Option<f64>,
    pub(super) handover_left: f64,
    pub(super) held: Count,
    pub(super) wheel: Option<f64>,
    pub(super) under_way: Pairs,
    pub(super) seen: Option<(f64, f64)>,
    pub(super) learnt: Lesson,
}

/// Acceleration, expected, measured, turn, change and delay of `Learnt`.
pub(super) type Lesson = (f64, f64, f64, f64, f64, f64);

impl Tail {
    pub(super) fn of<S>(state: &TrackerState<S>) -> Self {
        let under_way = state.under_way.as_deref();
        let learnt = under_way.map_or_else(Learnt::default, |line| *line.learnt());
        Self {
            steer: state.steer,
            handover_offset: state.handover.and_then(|handover| handover.offset),
            handover_left: state.handover.map_or(0.0, |handover| handover.left),
            held: state.held.argument(),
            wheel: under_way.map(popsteer_core::vehicle::UnderWay::wheel),
            under_way: Pairs(under_way.map_or_else(Vec::new, |line| line.commands().collect())),
            seen: learnt.seen,
            learnt: (
                learnt.acceleration,
                learnt.expected,
                learnt.measured,
                learnt.turn,
                learnt.change,
                learnt.delay,
            ),
        }
    }

    pub(super) fn restore<S>(
        self,
        law: S,
        actuator: Option<&Actuator>,
    ) -> Result<TrackerState<S>, InputError> {
        let under_way = match actuator {
            None => None,
            // Of a state from before an actuator was there the wheels follow at once.
            Some(actuator) if self.wheel.is_none() => Some(actuator.settled(self.steer)),
            Some(actuator) => {
                let wheel = self.wheel.unwrap_or(self.steer);
                let (acceleration, expected, measured, turn, change, delay) = self.learnt;
                let learnt = Learnt {
                    seen: self.seen,
                    acceleration,
                    expected,
                    measured,
                    turn,
                    change,
                    delay,
                };
                Some(actuator.restore(self.under_way.0.into_iter(), wheel, learnt)?)
            }
        };
        let handover = Handover {
            offset: self.handover_offset,
            left: self.handover_left,
        };
        let none = handover.offset.is_none() && handover.left <= 0.0 && handover.left >= 0.0;
        Ok(TrackerState {
            law,
            steer: self.steer,
            handover: (!none).then_some(handover),
            held: usize::try_from(self.held.0).unwrap_or(0),
            under_way: under_way.map(Box::new),
        })
    }
}

/// Pairs of numbers that Python sees as a tuple of tuples.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pairs(pub(super) Vec<(f64, f64)>);

impl<'py> FromPyObject<'_, 'py> for Pairs {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        object.extract().map(Self)
    }
}

impl<'py> IntoPyObject<'py> for Pairs {
    type Target = PyTuple;
    type Output = Bound<'py, PyTuple>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        PyTuple::new(py, self.0)
    }
}
