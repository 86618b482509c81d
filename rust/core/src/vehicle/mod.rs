//! The vehicle: pose and speed, and where it will be.

pub mod predict;
pub mod state;

pub use state::VehicleState;
