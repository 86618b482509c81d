//! Adaptive Pure-Pursuit, the paper's Equation 2.

use crate::error::{ConfigError, InputError};
use crate::geometry::get_distance;
use crate::laws::law::{Tracked, check_steer};
use crate::laws::params::law_params;
use crate::laws::search::{Search, search_of};
use crate::laws::{Belief, Decision, LateralLaw, LateralState, Steered};
use crate::math::{PI, acos, atan2, larger, sin};
use crate::path::follow::Located;
use crate::path::view::PathView;
use crate::status::Status;
use crate::vehicle::Vehicle;

law_params! {
    /// Parameters of [`PurePursuit`]; the paper's Table 1 at the paper's car, with the published
    /// code's 10 m of `min_lookahead`, where the paper's equation has 0. With `exact_lookahead`, a
    /// lookahead point behind the vehicle is turned to as one abeam.
    pub struct PurePursuitParams<Scaled> of Vehicle(wheelbase) {
        /// Velocity constant `k_v` [s]: `lookahead = max(min_lookahead, lookahead_gain * speed)`.
        lookahead_gain: f64 = 0.9, in [0.0, 1e3];
        /// Least lookahead [m].
        min_lookahead: Scaled = 10.0 / 3.0 * wheelbase, in [0.0, 1e4];
        /// Whether alpha is taken as the published code does, `acos(heading . line / lookahead)`,
        /// instead of as the angle between heading and line. The grid point lies up to the threshold
        /// inside the circle, so that reading never sees less than about `sqrt(2 tolerance /
        /// lookahead)`: the wheels chatter about straight ahead, and the path is tracked more
        /// tightly.
        alpha_by_arccos: bool = false;
    }
    with search
}

/// What [`PurePursuit`] remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PurePursuitState {
    /// The last bearing `alpha` [rad], the substitute where its arc cosine is not defined; 0
    /// without `alpha_by_arccos`.
    pub previous_alpha: f64,
}

/// The circle from the rear axle through the lookahead point:
/// `steer = atan(2 wheelbase sin(alpha) / lookahead)`, with `alpha` the bearing of the lookahead
/// point off the heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PurePursuit {
    steered: Steered,
    search: Search,
    alpha_by_arccos: bool,
}

impl PurePursuit {
    /// The controller with these parameters, for `vehicle`.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the field that is out of its range.
    pub fn new(vehicle: Vehicle, params: PurePursuitParams) -> Result<Self, ConfigError> {
        let vehicle = vehicle.checked()?;
        let params = params.resolved(&vehicle).checked()?;
        Ok(Self {
            search: search_of!(params),
            alpha_by_arccos: params.alpha_by_arccos,
            steered: Tracked::RearAxle.of(&vehicle, params.search_distance, params.lost_distance),
        })
    }
}

/// The published code's `alpha` towards a point `ahead` and to the `left` [m], signed here:
/// `previous` where it lies outside the circle straight ahead, and the arc cosine is not defined.
fn alpha_by_arccos(ahead: f64, left: f64, lookahead: f64, previous: f64) -> f64 {
    let cosine = ahead / lookahead;
    if cosine.abs() <= 1.0 {
        acos(cosine).copysign(left)
    } else {
        previous
    }
}

impl LateralState for PurePursuitState {}

impl LateralLaw for PurePursuit {
    type State = PurePursuitState;

    fn initial_state(&self) -> PurePursuitState {
        PurePursuitState::default()
    }

    fn steered(&self) -> &Steered {
        &self.steered
    }

    #[inline]
    fn decide(
        &self,
        path: &PathView<'_>,
        state: &mut PurePursuitState,
        at: &Located,
        _belief: &Belief,
    ) -> Decision {
        let wheelbase = self.vehicle().wheelbase;
        let scheduled = self.search.lookahead_gain * at.vehicle.forward_speed();
        // -0.0, a lookahead of nothing on the other side, becomes 0.0.
        let lookahead = larger(scheduled, self.search.min_lookahead) + 0.0;
        let target = self.search.find(path, at, lookahead);
        let to = target.point - at.position;
        let ahead = to.dot(&at.heading);
        let left = at.heading.perp(&to);
        // atan2 is the equation's atan, and defined where the paper's lookahead vanishes at rest.
        let wanted = if self.alpha_by_arccos {
            state.previous_alpha = alpha_by_arccos(ahead, left, lookahead, state.previous_alpha);
            atan2(2.0 * wheelbase * sin(state.previous_alpha), lookahead)
        } else {
            // sin(alpha) is left / distance, with the distance on the other side.
            let distance = get_distance(at.position, target.point);
            // Towards a point behind the circle would lead away from it, straight behind for good.
            let aside = if self.search.exact_lookahead && ahead < 0.0 {
                distance.copysign(left)
            } else {
                left
            };
            // A substitute nearer than the lookahead has a circle of its own.
            let nearer = self.search.exact_lookahead && !target.found && distance < lookahead;
            let reach = if nearer { distance } else { lookahead };
            atan2(2.0 * wheelbase * aside, reach * distance)
        };
        let (steer, status) = self.vehicle().limit_steer(wanted);
        Decision {
            steer,
            target: target.point,
            status: status | Status::LOOKAHEAD_LOST.when(!target.found),
        }
    }

    fn check_state(&self, state: &PurePursuitState) -> Result<(), InputError> {
        check_steer("law.previous_alpha", state.previous_alpha, PI)
    }
}
