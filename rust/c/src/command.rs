//! What goes into a step, and what comes out of it.

use popsteer_core::tracker::Reported;
use popsteer_core::vehicle::Known;
use popsteer_core::{Command, VehicleState};

use crate::fields::{Field, answer_fields, same_fields};

/// The pose of the vehicle's point, and the speed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CVehicleState {
    /// Position [m], within 1e9.
    pub x: f64,
    /// Position [m], within 1e9.
    pub y: f64,
    /// Heading [rad], counter-clockwise from x, within 1e6.
    pub yaw: f64,
    /// Speed [m/s], negative while rolling backwards, within 1e4.
    pub speed: f64,
}

same_fields!(CVehicleState, VehicleState, { x, y, yaw, speed });

/// What a vehicle may report beside pose and speed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CReported {
    /// The command that was applied since the last step in place of the controller's [rad]: a
    /// driver's or another controller's. NAN: the controller's.
    pub applied_steer: f64,
    /// The angle of the wheels now, as a sensor measured it [rad], on the scale of the commands.
    /// NAN: not measured.
    pub measured_steer: f64,
    /// How long before the step pose and speed were measured [s], 0 to 1.
    pub pose_age: f64,
    /// How far the vehicle is rolled to its right [rad], positive where its right side is lower.
    pub roll: f64,
}

same_fields!(CReported, Reported, { applied_steer, measured_steer, pose_age, roll });

/// What one step answers.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CCommand {
    /// Angle of the front wheels to command [rad], positive to the left.
    pub steer: f64,
    /// Offset of the tracked point of the measured vehicle from the path [m], positive left of it.
    pub cross_track_error: f64,
    /// Yaw of the measured vehicle less direction of the path [rad], in [-pi, pi].
    pub heading_error: f64,
    /// Cross-track error of the vehicle as it will be when the command reaches the wheels [m].
    pub predicted_cross_track_error: f64,
    /// Heading error of that vehicle [rad].
    pub predicted_heading_error: f64,
    /// The point aimed at [m].
    pub target_x: f64,
    /// The point aimed at [m].
    pub target_y: f64,
    /// The path's speed beside the rear axle [m/s], negative where it is driven backwards; NAN
    /// where the path has no speeds.
    pub reference_speed: f64,
    /// Distance that the rear axle has to go to the next cusp, or to the end [m]; negative past the
    /// end, INFINITY on a closed path without cusps.
    pub distance_to_stop: f64,
    /// How the step went: `POPSTEER_STATUS_...` bits; 0 is as the controller wants it.
    pub status: u32,
    /// Whether the path is driven backwards here.
    pub reverse: bool,
}

impl From<Command> for CCommand {
    #[inline]
    fn from(command: Command) -> Self {
        let Command {
            steer,
            cross_track_error,
            heading_error,
            predicted_cross_track_error,
            predicted_heading_error,
            target,
            reverse,
            reference_speed,
            distance_to_stop,
            status,
        } = command;
        Self {
            steer,
            cross_track_error,
            heading_error,
            predicted_cross_track_error,
            predicted_heading_error,
            target_x: target.x,
            target_y: target.y,
            reference_speed: f64::of(reference_speed),
            distance_to_stop,
            status: status.bits(),
            reverse,
        }
    }
}

/// One instant of a predicted trajectory.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CPredicted {
    /// Time since the last step [s].
    pub time: f64,
    /// Pose of the vehicle's point, and speed.
    pub vehicle: CVehicleState,
    /// Angle commanded then [rad].
    pub steer: f64,
}

/// What the motion has shown of the vehicle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct CEstimate {
    /// How many times more the vehicle turns than its figures say.
    pub gain: f64,
    /// Angle of the wheels at the command 0 [rad], the vehicle's `steer_offset` included.
    pub steer_offset: f64,
    /// Time from a command to its first effect on the wheels [s], the vehicle's `dead_time`
    /// included.
    pub dead_time: f64,
    /// Time constant of the wheels' response [s]: the vehicle's `steer_lag`, or less.
    pub steer_lag: f64,
    /// Angle of the motion of the point that does not slip to the heading, straight on [rad].
    pub slip: f64,
    /// How much that angle grows with the curvature [m].
    pub slip_length: f64,
    /// Acceleration [m/s^2].
    pub acceleration: f64,
    /// Ratio of the vehicle's speed to what its speed signal says.
    pub speed_scale: f64,
}

answer_fields!(CEstimate, Known, {
    gain, steer_offset, dead_time, steer_lag, slip, slip_length, acceleration, speed_scale
});

/// No angle but the last command was applied, and the pose is that of now.
#[unsafe(no_mangle)]
pub extern "C" fn popsteer_reported_default() -> CReported {
    Reported::NOTHING.into()
}
