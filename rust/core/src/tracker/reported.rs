//! Optional inputs of a step: the angle that was really applied, and the age of the pose.

use crate::error::{InputError, input_in_range, input_within};
use crate::vehicle::Vehicle;
use crate::vehicle::past::MAX_POSE_AGE;

/// The optional inputs of a step, besides pose and speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reported {
    /// The angle that was applied since the last step in place of the commanded one [rad]: a
    /// driver's, another controller's, or one that was measured. Prediction, estimates and limits
    /// continue from it. An angle of up to 90 degrees counts as the nearest one within `max_steer`.
    pub applied_steer: Option<f64>,
    /// How long before the step pose and speed were measured [s], from 0 to [`MAX_POSE_AGE`].
    pub pose_age: f64,
}

impl Reported {
    /// The last command was applied, and the pose is that of now.
    pub const NOTHING: Self = Self {
        applied_steer: None,
        pose_age: 0.0,
    };

    /// The same, within what `vehicle` can have done.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the number that is not finite or beyond its bound.
    #[inline]
    pub fn checked(self, vehicle: &Vehicle) -> Result<Self, InputError> {
        if self.applied_steer.is_none() && self.pose_age.to_bits() == 0 {
            return Ok(self);
        }
        let applied_steer = match self.applied_steer {
            None => None,
            Some(steer) => Some(checked_steer(vehicle, steer)?),
        };
        input_in_range("pose_age", self.pose_age, 0.0, MAX_POSE_AGE)?;
        Ok(Self {
            applied_steer,
            pose_age: self.pose_age,
        })
    }
}

fn checked_steer(vehicle: &Vehicle, steer: f64) -> Result<f64, InputError> {
    let limit = core::f64::consts::FRAC_PI_2;
    input_within("applied_steer", steer, limit).map(|steer| vehicle.at_wheels(steer))
}
