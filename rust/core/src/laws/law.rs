//! What every controller is: a vehicle, validated parameters and a small plain state that decide an
//! angle for a located vehicle.

use core::fmt;

use crate::error::{InputError, input_within};
use crate::geometry::Point;
use crate::path::follow::{Follow, Located};
use crate::path::view::PathView;
use crate::status::Status;
use crate::vehicle::{Estimate, Vehicle};

/// What a controller decides, for the mirrored vehicle: one that drives forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Angle of the mirrored vehicle's front wheels that is wanted [rad], within `max_steer`;
    /// [`Located::mirror`] gives that of the real vehicle.
    pub steer: f64,
    /// The point aimed at: the lookahead point, or the projection onto the path [m].
    pub target: Point,
    /// Saturated or lookahead lost, where that is so.
    pub status: Status,
}

/// What a controller may know of the vehicle besides its parameters, in the vehicle's own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Belief {
    /// Angle of the wheels when the command to be decided reaches them, without the estimated
    /// offset [rad].
    pub wheel: f64,
    /// The estimates.
    pub estimate: Estimate,
}

/// What all states of controllers have in common.
pub trait LateralState {
    /// Forgets what was measured against the path, because the path changes its direction.
    fn leave_path(&mut self) {}

    /// Forgets what the next step would be compared with: since the last one the vehicle stood, or has
    /// jumped.
    fn interrupt(&mut self) {}

    /// Notes a new path, to which the last error is `offset` [m] larger; None if that is unknown.
    fn change_path(&mut self, _offset: Option<f64>) {}

    /// Sets the last angle [rad] to the one that the wheels got in place of the controller's.
    /// Returns whether the next angle continues from it.
    fn set_steer(&mut self, _steer: f64) -> bool {
        false
    }
}

/// A steering controller: a vehicle and validated parameters that decide an angle.
pub trait LateralLaw {
    /// What the controller remembers from one step to the next.
    type State: Clone + PartialEq + fmt::Debug + LateralState;

    /// The state before the first step.
    fn initial_state(&self) -> Self::State;

    /// The vehicle that is steered, and how it follows the path.
    fn steered(&self) -> &Steered;

    /// The vehicle that is steered.
    #[inline]
    fn vehicle(&self) -> &Vehicle {
        &self.steered().vehicle
    }

    /// Which point of the vehicle is tracked, and how it is searched for on the path.
    #[inline]
    fn follow(&self) -> &Follow {
        &self.steered().follow
    }

    /// Whether the controller reads the [`Belief`]: its wheels are then modelled at every step.
    fn reads_belief(&self) -> bool {
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

    /// The angle of the wheels that the cross-track error alone asks for, times the gain on the
    /// heading [rad], where both are those of a controller that takes no account of
    /// `max_steer_rate`; 0 of one that does.
    fn pull(&self, _at: &Located) -> f64 {
        0.0
    }

    /// Whether `state` is one that this controller could have.
    ///
    /// # Errors
    ///
    /// [`InputError`], naming the field that is not.
    fn check_state(&self, _state: &Self::State) -> Result<(), InputError> {
        Ok(())
    }
}

/// A checked vehicle, and which of its points a controller tracks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steered {
    /// The vehicle.
    pub vehicle: Vehicle,
    /// Which point of it is tracked, and how it is searched for on the path.
    pub follow: Follow,
}

/// Which axle a controller steers by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tracked {
    FrontAxle,
    RearAxle,
    NoSlipPoint,
}

impl Tracked {
    /// How this point of a checked `vehicle` follows the path, with checked distances.
    pub(crate) fn of(self, vehicle: &Vehicle, search_distance: f64, lost_distance: f64) -> Steered {
        let wheelbase = vehicle.wheelbase;
        let (base, reference_offset) = match self {
            Self::FrontAxle => (vehicle.rear_axle, wheelbase),
            Self::RearAxle => (vehicle.rear_axle, 0.0),
            Self::NoSlipPoint => (vehicle.no_slip(), 0.0),
        };
        let follow = Follow {
            search_distance,
            lost_distance,
            ..Follow::of(vehicle, base, reference_offset)
        };
        Steered {
            vehicle: *vehicle,
            follow,
        }
    }
}

impl Vehicle {
    /// An angle brought within `max_steer`, and the status of that.
    #[inline]
    pub(crate) fn limit_steer(&self, steer: f64) -> (f64, Status) {
        let saturated = Status::SATURATED | Status::STEER_LIMIT;
        (
            self.at_wheels(steer),
            saturated.when(steer.abs() > self.max_steer),
        )
    }
}

/// Whether a remembered angle is within the limit.
pub(crate) fn check_steer(
    field: &'static str,
    steer: f64,
    max_steer: f64,
) -> Result<(), InputError> {
    input_within(field, steer, max_steer).map(|_| ())
}
