//! Plants, the closed loop and its metrics.
//!
//! A run repeats the control step of `popsteer_core` against a [`plant`]: [`Simulation`] moves the
//! vehicle and measures it, [`closed_loop`] lets a driver steer it.
//!
//! # Examples
//!
//! ```
//! use std::sync::Arc;
//! use popsteer_core::{Path, Tracker, VehicleState, laws::Pop};
//! use popsteer_sim::{Controller, Longitudinal, Perception, Settings, Simulation, closed_loop};
//! use popsteer_sim::plant::CarlaIdentified;
//!
//! let x: Vec<f64> = (0..200).map(f64::from).collect();
//! let path = Arc::new(Path::new(&x, &vec![0.0; 200], None, false)?);
//! let plant = CarlaIdentified::default();
//! let pop = Tracker::of(Pop::new(plant.vehicle, Default::default())?);
//! let start = VehicleState { x: 0.0, y: 1.0, yaw: 0.0, speed: 0.0 };
//! let mut simulation =
//!     Simulation::new(path, Arc::new(plant), start, *pop.follow(), Settings::default())?;
//! let mut controller = Controller::new(&pop);
//! let longitudinal = Longitudinal::default();
//! closed_loop::run(&mut simulation, &mut controller, &longitudinal, Perception::EXACT, |_| true)?;
//! assert!(simulation.metrics().finished);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(feature = "std")]
pub mod batch;
pub mod closed_loop;
pub mod delay;
#[cfg(feature = "std")]
pub mod episodes;
#[cfg(feature = "std")]
pub mod logged;
pub mod longitudinal;
#[cfg(feature = "std")]
pub mod many;
pub mod metrics;
pub mod noise;
pub mod plant;
pub mod record;
pub mod simulation;
#[cfg(test)]
mod tests;

#[cfg(feature = "std")]
pub use batch::{Batch, BatchError};
pub use closed_loop::{Controller, Driver, Driving};
#[cfg(feature = "std")]
pub use episodes::{Episodes, Weights};
#[cfg(feature = "std")]
pub use logged::LoggedWheels;
pub use longitudinal::Longitudinal;
pub use metrics::{ErrorStats, Metrics};
pub use noise::{Noise, Perception};
pub use plant::{Control, Plant, PlantState, behind_play};
pub use popsteer_core::laws::{Law, LawState};
pub use record::Record;
pub use simulation::{Settings, Simulation};
