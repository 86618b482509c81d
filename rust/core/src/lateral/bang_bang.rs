//! Bang-bang: a fixed angle back towards the path, the floor to measure against.

use super::{Belief, Decision, LateralLaw, LateralState, Tracked, or_scaled};
use crate::error::{ConfigError, InputError, config_in_range};
use crate::path::follow::{Follow, Located};
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
    /// Arc of the path that is searched on each side of the last projection [m], in addition to the
    /// distance travelled in a step; two wheelbases by default.
    pub search_distance: Option<f64>,
    /// Distance from the path beyond which the vehicle is lost and is searched for on the whole
    /// path [m]; ten wheelbases by default.
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
}

impl BangBangParams {
    /// The parameters with the defaults that scale with `vehicle` filled in.
    pub fn resolved(self, vehicle: &Vehicle) -> Self {
        Self {
            search_distance: or_scaled(self.search_distance, 2.0 * vehicle.wheelbase),
            lost_distance: or_scaled(self.lost_distance, 10.0 * vehicle.wheelbase),
            ..self
        }
    }
}

impl Default for BangBangParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What [`BangBang`] remembers: nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BangBangState {}

/// `steer = -amplitude sign(cross_track_error)` outside the deadband, 0 inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BangBang {
    vehicle: Vehicle,
    follow: Follow,
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
        Ok(Self {
            amplitude: config_in_range("amplitude", params.amplitude, 0.0, 1.57)?,
            deadband: config_in_range("deadband", params.deadband, 0.0, 1e6)?,
            follow: Tracked::FrontAxle.follow(
                &vehicle,
                params.search_distance,
                params.lost_distance,
            )?,
            vehicle,
        })
    }
}

impl LateralState for BangBangState {}

impl LateralLaw for BangBang {
    type State = BangBangState;

    fn initial_state(&self) -> BangBangState {
        BangBangState {}
    }

    fn vehicle(&self) -> &Vehicle {
        &self.vehicle
    }

    fn follow(&self) -> &Follow {
        &self.follow
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
        let (steer, status) = self.vehicle.limit_steer(wanted);
        Decision {
            steer,
            target: at.closest.point,
            status,
        }
    }

    fn check_state(&self, _state: &BangBangState) -> Result<(), InputError> {
        Ok(())
    }
}
