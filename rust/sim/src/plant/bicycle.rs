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
            let curvature = tan(moved.mean) / car.turning_length(vehicle.speed);
            state.yaw_rate = vehicle.speed * curvature;
            // Along the gear: a vehicle that still rolls the other way is below 0.
            let speed = gear * vehicle.speed;
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
        let mut state = PlantState::settled(&plant.vehicle, vehicle);
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

    /// A bicycle of `vehicle` after `time` [s] from 8 m/s, with its wheels commanded to 0.3 rad.
    fn driven(vehicle: Vehicle, time: f64) -> PlantState {
        let start = VehicleState {
            x: 0.0,
            y: 0.0,
            yaw: 0.0,
            speed: 8.0,
        };
        let plant = KinematicBicycle {
            vehicle,
            drag: 0.0,
            ..KinematicBicycle::DEFAULT
        };
        let mut state = PlantState::settled(&vehicle, start);
        let control = Control {
            steer: 0.3,
            throttle: 0.5,
            ..Control::default()
        };
        let substeps = popsteer_core::math::to_count(time / 0.001 + 0.5);
        plant.advance(&mut state, control, 0.001, substeps);
        state
    }

    #[test]
    fn test_bicycle_steers_as_its_vehicle_says() {
        let car = KinematicBicycle::VEHICLE;
        let lagging = driven(
            Vehicle {
                steer_lag: 0.2,
                ..car
            },
            0.2,
        );
        assert!((lagging.wheel - 0.3 * (1.0 - (-1.0_f64).exp())).abs() < 1e-9);
        let slow = Vehicle {
            max_steer_rate: Some(0.4),
            ..car
        };
        assert!((driven(slow, 0.5).wheel - 0.2).abs() < 1e-9);
        let narrow = Vehicle {
            max_steer: 0.1,
            ..car
        };
        assert!((driven(narrow, 0.5).wheel - 0.1).abs() <= 0.0);
        let heavy = Vehicle {
            understeer: 0.05,
            ..car
        };
        let curvature = |state: PlantState| state.yaw_rate / state.vehicle.speed;
        let speed = driven(heavy, 1.0).vehicle.speed;
        let expected = 0.3_f64.tan() / (3.0 + 0.05 * speed * speed);
        assert!((curvature(driven(heavy, 1.0)) - expected).abs() < 1e-4);
        let longer = Vehicle {
            turning_wheelbase: Some(4.0),
            ..car
        };
        assert!((curvature(driven(longer, 1.0)) - 0.3_f64.tan() / 4.0).abs() < 1e-4);
    }

    #[test]
    fn test_bicycle_moves_as_its_vehicle_says() {
        let car = KinematicBicycle::VEHICLE;
        let governed = Vehicle {
            max_speed: Some(9.0),
            ..car
        };
        assert!((driven(governed, 1.0).vehicle.speed - 9.0).abs() <= 0.0);
        let late = driven(
            Vehicle {
                drive_lag: 0.5,
                ..car
            },
            0.5,
        );
        assert!((late.throttle - 0.5 * (1.0 - (-1.0_f64).exp())).abs() < 1e-9);
        // The point that does not slip moves where the vehicle looks, here 1 m behind the pose's.
        let behind = driven(
            Vehicle {
                rear_axle: -1.0,
                ..car
            },
            1.0,
        );
        let rear = driven(car, 1.0).vehicle;
        let point = rear.ahead(1.0);
        assert!((behind.vehicle.yaw - rear.yaw).abs() < 1e-12);
        // The runs start 1 m apart along x.
        assert!((behind.vehicle.x + 1.0 - point.x).abs() < 1e-9);
        assert!((behind.vehicle.y - point.y).abs() < 1e-9);
    }
}
