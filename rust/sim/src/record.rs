//! What a control step of a run was measured as.

use popsteer_core::math::to_count;
use popsteer_core::{Point, Status};

/// One control step as it was measured, before the plant moved on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// Time [s].
    pub time: f64,
    /// Position of the tracked point [m].
    pub reference: Point,
    /// Position along x of the vehicle's point [m].
    pub x: f64,
    /// Position along y of that point [m].
    pub y: f64,
    /// Heading [rad].
    pub yaw: f64,
    /// Speed [m/s].
    pub speed: f64,
    /// Angle commanded [rad].
    pub steer: f64,
    /// Throttle commanded, 0 to 1.
    pub throttle: f64,
    /// Brake commanded, 0 to 1.
    pub brake: f64,
    /// Cross-track error at the tracked point [m].
    pub cross_track_error: f64,
    /// Heading error at the tracked point [rad] against the segment behind the nearest
    /// waypoint, as the paper's authors measured it.
    pub heading_error: f64,
    /// Cross-track error at the rear axle [m].
    pub rear_cross_track_error: f64,
    /// Heading error at the rear axle [rad] against the segment beside it.
    pub rear_heading_error: f64,
    /// Point aimed at [m]; not a number without a controller.
    pub target: Point,
    /// How the controller's step went.
    pub status: Status,
}

impl Record {
    /// How many numbers a record is.
    pub const LENGTH: usize = 17;

    /// The record as numbers.
    pub fn numbers(&self) -> [f64; Self::LENGTH] {
        [
            self.time,
            self.reference.x,
            self.reference.y,
            self.x,
            self.y,
            self.yaw,
            self.speed,
            self.steer,
            self.throttle,
            self.brake,
            self.cross_track_error,
            self.heading_error,
            self.rear_cross_track_error,
            self.rear_heading_error,
            self.target.x,
            self.target.y,
            f64::from(self.status.bits()),
        ]
    }

    /// The record of these numbers.
    pub fn of(numbers: [f64; Self::LENGTH]) -> Self {
        let [
            time,
            reference_x,
            reference_y,
            x,
            y,
            yaw,
            speed,
            steer,
            throttle,
            brake,
            cross_track_error,
            heading_error,
            rear_cross_track_error,
            rear_heading_error,
            target_x,
            target_y,
            status,
        ] = numbers;
        let bits = u32::try_from(to_count(status)).unwrap_or(0);
        Self {
            time,
            reference: Point::new(reference_x, reference_y),
            x,
            y,
            yaw,
            speed,
            steer,
            throttle,
            brake,
            cross_track_error,
            heading_error,
            rear_cross_track_error,
            rear_heading_error,
            target: Point::new(target_x, target_y),
            status: Status::from_bits(bits).unwrap_or_default(),
        }
    }
}
