//! The kinematic bicycle that does what its vehicle says.

use super::{Control, PedalMap, Plant, PlantState, at_its_wheels};
use popsteer_core::Vehicle;
use popsteer_core::math::{decay, tan};
use popsteer_core::vehicle::bicycle::advance;

popsteer_core::params! {
    /// The kinematic bicycle of a vehicle, with an engine, brakes and linear drag; a passenger car
    /// by default.
    ///
    /// Wheels, turning and the no-slip point are those of [`Vehicle`]; its `drive_lag` and
    /// `max_speed` count as well.
    pub struct KinematicBicycle {
        /// Acceleration at full throttle [m/s^2].
        drive: f64 = 6.0, in [0.0, 1e3];
        /// Drag linear in speed [1/s].
        drag: f64 = 0.28, in [0.0, 1e3];
        /// Deceleration at full brake [m/s^2].
        braking: f64 = 9.0, in [0.0, 1e3];
    }
    with vehicle: Vehicle = Self::VEHICLE;
}

impl KinematicBicycle {
    /// Its name on the command line.
    pub const NAME: &str = "kinematic-bicycle";

    /// The vehicle that it is by default: of the paper's wheelbase, its wheels turn at once.
    pub const VEHICLE: Vehicle = Vehicle {
        steer_lag: 0.0,
        ..Vehicle::PAPER
    };
}

impl Plant for KinematicBicycle {
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
            air_drag: 0.0,
        })
    }

    fn reverses(&self) -> bool {
        true
    }

    fn advance(&self, state: &mut PlantState, control: Control, dt: f64, substeps: usize) {
        let car = at_its_wheels(&self.vehicle);
        let gear = if control.reverse { -1.0 } else { 1.0 };
        let kept = decay(dt, car.drive_lag);
        let mut vehicle = state.vehicle.ahead(car.no_slip());
        for _ in 0..substeps {
            let moved = car.move_wheel(state.wheel, control.steer, dt);
            state.wheel = moved.wheel;
            state.throttle = control.throttle + (state.throttle - control.throttle) * kept;
            let curvature =
                tan(state.push(moved.mean, car.steer_play)) / car.turning_length(vehicle.speed);
            state.yaw_rate = vehicle.speed * curvature;
            // Along the gear: a vehicle that still rolls the other way is below 0.
            // That of one at rest is 0.0, not -0.0, whose sign the brakes would take for a motion.
            let speed = gear * vehicle.speed + 0.0;
            let braking = (self.braking * control.brake).copysign(speed);
            let acceleration = self.drive * state.throttle - braking - self.drag * speed;
            vehicle = advance(vehicle, vehicle.speed * dt, curvature, 0.0);
            let next = speed + acceleration * dt;
            // Neither brakes nor drag drive: at rest they end.
            let stays = if speed < 0.0 {
                next.min(0.0)
            } else {
                next.max(0.0)
            };
            let top = car.max_speed.unwrap_or(f64::INFINITY).max(speed);
            vehicle.speed = gear * stays.min(top);
        }
        state.vehicle = vehicle.ahead(-car.no_slip());
    }
}
