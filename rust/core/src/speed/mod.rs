//! How fast: speeds planned along a path, and the controllers of throttle and brake.
//!
//! [`curvature`] takes the curvature from waypoints that are noisy, and [`profile`] finds the
//! greatest speeds that a vehicle's limits allow along it; both run once for a path. [`tracker`] with
//! its estimate of the [`disturbance`], [`pid`] and [`coupled`] run at each step.

pub mod bias;
pub mod coupled;
#[cfg(feature = "alloc")]
pub mod curvature;
pub mod defaults;
pub mod disturbance;
#[cfg(feature = "alloc")]
mod jerk;
pub mod law;
#[cfg(feature = "alloc")]
pub mod limits;
pub mod pedals;
pub mod pid;
#[cfg(feature = "alloc")]
pub mod profile;
pub mod servo;
mod stops;
#[cfg(test)]
mod tests;
pub mod tracker;

pub use coupled::{CoupledLongitudinal, CoupledLongitudinalParams};
#[cfg(feature = "alloc")]
pub use curvature::path_curvature;
pub use law::{Phase, Sensed, SpeedCommand, SpeedLaw, SpeedState, SpeedTrackerParams};
#[cfg(feature = "alloc")]
pub use limits::{OverSpeed, SpeedLimits};
pub use pedals::Pedals;
pub use pid::{SpeedPid, SpeedPidParams, SpeedPidState};
#[cfg(feature = "alloc")]
pub use profile::{Course, Limit, plan_speeds};
pub use servo::Servo;
pub use tracker::{SpeedTracker, SpeedTrackerState, Told};
