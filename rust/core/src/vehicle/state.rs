//! Pose and speed of the vehicle, checked at every step.

use crate::bounds::{MAX_COORDINATE, MAX_DT, MAX_SPEED, MAX_YAW, MIN_DT};
use crate::error::{InputError, Requirement, input_in_range, input_within};
use crate::geometry::Point;
use crate::math::{cos, from_count, saturate, sin, wrap};

/// Pose of the vehicle's point, and speed.
// The order of the fields is fixed: arrays of these come from C.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VehicleState {
    /// Position along x [m].
    pub x: f64,
    /// Position along y [m].
    pub y: f64,
    /// Heading [rad], counter-clockwise from x.
    pub yaw: f64,
    /// Forward speed [m/s]; negative while rolling backwards.
    pub speed: f64,
}

impl VehicleState {
    /// At rest at the origin.
    pub const ORIGIN: Self = Self {
        x: 0.0,
        y: 0.0,
        yaw: 0.0,
        speed: 0.0,
    };

    /// The state itself where every number in it is finite and within its bound.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the first field that is not.
    #[inline]
    pub fn checked(self) -> Result<Self, InputError> {
        input_within("x", self.x, MAX_COORDINATE)?;
        input_within("y", self.y, MAX_COORDINATE)?;
        input_within("yaw", self.yaw, MAX_YAW)?;
        input_within("speed", self.speed, MAX_SPEED)?;
        Ok(self)
    }

    /// A state that was predicted, brought within the bounds of one that is given: places and
    /// speeds beyond them are put onto them, a yaw beyond them is turned back by whole turns.
    #[inline]
    pub fn bounded(self) -> Self {
        let yaw = if self.yaw.abs() <= MAX_YAW {
            self.yaw
        } else {
            wrap(self.yaw)
        };
        Self {
            x: saturate(self.x, -MAX_COORDINATE, MAX_COORDINATE),
            y: saturate(self.y, -MAX_COORDINATE, MAX_COORDINATE),
            yaw,
            speed: saturate(self.speed, -MAX_SPEED, MAX_SPEED),
        }
    }

    /// The same vehicle by the pose of a point `offset` [m] farther ahead.
    #[inline]
    pub fn ahead(self, offset: f64) -> Self {
        if offset.abs() <= 0.0 {
            return self;
        }
        let point = self.point_ahead(offset);
        Self {
            x: point.x,
            y: point.y,
            ..self
        }
    }

    /// The same vehicle by the pose of a point `offset` [m] farther to the left, within the bounds.
    #[inline]
    pub fn left(self, offset: f64) -> Self {
        if offset.abs() <= 0.0 {
            return self;
        }
        Self {
            x: self.x - offset * sin(self.yaw),
            y: self.y + offset * cos(self.yaw),
            ..self
        }
        .bounded()
    }

    /// The point `offset` [m] ahead along the heading.
    #[inline]
    pub fn point_ahead(&self, offset: f64) -> Point {
        Point::new(
            self.x + offset * cos(self.yaw),
            self.y + offset * sin(self.yaw),
        )
    }

    /// The speed where the vehicle rolls forward, else 0 [m/s]: what the controllers steer by while
    /// it still rolls the other way.
    #[inline]
    pub fn forward_speed(&self) -> f64 {
        if self.speed > 0.0 { self.speed } else { 0.0 }
    }
}

/// `dt` [s] where it is a control period that a step can take.
///
/// # Errors
///
/// [`InputError`] for one that is not finite, not positive, or beyond the bounds.
#[inline]
pub fn checked_dt(dt: f64) -> Result<f64, InputError> {
    input_in_range("dt", dt, MIN_DT, MAX_DT)
}

/// `dt` [s] as a step takes it: None where it is no control period, as of a clock that was set or that
/// repeats a stamp. Its step holds the last command.
///
/// # Errors
///
/// [`InputError`] for one that is not finite.
#[inline]
pub fn period(dt: f64) -> Result<Option<f64>, InputError> {
    match checked_dt(dt) {
        Err(error) if !dt.is_finite() => Err(error),
        checked => Ok(checked.ok()),
    }
}

/// Refuses a `count` of a state that does not lie in `[low, high]`.
pub(crate) fn check_count(
    field: &'static str,
    count: usize,
    low: usize,
    high: usize,
) -> Result<(), InputError> {
    if low <= count && count <= high {
        return Ok(());
    }
    Err(InputError {
        field,
        value: from_count(count),
        requirement: Requirement::CountInRange(low, high),
    })
}
