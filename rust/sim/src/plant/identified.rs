//! The vehicle identified from the authors' CARLA run.

use super::{Control, PedalMap, Plant, PlantState, at_its_wheels};
use popsteer_core::Vehicle;
use popsteer_core::math::{cos, sin, tan};

popsteer_core::params! {
    /// Single-track steady-state yaw response with a lag, and a longitudinal model with throttle
    /// lag, drag and loss in bends, fitted to the run that the paper's authors recorded in CARLA.
    ///
    /// ```text
    /// yaw_rate' = (speed tan(steer) / (turning_wheelbase + understeer speed^2) - yaw_rate) / steer_lag
    /// u'        = (throttle - u) / throttle_lag
    /// speed'    = drive u - drag speed - air_drag speed^2 - bend_loss |yaw_rate| speed - braking brake
    /// x', y'    = speed (cos yaw, sin yaw)   of the no-slip point
    /// ```
    ///
    /// The lag acts on the yaw rate, where the chain of [`Vehicle`] has it at the wheels: to first
    /// order that is the same. A limit of the wheels' rate acts before it.
    ///
    /// The log holds no braking; `braking` is an assumption. The speed never falls below 0.
    pub struct CarlaIdentified {
        /// Time constant of the throttle [s].
        throttle_lag: f64 = 0.25, in [1e-3, 1e3];
        /// Acceleration at full throttle [m/s^2].
        drive: f64 = 6.0, in [0.0, 1e3];
        /// Drag linear in speed [1/s].
        drag: f64 = 0.28, in [0.0, 1e3];
        /// Drag quadratic in speed [1/m].
        air_drag: f64 = 0.001, in [0.0, 1e3];
        /// Loss in bends.
        bend_loss: f64 = 0.11, in [0.0, 1e3];
        /// Deceleration at full brake [m/s^2].
        braking: f64 = 9.0, in [0.0, 1e3];
    }
    with vehicle: Vehicle = Self::VEHICLE;
}

impl CarlaIdentified {
    /// Its name on the command line.
    pub const NAME: &str = "carla-identified";

    /// The vehicle found in the authors' run: its axles are 3 m apart, about the no-slip point, and
    /// it turns as with 3.553 m.
    pub const VEHICLE: Vehicle = Vehicle {
        wheelbase: 3.0,
        turning_wheelbase: Some(3.553),
        rear_axle: -1.94,
        no_slip_point: Some(0.0),
        understeer: 2.9e-4,
        steer_lag: 0.1,
        drive_lag: 0.25, // the default throttle_lag
        ..Vehicle::PAPER
    };
}

impl Plant for CarlaIdentified {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn vehicle(&self) -> &Vehicle {
        &self.vehicle
    }

    fn pedals(&self) -> Option<PedalMap> {
        Some(PedalMap {
            drive: self.drive,
            braking: self.braking,
            drag: self.drag,
            air_drag: self.air_drag,
        })
    }

    fn advance(&self, state: &mut PlantState, control: Control, dt: f64, substeps: usize) {
        let car = Vehicle {
            steer_lag: 0.0,
            ..at_its_wheels(&self.vehicle)
        };
        let lag = self.vehicle.steer_lag;
        let share = if dt < lag { dt / lag } else { 1.0 };
        let mut vehicle = state.vehicle.ahead(car.no_slip());
        for _ in 0..substeps {
            let PlantState {
                yaw_rate, throttle, ..
            } = *state;
            let moved = car.move_wheel(state.wheel, control.steer, dt);
            state.wheel = moved.wheel;
            let speed = vehicle.speed;
            let steady =
                speed * tan(state.push(moved.mean, car.steer_play)) / car.turning_length(speed);
            let acceleration = self.drive * throttle
                - self.drag * speed
                - self.air_drag * speed * speed
                - self.bend_loss * yaw_rate.abs() * speed
                - self.braking * control.brake;
            vehicle.x += dt * speed * cos(vehicle.yaw);
            vehicle.y += dt * speed * sin(vehicle.yaw);
            vehicle.yaw += dt * yaw_rate;
            vehicle.speed = (speed + dt * acceleration).max(0.0);
            state.yaw_rate += share * (steady - yaw_rate);
            // As with the steering lag: a step that is longer than the lag ends at the pedal.
            let missing = control.throttle - throttle;
            state.throttle += if dt < self.throttle_lag {
                dt * missing / self.throttle_lag
            } else {
                missing
            };
        }
        state.vehicle = vehicle.ahead(-car.no_slip());
    }
}
