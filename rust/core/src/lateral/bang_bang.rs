//! Bang-bang: a fixed angle back towards the path, the floor to measure against.

use super::{Body, Command, LateralLaw, LateralState, body_params, check_waypoint, command};
use crate::error::{ConfigError, InputError, config_in_range};
use crate::path::follow::Follow;
use crate::path::view::PathView;
use crate::vehicle::VehicleState;

/// Parameters of [`BangBang`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BangBangParams {
    /// The angle that is switched [rad]; at most `max_steer` of it is used. The published code
    /// takes a tenth of its limit.
    pub amplitude: f64,
    /// Cross-track errors up to this leave the wheels straight [m].
    pub deadband: f64,
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

impl BangBangParams {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        amplitude: 0.122,
        deadband: 0.0,
        wheelbase: 3.0,
        reference_offset: None,
        max_steer: 1.22,
        search_distance: None,
        lost_distance: None,
    };
}

impl Default for BangBangParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What [`BangBang`] remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BangBangState {
    /// The waypoint at which the segment of the last foot starts; none before the first step.
    pub waypoint: Option<usize>,
}

/// `steer = -amplitude sign(cross_track_error)` outside the deadband, 0 inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BangBang {
    body: Body,
    amplitude: f64,
    deadband: f64,
}

impl BangBang {
    /// The law with these parameters.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn new(params: BangBangParams) -> Result<Self, ConfigError> {
        Ok(Self {
            amplitude: config_in_range("amplitude", params.amplitude, 0.0, 1.57)?,
            deadband: config_in_range("deadband", params.deadband, 0.0, 1e6)?,
            body: Body::new(body_params!(params), params.wheelbase)?,
        })
    }
}

impl LateralState for BangBangState {
    #[inline]
    fn set_waypoint(&mut self, waypoint: Option<usize>) {
        self.waypoint = waypoint;
    }
}

impl LateralLaw for BangBang {
    type State = BangBangState;

    fn initial_state(&self) -> BangBangState {
        BangBangState::default()
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
        state: &mut BangBangState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<Command, InputError> {
        let at = self.body.locate(path, state.waypoint, vehicle, dt)?;
        let error = at.foot.cross_track_error();
        let wanted = if error > self.deadband {
            -self.amplitude
        } else if error < -self.deadband {
            self.amplitude
        } else {
            0.0
        };
        let (steer, status) = self.body.limit(wanted);
        state.waypoint = Some(at.foot.segment);
        Ok(command(&at, steer, at.foot.point, status))
    }

    fn check_state(&self, path: &PathView<'_>, state: &BangBangState) -> Result<(), InputError> {
        check_waypoint(path, state.waypoint)
    }
}
