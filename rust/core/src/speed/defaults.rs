//! The limits of the speed that a plan takes where neither it nor the vehicle has one: brisk for an
//! ordinary car, and far from the grip of a dry road.

use crate::math::sqrt;
use crate::vehicle::Vehicle;

/// Top speed [m/s].
pub const MAX_SPEED: f64 = 25.0;
/// Largest lateral acceleration [m/s²].
pub const MAX_LATERAL_ACCELERATION: f64 = 4.0;
/// Largest driving acceleration [m/s²].
pub const MAX_ACCELERATION: f64 = 2.0;
/// Largest braking deceleration [m/s²].
pub const MAX_DECELERATION: f64 = Vehicle::COMFORT_BRAKING;
/// What the brakes can do [m/s²]: those of an ordinary car on a dry road do more.
pub const BRAKE_DECELERATION: f64 = Vehicle::BRAKES;
/// Braking deceleration of a stop that no plan contains: of the simulated pedals at a cusp, and of a
/// vehicle whose inputs are missing [m/s²].
pub const STOP_DECELERATION: f64 = 2.0;
/// Share of the vehicle's lateral acceleration that plans use in bends; controllers steer up to all
/// of it. With a larger share, a vehicle that runs wide returns to the path only after the bend.
pub const BEND_SHARE: f64 = 0.9;
/// Length over which the curvature is smoothed, in wheelbases: 2 m for a car of 3 m.
pub const SMOOTHING: f64 = 2.0 / 3.0;
/// The same for jumps of the curvature, where a vehicle parks.
pub const SHARP: f64 = 1.0 / 6.0;

/// Share of a limit of the acceleration that any slope leaves: a path that is too steep is driven slowly.
pub const LEAST_ON_SLOPES: f64 = 0.1;
/// Standard gravity [m/s²].
pub const GRAVITY: f64 = 9.806_65;

/// The acceleration along a path by gravity [m/s²], negative uphill: `-g sin(atan(grade))`.
#[inline]
#[must_use]
pub fn gravity_along(grade: f64) -> f64 {
    -GRAVITY * grade / sqrt(1.0 + grade * grade)
}
