//! The bounds of what a step takes: within them nothing overflows.

/// The largest coordinate [m], of waypoints and vehicles alike.
pub const MAX_COORDINATE: f64 = 1e9;
/// The largest reference speed, and the largest speed of a vehicle [m/s].
pub const MAX_SPEED: f64 = 1e4;
/// The largest yaw [rad] that a step takes; it need not be wrapped.
pub const MAX_YAW: f64 = 1e6;
/// The shortest control period [s].
pub const MIN_DT: f64 = 1e-6;
/// The longest control period [s].
pub const MAX_DT: f64 = 1e3;

/// Bound of the slope of a path, rise over run: 45 degrees.
pub const MAX_GRADE: f64 = 1.0;
