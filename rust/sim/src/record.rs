//! What a control step of a run was measured as.

use popsteer_core::{Point, Status};

/// One control step as it was measured, before the plant moved on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    #[cfg_attr(feature = "serde", serde(with = "bits"))]
    pub status: Status,
}

/// A number of a record: its name, and where it is.
pub type Column = (&'static str, fn(&Record) -> f64);

impl Record {
    /// The numbers of a record, beside its status: their names, and where they are.
    pub const COLUMNS: [Column; 16] = [
        ("time", |record| record.time),
        ("x", |record| record.x),
        ("y", |record| record.y),
        ("yaw", |record| record.yaw),
        ("speed", |record| record.speed),
        ("steer", |record| record.steer),
        ("throttle", |record| record.throttle),
        ("brake", |record| record.brake),
        ("reference_x", |record| record.reference.x),
        ("reference_y", |record| record.reference.y),
        ("cross_track_error", |record| record.cross_track_error),
        ("heading_error", |record| record.heading_error),
        ("rear_cross_track_error", |record| {
            record.rear_cross_track_error
        }),
        ("rear_heading_error", |record| record.rear_heading_error),
        ("target_x", |record| record.target.x),
        ("target_y", |record| record.target.y),
    ];
}

/// A status as its bits.
#[cfg(feature = "serde")]
pub(crate) mod bits {
    use popsteer_core::Status;
    use serde::de::{Deserialize, Deserializer, Error};
    use serde::ser::Serializer;

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
    pub(crate) fn serialize<S: Serializer>(status: &Status, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_u64(status.bits().into())
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Status, D::Error> {
        let status = u32::try_from(u64::deserialize(from)?).ok();
        let status = status.and_then(Status::from_bits);
        status.ok_or_else(|| D::Error::custom("the bits of a Status"))
    }
}
