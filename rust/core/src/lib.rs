//! Path-tracking steering controllers for car-like vehicles.
//!
//! The crate has the POP controller (proximally optimal predictive), preview POP, and the controllers
//! that they are compared with: PID, Pure-Pursuit and Stanley. It has three longitudinal
//! controllers, and plans speeds along a path. "The paper" in these pages is C. Samak, T. Samak, S.
//! Kandhasamy, *Proximally Optimal Predictive Control Algorithm for Path Tracking of Self-Driving
//! Cars*.
//!
//! One control step passes through the modules once, always in this order:
//!
//! ```text
//! pose + speed -> estimate, predict -> locate -> look ahead -> controller -> limits -> command
//! speed + angle -> longitudinal controller -> throttle, brake
//! ```
//!
//! Every controller has the same shape: immutable parameters, validated once; a small plain state;
//! and [`Tracker::step`], which reads both. SI units and radians throughout, x forward,
//! y left, yaw counter-clockwise, positive steering to the left.
//!
//! # Examples
//!
//! ```
//! use popsteer_core::laws::{Pop, PopParams};
//! use popsteer_core::{Path, Reported, Tracker, Vehicle, VehicleState};
//!
//! let path = Path::new(&[0.0, 10.0, 20.0], &[0.0, 0.0, 0.0], None, false)?;
//! let car = Vehicle { wheelbase: 2.7, rear_axle: -1.35, ..Vehicle::DEFAULT };
//! let controller = Tracker::of(Pop::new(car, PopParams::DEFAULT)?);
//! let mut state = controller.initial_state();
//! let vehicle = VehicleState { x: 0.0, y: 0.5, yaw: 0.0, speed: 5.0 };
//! let command = controller.step(&path.view(), &mut state, vehicle, 0.05, Reported::NOTHING)?;
//! assert!(command.steer < 0.0); // left of the path: steer right
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]
#![deny(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::as_conversions,
    clippy::float_cmp,
    clippy::std_instead_of_core,
    clippy::std_instead_of_alloc,
    clippy::alloc_instead_of_core,
    clippy::missing_errors_doc,
    clippy::too_many_lines
)]
#![cfg_attr(
    test,
    expect(
        clippy::unwrap_used,
        clippy::float_cmp,
        reason = "a test fails by panicking, and compares bits"
    )
)]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(any(feature = "std", test))]
extern crate std;

#[cfg(not(any(feature = "std", feature = "libm")))]
compile_error!("popsteer-core needs the feature `std` or the feature `libm` for its mathematics");

pub mod bounds;
pub mod driver;
pub mod error;
pub mod geometry;
pub mod laws;
pub mod math;
pub mod params;
pub mod path;
#[cfg(feature = "serde")]
mod row;
pub mod speed;
pub mod status;
#[cfg(test)]
mod tests;
pub mod tracker;
pub mod vehicle;

pub use driver::{Drive, Driver, DriverParams};
pub use error::{ConfigError, InputError, PathError};
pub use geometry::Point;
pub use laws::{LateralLaw, LateralState};
#[cfg(feature = "alloc")]
pub use path::Path;
pub use path::PathView;
pub use status::Status;
pub use tracker::{Command, Reported, Tracker};
pub use vehicle::{Vehicle, VehicleState};
