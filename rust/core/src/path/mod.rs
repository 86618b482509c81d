//! The reference path: where am I, and where do I aim?
//!
//! [`view`] holds the waypoints, [`locate`] finds the vehicle beside them and [`relocalise`]
//! finds it anew after a jump, [`resample`] makes the fine grid of the near neighbourhood and
//! [`lookahead`] searches it.

pub mod jump;
pub mod locate;
pub mod lookahead;
#[cfg(feature = "alloc")]
mod owned;
pub mod preview;
pub mod relocalise;
pub mod resample;
pub mod view;

pub use locate::Projection;
#[cfg(feature = "alloc")]
pub use owned::Path;
pub use view::PathView;
