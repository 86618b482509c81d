//! POP: proximally optimal predictive control, the paper's Algorithm 1.

use super::{Body, Command, LateralLaw, Located, Search, Status, check_steer, check_waypoint};
use crate::Point;
use crate::error::{ConfigError, InputError, Requirement, config_in_range};
use crate::math::{PI, from_count, saturate};
use crate::path::lookahead::Lookahead;
use crate::path::view::{PathView, get_distance};
use crate::vehicle::VehicleState;
use crate::vehicle::predict::get_predicted_location;

/// Parameters of [`Pop`]; the paper's Table 1 by default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PopParams {
    /// Velocity constant `k_v` [s]: `lookahead = min_lookahead + lookahead_gain speed`.
    pub lookahead_gain: f64,
    /// Lookahead at rest `ld_min` [m]; the published code's 6 m, the paper gives none.
    pub min_lookahead: f64,
    /// Optimization range `delta_nbd` [rad]: candidates lie at most this far from the last angle.
    pub steer_span: f64,
    /// Optimization resolution: the number of candidates, odd.
    pub candidate_count: usize,
    /// Threshold `epsilon` of the lookahead search [m].
    pub lookahead_tolerance: f64,
    /// Arc ahead of the vehicle that is searched [m].
    pub window_ahead: f64,
    /// Greatest distance of neighbours on the re-discretised path [m].
    pub grid_spacing: f64,
    /// Distance of the axles [m].
    pub wheelbase: f64,
    /// Reference point ahead of the rear axle [m]; the front axle, `wheelbase`, by default.
    pub reference_offset: Option<f64>,
    /// Steering limit `delta_max` [rad].
    pub max_steer: f64,
}

impl PopParams {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        lookahead_gain: 0.2,
        min_lookahead: 6.0,
        steer_span: 3.0 * (PI / 180.0),
        candidate_count: 21,
        lookahead_tolerance: 0.01,
        window_ahead: 20.0,
        grid_spacing: 0.01,
        wheelbase: 3.0,
        reference_offset: None,
        max_steer: 1.22,
    };
}

impl Default for PopParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What [`Pop`] remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PopState {
    /// The waypoint nearest at the last step; none before the first.
    pub waypoint: Option<usize>,
    /// The last angle `delta_prev` [rad].
    pub previous_steer: f64,
}

/// The POP controller: of the angles in the neighbourhood of the last one, the angle whose
/// predicted location lies closest to the lookahead point.
///
/// With one-step point prediction the wheelbase does not enter; it only places the reference
/// point. The last angle is looked at first and wins ties, so a vehicle at rest, where every
/// candidate predicts the same location, keeps its wheels still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pop {
    body: Body,
    search: Search,
    steer_span: f64,
    candidate_count: usize,
}

impl Pop {
    /// The largest number of candidates.
    pub const MAX_CANDIDATES: usize = 100_001;

    /// The law with these parameters.
    ///
    /// # Errors
    ///
    /// [`ConfigError`], naming the parameter that is out of its range.
    pub fn new(params: PopParams) -> Result<Self, ConfigError> {
        let search = Search {
            lookahead_gain: params.lookahead_gain,
            min_lookahead: params.min_lookahead,
            lookahead_tolerance: params.lookahead_tolerance,
            window_ahead: params.window_ahead,
            grid_spacing: params.grid_spacing,
        }
        .checked()?;
        let steer_span = config_in_range("steer_span", params.steer_span, 1e-6, PI)?;
        let count = params.candidate_count;
        if count.is_multiple_of(2) || !(3..=Self::MAX_CANDIDATES).contains(&count) {
            return Err(ConfigError {
                field: "candidate_count",
                value: from_count(count),
                requirement: Requirement::OddInRange(3, Self::MAX_CANDIDATES),
            });
        }
        let body = Body::new(
            params.wheelbase,
            params.reference_offset,
            params.wheelbase,
            params.max_steer,
        )?;
        Ok(Self {
            body,
            search,
            steer_span,
            candidate_count: count,
        })
    }

    /// Algorithm 1 up to the choice of the angle.
    #[inline]
    fn decide(
        &self,
        path: &PathView<'_>,
        state: &mut PopState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<(Located, Lookahead, f64), InputError> {
        let at = self.body.locate(path, state.waypoint, vehicle, dt)?;
        let speed = vehicle.forward_speed();
        let lookahead = self.search.min_lookahead + self.search.lookahead_gain * speed;
        let target = self.search.find(path, &at, lookahead);
        let steer = self.choose(
            target.point - at.position,
            VehicleState {
                x: 0.0,
                y: 0.0,
                yaw: vehicle.yaw,
                speed,
            },
            state.previous_steer,
            dt,
        );
        *state = PopState {
            waypoint: Some(at.nearest),
            previous_steer: steer,
        };
        Ok((at, target, steer))
    }

    /// The optimization loop of Algorithm 1, with the vehicle at the origin: distances are the
    /// same there, and no digits are lost far from it.
    fn choose(&self, target: Point, vehicle: VehicleState, previous_steer: f64, dt: f64) -> f64 {
        let travel = vehicle.speed * dt;
        let range = get_distance(Point::new(0.0, 0.0), target);
        // The candidates' distances differ by about travel * span^2; below the rounding of the
        // distances themselves their order is noise, and following it would wind the wheels up.
        if travel * self.steer_span * self.steer_span <= 16.0 * f64::EPSILON * range {
            return previous_steer;
        }
        let distance_to_target =
            |steer| get_distance(get_predicted_location(vehicle, steer, dt), target);
        let mut steer = previous_steer;
        let mut least = distance_to_target(steer);
        for k in 0..self.candidate_count {
            let candidate = self.candidate(previous_steer, k);
            let distance = distance_to_target(candidate);
            if distance < least {
                steer = candidate;
                least = distance;
            }
        }
        steer
    }

    /// Candidate `k` of `delta_list`: evenly over `previous_steer +- steer_span`, within the
    /// limit.
    #[inline]
    fn candidate(&self, previous_steer: f64, k: usize) -> f64 {
        let half = from_count(self.candidate_count / 2);
        let offset = self.steer_span * ((from_count(k) - half) / half);
        let max_steer = self.body.max_steer;
        saturate(previous_steer + offset, -max_steer, max_steer)
    }
}

impl LateralLaw for Pop {
    type State = PopState;

    fn initial_state(&self) -> PopState {
        PopState::default()
    }

    fn reference_offset(&self) -> f64 {
        self.body.reference_offset
    }

    fn step(
        &self,
        path: &PathView<'_>,
        state: &mut PopState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<Command, InputError> {
        let (at, target, steer) = self.decide(path, state, vehicle, dt)?;
        let status = if !target.found {
            Status::LookaheadLost
        } else if steer.abs() >= self.body.max_steer {
            Status::Saturated
        } else {
            Status::Ok
        };
        Ok(at.command(&at.project(path), steer, target.point, status))
    }

    fn steer(
        &self,
        path: &PathView<'_>,
        state: &mut PopState,
        vehicle: VehicleState,
        dt: f64,
    ) -> Result<f64, InputError> {
        self.decide(path, state, vehicle, dt)
            .map(|(_, _, steer)| steer)
    }

    fn check_state(&self, path: &PathView<'_>, state: &PopState) -> Result<(), InputError> {
        check_waypoint(path, state.waypoint)?;
        check_steer("previous_steer", state.previous_steer, self.body.max_steer)
    }
}
