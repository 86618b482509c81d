//! Preview POP.

use super::{Search, Subject};
use crate::bytes::Bytes;
use popsteer_core::laws::{PreviewPop, PreviewPopParams, PreviewPopState};
use popsteer_core::{ConfigError, Vehicle};
use std::f64::consts::FRAC_PI_2;

impl Subject for PreviewPop {
    /// Where the direction may change, arc lengths ahead are taken from that place, and round
    /// otherwise.
    const MIRRORED: bool = false;

    type Params = PreviewPopParams;

    fn draw(bytes: &mut Bytes) -> PreviewPopParams {
        let search = Search::draw(bytes);
        let mut params = PreviewPopParams::DEFAULT;
        params.steer_span_rate = bytes.optional([0.1, 3.0], [1e-3, 1e6]);
        params.horizon = bytes.parameter(1.0, [0.1, 3.0], [0.05, 100.0]);
        params.heading_cost = bytes.optional([0.0, 10.0], [0.0, 1e3]);
        params.steer_rate_cost = bytes.optional([0.01, 2.0], [1e-5, 1e3]);
        params.approach_angle = bytes.parameter(0.25, [0.05, 1.0], [1e-3, FRAC_PI_2]);
        params.min_speed = bytes.optional([0.5, 8.0], [1e-3, 1e4]);
        params.smoothing_length = bytes.optional([0.0, 6.0], [0.0, 1e3]);
        params.search_distance = search.search_distance;
        params.lost_distance = search.lost_distance;
        params
    }

    fn make(vehicle: &Vehicle, params: PreviewPopParams) -> Result<Self, ConfigError> {
        Self::new(*vehicle, params)
    }

    fn previous_steer(state: &PreviewPopState) -> Option<f64> {
        Some(state.previous_steer)
    }

    fn draw_state(bytes: &mut Bytes) -> Option<PreviewPopState> {
        Some(PreviewPopState {
            previous_steer: bytes.number([-1.0, 1.0], [-1.57, 1.57]),
            reached_limits: bytes.hostile().to_bits(),
        })
    }
}
