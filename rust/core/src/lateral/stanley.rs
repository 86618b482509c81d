//! The Stanley law, the paper's Equation 3.

use super::{Body, Command, LateralLaw, LateralState, body_params, check_waypoint, command};
use crate::error::{ConfigError, InputError, config_in_range};
use crate::math::{atan, wrap};
use crate::path::follow::Follow;
use crate::path::locate::path_yaw_behind;
use crate::path::view::PathView;
use crate::vehicle::VehicleState;

/// Parameters of [`Stanley`]; the paper's Table 1 by default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StanleyParams {
    /// Crosstrack error constant `k_chi` [1/s].
    pub cross_track_gain: f64,
    /// Velocity constant `k_v`.
    pub speed_gain: f64,
    /// Softening constant `k_s` [m/s], which keeps the quotient finite at rest.
    pub softening: f64,
    /// Whether the path's heading is that of the segment behind the nearest waypoint, as in the
    /// published code, instead of that at the foot.
    pub heading_behind: bool,
    /// Distance of the axles [m].
    pub wheelbase: f64,
    /// Reference point ahead of the rear axle [m]; the front axle, `wheelbase`, by default.
    pub reference_offset: Option<f64>,
    /// Steering limit `delta_max` [rad].
    pub max_steer: f64,
    /// How far along the path from the last place the vehicle is looked for [m], beside what it
    /// travels in a step; two wheelbases by default.
    pub search_distance: Option<f64>,
    /// Farther than this from its place the vehicle is lost, and looked for on the whole path
    /// [m]; ten wheelbases by default.
    pub lost_distance: Option<f64>,
}

impl StanleyParams {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        cross_track_gain: 1.5,
        speed_gain: 1.3,
        softening: 1e-5,
        heading_behind: false,
        wheelbase: 3.0,
        reference_offset: None,
        max_steer: 1.22,
        search_distance: None,
        lost_distance: None,
    };
}

impl Default for StanleyParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What [`Stanley`] remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StanleyState {
    /// The waypoint at which the segment of the last foot starts; none before the first step.
    pub waypoint: Option<usize>,
}

/// Heading and cross-track error at the front axle:
/// `steer = -(heading_error + atan(cross_track_gain cross_track_error / (softening + speed_gain
/// speed)))`.
///
/// The signs are those of this crate's errors, positive to the left; the paper's are the
/// opposite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stanley {
    body: Body,
    cross_track_gain: f64,
    speed_gain: f64,
    softening: f64,
    heading_behind: bool,
}

impl Stanley {
    /// The law with these parameters.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn new(params: StanleyParams) -> Result<Self, ConfigError> {
        Ok(Self {
            cross_track_gain: config_in_range(
                "cross_track_gain",
                params.cross_track_gain,
                0.0,
                1e6,
            )?,
            speed_gain: config_in_range("speed_gain", params.speed_gain, 0.0, 1e6)?,
            softening: config_in_range("softening", params.softening, 1e-9, 1e6)?,
            heading_behind: params.heading_behind,
            body: Body::new(body_params!(params), params.wheelbase)?,
        })
    }
}

impl LateralState for StanleyState {
    #[inline]
    fn set_waypoint(&mut self, waypoint: Option<usize>) {
        self.waypoint = waypoint;
    }
}

impl LateralLaw for Stanley {
    type State = StanleyState;

    fn initial_state(&self) -> StanleyState {
        StanleyState::default()
    }

    fn follow(&self) -> &Follow {
        &self.body.follow
    }

    fn max_steer(&self) -> f64 {
        self.body.max_steer
    }

    fn step(
        &self,
        path: &PathView<'_>,
        state: &mut StanleyState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<Command, InputError> {
        let at = self.body.locate(path, state.waypoint, vehicle, dt)?;
        let speed = self.softening + self.speed_gain * at.vehicle.forward_speed();
        let pull = atan(self.cross_track_gain * at.foot.cross_track_error() / speed);
        let path_yaw = if self.heading_behind {
            path_yaw_behind(path, at.foot.nearest_waypoint(path))
        } else {
            at.foot.path_yaw()
        };
        let heading_error = wrap(at.vehicle.yaw - path_yaw);
        let (steer, status) = self.body.limit(-(heading_error + pull));
        state.waypoint = Some(at.foot.segment);
        Ok(command(&at, steer, at.foot.point, status))
    }

    fn check_state(&self, path: &PathView<'_>, state: &StanleyState) -> Result<(), InputError> {
        check_waypoint(path, state.waypoint)
    }
}
