//! The lateral controllers, one a file, behind [`LateralLaw`], and [`Tracker`], which steps them.
//!
//! A law decides an angle for a located vehicle; it is a vehicle, validated parameters and a small
//! plain state. A [`Tracker`] is all of a step around it: estimate, predict, locate, limit.

mod approach;
pub mod bang_bang;
pub mod command;
pub mod command_limits;
pub mod cost_to_go;
pub mod error_buffer;
mod held;
pub mod limited;
pub mod missed;
pub mod monitor;
pub mod monitor_state;
pub mod pid;
pub mod plan;
pub mod pop;
pub mod predict;
pub mod preview_params;
pub mod preview_pop;
pub mod pure_pursuit;
pub mod replan;
pub mod reported;
pub mod search;
mod sight;
pub mod stanley;
pub mod tracker;
pub mod tracker_state;

pub use bang_bang::{BangBang, BangBangParams, BangBangState};
pub use command::{Command, Status};
pub use monitor::MonitorParams;
pub use monitor_state::MonitorState;
pub use pid::{Pid, PidParams, PidState};
pub use pop::{Pop, PopParams, PopState};
pub use predict::Predicted;
pub use preview_params::PreviewPopParams;
pub use preview_pop::{PreviewPop, PreviewPopState};
pub use pure_pursuit::{PurePursuit, PurePursuitParams, PurePursuitState};
pub use reported::Reported;
pub use stanley::{Stanley, StanleyParams, StanleyState};
pub use tracker::Tracker;
pub use tracker_state::{Answer, Handover, Place, Seen, TrackerState};

use core::fmt;

use crate::error::{ConfigError, InputError, config_in_range, input_in_range};
use crate::geometry::Point;
use crate::path::follow::{Follow, Located};
use crate::path::view::PathView;
use crate::vehicle::{AdaptParams, Estimate, Vehicle};

/// What a law decides, for the vehicle as one that drives forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Angle of the front wheels that is wanted [rad], within the vehicle's `max_steer`.
    pub steer: f64,
    /// The point aimed at: the lookahead point, or the projection onto the path [m].
    pub target: Point,
    /// Saturated or lookahead lost, where that is so.
    pub status: Status,
}

/// What a law may know of the vehicle beyond its own figures, in the vehicle's own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Belief {
    /// Angle of the wheels when the command to be decided reaches them, without the estimated
    /// offset [rad].
    pub wheel: f64,
    /// What the motion has shown.
    pub estimate: Estimate,
}

/// What all states of laws have in common.
pub trait LateralState {
    /// Forgets what was measured against the path: it leads another way from now on.
    fn leave_path(&mut self) {}

    /// Another path is followed from now on, against which the last error is `offset` [m] larger;
    /// by nobody knows how much where that is none.
    fn change_path(&mut self, _offset: Option<f64>) {}

    /// Takes note of the angle [rad] that the wheels were given instead of the law's answer.
    /// Whether the law's next answer goes on from it.
    fn set_steer(&mut self, _steer: f64) -> bool {
        false
    }
}

/// A steering law: a vehicle and validated parameters that decide an angle.
pub trait LateralLaw {
    /// What the law remembers from one step to the next.
    type State: Clone + PartialEq + fmt::Debug + LateralState;

    /// The state before the first step.
    fn initial_state(&self) -> Self::State;

    /// The vehicle that is steered.
    fn vehicle(&self) -> &Vehicle;

    /// Which point of the vehicle the law follows along the path, and how.
    fn follow(&self) -> &Follow;

    /// Whether the law reads the [`Belief`]: its wheels are then modelled at every step.
    fn predicts(&self) -> bool {
        false
    }

    /// The angle for a located vehicle.
    fn decide(
        &self,
        path: &PathView<'_>,
        state: &mut Self::State,
        at: &Located,
        belief: &Belief,
    ) -> Decision;

    /// Whether `state` is one that this law could have.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the field that is not.
    fn check_state(&self, state: &Self::State) -> Result<(), InputError>;

    /// How a tracker of this law adapts unless it is told otherwise: at all where an estimate
    /// counts, in a law that predicts and where commands are in flight.
    fn default_adapt(&self) -> Option<AdaptParams> {
        (self.predicts() || self.vehicle().dead_time > 0.0).then_some(AdaptParams::DEFAULT)
    }
}

/// Which axle a law steers by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tracked {
    FrontAxle,
    RearAxle,
    NoSlipPoint,
}

impl Tracked {
    /// How the vehicle's point is followed, with these distances.
    fn follow(
        self,
        vehicle: &Vehicle,
        search_distance: Option<f64>,
        lost_distance: Option<f64>,
    ) -> Result<Follow, ConfigError> {
        let wheelbase = vehicle.wheelbase;
        let (search, lost) = (resolved(search_distance), resolved(lost_distance));
        let (base, reference_offset) = match self {
            Self::FrontAxle => (vehicle.rear_axle, wheelbase),
            Self::RearAxle => (vehicle.rear_axle, 0.0),
            Self::NoSlipPoint => (vehicle.no_slip(), 0.0),
        };
        Ok(Follow {
            search_distance: config_in_range("search_distance", search, 0.0, 1e6)?,
            lost_distance: config_in_range("lost_distance", lost, 1e-3, 1e9)?,
            ..Follow::of(vehicle, base, reference_offset)
        })
    }
}

impl Vehicle {
    /// An angle brought within `max_steer`, and the status of that.
    #[inline]
    fn limit_steer(&self, steer: f64) -> (f64, Status) {
        if steer > self.max_steer {
            (self.max_steer, Status::SATURATED)
        } else if steer < -self.max_steer {
            (-self.max_steer, Status::SATURATED)
        } else {
            (steer, Status::OK)
        }
    }
}

/// A parameter that is given, or its default for the vehicle.
fn or_scaled(given: Option<f64>, default: f64) -> Option<f64> {
    given.or(Some(default))
}

/// A parameter after its defaults were filled in; one that was not is refused as not a number.
fn resolved(given: Option<f64>) -> f64 {
    given.unwrap_or(f64::NAN)
}

/// Whether a remembered angle is within the limit.
fn check_steer(field: &'static str, steer: f64, max_steer: f64) -> Result<(), InputError> {
    input_in_range(field, steer, -max_steer, max_steer).map(|_| ())
}
