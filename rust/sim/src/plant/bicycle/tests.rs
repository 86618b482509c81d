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
