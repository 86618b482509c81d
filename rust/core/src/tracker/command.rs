//! The command of one step.

use super::state::{Answer, Tracking};
use crate::geometry::Point;
use crate::status::Status;

/// The command of one step, with its errors and status.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Angle to command [rad], positive to the left.
    pub steer: f64,
    /// Offset of the tracked point of the measured vehicle from the path [m], positive left of it.
    pub cross_track_error: f64,
    /// Yaw of the measured vehicle less direction of the path [rad], in `[-pi, pi]`.
    pub heading_error: f64,
    /// Cross-track error of the vehicle as it will be when the command reaches the wheels [m];
    /// that of the measured one without a dead time.
    pub predicted_cross_track_error: f64,
    /// Heading error of that vehicle [rad].
    pub predicted_heading_error: f64,
    /// The point aimed at: the lookahead point, or the projection onto the path [m].
    pub target: Point,
    /// Whether the path is driven backwards here.
    pub reverse: bool,
    /// The path's speed beside the rear axle [m/s], negative where it is driven backwards; None
    /// if the path has no speeds. Its square is linear between waypoints; a speed of 0 at a cusp
    /// or at an end counts as a tenth of the wheelbase a second, so that no vehicle stops before
    /// it.
    pub reference_speed: Option<f64>,
    /// Distance that the rear axle has to go along the path to the next cusp, or to the end [m];
    /// negative past the end, infinite on a closed path without cusps.
    pub distance_to_stop: f64,
    /// How the step went.
    pub status: Status,
}

impl Command {
    /// No command: every number is NaN.
    pub const NONE: Self = Self {
        steer: f64::NAN,
        cross_track_error: f64::NAN,
        heading_error: f64::NAN,
        predicted_cross_track_error: f64::NAN,
        predicted_heading_error: f64::NAN,
        target: Point::new(f64::NAN, f64::NAN),
        reverse: false,
        reference_speed: None,
        distance_to_stop: f64::NAN,
        status: Status::OK,
    };
}

impl<S> Tracking<S> {
    /// The command of a step that went as `status` says.
    #[inline]
    pub fn command(&self, status: Status) -> Command {
        let answer = self.answer.as_ref().unwrap_or(&Answer::NOWHERE);
        let (measured, predicted) = (&answer.measured, &answer.predicted);
        let heading_error = measured.heading_error();
        Command {
            steer: self.steer,
            cross_track_error: measured.cross_track_error,
            heading_error,
            predicted_cross_track_error: predicted.cross_track_error,
            predicted_heading_error: if predicted.heads_as(measured) {
                heading_error
            } else {
                predicted.heading_error()
            },
            target: answer.target,
            reverse: answer.reverse,
            reference_speed: answer.ahead.reference_speed,
            distance_to_stop: answer.ahead.distance_to_stop,
            status,
        }
    }
}
