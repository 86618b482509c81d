//! What the law is told, answers, and remembers.

use crate::error::{InputError, input_within};
use crate::path::stop::Ahead;
use crate::speed::disturbance::Observer;
use crate::speed::servo::Servo;
use crate::status::Status;
use crate::vehicle::Drive;

/// Bounds of the accelerations [m/s²] and the speed [m/s] of a state, beyond what a step can leave there.
pub(super) const ACCELERATION_BOUND: f64 = 1e4;
pub(super) const SPEED_BOUND: f64 = 1e8;

/// What the vehicle does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Phase {
    /// It keeps its plan.
    #[default]
    Driving,
    /// It brakes for a stop.
    Stopping,
    /// It is held at its stop.
    Standing,
    /// It stands until its wheels are turned.
    Turning,
    /// It stands until its gear is in.
    Shifting,
    /// It brakes or stands as it was told to, for a fault, or as long as nothing is known of it.
    Stopped,
}

impl Phase {
    /// All of them, each at the number that stands for it in C.
    pub const ALL: [Self; 6] = [
        Self::Driving,
        Self::Stopping,
        Self::Standing,
        Self::Turning,
        Self::Shifting,
        Self::Stopped,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Driving => "driving",
            Self::Stopping => "stopping",
            Self::Standing => "standing",
            Self::Turning => "turning",
            Self::Shifting => "shifting",
            Self::Stopped => "stopped",
        }
    }
}

/// What a step of the speed answers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SpeedCommand {
    /// Acceleration in the direction of driving [m/s^2]; negative brakes.
    pub acceleration: f64,
    /// Speed to command in the direction of driving [m/s], for a vehicle that takes a speed: never
    /// above the top speed; negative only while the vehicle still rolls the other way.
    pub speed: f64,
    /// Speed that the plan has beside the rear axle [m/s]; at least that to creep with, so never negative.
    pub reference_speed: f64,
    /// Distance along the path to the next stop [m]: a cusp, the end, or a speed of 0, for the vehicle's
    /// `stop_point` at the last two; infinite where there is none, negative where it was overrun.
    pub distance_to_stop: f64,
    /// Whether the vehicle is to drive backwards: while it rolls, the way that it rolls.
    pub reverse: bool,
    /// Whether the vehicle is to be held where it stands.
    pub standing: bool,
    /// Whether it overruns its stop, however hard it brakes, by this step and the last one; or stands
    /// beyond it.
    pub cannot_stop: bool,
    /// What the vehicle does.
    pub phase: Phase,
    /// What is known of the inputs: of the tracker, or of the driver around the law. No part of a state.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub status: Status,
}

impl SpeedCommand {
    /// Before anything is known: stand, and not as one that has arrived.
    pub(crate) const WAITING: Self = Self {
        acceleration: 0.0,
        speed: 0.0,
        reference_speed: 0.0,
        distance_to_stop: f64::INFINITY,
        reverse: false,
        standing: true,
        cannot_stop: false,
        phase: Phase::Stopped,
        status: Status::OK,
    };

    /// Refuses one that no law gives.
    pub(crate) fn check(&self) -> Result<(), InputError> {
        const FIELD: &str = "command";
        input_within(FIELD, self.acceleration, ACCELERATION_BOUND)?;
        input_within(FIELD, self.speed, SPEED_BOUND)?;
        let ahead = Ahead {
            reference_speed: Some(self.reference_speed),
            distance_to_stop: self.distance_to_stop,
        };
        ahead.check(FIELD)
    }
}

/// What is believed of the vehicle, and what it was told.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensed {
    /// Speed [m/s], negative backwards.
    pub speed: f64,
    /// How long ago it had that speed [s].
    pub age: f64,
    /// Standard deviations of the noise of its position [m] and of its speed [m/s].
    pub noise: (f64, f64),
    /// Whether the reverse gear is in; None where that is not reported.
    pub reverse_gear: Option<bool>,
    /// With which deceleration [m/s²] it is to stop here, by the operator or for a fault; None: it goes on.
    pub stop: Option<f64>,
}

/// What the law remembers.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is remembered by itself"
)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SpeedState {
    /// The last command [m/s^2].
    pub acceleration: f64,
    /// The speed along the path [m/s].
    pub speed: f64,
    /// The commands in flight, and the drive; None before the first step.
    pub drive: Option<Drive>,
    /// What else pushes.
    pub observer: Observer,
    /// The waypoint of the next stop, where it lies [m], and the distance to it, as steady as the speed.
    pub stop: Option<(usize, (f64, f64), f64)>,
    /// Whether the vehicle is held at its stop.
    pub standing: bool,
    /// Whether it brakes for its stop.
    pub stopping: bool,
    /// Whether it overruns its stop by the last step.
    pub overruns: bool,
    /// How long it stands until its wheels are turned and its gear is in [s].
    pub waits: (f64, f64),
    /// The wheels' angle before the turn that it is to wait for [rad].
    pub wheels: Option<f64>,
    /// Whether the path is driven backwards; None before the first step.
    pub reverse: Option<bool>,
    /// For how long it has been at rest [s].
    pub still: f64,
    /// Whether it still rolls the way that it drove before.
    pub rolls: bool,
    /// Whether it has not moved since its direction changed.
    pub shifting: bool,
    /// The first segment of the next section, once the vehicle stands at a cusp.
    pub passes: Option<usize>,
    /// The speed command, for a vehicle that takes one.
    pub servo: Servo,
}

impl SpeedState {
    /// The sign of its speeds: -1 in reverse gear.
    #[inline]
    pub(crate) fn gear(&self) -> f64 {
        if self.reverse == Some(true) {
            -1.0
        } else {
            1.0
        }
    }

    /// Whether the vehicle is held: at its stop, or until its wheels are turned and its gear is in.
    pub(super) fn is_held(&self) -> bool {
        self.standing || self.waits.0 > 0.0 || self.waits.1 > 0.0
    }
}
