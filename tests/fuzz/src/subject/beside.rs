//! The laws that steer by what is beside the vehicle.

use super::{Body, Drawn, Subject, gain, waypoint};
use crate::bytes::Bytes;
use popsteer_core::lateral::pid::ErrorBuffer;
use popsteer_core::lateral::{
    BangBang, BangBangParams, BangBangState, Pid, PidParams, PidState, Stanley, StanleyParams,
    StanleyState,
};

impl Subject for Stanley {
    fn draw(bytes: &mut Bytes) -> Drawn<Self> {
        let body = Body::draw(bytes);
        let law = Self::new(StanleyParams {
            cross_track_gain: gain(bytes, 1.5),
            speed_gain: gain(bytes, 1.3),
            softening: bytes.parameter(1e-5, [1e-5, 1.0], [1e-9, 1e6]),
            heading_behind: bytes.byte() & 1 == 1,
            wheelbase: body.wheelbase,
            reference_offset: body.reference_offset,
            max_steer: body.max_steer,
            search_distance: body.search_distance,
            lost_distance: body.lost_distance,
        })?;
        Ok((law, body.max_steer))
    }

    fn waypoint(state: &StanleyState) -> Option<usize> {
        state.waypoint
    }

    fn draw_state(bytes: &mut Bytes) -> Option<StanleyState> {
        Some(StanleyState {
            waypoint: waypoint(bytes),
        })
    }
}

impl Subject for BangBang {
    fn draw(bytes: &mut Bytes) -> Drawn<Self> {
        let body = Body::draw(bytes);
        let law = Self::new(BangBangParams {
            amplitude: bytes.parameter(0.122, [0.0, 1.0], [0.0, 1.57]),
            deadband: bytes.parameter(0.0, [0.0, 1.0], [0.0, 1e6]),
            wheelbase: body.wheelbase,
            reference_offset: body.reference_offset,
            max_steer: body.max_steer,
            search_distance: body.search_distance,
            lost_distance: body.lost_distance,
        })?;
        Ok((law, body.max_steer))
    }

    fn waypoint(state: &BangBangState) -> Option<usize> {
        state.waypoint
    }

    fn draw_state(bytes: &mut Bytes) -> Option<BangBangState> {
        Some(BangBangState {
            waypoint: waypoint(bytes),
        })
    }
}

/// The length of most buffers: short, so that they come round within a life.
const BUFFER_LENGTH: usize = 4;

fn buffer_length(bytes: &mut Bytes) -> usize {
    match bytes.byte() {
        0..=149 => BUFFER_LENGTH,
        150..=249 => bytes.below(9),
        250 => ErrorBuffer::CAPACITY,
        251 => ErrorBuffer::CAPACITY + 1,
        252 => usize::MAX,
        _ => 500,
    }
}

impl Subject for Pid {
    fn draw(bytes: &mut Bytes) -> Drawn<Self> {
        let body = Body::draw(bytes);
        let law = Self::new(PidParams {
            kp: gain(bytes, 0.25),
            ki: gain(bytes, 0.01),
            kd: gain(bytes, 0.2),
            buffer_length: buffer_length(bytes),
            integral_with_dt: bytes.byte() & 1 == 0,
            wheelbase: body.wheelbase,
            reference_offset: body.reference_offset,
            max_steer: body.max_steer,
            search_distance: body.search_distance,
            lost_distance: body.lost_distance,
        })?;
        Ok((law, body.max_steer))
    }

    fn waypoint(state: &PidState) -> Option<usize> {
        state.waypoint
    }

    fn draw_state(bytes: &mut Bytes) -> Option<PidState> {
        let whole = [-1e16, 1e16];
        let length = buffer_length(bytes);
        let terms: Vec<f64> = (0..bytes.below(9))
            .map(|_| bytes.number([-5.0, 5.0], whole))
            .collect();
        let buffer = ErrorBuffer::restore(
            length,
            &terms,
            bytes.below(9),
            bytes.number([-5.0, 5.0], whole),
        );
        Some(PidState {
            waypoint: waypoint(bytes),
            previous_error: (bytes.byte() & 1 == 0).then(|| bytes.number([-5.0, 5.0], whole)),
            buffer: buffer.ok()?,
        })
    }

    /// Without the room of the buffer that is not in use.
    fn same(a: &PidState, b: &PidState) -> bool {
        let rest = |state: &PidState| {
            let buffer = &state.buffer;
            (
                state.waypoint,
                state.previous_error,
                buffer.length(),
                buffer.next(),
                buffer.sum().to_bits(),
            )
        };
        rest(a) == rest(b) && a.buffer.terms().eq(b.buffer.terms())
    }
}
