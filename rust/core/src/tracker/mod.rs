//! All of a control step around a controller, by [`Tracker`]: estimate, predict, locate, limit.

pub mod command;
pub mod hold;
pub mod intend;
pub mod limit;
pub mod monitor;
mod perceive;
pub mod replan;
pub mod reported;
mod see;
pub(crate) mod seen;
pub mod state;
pub mod step;

pub use command::Command;
pub use intend::Predicted;
pub use monitor::{MonitorParams, MonitorState};
pub use reported::Reported;
pub use state::{Answer, Deviation, Handover, Model, TrackerState, Tracking};
pub use step::Tracker;
