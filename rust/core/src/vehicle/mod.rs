//! The vehicle: its parameters, prediction, commands in flight, and estimation from its motion.

pub mod bicycle;
pub mod delay;
pub mod estimate;
pub mod estimator;
pub mod past;
pub mod state;
pub mod timed;
pub mod wheels;

pub use delay::InFlight;
pub use estimate::{AdaptParams, Estimate};
pub use estimator::Estimator;
pub use past::Past;
pub use state::VehicleState;

use crate::error::{ConfigError, config_in_range, config_optional as optional};
use crate::math::saturate;

/// All parameters of a car-like vehicle, in one immutable value.
///
/// A *pose* is always that of the vehicle's point, wherever it is measured; the axles are given
/// relative to it. One chain leads from a command to the motion of the vehicle, in prediction, in
/// preview POP and in plants that are made from a vehicle:
///
/// ```text
/// wheel' = clip((command(t - dead_time) + steer_offset - wheel) / steer_lag, +-max_steer_rate)
/// |wheel| <= max_steer
/// yaw'   = speed tan(wheel) / (turning_wheelbase + understeer speed^2)
/// ```
///
/// and the no-slip point moves along the vehicle's heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vehicle {
    /// Distance of the axles `L` [m]; the default lengths of all parameters scale with it.
    pub wheelbase: f64,
    /// How far ahead of the pose's point the rear axle lies [m]: 0 where the pose is the rear
    /// axle's, negative where it is of a point ahead of that.
    pub rear_axle: f64,
    /// How far ahead of the pose's point lies the no-slip point [m], the one that moves along the
    /// vehicle's heading; the rear axle by default.
    pub no_slip_point: Option<f64>,
    /// The wheelbase that the vehicle turns by [m]; `wheelbase` by default.
    pub turning_wheelbase: Option<f64>,
    /// Understeer gradient `K` [s^2/m].
    pub understeer: f64,
    /// Angle of the wheels at the command 0 [rad].
    pub steer_offset: f64,
    /// Time constant of the wheels' first-order response to a command [s].
    pub steer_lag: f64,
    /// Time from a command to its first effect on the wheels [s].
    pub dead_time: f64,
    /// Largest angle of the front wheels `delta_max` [rad].
    pub max_steer: f64,
    /// Largest rate of the front wheels' angle [rad/s]; none for no limit.
    pub max_steer_rate: Option<f64>,
    /// Largest lateral acceleration that a command may ask for [m/s^2]; none for no limit.
    pub max_lateral_acceleration: Option<f64>,
    /// Top speed [m/s]; none for no limit.
    pub max_speed: Option<f64>,
    /// Largest driving acceleration [m/s^2]; none where it is not known.
    pub max_acceleration: Option<f64>,
    /// Largest braking deceleration [m/s^2]; none where it is not known.
    pub max_deceleration: Option<f64>,
    /// Time constant with which the drive answers the pedals [s].
    pub drive_lag: f64,
}

impl Vehicle {
    /// The paper's wheelbase and steering limit, the lag identified from its recorded run, and the
    /// lateral acceleration of a car.
    pub const DEFAULT: Self = Self {
        wheelbase: 3.0,
        rear_axle: 0.0,
        no_slip_point: None,
        turning_wheelbase: None,
        understeer: 0.0,
        steer_offset: 0.0,
        steer_lag: 0.1,
        dead_time: 0.0,
        max_steer: 1.22,
        max_steer_rate: None,
        max_lateral_acceleration: Some(4.0),
        max_speed: None,
        max_acceleration: None,
        max_deceleration: None,
        drive_lag: 0.0,
    };

    /// The paper's vehicle: its track asks for more lateral acceleration than a car's.
    pub const PAPER: Self = Self {
        max_lateral_acceleration: None,
        ..Self::DEFAULT
    };

