//! The limits of the speed that a plan takes where neither it nor the vehicle has one: brisk for an
//! ordinary car, and far from the grip of a dry road.

/// Top speed [m/s].
pub const MAX_SPEED: f64 = 25.0;
/// Largest lateral acceleration [m/s²].
pub const MAX_LATERAL_ACCELERATION: f64 = 4.0;
/// Largest driving acceleration [m/s²].
pub const MAX_ACCELERATION: f64 = 2.0;
/// Largest braking deceleration [m/s²].
pub const MAX_DECELERATION: f64 = 3.0;
/// Braking deceleration of a stop that no plan contains: of the simulated pedals at a cusp, and of a
/// vehicle whose inputs are missing [m/s²].
pub const STOP_DECELERATION: f64 = 2.0;
/// Share of the vehicle's lateral acceleration that plans use in bends; controllers steer up to all
/// of it. With a larger share, a vehicle that runs wide returns to the path only after the bend.
pub const BEND_SHARE: f64 = 0.9;
/// Length over which the curvature is smoothed, in wheelbases: 2 m for a car of 3 m.
pub const SMOOTHING: f64 = 2.0 / 3.0;
