//! Bang-bang: a fixed angle back towards the path, the floor to measure against.

use crate::error::ConfigError;
use crate::laws::law::Tracked;
use crate::laws::params::law_params;
use crate::laws::{Belief, Decision, LateralLaw, LateralState, Steered};
use crate::path::follow::Located;
use crate::path::view::PathView;
use crate::vehicle::Vehicle;

law_params! {
    /// Parameters of [`BangBang`].
    pub struct BangBangParams<Scaled> of Vehicle(wheelbase) {
        /// The angle that is switched [rad]; at most `max_steer` of it is used. The published code
        /// takes a tenth of its limit.
        amplitude: f64 = 0.122, in [0.0, 1.57];
        /// Cross-track errors up to this leave the wheels straight [m].
        deadband: f64 = 0.0, in [0.0, 1e6];
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
        let params = params.resolved(&vehicle).checked()?;
        Ok(Self {
            amplitude: params.amplitude,
            deadband: params.deadband,
            steered: Tracked::FrontAxle.of(vehicle, params.search_distance, params.lost_distance),
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