    /// The vehicle itself where every number is within its range.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the field that is not.
    pub fn checked(self) -> Result<Self, ConfigError> {
        config_in_range("wheelbase", self.wheelbase, 1e-3, 1e3)?;
        config_in_range("rear_axle", self.rear_axle, -1e3, 1e3)?;
        optional("no_slip_point", self.no_slip_point, -1e3, 1e3)?;
        optional("turning_wheelbase", self.turning_wheelbase, 1e-3, 1e3)?;
        config_in_range("understeer", self.understeer, 0.0, 1e3)?;
        config_in_range("steer_offset", self.steer_offset, -0.5, 0.5)?;
        config_in_range("steer_lag", self.steer_lag, 0.0, 10.0)?;
        config_in_range("dead_time", self.dead_time, 0.0, 10.0)?;
        config_in_range("max_steer", self.max_steer, 1e-3, 1.57)?;
        optional("max_steer_rate", self.max_steer_rate, 1e-3, 1e6)?;
        optional(
            "max_lateral_acceleration",
            self.max_lateral_acceleration,
            1e-3,
            1e6,
        )?;
        optional("max_speed", self.max_speed, 1e-3, 1e4)?;
        optional("max_acceleration", self.max_acceleration, 1e-3, 1e3)?;
        optional("max_deceleration", self.max_deceleration, 1e-3, 1e3)?;
        config_in_range("drive_lag", self.drive_lag, 0.0, 10.0)?;
        Ok(self)
    }

    /// How far ahead of the pose's point the front axle lies [m].
    #[inline]
    pub fn front_axle(&self) -> f64 {
        self.rear_axle + self.wheelbase
    }

    /// How far ahead of the pose's point the no-slip point lies [m].
    #[inline]
    pub fn no_slip(&self) -> f64 {
        self.no_slip_point.unwrap_or(self.rear_axle)
    }

    /// The length that turns an angle of the wheels into a curvature at `speed` [m/s]:
    /// `curvature = tan(wheel) / turning_length` [m].
    #[inline]
    pub fn turning_length(&self, speed: f64) -> f64 {
        self.turning_wheelbase.unwrap_or(self.wheelbase) + self.understeer * speed * speed
    }

    /// An angle that the wheels can have [rad].
    #[inline]
    pub fn at_wheels(&self, angle: f64) -> f64 {
        saturate(angle, -self.max_steer, self.max_steer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn test_vehicle_bad_field_is_named() {
        assert_eq!(Vehicle::DEFAULT.checked(), Ok(Vehicle::DEFAULT));
        let spoil: [fn(&mut Vehicle, f64); 15] = [
            |car, bad| car.wheelbase = bad,
            |car, bad| car.rear_axle = bad,
            |car, bad| car.no_slip_point = Some(bad),
            |car, bad| car.turning_wheelbase = Some(bad),
            |car, bad| car.understeer = bad,
            |car, bad| car.steer_offset = bad,
            |car, bad| car.steer_lag = bad,
            |car, bad| car.dead_time = bad,
            |car, bad| car.max_steer = bad,
            |car, bad| car.max_steer_rate = Some(bad),
            |car, bad| car.max_lateral_acceleration = Some(bad),
            |car, bad| car.max_speed = Some(bad),
            |car, bad| car.max_acceleration = Some(bad),
            |car, bad| car.max_deceleration = Some(bad),
            |car, bad| car.drive_lag = bad,
        ];
        let names = [
            "wheelbase",
            "rear_axle",
            "no_slip_point",
            "turning_wheelbase",
            "understeer",
            "steer_offset",
            "steer_lag",
            "dead_time",
            "max_steer",
            "max_steer_rate",
            "max_lateral_acceleration",
            "max_speed",
            "max_acceleration",
            "max_deceleration",
            "drive_lag",
        ];
        for (spoil, name) in spoil.iter().zip(names) {
            for bad in [f64::NAN, f64::INFINITY, -1e7] {
                let mut car = Vehicle::DEFAULT;
                spoil(&mut car, bad);
                assert_eq!(car.checked().unwrap_err().field, name);
            }
        }
    }

    #[test]
    fn test_vehicle_points_are_told_from_the_pose() {
        let car = Vehicle {
            rear_axle: -1.25,
            ..Vehicle::DEFAULT
        };
        assert_eq!((car.front_axle(), car.no_slip()), (1.75, -1.25));
        let slipping = Vehicle {
            no_slip_point: Some(0.0),
            turning_wheelbase: Some(3.5),
            understeer: 0.01,
            ..car
        };
        assert_eq!(
            (slipping.no_slip(), slipping.turning_length(10.0)),
            (0.0, 4.5)
        );
    }
}
