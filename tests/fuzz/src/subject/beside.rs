//! The laws that steer by what is beside the vehicle.

use super::{Search, Subject, gain, scaled_gain};
use crate::bytes::Bytes;
use popsteer_core::laws::pid::error_buffer::ErrorBuffer;
use popsteer_core::laws::{Pid, PidParams, PidState, Stanley, StanleyParams, StanleyState};
use popsteer_core::{ConfigError, Point, Vehicle};

impl Subject for Stanley {
    type Params = StanleyParams;

    fn draw(bytes: &mut Bytes) -> StanleyParams {
        let search = Search::draw(bytes);
        StanleyParams {
            cross_track_gain: gain(bytes, 1.5),
            speed_gain: gain(bytes, 1.3),
            softening: bytes.optional([1e-5, 1.0], [1e-9, 1e6]),
            heading_behind: bytes.byte() & 1 == 1,
            smoothing_length: bytes.optional([0.0, 6.0], [0.0, 1e4]),
            search_distance: search.search_distance,
            lost_distance: search.lost_distance,
        }
    }

    fn make(vehicle: &Vehicle, params: StanleyParams) -> Result<Self, ConfigError> {
        Self::new(*vehicle, params)
    }

    fn draw_state(_bytes: &mut Bytes) -> Option<StanleyState> {
        Some(StanleyState {})
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
    type Params = PidParams;

    fn draw(bytes: &mut Bytes) -> PidParams {
        let search = Search::draw(bytes);
        PidParams {
            kp: scaled_gain(bytes),
            ki: scaled_gain(bytes),
            kd: scaled_gain(bytes),
            buffer_length: buffer_length(bytes),
            integral_with_dt: bytes.byte() & 1 == 0,
            smoothing_length: bytes.optional([0.0, 6.0], [0.0, 1e4]),
            search_distance: search.search_distance,
            lost_distance: search.lost_distance,
            derivative_filter: bytes.number([0.0, 0.5], [0.0, 1e3]),
        }
    }

    fn make(vehicle: &Vehicle, params: PidParams) -> Result<Self, ConfigError> {
        Self::new(*vehicle, params)
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
            previous_error: (bytes.byte() & 1 == 0).then(|| bytes.number([-5.0, 5.0], whole)),
            previous_position: (bytes.byte() & 1 == 0).then(|| {
                let mut coordinate = || bytes.number([-50.0, 50.0], [-5e9, 5e9]);
                Point::new(coordinate(), coordinate())
            }),
            buffer: buffer.ok()?,
            rate: bytes.number([-5.0, 5.0], whole),
        })
    }

    /// Without the room of the buffer that is not in use.
    fn same(a: &PidState, b: &PidState) -> bool {
        let rest = |state: &PidState| {
            let buffer = &state.buffer;
            (
                state.previous_error,
                state.previous_position,
                state.rate.to_bits(),
                buffer.length(),
                buffer.next(),
                buffer.sum().to_bits(),
            )
        };
        rest(a) == rest(b) && a.buffer.terms().eq(b.buffer.terms())
    }
}
