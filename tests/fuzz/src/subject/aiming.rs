//! The laws that aim at a point ahead.

use super::{Body, Drawn, Subject, waypoint};
use crate::bytes::Bytes;
use popsteer_core::lateral::{
    Pop, PopParams, PopState, PurePursuit, PurePursuitParams, PurePursuitState,
};
use std::f64::consts::PI;

/// The parameters of the search for that point.
struct Search {
    lookahead_gain: f64,
    min_lookahead: f64,
    exact_lookahead: bool,
    lookahead_tolerance: f64,
    window_ahead: f64,
    grid_spacing: f64,
}

impl Search {
    fn draw(bytes: &mut Bytes) -> Self {
        Self {
            lookahead_gain: bytes.parameter(0.2, [0.0, 1.0], [0.0, 1e3]),
            min_lookahead: bytes.parameter(6.0, [0.0, 12.0], [0.0, 1e4]),
            exact_lookahead: bytes.byte() & 1 == 0,
            lookahead_tolerance: bytes.parameter(0.01, [0.005, 0.5], [1e-9, 1e3]),
            window_ahead: bytes.parameter(20.0, [5.0, 40.0], [1e-3, 1e6]),
            grid_spacing: bytes.parameter(0.01, [0.01, 1.0], [1e-4, 1e3]),
        }
    }
}

impl Subject for Pop {
    fn draw(bytes: &mut Bytes) -> Drawn<Self> {
        let search = Search::draw(bytes);
        let body = Body::draw(bytes);
        let law = Self::new(PopParams {
            lookahead_gain: search.lookahead_gain,
            min_lookahead: search.min_lookahead,
            exact_lookahead: search.exact_lookahead,
            lookahead_tolerance: search.lookahead_tolerance,
            window_ahead: search.window_ahead,
            grid_spacing: search.grid_spacing,
            horizon: (bytes.byte() > 200).then(|| bytes.number([0.1, 2.0], [1e-3, 100.0])),
            understeer: bytes.parameter(0.0, [0.0, 0.01], [0.0, 1e3]),
            steer_lag: bytes.parameter(0.1, [0.0, 0.5], [0.0, 10.0]),
            steer_span: bytes.parameter(0.05, [0.01, 0.5], [1e-6, PI]),
            candidate_count: match bytes.byte() {
                0..=199 => 21,
                200..=249 => 2 * bytes.below(31) + 1,
                250 => 501,
                251 => 20,
                252 => 0,
                253 => Self::MAX_CANDIDATES + 2,
                _ => usize::MAX,
            },
            wheelbase: body.wheelbase,
            reference_offset: body.reference_offset,
            max_steer: body.max_steer,
            search_distance: body.search_distance,
            lost_distance: body.lost_distance,
        })?;
        Ok((law, body.max_steer))
    }

    fn waypoint(state: &PopState) -> Option<usize> {
        state.waypoint
    }

    fn previous_steer(state: &PopState) -> Option<f64> {
        Some(state.previous_steer)
    }

    fn draw_state(bytes: &mut Bytes) -> Option<PopState> {
        Some(PopState {
            waypoint: waypoint(bytes),
            previous_steer: bytes.number([-1.0, 1.0], [-1.57, 1.57]),
            model_steer: bytes.number([-1.0, 1.0], [-1.57, 1.57]),
        })
    }
}

impl Subject for PurePursuit {
    fn draw(bytes: &mut Bytes) -> Drawn<Self> {
        let search = Search::draw(bytes);
        let body = Body::draw(bytes);
        let law = Self::new(PurePursuitParams {
            lookahead_gain: search.lookahead_gain,
            min_lookahead: search.min_lookahead,
            exact_lookahead: search.exact_lookahead,
            alpha_by_arccos: bytes.byte() & 1 == 1,
            lookahead_tolerance: search.lookahead_tolerance,
            window_ahead: search.window_ahead,
            grid_spacing: search.grid_spacing,
            wheelbase: body.wheelbase,
            reference_offset: body.reference_offset,
            max_steer: body.max_steer,
            search_distance: body.search_distance,
            lost_distance: body.lost_distance,
        })?;
        Ok((law, body.max_steer))
    }

    fn waypoint(state: &PurePursuitState) -> Option<usize> {
        state.waypoint
    }

    fn draw_state(bytes: &mut Bytes) -> Option<PurePursuitState> {
        Some(PurePursuitState {
            waypoint: waypoint(bytes),
            previous_alpha: bytes.number([-1.0, 1.0], [-PI, PI]),
        })
    }
}
