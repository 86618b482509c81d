//! How fast may a path be driven?
//!
//! [`curvature`] takes the curvature from waypoints that are noisy, and [`speed_profile`] finds the
//! greatest speeds that a vehicle's limits allow along it. Both run once for a path, not in a step.

pub mod curvature;
pub mod limits;
pub mod speed_profile;

pub use curvature::path_curvature;
pub use limits::{Limits, OverSpeed};
pub use speed_profile::{Course, Limit, plan_speeds};
