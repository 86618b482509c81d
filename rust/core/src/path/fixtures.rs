//! What several tests here drive on.

use super::follow::Follow;
use crate::Path;
use crate::vehicle::VehicleState;

/// How the front axle of a wheelbase of 3 m is followed.
pub(super) const FOLLOW: Follow = Follow {
    base: 0.0,
    reference_offset: 3.0,
    rear_axle: 0.0,
    search_distance: 6.0,
    lost_distance: 30.0,
    arrival_distance: 0.15,
    opposite_distance: 10.0,
};

/// 20 m forward along x, 10 m back, 20 m forward again, standing at each cusp and at the end.
pub(super) fn shuttle() -> Path {
    let x: [f64; 6] = [0.0, 10.0, 20.0, 10.0, 20.0, 30.0];
    let speed = [2.0, 2.0, 0.0, 0.0, 2.0, 0.0];
    let path = Path::new(&x, &[0.0; 6], Some(&speed), false).unwrap();
    path.with_reverse(&[false, false, true, false, false, false])
        .unwrap()
}

/// A vehicle that looks along x.
pub(super) fn at(x: f64, y: f64, speed: f64) -> VehicleState {
    VehicleState {
        x,
        y,
        yaw: 0.0,
        speed,
    }
}
