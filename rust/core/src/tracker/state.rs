//! What a tracker remembers.

use core::ops::{Deref, DerefMut};

use crate::bounds::{MAX_COORDINATE, MAX_YAW};
use crate::error::{InputError, input_within};
use crate::geometry::Point;
use crate::laws::LateralState;
use crate::math::{atan2, wrap};
use crate::path::Place;
use crate::path::follow::Located;
use crate::path::stop::Ahead;
use crate::tracker::monitor::state::MonitorState;
use crate::vehicle::past::Past;
use crate::vehicle::{Estimator, Fault, Gate, InFlight, Vehicle, VehicleState};

/// Time in which the difference to a driver's angle fades [s].
pub const HANDOVER_TIME: f64 = 1.0;

/// A hand-over: the difference to the angle that was taken over [rad], and its remaining time [s].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Handover {
    /// None before the first step.
    pub offset: Option<f64>,
    /// From [`HANDOVER_TIME`] to 0.
    pub remaining: f64,
}

/// Errors of the last step, which are repeated while an input is held.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Deviation {
    /// Cross-track error [m].
    pub cross_track_error: f64,
    /// Heading of the vehicle, mirrored where it drives backwards [rad].
    pub yaw: f64,
    /// Along the path [m].
    pub along: Point,
}

impl Deviation {
    #[inline]
    pub(super) fn of(at: &Located) -> Self {
        Self {
            cross_track_error: at.closest.cross_track_error(),
            yaw: at.vehicle.yaw,
            along: at.closest.along(),
        }
    }

    #[inline]
    pub(super) fn heading_error(&self) -> f64 {
        wrap(self.yaw - atan2(self.along.y, self.along.x))
    }

    /// Whether the heading error of `other` is that of this one, to the bit.
    #[inline]
    pub(super) fn heads_as(&self, other: &Self) -> bool {
        self.yaw.to_bits() == other.yaw.to_bits()
            && self.along.x.to_bits() == other.along.x.to_bits()
            && self.along.y.to_bits() == other.along.y.to_bits()
    }

    fn check(&self) -> Result<(), InputError> {
        let most = 4.0 * MAX_COORDINATE;
        input_within("answer", self.cross_track_error, most)?;
        input_within("answer", self.yaw, 2.0 * MAX_YAW)?;
        input_within("answer", self.along.x, most)?;
        input_within("answer", self.along.y, most)?;
        Ok(())
    }
}

/// The last step's command besides its angle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Answer {
    /// The measured vehicle.
    pub measured: Deviation,
    /// The predicted one.
    pub predicted: Deviation,
    /// The point aimed at [m].
    pub target: Point,
    /// Whether the path was driven backwards.
    pub reverse: bool,
    /// Reference speed and distance to the next stop.
    pub ahead: Ahead,
    /// The pose of the vehicle's point, and the speed.
    pub vehicle: VehicleState,
}

impl Answer {
    /// Before the first step: stop.
    pub(super) const NOWHERE: Self = {
        let deviation = Deviation {
            cross_track_error: 0.0,
            yaw: 0.0,
            along: Point::new(1.0, 0.0),
        };
        Self {
            measured: deviation,
            predicted: deviation,
            target: Point::new(0.0, 0.0),
            reverse: false,
            ahead: Ahead {
                reference_speed: None,
                distance_to_stop: 0.0,
            },
            vehicle: VehicleState::ORIGIN,
        }
    };

    pub(super) fn checked(self) -> Result<Self, InputError> {
        const FIELD: &str = "answer";
        self.measured.check()?;
        self.predicted.check()?;
        input_within(FIELD, self.target.x, 4.0 * MAX_COORDINATE)?;
        input_within(FIELD, self.target.y, 4.0 * MAX_COORDINATE)?;
        self.ahead.check(FIELD)?;
        let vehicle = self.vehicle.checked();
        vehicle.map_err(|error| InputError {
            field: FIELD,
            ..error
        })?;
        Ok(self)
    }
}

