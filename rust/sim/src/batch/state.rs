//! States as a batch keeps them.

use popsteer_core::tracker::{Answer, Handover, MonitorState, Place, TrackerState};
use popsteer_core::vehicle::Estimator;

/// A state, without the 5 kB for commands in flight and the past where there is neither.
#[expect(
    clippy::large_enum_variant,
    reason = "most are short, and there are many"
)]
#[derive(Clone, Debug)]
pub(super) enum KeptState<S> {
    Whole(Box<TrackerState<S>>),
    Short(Short<S>),
}

/// A state without commands in flight and without a past.
#[derive(Clone, Debug)]
pub(super) struct Short<S> {
    law: S,
    waypoint: Option<usize>,
    measured_waypoint: Option<usize>,
    place: Option<Place>,
    steer: f64,
    handover: Option<Handover>,
    held: usize,
    held_time: f64,
    period: f64,
    answer: Option<Answer>,
    estimator: Estimator,
    monitor: Option<MonitorState>,
}

/// A larger state of a controller costs more to be moved at each step than it saves [bytes].
const SHORT: usize = 256;

impl<S: Clone> KeptState<S> {
    pub(super) fn new(state: TrackerState<S>) -> Self {
        if state.in_flight.is_some() || state.past.is_some() || size_of::<S>() > SHORT {
            Self::Whole(Box::new(state))
        } else {
            Self::Short(Short::of(&state))
        }
    }

    /// What `change` comes to with the state.
    #[inline]
    pub(super) fn with<T>(&mut self, change: impl FnOnce(&mut TrackerState<S>) -> T) -> T {
        match self {
            Self::Whole(state) => change(state),
            Self::Short(short) => {
                let mut state = short.whole();
                let answer = change(&mut state);
                if state.past.is_some() {
                    *self = Self::Whole(Box::new(state));
                } else {
                    *short = Short::of(&state);
                }
                answer
            }
        }
    }

    pub(super) fn whole(&self) -> TrackerState<S> {
        match self {
            Self::Whole(state) => TrackerState::clone(state),
            Self::Short(short) => short.whole(),
        }
    }
}

impl<S: Clone> Short<S> {
    #[inline]
    fn of(state: &TrackerState<S>) -> Self {
        Self {
            law: state.law.clone(),
            waypoint: state.waypoint,
            measured_waypoint: state.measured_waypoint,
            place: state.place,
            steer: state.steer,
            handover: state.handover,
            held: state.held,
            held_time: state.held_time,
            period: state.period,
            answer: state.answer,
            estimator: state.estimator,
            monitor: state.monitor,
        }
    }

    #[inline]
    fn whole(&self) -> TrackerState<S> {
        TrackerState {
            law: self.law.clone(),
            waypoint: self.waypoint,
            measured_waypoint: self.measured_waypoint,
            place: self.place,
            steer: self.steer,
            handover: self.handover,
            held: self.held,
            held_time: self.held_time,
            period: self.period,
            answer: self.answer,
            in_flight: None,
            past: None,
            estimator: self.estimator,
            monitor: self.monitor,
        }
    }
}
