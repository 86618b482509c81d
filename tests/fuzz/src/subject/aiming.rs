//! The laws that aim at a point ahead.

use super::{Search, Subject};
use crate::bytes::Bytes;
use popsteer_core::laws::{
    Pop, PopParams, PopState, PurePursuit, PurePursuitParams, PurePursuitState,
};
use popsteer_core::{ConfigError, Vehicle};
use std::f64::consts::PI;

/// The parameters of the search for that point.
struct Aim {
    lookahead_gain: f64,
    min_lookahead: Option<f64>,
    exact_lookahead: bool,
    lookahead_tolerance: Option<f64>,
    window_ahead: Option<f64>,
    grid_spacing: Option<f64>,
}

impl Aim {
    fn draw(bytes: &mut Bytes) -> Self {
        Self {
            lookahead_gain: bytes.parameter(0.2, [0.0, 1.0], [0.0, 1e3]),
            min_lookahead: bytes.optional([0.0, 12.0], [0.0, 1e4]),
            exact_lookahead: bytes.byte() & 1 == 0,
            lookahead_tolerance: bytes.optional([0.005, 0.5], [1e-9, 1e3]),
            window_ahead: bytes.optional([5.0, 40.0], [1e-3, 1e6]),
            grid_spacing: bytes.optional([0.01, 1.0], [1e-4, 1e3]),
        }
    }
}

impl Subject for Pop {
    type Params = PopParams;

    fn draw(bytes: &mut Bytes) -> PopParams {
        let (aim, search) = (Aim::draw(bytes), Search::draw(bytes));
        PopParams {
            lookahead_gain: aim.lookahead_gain,
            min_lookahead: aim.min_lookahead,
            exact_lookahead: aim.exact_lookahead,
            lookahead_tolerance: aim.lookahead_tolerance,
            window_ahead: aim.window_ahead,
            grid_spacing: aim.grid_spacing,
            steer_span: bytes.parameter(0.05, [0.01, 0.5], [1e-6, PI]),
            candidate_count: match bytes.byte() {
                0..=199 => 21,
                200..=249 => 2 * bytes.below(31) + 1,
                250 => 501,
                251 => 20,
                252 => 0,
                253 => 100_003,
                _ => usize::MAX,
            },
            search_distance: search.search_distance,
            lost_distance: search.lost_distance,
        }
    }

    fn make(vehicle: &Vehicle, params: PopParams) -> Result<Self, ConfigError> {
        Self::new(*vehicle, params)
    }

    fn previous_steer(state: &PopState) -> Option<f64> {
        Some(state.previous_steer)
    }

    fn draw_state(bytes: &mut Bytes) -> Option<PopState> {
        Some(PopState {
            previous_steer: bytes.number([-1.0, 1.0], [-1.57, 1.57]),
        })
    }
}

impl Subject for PurePursuit {
    type Params = PurePursuitParams;

    fn draw(bytes: &mut Bytes) -> PurePursuitParams {
        let (aim, search) = (Aim::draw(bytes), Search::draw(bytes));
        PurePursuitParams {
            lookahead_gain: aim.lookahead_gain,
            min_lookahead: aim.min_lookahead,
            exact_lookahead: aim.exact_lookahead,
            alpha_by_arccos: bytes.byte() & 1 == 1,
            lookahead_tolerance: aim.lookahead_tolerance,
            window_ahead: aim.window_ahead,
            grid_spacing: aim.grid_spacing,
            search_distance: search.search_distance,
            lost_distance: search.lost_distance,
        }
    }

    fn make(vehicle: &Vehicle, params: PurePursuitParams) -> Result<Self, ConfigError> {
        Self::new(*vehicle, params)
    }

    fn draw_state(bytes: &mut Bytes) -> Option<PurePursuitState> {
        Some(PurePursuitState {
            previous_alpha: bytes.number([-1.0, 1.0], [-PI, PI]),
        })
    }
}
