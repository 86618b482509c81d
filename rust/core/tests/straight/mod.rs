//! Places beside a straight path, and what an answer is held against.

use popsteer_core::{Path, Vehicle, VehicleState};

/// A vehicle whose wheels do at once what they are commanded; 3 m long.
pub(crate) const CAR: Vehicle = Vehicle {
    steer_lag: 0.0,
    ..Vehicle::PAPER
};
const PATH_YAW: f64 = 0.3;

pub(crate) fn straight() -> Path {
    let along: Vec<f64> = (0..100).map(f64::from).collect();
    let x: Vec<f64> = along.iter().map(|s| 2.0 + s * PATH_YAW.cos()).collect();
    let y: Vec<f64> = along.iter().map(|s| -1.0 + s * PATH_YAW.sin()).collect();
    Path::new(&x, &y, None, false).unwrap()
}

/// `along` the straight path and `left` of it [m], `heading` off it [rad].
pub(crate) fn beside(along: f64, left: f64, heading: f64, speed: f64) -> VehicleState {
    let (sin, cos) = PATH_YAW.sin_cos();
    VehicleState {
        x: 2.0 + along * cos - left * sin,
        y: -1.0 + along * sin + left * cos,
        yaw: PATH_YAW + heading,
        speed,
    }
}

#[track_caller]
pub(crate) fn assert_close(number: f64, expected: f64) {
    let most = 1e-9 * expected.abs().max(1.0);
    assert!(
        (number - expected).abs() <= most,
        "{number}, not {expected}"
    );
}
