//! Bang-bang: a fixed angle back towards the path, the floor to measure against.

use crate::error::{ConfigError, config_in_range};
use crate::laws::law::{Tracked, or_scaled};
use crate::laws::{Belief, Decision, LateralLaw, LateralState, Steered};
use crate::path::follow::Located;
use crate::path::view::PathView;
use crate::vehicle::Vehicle;

/// Parameters of [`BangBang`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BangBangParams {
    /// The angle that is switched [rad]; at most `max_steer` of it is used. The published code
    /// takes a tenth of its limit.
    pub amplitude: f64,
    /// Cross-track errors up to this leave the wheels straight [m].
    pub deadband: f64,
    /// [`Follow::search_distance`](crate::path::Follow::search_distance), by default 2 wheelbases.
    pub search_distance: Option<f64>,
    /// [`Follow::lost_distance`](crate::path::Follow::lost_distance), by default 10 wheelbases.
    pub lost_distance: Option<f64>,
}

impl BangBangParams {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        amplitude: 0.122,
        deadband: 0.0,
        search_distance: None,
        lost_distance: None,
    };

    /// The parameters with the defaults that scale with `vehicle` filled in.
    pub fn resolved(self, vehicle: &Vehicle) -> Self {
        Self {
            search_distance: or_scaled(self.search_distance, 2.0 * vehicle.wheelbase),
            lost_distance: or_scaled(self.lost_distance, 10.0 * vehicle.wheelbase),
            ..self
        }
    }
}

/// What [`BangBang`] remembers: nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BangBangState {}

/// `steer = -amplitude sign(cross_track_error)` outside the deadband, 0 inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BangBang {
    steered: Steered,
    amplitude: f64,
    deadband: f64,
}

impl BangBang {
    /// The controller with these parameters, for `vehicle`.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the field that is out of its range.
    pub fn new(vehicle: Vehicle, params: BangBangParams) -> Result<Self, ConfigError> {
        let vehicle = vehicle.checked()?;
        let params = params.resolved(&vehicle);
        let distances = (params.search_distance, params.lost_distance);
        Ok(Self {
            amplitude: config_in_range("amplitude", params.amplitude, 0.0, 1.57)?,
            deadband: config_in_range("deadband", params.deadband, 0.0, 1e6)?,
            steered: Tracked::FrontAxle.of(vehicle, distances)?,
        })
    }
}

impl LateralState for BangBangState {}

impl LateralLaw for BangBang {
    type State = BangBangState;

    fn initial_state(&self) -> BangBangState {
        BangBangState {}
    }

    fn steered(&self) -> &Steered {
        &self.steered
    }

    fn decide(
        &self,
        _path: &PathView<'_>,
        _state: &mut BangBangState,
        at: &Located,
        _belief: &Belief,
    ) -> Decision {
        let error = at.closest.cross_track_error();
        let wanted = if error > self.deadband {
            -self.amplitude
        } else if error < -self.deadband {
            self.amplitude
        } else {
            0.0
        };
        let (steer, status) = self.vehicle().limit_steer(wanted);
        Decision {
            steer,
            target: at.closest.point,
            status,
        }
    }
}
