//! The lateral controllers, one a file, behind [`LateralLaw`].
//!
//! A controller decides an angle for a located vehicle; it is a vehicle, validated parameters and a
//! small plain state. All else of a step around it is a [`Tracker`](crate::Tracker)'s.

pub mod any;
pub mod law;
mod params;
pub mod pid;
pub mod pop;
pub mod preview_pop;
pub mod pure_pursuit;
pub mod search;
pub mod stanley;

pub use any::{Law, LawState};
pub use law::{Belief, Decision, LateralLaw, LateralState, Steered};
pub use pid::{Pid, PidParams, PidState};
pub use pop::{Pop, PopParams, PopState};
pub use preview_pop::{PreviewPop, PreviewPopParams, PreviewPopState};
pub use pure_pursuit::{PurePursuit, PurePursuitParams, PurePursuitState};
pub use stanley::{Stanley, StanleyParams, StanleyState};
