//! Optional inputs of a step: the command that was really applied, the measured angle of the wheels,
//! the age of the pose, and the roll.

use crate::error::{InputError, input_within};
use crate::vehicle::Vehicle;
use crate::vehicle::past::checked_age;

/// The optional inputs of a step, besides pose and speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reported {
    /// The command that was applied since the last step in place of the controller's [rad]: a
    /// driver's or another controller's. Prediction, estimates and limits continue from it. Dead
    /// time and lag are still ahead of it. An angle of up to 90 degrees counts as the nearest one
    /// within `max_steer`.
    pub applied_steer: Option<f64>,
    /// The angle of the wheels now, as a sensor measured it [rad], on the scale of the commands: the
    /// `steer_offset` is not in it. Dead time and lag are behind it: the prediction starts from it
    /// in place of the modelled angle, and nothing else changes. Range as `applied_steer`.
    pub measured_steer: Option<f64>,
    /// How long before the step pose and speed were measured [s], from 0 to
    /// [`MAX_POSE_AGE`](crate::vehicle::past::MAX_POSE_AGE). A difference of two stamps that rounding
    /// makes negative, by less than the shortest period, is 0.
    pub pose_age: f64,
    /// How far the vehicle is rolled to its right [rad], up to 90 degrees: positive where its right side
    /// is lower. It matters to an antenna above ground alone.
    pub roll: f64,
}

impl Reported {
    /// The last command was applied, and the pose is that of now.
    pub const NOTHING: Self = Self {
        applied_steer: None,
        measured_steer: None,
        pose_age: 0.0,
        roll: 0.0,
    };

    /// The same, within what `vehicle` can have done.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the number that is not finite or beyond its bound.
    #[inline]
    pub fn checked(self, vehicle: &Vehicle) -> Result<Self, InputError> {
        if self == Self::NOTHING {
            return Ok(self);
        }
        let limit = core::f64::consts::FRAC_PI_2;
        let checked = |name, steer: Option<f64>| match steer {
            None => Ok(None),
            Some(steer) => input_within(name, steer, limit).map(|it| Some(vehicle.at_wheels(it))),
        };
        Ok(Self {
            applied_steer: checked("applied_steer", self.applied_steer)?,
            measured_steer: checked("measured_steer", self.measured_steer)?,
            pose_age: checked_age(self.pose_age)?,
            roll: input_within("roll", self.roll, limit)?,
        })
    }
}
