//! The vehicle identified from the authors' CARLA run.

use super::{Control, Geometry, Plant, PlantState};
use popsteer_core::error::{ConfigError, config_in_range};

/// Single-track steady-state yaw response with a lag, and a longitudinal model with throttle
/// lag, drag and loss in bends, fitted to the run that the paper's authors recorded in CARLA.
///
/// ```text
/// yaw_rate' = (speed tan(steer) / (wheelbase + understeer speed^2) - yaw_rate) / yaw_lag
/// u'        = (throttle - u) / throttle_lag
/// speed'    = drive u - drag speed - air_drag speed^2 - bend_loss |yaw_rate| speed - braking brake
/// x', y'    = speed (cos yaw, sin yaw)
/// ```
///
/// The log holds no braking; `braking` is an assumption. The speed never falls below 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarlaIdentified {
    /// Effective wheelbase [m].
    pub wheelbase: f64,
    /// Understeer coefficient [s^2/m].
    pub understeer: f64,
    /// Time constant of the yaw rate [s].
    pub yaw_lag: f64,
    /// Time constant of the throttle [s].
    pub throttle_lag: f64,
    /// Acceleration at full throttle [m/s^2].
    pub drive: f64,
    /// Drag linear in speed [1/s].
    pub drag: f64,
    /// Drag quadratic in speed [1/m].
    pub air_drag: f64,
    /// Loss in bends.
    pub bend_loss: f64,
    /// Deceleration at full brake [m/s^2].
    pub braking: f64,
}

impl CarlaIdentified {
    /// Its name on the command line.
    pub const NAME: &str = "carla-identified";

    /// The values found in the authors' run.
    pub const DEFAULT: Self = Self {
        wheelbase: 3.553,
        understeer: 2.9e-4,
        yaw_lag: 0.100,
        throttle_lag: 0.25,
        drive: 6.0,
        drag: 0.28,
        air_drag: 0.001,
        bend_loss: 0.11,
        braking: 9.0,
    };

    /// The plant itself where every parameter is within its range.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is not.
    pub fn checked(self) -> Result<Self, ConfigError> {
        config_in_range("wheelbase", self.wheelbase, 1e-3, 1e3)?;
        config_in_range("understeer", self.understeer, 0.0, 1e3)?;
        config_in_range("yaw_lag", self.yaw_lag, 1e-3, 1e3)?;
        config_in_range("throttle_lag", self.throttle_lag, 1e-3, 1e3)?;
        config_in_range("drive", self.drive, 0.0, 1e3)?;
        config_in_range("drag", self.drag, 0.0, 1e3)?;
        config_in_range("air_drag", self.air_drag, 0.0, 1e3)?;
        config_in_range("bend_loss", self.bend_loss, 0.0, 1e3)?;
        config_in_range("braking", self.braking, 0.0, 1e3)?;
        Ok(self)
    }
}

impl Default for CarlaIdentified {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Plant for CarlaIdentified {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    /// The axles of the authors' code about the point that does not slip; 3 m apart.
    fn geometry(&self) -> Geometry {
        Geometry {
            front_offset: 1.06,
            rear_offset: -1.94,
            wheelbase: 3.0,
        }
    }

    fn advance(&self, state: &mut PlantState, control: Control, dt: f64, substeps: usize) {
        let tangent = control.steer.tan();
        for _ in 0..substeps {
            let PlantState {
                vehicle,
                yaw_rate,
                throttle,
            } = *state;
            let speed = vehicle.speed;
            let steady = speed * tangent / (self.wheelbase + self.understeer * speed * speed);
            let acceleration = self.drive * throttle
                - self.drag * speed
                - self.air_drag * speed * speed
                - self.bend_loss * yaw_rate.abs() * speed
                - self.braking * control.brake;
            state.vehicle.x += dt * speed * vehicle.yaw.cos();
            state.vehicle.y += dt * speed * vehicle.yaw.sin();
            state.vehicle.yaw += dt * yaw_rate;
            state.vehicle.speed = (speed + dt * acceleration).max(0.0);
            state.yaw_rate += dt * (steady - yaw_rate) / self.yaw_lag;
            state.throttle += dt * (control.throttle - throttle) / self.throttle_lag;
        }
    }
}
