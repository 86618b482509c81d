//! The laws as the fuzzer sees them: parameters and states out of bytes.

mod aiming;
mod beside;
mod preview;

use crate::bytes::Bytes;
use popsteer_core::{ConfigError, LateralLaw};

/// A law and the limit that it was given.
pub(crate) type Drawn<L> = Result<(L, f64), ConfigError>;

/// What a life needs of a law beside its own trait.
pub(crate) trait Subject: LateralLaw {
    /// Whether the angles backwards are those forwards to the last bit.
    const MIRRORED: bool = true;

    /// A law of parameters that may or may not do.
    fn draw(bytes: &mut Bytes) -> Drawn<Self>
    where
        Self: Sized;

    /// A state that the law may or may not have.
    fn draw_state(bytes: &mut Bytes) -> Option<Self::State>;

    /// The waypoint that a state remembers.
    fn waypoint(state: &Self::State) -> Option<usize>;

    /// The angle that the law goes on from, where it looks in the neighbourhood of the last one.
    fn previous_steer(_state: &Self::State) -> Option<f64> {
        None
    }

    /// Whether two states are one.
    fn same(a: &Self::State, b: &Self::State) -> bool {
        a == b
    }
}

/// A waypoint that a path may or may not have.
pub(crate) fn waypoint(bytes: &mut Bytes) -> Option<usize> {
    match bytes.byte() {
        0..=99 => None,
        255 => Some(usize::MAX),
        _ => Some(bytes.below(32)),
    }
}

/// The parameters that every law has.
struct Body {
    wheelbase: f64,
    reference_offset: Option<f64>,
    max_steer: f64,
    search_distance: Option<f64>,
    lost_distance: Option<f64>,
}

impl Body {
    fn draw(bytes: &mut Bytes) -> Self {
        Self {
            wheelbase: bytes.parameter(3.0, [1.0, 4.0], [1e-3, 1e3]),
            reference_offset: (bytes.byte() > 200).then(|| bytes.number([-3.0, 4.0], [-1e3, 1e3])),
            max_steer: bytes.parameter(1.22, [0.3, 1.3], [1e-3, 1.57]),
            search_distance: (bytes.byte() > 200).then(|| bytes.number([0.0, 20.0], [0.0, 1e6])),
            lost_distance: (bytes.byte() > 200).then(|| bytes.number([1.0, 40.0], [1e-3, 1e9])),
        }
    }
}

fn gain(bytes: &mut Bytes, default: f64) -> f64 {
    bytes.parameter(default, [0.0, 2.0], [0.0, 1e6])
}
