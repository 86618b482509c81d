//! The reference path: where am I, and where do I aim?
//!
//! [`view`] holds the waypoints, [`locate`] finds a point beside them and [`relocalise`] finds it
//! anew after a jump, with an [`index`] on long paths, [`follow`] takes a vehicle along them in both directions, [`preview`] tells
//! how the path turns ahead, [`stop`] how far and how fast to go on, [`resample`] makes the fine grid of the near neighbourhood and
//! [`lookahead`] searches it.

pub mod follow;
pub(crate) mod index;
pub mod jump;
pub mod locate;
pub mod lookahead;
mod nearby;
#[cfg(feature = "alloc")]
mod owned;
pub mod preview;
pub mod relocalise;
pub mod resample;
pub mod stop;
pub mod view;

pub use follow::{Follow, Located};
pub use index::{Found, STEP_BUDGET};
pub use locate::{Foot, Projection};
#[cfg(feature = "alloc")]
pub use owned::{Path, distinct_waypoints};
pub use stop::Ahead;
pub use view::PathView;
