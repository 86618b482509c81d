//! The Stanley controller, the paper's Equation 3.

use crate::error::{ConfigError, config_in_range};
use crate::laws::law::{Tracked, or_scaled, within};
use crate::laws::{Belief, Decision, LateralLaw, LateralState, Steered};
use crate::math::{atan, wrap};
use crate::path::follow::Located;
use crate::path::preview::Preview;
use crate::path::projection::path_yaw_behind;
use crate::path::view::PathView;
use crate::vehicle::Vehicle;

/// Parameters of [`Stanley`]; the paper's Table 1 by default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StanleyParams {
    /// Crosstrack error constant `k_chi` [1/s].
    pub cross_track_gain: f64,
    /// Velocity constant `k_v`.
    pub speed_gain: f64,
    /// Softening constant `k_s` [m/s], which keeps the quotient finite at rest; by default 1e-5 at
    /// the paper's wheelbase, in proportion at others.
    pub softening: Option<f64>,
    /// Whether the path's heading is that of the segment behind the nearest waypoint, as in the
    /// published code, instead of that at the closest point.
    pub heading_behind: bool,
    /// Length of path over which its heading is taken [m]; a wheelbase by default. More: less of
    /// the waypoints' noise is steered, and bends shorter than this are cut. 0, or
    /// `heading_behind`: the heading of one segment, as printed.
    pub smoothing_length: Option<f64>,
    /// [`Follow::search_distance`](crate::path::Follow::search_distance), by default 2 wheelbases.
    pub search_distance: Option<f64>,
    /// [`Follow::lost_distance`](crate::path::Follow::lost_distance), by default 10 wheelbases.
    pub lost_distance: Option<f64>,
}

impl StanleyParams {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        cross_track_gain: 1.5,
        speed_gain: 1.3,
        softening: None,
        heading_behind: false,
        smoothing_length: None,
        search_distance: None,
        lost_distance: None,
    };

    /// The parameters with the defaults that scale with `vehicle` filled in.
    pub fn resolved(self, vehicle: &Vehicle) -> Self {
        Self {
            softening: or_scaled(self.softening, 1e-5 / 3.0 * vehicle.wheelbase),
            smoothing_length: or_scaled(self.smoothing_length, vehicle.wheelbase),
            search_distance: or_scaled(self.search_distance, 2.0 * vehicle.wheelbase),
            lost_distance: or_scaled(self.lost_distance, 10.0 * vehicle.wheelbase),
            ..self
        }
    }
}

/// What [`Stanley`] remembers: nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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
    cross_track_gain: f64,
    speed_gain: f64,
    softening: f64,
    heading_behind: bool,
    smoothing_length: f64,
}

impl Stanley {
    /// The controller with these parameters, for `vehicle`.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the field that is out of its range.
    pub fn new(vehicle: Vehicle, params: StanleyParams) -> Result<Self, ConfigError> {
        let vehicle = vehicle.checked()?;
        let params = params.resolved(&vehicle);
        let distances = (params.search_distance, params.lost_distance);
        let gain = params.cross_track_gain;
        Ok(Self {
            cross_track_gain: config_in_range("cross_track_gain", gain, 0.0, 1e6)?,
            speed_gain: config_in_range("speed_gain", params.speed_gain, 0.0, 1e6)?,
            softening: within("softening", params.softening, 1e-9, 1e6)?,
            heading_behind: params.heading_behind,
            smoothing_length: within("smoothing_length", params.smoothing_length, 0.0, 1e4)?,
            steered: Tracked::FrontAxle.of(vehicle, distances)?,
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
    fn decide(
        &self,
        path: &PathView<'_>,
        _state: &mut StanleyState,
        at: &Located,
        _belief: &Belief,
    ) -> Decision {
        let speed = self.softening + self.speed_gain * at.vehicle.forward_speed();
        let pull = atan(self.cross_track_gain * at.closest.cross_track_error() / speed);
        let path_yaw = if self.heading_behind {
            path_yaw_behind(path, at.closest.nearest_waypoint(path))
        } else if self.smoothing_length > 0.0 {
            let arc_length = at.closest.arc_length(path);
            Preview::yaw_at(path, self.smoothing_length, at.closest.segment, arc_length)
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
