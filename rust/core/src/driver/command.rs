//! The answer of a driver's step.

use crate::geometry::Point;
use crate::speed::{Phase, SpeedCommand};
use crate::status::Status;
use crate::tracker::Command;
use crate::vehicle::Fault;

/// What to do until the next step: for the steering, and for the drive with its gear.
///
/// Errors and distances are those of the vehicle as it is believed to be now, after the age of its
/// pose; in the frame of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Angle to command [rad], positive to the left.
    pub steer: f64,
    /// Acceleration in the direction of driving [m/s^2]; negative brakes.
    pub acceleration: f64,
    /// Speed to command in the direction of driving [m/s], for a vehicle that takes a speed.
    pub speed: f64,
    /// Whether the vehicle is to be in reverse gear.
    pub reverse: bool,
    /// Whether the vehicle is to be held where it stands.
    pub hold: bool,
    /// What the vehicle does.
    pub phase: Phase,
    /// Why the vehicle stops, or has stopped: the first fault since the last
    /// [`release`](super::Driver::release).
    pub fault: Option<Fault>,
    /// How the step went.
    pub status: Status,
    /// Offset of the point that the controller tracks from the path [m], positive left of it.
    pub cross_track_error: f64,
    /// Yaw of the vehicle less direction of the path [rad], in `[-pi, pi]`.
    pub heading_error: f64,
    /// Cross-track error of the vehicle when the command reaches the wheels [m].
    pub predicted_cross_track_error: f64,
    /// Heading error of that vehicle [rad].
    pub predicted_heading_error: f64,
    /// The point aimed at [m].
    pub target: Point,
    /// The planned speed beside the rear axle [m/s], never negative.
    pub reference_speed: f64,
    /// Distance that the rear axle has to go along the path to the next stop [m]; negative past it,
    /// infinite if there is none.
    pub distance_to_stop: f64,
}

impl Drive {
    /// The answers of both laws.
    #[inline]
    pub(super) fn of(command: &Command, pace: &SpeedCommand, fault: Option<Fault>) -> Self {
        Self {
            steer: command.steer,
            acceleration: pace.acceleration,
            speed: pace.speed,
            reverse: pace.reverse,
            hold: pace.standing,
            phase: pace.phase,
            fault,
            status: command.status,
            cross_track_error: command.cross_track_error,
            heading_error: command.heading_error,
            predicted_cross_track_error: command.predicted_cross_track_error,
            predicted_heading_error: command.predicted_heading_error,
            target: command.target,
            reference_speed: pace.reference_speed,
            distance_to_stop: pace.distance_to_stop,
        }
    }
}
