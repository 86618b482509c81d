//! The laws as the fuzzer sees them: parameters and states out of bytes.

use crate::bytes::Bytes;
use popsteer_core::lateral::pid::ErrorBuffer;
use popsteer_core::lateral::{
    BangBang, BangBangParams, BangBangState, Pid, PidParams, PidState, Pop, PopParams, PopState,
    PurePursuit, PurePursuitParams, PurePursuitState, Stanley, StanleyParams, StanleyState,
};
use popsteer_core::{ConfigError, LateralLaw};
use std::f64::consts::PI;

/// A law and the limit that it was given.
pub(crate) type Drawn<L> = Result<(L, f64), ConfigError>;

/// What a life needs of a law beside its own trait.
pub(crate) trait Subject: LateralLaw {
    /// A law of parameters that may or may not do.
    fn draw(bytes: &mut Bytes) -> Drawn<Self>
    where
        Self: Sized;

    /// A state that the law may or may not have.
    fn draw_state(bytes: &mut Bytes) -> Option<Self::State>;

    /// Whether two states are one.
    fn same(a: &Self::State, b: &Self::State) -> bool {
        a == b
    }
}

fn waypoint(bytes: &mut Bytes) -> Option<usize> {
    match bytes.byte() {
        0..=99 => None,
        255 => Some(usize::MAX),
        _ => Some(bytes.below(32)),
    }
}

/// Wheelbase, reference offset and steering limit.
fn body(bytes: &mut Bytes) -> (f64, Option<f64>, f64) {
    let wheelbase = bytes.parameter(3.0, [1.0, 4.0], [1e-3, 1e3]);
    let offset = (bytes.byte() > 200).then(|| bytes.number([-3.0, 4.0], [-1e3, 1e3]));
    let max_steer = bytes.parameter(1.22, [0.3, 1.3], [1e-3, 1.57]);
    (wheelbase, offset, max_steer)
}

/// Gain, least lookahead, tolerance, window and grid of the search.
fn search(bytes: &mut Bytes) -> [f64; 5] {
    [
        bytes.parameter(0.2, [0.0, 1.0], [0.0, 1e3]),
        bytes.parameter(6.0, [0.0, 12.0], [0.0, 1e4]),
        bytes.parameter(0.01, [0.005, 0.5], [1e-9, 1e3]),
        bytes.parameter(20.0, [5.0, 40.0], [1e-3, 1e6]),
        bytes.parameter(0.01, [0.01, 1.0], [1e-4, 1e3]),
    ]
}

fn gain(bytes: &mut Bytes, default: f64) -> f64 {
    bytes.parameter(default, [0.0, 2.0], [0.0, 1e6])
}

impl Subject for Pop {
    fn draw(bytes: &mut Bytes) -> Drawn<Self> {
        let [
            lookahead_gain,
            min_lookahead,
            lookahead_tolerance,
            window_ahead,
            grid_spacing,
        ] = search(bytes);
        let (wheelbase, reference_offset, max_steer) = body(bytes);
        let law = Self::new(PopParams {
            lookahead_gain,
            min_lookahead,
            lookahead_tolerance,
            window_ahead,
            grid_spacing,
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
            wheelbase,
            reference_offset,
            max_steer,
        })?;
        Ok((law, max_steer))
    }

    fn draw_state(bytes: &mut Bytes) -> Option<PopState> {
        Some(PopState {
            waypoint: waypoint(bytes),
            previous_steer: bytes.number([-1.0, 1.0], [-1.57, 1.57]),
        })
    }
}

impl Subject for PurePursuit {
    fn draw(bytes: &mut Bytes) -> Drawn<Self> {
        let [
            lookahead_gain,
            min_lookahead,
            lookahead_tolerance,
            window_ahead,
            grid_spacing,
        ] = search(bytes);
        let (wheelbase, reference_offset, max_steer) = body(bytes);
        let law = Self::new(PurePursuitParams {
            lookahead_gain,
            min_lookahead,
            alpha_by_arccos: bytes.byte() & 1 == 1,
            lookahead_tolerance,
            window_ahead,
            grid_spacing,
            wheelbase,
            reference_offset,
            max_steer,
        })?;
        Ok((law, max_steer))
    }

    fn draw_state(bytes: &mut Bytes) -> Option<PurePursuitState> {
        Some(PurePursuitState {
            waypoint: waypoint(bytes),
            previous_alpha: bytes.number([-1.0, 1.0], [-PI, PI]),
        })
    }
}

impl Subject for Stanley {
    fn draw(bytes: &mut Bytes) -> Drawn<Self> {
        let (wheelbase, reference_offset, max_steer) = body(bytes);
        let law = Self::new(StanleyParams {
            cross_track_gain: gain(bytes, 1.5),
            speed_gain: gain(bytes, 1.3),
            softening: bytes.parameter(1e-5, [1e-5, 1.0], [1e-9, 1e6]),
            heading_behind: bytes.byte() & 1 == 1,
            wheelbase,
            reference_offset,
            max_steer,
        })?;
        Ok((law, max_steer))
    }

    fn draw_state(bytes: &mut Bytes) -> Option<StanleyState> {
        Some(StanleyState {
            waypoint: waypoint(bytes),
        })
    }
}

impl Subject for BangBang {
    fn draw(bytes: &mut Bytes) -> Drawn<Self> {
        let (wheelbase, reference_offset, max_steer) = body(bytes);
        let law = Self::new(BangBangParams {
            amplitude: bytes.parameter(0.122, [0.0, 1.0], [0.0, 1.57]),
            deadband: bytes.parameter(0.0, [0.0, 1.0], [0.0, 1e6]),
            wheelbase,
            reference_offset,
            max_steer,
        })?;
        Ok((law, max_steer))
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
        let (wheelbase, reference_offset, max_steer) = body(bytes);
        let law = Self::new(PidParams {
            kp: gain(bytes, 0.25),
            ki: gain(bytes, 0.01),
            kd: gain(bytes, 0.2),
            buffer_length: buffer_length(bytes),
            integral_with_dt: bytes.byte() & 1 == 0,
            wheelbase,
            reference_offset,
            max_steer,
        })?;
        Ok((law, max_steer))
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
