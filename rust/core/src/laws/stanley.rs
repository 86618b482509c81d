//! The Stanley controller, the paper's Equation 3.

use crate::error::ConfigError;
use crate::laws::law::Tracked;
use crate::laws::params::law_params;
use crate::laws::{Belief, Decision, LateralLaw, LateralState, Steered};
use crate::math::{atan, wrap};
use crate::path::follow::Located;
use crate::path::preview::Preview;
use crate::path::projection::path_yaw_behind;
use crate::path::view::PathView;
use crate::vehicle::Vehicle;

law_params! {
    /// Parameters of [`Stanley`]; the paper's Table 1 at the paper's car.
    pub struct StanleyParams<Scaled> of Vehicle(wheelbase) {
        /// Crosstrack error constant `k_chi` [1/s].
        cross_track_gain: f64 = 1.5, in [0.0, 1e6];
        /// Velocity constant `k_v`.
        speed_gain: f64 = 1.3, in [0.0, 1e6];
        /// Softening constant `k_s` [m/s], which keeps the quotient finite at rest.
        softening: Scaled = 1.0 / 3.0 * wheelbase, in [1e-9, 1e6];
        /// Whether the path's heading is that of the segment behind the nearest waypoint, as in the
        /// published code, instead of that at the closest point.
        heading_behind: bool = false;
        /// Length of path over which its heading is taken [m]. More: less of the waypoints' noise
        /// is steered, and bends shorter than this are cut. 0, or `heading_behind`: the heading of
        /// one segment, as printed.
        smoothing_length: Scaled = wheelbase, in [0.0, 1e4];
    }
}

/// What [`Stanley`] remembers: nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StanleyState {}

/// Heading and cross-track error at the front axle:
/// `steer = -(heading_error + atan(cross_track_gain cross_track_error / (softening + speed_gain
/// speed)))`.
///
/// The signs are those of this crate's errors, positive to the left; the paper's are the
/// opposite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stanley {
    steered: Steered,
    params: StanleyParams<f64>,
}

impl Stanley {
    /// The controller with these parameters, for `vehicle`.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the field that is out of its range.
    pub fn new(vehicle: Vehicle, params: StanleyParams) -> Result<Self, ConfigError> {
        let vehicle = vehicle.checked()?;
        let params = params.resolved(&vehicle).checked()?;
        Ok(Self {
            steered: Tracked::FrontAxle.of(&vehicle, params.search_distance, params.lost_distance),
            params,
        })
    }
}

impl LateralState for StanleyState {}

impl LateralLaw for Stanley {
    type State = StanleyState;

    fn initial_state(&self) -> StanleyState {
        StanleyState {}
    }

    fn steered(&self) -> &Steered {
        &self.steered
    }

    #[inline]
    fn pull(&self, at: &Located) -> f64 {
        let params = &self.params;
        let speed = params.softening + params.speed_gain * at.vehicle.forward_speed();
        atan(params.cross_track_gain * at.closest.cross_track_error() / speed)
    }

    #[inline]
    fn decide(
        &self,
        path: &PathView<'_>,
        _state: &mut StanleyState,
        at: &Located,
        _belief: &Belief,
    ) -> Decision {
        let params = &self.params;
        let pull = self.pull(at);
        let path_yaw = if params.heading_behind {
            path_yaw_behind(path, at.closest.nearest_waypoint(path))
        } else if params.smoothing_length > 0.0 {
            let (segment, arc) = (at.closest.segment, at.closest.arc_length(path));
            Preview::yaw_at(path, params.smoothing_length, segment, arc)
        } else {
            at.closest.path_yaw()
        };
        let heading_error = wrap(at.vehicle.yaw - path_yaw);
        let (steer, status) = self.vehicle().limit_steer(-(heading_error + pull));
        Decision {
            steer,
            target: at.closest.point,
            status,
        }
    }
}
