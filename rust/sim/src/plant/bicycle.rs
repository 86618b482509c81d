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

    fn reverses(&self) -> bool {
        true
    }

    fn advance(&self, state: &mut PlantState, control: Control, dt: f64, substeps: usize) {
        let gear = if control.reverse { -1.0 } else { 1.0 };
        for _ in 0..substeps {
            // Along the gear: a vehicle that still rolls the other way is below 0.
            let speed = gear * state.vehicle.speed;
            let braking = (self.braking * control.brake).copysign(speed);
            let acceleration = self.drive * control.throttle - braking - self.drag * speed;
            state.yaw_rate = state.vehicle.speed * control.steer.tan() / self.wheelbase;
            state.throttle = control.throttle;
            state.vehicle = kinematic_bicycle(
                state.vehicle,
                control.steer,
                gear * acceleration,
                self.wheelbase,
                dt,
            );
            // Neither brakes nor drag drive: at rest they end.
            let next = gear * state.vehicle.speed;
            let stays = if speed < 0.0 {
                next.min(0.0)
            } else {
                next.max(0.0)
            };
            state.vehicle.speed = gear * stays;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use popsteer_core::VehicleState;

    #[test]
    fn test_bicycle_brakes_to_rest_then_backs_up_with_the_wheels_mirrored() {
        let plant = KinematicBicycle::DEFAULT;
        let vehicle = VehicleState {
            x: 0.0,
            y: 0.0,
            yaw: 0.0,
            speed: 1.0,
        };
        let mut state = PlantState {
            vehicle,
            yaw_rate: 0.0,
            throttle: 0.0,
        };
        let control = Control {
            steer: 0.2,
            throttle: 0.0,
            brake: 1.0,
            reverse: true,
        };
        plant.advance(&mut state, control, 0.005, 100);
        assert!(state.vehicle.speed.abs() <= 0.0);
        let before = state.vehicle;
        let backwards = Control {
            throttle: 0.2,
            brake: 0.0,
            ..control
        };
        plant.advance(&mut state, backwards, 0.005, 200);
        assert!(state.vehicle.speed < -0.9);
        assert!(state.vehicle.x < before.x && state.vehicle.yaw < before.yaw);
    }
}
