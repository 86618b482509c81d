//! The plain kinematic bicycle.

use super::{Control, Geometry, Plant, PlantState};
use popsteer_core::error::{ConfigError, config_in_range};
use popsteer_core::vehicle::predict::kinematic_bicycle;

/// The kinematic bicycle about its rear axle, with an engine, brakes and linear drag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KinematicBicycle {
    /// Distance of the axles [m].
    pub wheelbase: f64,
    /// Acceleration at full throttle [m/s^2].
    pub drive: f64,
    /// Drag linear in speed [1/s].
    pub drag: f64,
    /// Deceleration at full brake [m/s^2].
    pub braking: f64,
}

impl KinematicBicycle {
    /// Its name on the command line.
    pub const NAME: &str = "kinematic-bicycle";

    /// A middling car.
    pub const DEFAULT: Self = Self {
        wheelbase: 3.0,
        drive: 6.0,
        drag: 0.28,
        braking: 9.0,
    };

    /// The plant itself where every parameter is within its range.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is not.
    pub fn checked(self) -> Result<Self, ConfigError> {
        config_in_range("wheelbase", self.wheelbase, 1e-3, 1e3)?;
        config_in_range("drive", self.drive, 0.0, 1e3)?;
        config_in_range("drag", self.drag, 0.0, 1e3)?;
        config_in_range("braking", self.braking, 0.0, 1e3)?;
        Ok(self)
    }
}

impl Default for KinematicBicycle {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Plant for KinematicBicycle {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn geometry(&self) -> Geometry {
        Geometry {
            front_offset: self.wheelbase,
            rear_offset: 0.0,
            wheelbase: self.wheelbase,
        }
    }

    fn advance(&self, state: &mut PlantState, control: Control, dt: f64, substeps: usize) {
        for _ in 0..substeps {
            let speed = state.vehicle.speed;
            let acceleration =
                self.drive * control.throttle - self.braking * control.brake - self.drag * speed;
            state.yaw_rate = speed * control.steer.tan() / self.wheelbase;
            state.throttle = control.throttle;
            state.vehicle = kinematic_bicycle(
                state.vehicle,
                control.steer,
                acceleration,
                self.wheelbase,
                dt,
            );
            state.vehicle.speed = state.vehicle.speed.max(0.0);
        }
    }
}
