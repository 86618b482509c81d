//! Adaptive Pure-Pursuit, the paper's Equation 2.

use super::{
    Body, Command, LateralLaw, LateralState, Status, Target, body_params, check_steer,
    check_waypoint, command, search_params,
};
use crate::error::{ConfigError, InputError};
use crate::math::{PI, acos, atan2, sin};
use crate::path::follow::{Follow, Located};
use crate::path::view::{PathView, get_distance};
use crate::vehicle::VehicleState;

/// Parameters of [`PurePursuit`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PurePursuitParams {
    /// Velocity constant `k_v` [s]: `lookahead = max(min_lookahead, lookahead_gain speed)`.
    pub lookahead_gain: f64,
    /// Least lookahead [m]; the published code's 10 m by default, the paper's equation has 0.
    pub min_lookahead: f64,
    /// Whether `alpha` is taken as the published code does, `acos(heading . line / lookahead)`,
    /// instead of as the angle between heading and line. The grid point lies up to the threshold
    /// inside the circle, so that reading never sees less than about `sqrt(2 tolerance /
    /// lookahead)`: the wheels chatter about straight ahead, and the path is tracked more tightly.
    pub alpha_by_arccos: bool,
    /// Whether the lookahead point is the path's first crossing of the circle ahead of the
    /// vehicle, [`get_crossing`](crate::path::lookahead::get_crossing), instead of what the
    /// paper's search finds; with it, a point behind the vehicle is turned to as one abeam.
    pub exact_lookahead: bool,
    /// Threshold `epsilon` of the paper's search [m].
    pub lookahead_tolerance: f64,
    /// Arc ahead of the vehicle that the paper's search looks at [m].
    pub window_ahead: f64,
    /// Greatest distance of neighbours on the path as the paper's search re-discretises it [m].
    pub grid_spacing: f64,
    /// Distance of the axles `L` [m].
    pub wheelbase: f64,
    /// Reference point ahead of the rear axle [m]; the rear axle, 0, by default.
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

impl PurePursuitParams {
    /// The defaults: the paper's Table 1, the least lookahead from the published code.
    pub const DEFAULT: Self = Self {
        lookahead_gain: 0.9,
        min_lookahead: 10.0,
        alpha_by_arccos: false,
        exact_lookahead: true,
        lookahead_tolerance: 0.01,
        window_ahead: 20.0,
        grid_spacing: 0.01,
        wheelbase: 3.0,
        reference_offset: None,
        max_steer: 1.22,
        search_distance: None,
        lost_distance: None,
    };
}

impl Default for PurePursuitParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What [`PurePursuit`] remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PurePursuitState {
    /// The waypoint at which the segment of the last foot starts; none before the first step.
    pub waypoint: Option<usize>,
    /// The last bearing `alpha` [rad], which stands in where its arc cosine is not defined; 0
    /// without `alpha_by_arccos`.
    pub previous_alpha: f64,
}

/// The circle from the rear axle through the lookahead point:
/// `steer = atan(2 wheelbase sin(alpha) / lookahead)`, with `alpha` the bearing of the lookahead
/// point off the heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PurePursuit {
    body: Body,
    search: super::Search,
    alpha_by_arccos: bool,
}

impl PurePursuit {
    /// The law with these parameters.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn new(params: PurePursuitParams) -> Result<Self, ConfigError> {
        let search = search_params!(params).checked()?;
        let body = Body::new(body_params!(params), 0.0)?;
        Ok(Self {
            body,
            search,
            alpha_by_arccos: params.alpha_by_arccos,
        })
    }

    #[inline]
    fn decide(
        &self,
        path: &PathView<'_>,
        state: &mut PurePursuitState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<(Located, Target, f64, Status), InputError> {
        let at = self.body.locate(path, state.waypoint, vehicle, dt)?;
        let scheduled = self.search.lookahead_gain * at.vehicle.forward_speed();
        let lookahead = if scheduled > self.search.min_lookahead {
            scheduled
        } else {
            self.search.min_lookahead
        };
        // -0.0, a lookahead of nothing on the other side, becomes 0.0.
        let lookahead = lookahead + 0.0;
        let target = self.search.find(path, &at, lookahead);
        let to = target.point - at.position;
        let (cosine, sine) = (at.heading.x, at.heading.y);
        let ahead = to.x * cosine + to.y * sine;
        let left = to.y * cosine - to.x * sine;
        // atan2 is the equation's atan, and defined where the paper's lookahead vanishes at rest.
        let mut alpha = state.previous_alpha;
        let wanted = if self.alpha_by_arccos {
            alpha = alpha_by_arccos(ahead, left, lookahead, alpha);
            atan2(2.0 * self.body.wheelbase * sin(alpha), lookahead)
        } else {
            // sin(alpha) is left / distance, with the distance on the other side.
            let distance = get_distance(at.position, target.point);
            // Towards a point behind the circle would lead away from it, straight behind for good.
            let aside = if self.search.exact_lookahead && ahead < 0.0 {
                distance.copysign(left)
            } else {
                left
            };
            atan2(2.0 * self.body.wheelbase * aside, lookahead * distance)
        };
        let (steer, status) = self.body.limit(wanted);
        *state = PurePursuitState {
            waypoint: Some(at.foot.segment),
            previous_alpha: alpha,
        };
        Ok((at, target, steer, status))
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

impl LateralState for PurePursuitState {
    #[inline]
    fn set_waypoint(&mut self, waypoint: Option<usize>) {
        self.waypoint = waypoint;
    }
}

impl LateralLaw for PurePursuit {
    type State = PurePursuitState;

    fn initial_state(&self) -> PurePursuitState {
        PurePursuitState::default()
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
        state: &mut PurePursuitState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<Command, InputError> {
        let (at, target, steer, limited) = self.decide(path, state, vehicle, dt)?;
        let status = if target.found {
            limited
        } else {
            Status::LookaheadLost
        };
        Ok(command(&at, steer, target.point, status))
    }

    fn steer(
        &self,
        path: &PathView<'_>,
        state: &mut PurePursuitState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<f64, InputError> {
        self.decide(path, state, vehicle, dt)
            .map(|(at, _, steer, _)| at.turn(steer))
    }

    fn check_state(&self, path: &PathView<'_>, state: &PurePursuitState) -> Result<(), InputError> {
        check_waypoint(path, state.waypoint)?;
        check_steer("previous_alpha", state.previous_alpha, PI)
    }
}
