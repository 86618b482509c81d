//! The whole vehicle in one control step: [`Driver`] steers and drives.
//!
//! ```text
//! clock ─> belief ─> place ─> speed law ─> steering law ─> limits ─> Drive
//! ```
//!
//! Clock, belief and place are there once, and both laws are functions of them. A driver answers
//! every input: what does not come, or cannot be used, is replaced by what is expected, and what
//! stays wrong is a [`Fault`](crate::vehicle::Fault), for which it stops by what is still believed.

mod command;
mod safe_stop;
mod signals;
mod state;
mod step;

pub use command::Drive;
pub use signals::{Sensed, Signals};
pub use state::DriverState;
pub use step::{Driver, DriverParams};
