//! Angles, limits, and where the vehicle will be.

use crate::bytes::Bytes;
use popsteer_core::VehicleState;
use popsteer_core::bounds::MAX_YAW;
use popsteer_core::error::{config_in_range, input_in_range};
use popsteer_core::math::{ceil_to_count, from_count, saturate, to_count, wrap};
use popsteer_core::vehicle::bicycle::{
    MAX_STEPS, get_predicted_location, kinematic_bicycle, steps,
};
use popsteer_core::vehicle::state::checked_dt;
use std::f64::consts::PI;

/// A few numbers and one vehicle through every function.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    for _ in 0..4 {
        check_numbers(&mut bytes);
        check_vehicle(&mut bytes);
        if bytes.is_empty() {
            break;
        }
    }
}

fn check_numbers(bytes: &mut Bytes) {
    let value = bytes.number([-10.0, 10.0], [-MAX_YAW, MAX_YAW]);
    let turned = wrap(value);
    if value.is_finite() {
        assert!(turned.abs() <= PI);
        assert_eq!(wrap(-value).to_bits(), (-turned).to_bits());
        assert_eq!(wrap(turned).to_bits(), turned.to_bits());
        if value.abs() <= MAX_YAW {
            assert!((turned.sin() - value.sin()).abs() <= 1e-9);
        }
    } else {
        assert!(turned.is_nan());
    }
    let count = to_count(value);
    assert!(ceil_to_count(value) - count <= 1);
    if (0.0..1e15).contains(&value) {
        assert!(from_count(count) <= value && value <= from_count(ceil_to_count(value)));
    }
    let (low, high) = (
        bytes.number([-2.0, 0.0], [-1e9, 0.0]),
        bytes.within(0.0, 2.0),
    );
    for checked in [
        config_in_range("value", value, low, high).ok(),
        input_in_range("value", value, low, high).ok(),
    ] {
        assert_eq!(checked.is_some(), low <= value && value <= high);
    }
    if low <= high && !value.is_nan() {
        let limited = saturate(value, low, high);
        assert!(low <= limited && limited <= high);
    }
}

fn check_vehicle(bytes: &mut Bytes) {
    let vehicle = VehicleState {
        x: bytes.number([-100.0, 100.0], [-1e9, 1e9]),
        y: bytes.number([-100.0, 100.0], [-1e9, 1e9]),
        yaw: bytes.number([-4.0, 4.0], [-MAX_YAW, MAX_YAW]),
        speed: bytes.number([-5.0, 40.0], [-1e4, 1e4]),
    };
    let steer = bytes.number([-1.0, 1.0], [-1.57, 1.57]);
    let acceleration = bytes.number([-9.0, 9.0], [-1e3, 1e3]);
    let wheelbase = bytes.number([1.0, 4.0], [1e-3, 1e3]);
    let dt = bytes.number([0.001, 0.5], [1e-6, 1e3]);
    let horizon = bytes.number([0.1, 3.0], [0.05, 100.0]);
    let location = get_predicted_location(vehicle, steer, dt);
    let moved = kinematic_bicycle(vehicle, steer, acceleration, wheelbase, dt);
    let ahead = vehicle.point_ahead(wheelbase);
    let good = vehicle.checked().is_ok()
        && checked_dt(dt).is_ok()
        && steer.abs() <= 1.57
        && acceleration.abs() <= 1e3
        && (1e-3..=1e3).contains(&wheelbase);
    if !good {
        return;
    }
    if (0.05..=100.0).contains(&horizon) {
        let (count, period) = steps(horizon, dt);
        assert!((1..=MAX_STEPS).contains(&count) && period >= dt);
        assert!(period * from_count(count) >= horizon * (1.0 - 1e-6));
    }
    assert!(vehicle.forward_speed() >= 0.0);
    let numbers = [moved.x, moved.y, moved.yaw, moved.speed, ahead.x, ahead.y];
    assert!(numbers.iter().all(|number| number.is_finite()));
    let speed = vehicle.speed;
    let bounded = VehicleState { speed, ..moved }.bounded();
    assert_eq!(bounded.checked(), Ok(bounded));
    // Equation 6, by hand.
    let (sin, cos) = (vehicle.yaw + steer).sin_cos();
    let (x, y) = (vehicle.x + cos * speed * dt, vehicle.y + sin * speed * dt);
    let slack = 1e-12 * (1.0 + vehicle.x.abs() + vehicle.y.abs() + (vehicle.speed * dt).abs());
    assert!((x - location.x).abs() <= slack && (y - location.y).abs() <= slack);
}
