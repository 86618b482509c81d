//! What a driver remembers.

use super::signals::Signals;
use crate::speed::{SpeedCommand, SpeedState};
use crate::tracker::TrackerState;
use crate::vehicle::Fault;

/// What a [`Driver`](super::Driver) remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Clone + serde::Serialize",
        deserialize = "S: serde::Deserialize<'de>"
    ))
)]
pub struct DriverState<S> {
    /// Belief, place and steering.
    pub tracker: TrackerState<S>,
    /// The speed law.
    pub speed: SpeedState,
    /// The last speed signal [m/s], believed or not; None before the first step.
    pub heard: Option<f64>,
    /// What comes, and what does not.
    pub signals: Signals,
    /// The last answer of the speed law; None before the first step.
    pub pace: Option<SpeedCommand>,
    /// Why the vehicle stops, or has stopped.
    pub fault: Option<Fault>,
    /// Whether its operator holds it.
    pub held: bool,
    /// What a step found that is a fault if the next one finds it too.
    pub doubt: Option<Fault>,
}

impl<S> DriverState<S> {
    /// The same with the controller's state made into another by `change`.
    pub fn map<T>(self, change: impl FnOnce(S) -> T) -> DriverState<T> {
        DriverState {
            tracker: self.tracker.map(change),
            speed: self.speed,
            heard: self.heard,
            signals: self.signals,
            pace: self.pace,
            fault: self.fault,
            held: self.held,
            doubt: self.doubt,
        }
    }
}
