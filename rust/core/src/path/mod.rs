//! The reference path: projection, lookahead and preview.
//!
//! - `sound` mends waypoints or refuses them.
//! - [`view`] holds the waypoints, which [`measure`] has checked, and [`Path`] owns them.
//! - [`projection`] is the closest point of a segment; [`locate`] finds it along the arc around the
//!   last one, and [`relocalise`] on the whole path after a jump, with the boxes of an index on
//!   long paths.
//! - [`follow`] takes a vehicle along the path in both directions, and [`place`] says where it is.
//! - [`carry`] takes a place over to a path that replaces another.
//! - `shape` is the curve that headings and curvatures of a planner's own make.
//! - [`preview`] gives the path's turns ahead, [`stop`] distance and speed to the next stop.
//! - [`resample`] makes the fine grid of the near neighbourhood and [`lookahead`] searches it, as
//!   [`jump`] does faster.

mod best;
mod boxes;
pub mod carry;
pub mod follow;
pub(crate) mod index;
pub mod jump;
pub mod locate;
pub mod lookahead;
pub mod measure;
mod nearby;
#[cfg(feature = "alloc")]
mod owned;
pub mod place;
pub mod preview;
pub mod projection;
pub mod relocalise;
pub mod resample;
mod shape;
#[cfg(feature = "alloc")]
pub mod sound;
pub mod stop;
#[cfg(test)]
mod tests;
pub mod view;

pub use follow::{Follow, Located};
pub use index::{Found, STEP_BUDGET};
#[cfg(feature = "alloc")]
pub use owned::Path;
pub use place::{Place, Spot};
pub use projection::{ClosestPoint, Projection};
pub use stop::Ahead;
pub use view::PathView;
