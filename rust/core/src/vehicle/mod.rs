//! The vehicle: pose and speed, where it will be, and how commands come to its wheels.

pub mod actuator;
pub mod learning;
pub mod predict;
pub mod state;

pub use actuator::{Actuator, ActuatorParams, UnderWay};
pub use learning::Learnt;
pub use state::VehicleState;
