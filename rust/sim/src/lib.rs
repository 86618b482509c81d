//! Plants, the closed loop and its metrics.
//!
//! A run is one walk after another through `popsteer_core`, against a [`plant`]:
//! [`Simulation`] holds the vehicle and measures it, [`closed_loop`] lets a law drive it.
//!
//! # Examples
//!
//! ```
//! use std::sync::Arc;
//! use popsteer_core::{Path, VehicleState};
//! use popsteer_sim::{Drive, Law, Settings, Simulation, closed_loop, plant::CarlaIdentified};
//!
//! let x: Vec<f64> = (0..200).map(f64::from).collect();
//! let path = Arc::new(Path::new(&x, &vec![0.0; 200], None, false)?);
//! let law = Law::Pop(popsteer_core::lateral::Pop::new(Default::default())?);
//! let start = VehicleState { x: 0.0, y: 1.0, yaw: 0.0, speed: 0.0 };
//! let mut simulation =
//!     Simulation::new(path, Arc::new(CarlaIdentified::default()), start, 0.0, Settings::default())?;
//! closed_loop::run(&mut simulation, &law, &Drive::default(), |_| true)?;
//! assert!(simulation.metrics().finished);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod batch;
pub mod closed_loop;
pub mod drive;
pub mod law;
pub mod many;
pub mod metrics;
pub mod plant;
pub mod simulation;

pub use batch::{Batch, BatchError};
pub use drive::Drive;
pub use law::{Law, LawState};
pub use metrics::{ErrorStats, Metrics};
pub use plant::{Control, Geometry, Plant, PlantState};
pub use simulation::{Record, Settings, Simulation};
