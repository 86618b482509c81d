//! Preview POP.

use super::{Body, Drawn, Subject, waypoint};
use crate::bytes::Bytes;
use popsteer_core::lateral::{PreviewPop, PreviewPopParams, PreviewPopState};
use popsteer_core::path::view::MAX_COORDINATE;
use popsteer_core::vehicle::state::MAX_YAW;
use std::f64::consts::{FRAC_PI_2, PI};

impl Subject for PreviewPop {
    /// Where the direction may change, arc lengths ahead are taken from that place, and round
    /// otherwise.
    const MIRRORED: bool = false;

    fn draw(bytes: &mut Bytes) -> Drawn<Self> {
        let standard = PreviewPopParams::DEFAULT;
        let mut learning_time = || {
            if bytes.byte() < 128 {
                0.0
            } else {
                bytes.number([0.05, 5.0], [0.0, 1e6])
            }
        };
        let (turn_learning_time, slip_learning_time) = (learning_time(), learning_time());
        let body = Body::draw(bytes);
        let law = Self::new(PreviewPopParams {
            steer_span: bytes.parameter(standard.steer_span, [0.01, 0.5], [1e-6, PI]),
            max_steer_rate: bytes.parameter(standard.max_steer_rate, [0.1, 3.0], [1e-3, 1e3]),
            max_lateral_acceleration: bytes.parameter(15.0, [1.0, 20.0], [1e-3, 1e6]),
            horizon: bytes.parameter(1.0, [0.1, 3.0], [0.05, 100.0]),
            heading_cost: bytes.parameter(3.0, [0.0, 10.0], [0.0, 1e3]),
            steer_rate_cost: bytes.parameter(0.25, [0.01, 2.0], [1e-3, 1e3]),
            approach_angle: bytes.parameter(0.25, [0.05, 1.0], [1e-3, FRAC_PI_2]),
            min_speed: bytes.parameter(5.0, [0.5, 8.0], [0.1, 1e3]),
            smoothing_length: bytes.parameter(2.0, [0.0, 6.0], [0.0, 1e3]),
            turn_learning_time,
            slip_learning_time,
            understeer: bytes.parameter(0.0, [0.0, 0.01], [0.0, 1e3]),
            steer_lag: bytes.parameter(0.1, [0.0, 0.5], [0.0, 10.0]),
            wheelbase: body.wheelbase,
            reference_offset: body.reference_offset,
            max_steer: body.max_steer,
            search_distance: body.search_distance,
            lost_distance: body.lost_distance,
        })?;
        Ok((law, body.max_steer))
    }

    fn waypoint(state: &PreviewPopState) -> Option<usize> {
        state.waypoint
    }

    fn previous_steer(state: &PreviewPopState) -> Option<f64> {
        Some(state.previous_steer)
    }

    fn draw_state(bytes: &mut Bytes) -> Option<PreviewPopState> {
        let coordinates = [-MAX_COORDINATE, MAX_COORDINATE];
        Some(PreviewPopState {
            waypoint: waypoint(bytes),
            previous_steer: bytes.number([-1.0, 1.0], [-1.57, 1.57]),
            curvature: bytes.number([-0.3, 0.3], [-1e7, 1e7]),
            previous_x: bytes.number([-20.0, 20.0], coordinates),
            previous_y: bytes.number([-20.0, 20.0], coordinates),
            previous_yaw: bytes.number([-4.0, 4.0], [-MAX_YAW - PI, MAX_YAW + PI]),
            travel: bytes.number([0.0, 1.0], [0.0, 1e7]),
            turn: bytes.number([-0.1, 0.1], [-1e15, 1e15]),
            turn_offset: bytes.number([-0.05, 0.05], [-0.05, 0.05]),
            slip: bytes.number([-0.15, 0.15], [-0.15, 0.15]),
            slip_length: bytes.number([-3.0, 3.0], [-1e3, 1e3]),
        })
    }
}