/// Declares the two parts of a [`TrackerState`], and the form in which serde shows it: all their
/// fields, as those of one struct.
macro_rules! parts {
    (
        $(#[doc = $about:literal])+
        $first:ident {
            $(#[doc = $law_text:literal])+ law: $law:ty,
            $($(#[doc = $text:literal])+ $kept:ident: $kind:ty,)+
        }
        $(#[doc = $second_about:literal])+
        $second:ident { $($(#[doc = $other_text:literal])+ $other:ident: $other_kind:ty,)+ }
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $first<S> {
            $(#[doc = $law_text])+ pub law: $law,
            $($(#[doc = $text])+ pub $kept: $kind,)+
        }

        $(#[doc = $second_about])+
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $second {
            $($(#[doc = $other_text])+ pub $other: $other_kind,)+
        }

        impl<S> TrackerState<S> {
            /// The same with the controller's state made into another by `change`.
            pub fn map<T>(self, change: impl FnOnce(S) -> T) -> TrackerState<T> {
                let Self { tracking, model } = self;
                let law = change(tracking.law);
                TrackerState { tracking: $first { law, $($kept: tracking.$kept,)+ }, model }
            }
        }

        /// A [`TrackerState`] as data.
        #[cfg(feature = "serde")]
        #[derive(serde::Serialize, serde::Deserialize)]
        #[serde(rename = "TrackerState")]
        struct Data<S> {
            law: $law,
            $($kept: $kind,)+
            $($other: $other_kind,)+
        }

        #[cfg(feature = "serde")]
        impl<S> From<TrackerState<S>> for Data<S> {
            fn from(state: TrackerState<S>) -> Self {
                let TrackerState { tracking, model } = state;
                Self {
                    law: tracking.law,
                    $($kept: tracking.$kept,)+
                    $($other: model.$other,)+
                }
            }
        }

        #[cfg(feature = "serde")]
        impl<S> From<Data<S>> for TrackerState<S> {
            fn from(data: Data<S>) -> Self {
                Self {
                    tracking: $first { law: data.law, $($kept: data.$kept,)+ },
                    model: $second { $($other: data.$other,)+ },
                }
            }
        }
    };
}

parts! {
    /// What every [`Tracker`](super::Tracker) remembers.
    Tracking {
        /// What the controller remembers.
        law: S,
        /// Where the measured vehicle is on the path.
        place: Place,
        /// The angle last commanded [rad].
        steer: f64,
        /// A hand-over that is not over.
        handover: Option<Handover>,
        /// How many inputs in a row were refused, or came in no time.
        held: usize,
        /// How much time they took, which the next step counts [s].
        held_time: f64,
        /// The time that the last step counted [s]; 0 before the first.
        period: f64,
        /// The last answer; None before the first step.
        answer: Option<Answer>,
        /// What the monitor remembers; None before the first step.
        monitor: Option<MonitorState>,
        /// The poses that are believed; None before the first step, and without a gate.
        gate: Option<Gate>,
    }
    /// What is remembered of a vehicle that is modelled: 5.9 kB, of which a batch keeps what is in
    /// flight, and nothing for other vehicles. Its default is that of those.
    Model {
        /// Commands in flight, if the vehicle is modelled.
        in_flight: Option<InFlight>,
        /// The wheels' recent angles; None before the first pose with an age.
        past: Option<Past>,
        /// The estimator's state.
        estimator: Estimator,
    }
}

/// What a [`Tracker`](super::Tracker) remembers; it dereferences to its [`Tracking`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(
        into = "Data<S>",
        from = "Data<S>",
        bound(
            serialize = "S: Clone + serde::Serialize",
            deserialize = "S: serde::Deserialize<'de>"
        )
    )
)]
pub struct TrackerState<S> {
    /// What every tracker remembers.
    pub tracking: Tracking<S>,
    /// What is remembered of a modelled vehicle.
    pub model: Model,
}

impl<S> Deref for TrackerState<S> {
    type Target = Tracking<S>;

    #[inline]
    fn deref(&self) -> &Tracking<S> {
        &self.tracking
    }
}

impl<S> DerefMut for TrackerState<S> {
    #[inline]
    fn deref_mut(&mut self) -> &mut Tracking<S> {
        &mut self.tracking
    }
}

impl Model {
    /// Whether nothing is modelled; nothing is estimated then.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.in_flight.is_none() && self.past.is_none()
    }
}

impl<S: LateralState> TrackerState<S> {
    /// The localisation has jumped, or the vehicle was searched for: it is near `place`, and the motion
    /// until now is not used for estimates.
    pub(crate) fn jump_to(&mut self, place: Place) {
        self.tracking.jump(place);
        self.model.estimator.last_measured = None;
        self.gate = None;
        if let Some(monitor) = &mut self.monitor {
            monitor.within = false;
        }
    }
}

impl<S> Tracking<S> {
    /// The speeds at the last step and at the last pose that was believed [m/s]; the one `now` without.
    #[inline]
    pub(super) fn speeds_before(&self, now: f64) -> (f64, f64) {
        let last = self.answer.as_ref();
        let last = last.map_or(now, |last| last.vehicle.speed);
        let gate = self.gate.as_ref();
        (last, gate.map_or(last, |gate| gate.believed.speed))
    }

    /// What is not believed, by the last step of the vehicle `car`; None if nothing is wrong. Where
    /// there is one, the status of that step has [`IMPLAUSIBLE`](crate::Status::IMPLAUSIBLE).
    pub fn fault(&self, car: &Vehicle) -> Option<Fault> {
        let gate = self.gate.as_ref().and_then(|gate| gate.fault(car));
        let turning = self.monitor.as_ref().and_then(MonitorState::fault);
        // A wrong speed or heading turns the vehicle otherwise than commanded, too; its own residual names it.
        let doubted = self.gate.as_ref().and_then(|gate| gate.doubts(car));
        gate.or(turning.map(|fault| doubted.unwrap_or(fault)))
    }
}

impl<S: LateralState> Tracking<S> {
    /// The localisation has jumped: what was measured against the path before says nothing of the
    /// errors from here on.
    pub(super) fn jump(&mut self, place: Place) {
        self.place = place;
        self.law.interrupt();
        if let Some(monitor) = &mut self.monitor {
            monitor.interrupt();
        }
    }
}

/// The widest offset of a hand-over: from one end of the wheels to the other [rad].
pub(super) fn widest_offset(vehicle: &Vehicle) -> f64 {
    let offsets = vehicle.steer_offset.abs() + Estimator::MAX_STEER_OFFSET;
    2.0 * vehicle.max_steer + offsets
}

#[cfg(test)]
mod tests;
