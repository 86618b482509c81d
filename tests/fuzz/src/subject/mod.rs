//! The laws as the fuzzer sees them: parameters and states out of bytes.

mod aiming;
mod beside;
mod preview;

use crate::bytes::Bytes;
use popsteer_core::{ConfigError, LateralLaw, Vehicle};

/// What a life needs of a law beside its own trait.
pub(crate) trait Subject: LateralLaw + Sized {
    /// Whether the angles backwards are those forwards to the last bit.
    const MIRRORED: bool = true;

    /// The law's parameters.
    type Params: Copy;

    /// Parameters that may or may not do.
    fn draw(bytes: &mut Bytes) -> Self::Params;

    /// The law with these parameters, for a vehicle.
    fn make(vehicle: &Vehicle, params: Self::Params) -> Result<Self, ConfigError>;

    /// A state that the law may or may not have.
    fn draw_state(bytes: &mut Bytes) -> Option<Self::State>;

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

/// How far around its last place a vehicle is looked for, and from where on it is lost.
struct Search {
    search_distance: Option<f64>,
    lost_distance: Option<f64>,
}

impl Search {
    fn draw(bytes: &mut Bytes) -> Self {
        Self {
            search_distance: (bytes.byte() > 200).then(|| bytes.number([0.0, 20.0], [0.0, 1e6])),
            lost_distance: (bytes.byte() > 200).then(|| bytes.number([1.0, 40.0], [1e-3, 1e9])),
        }
    }
}

fn gain(bytes: &mut Bytes, default: f64) -> f64 {
    bytes.parameter(default, [0.0, 2.0], [0.0, 1e6])
}

/// A gain whose default goes with the vehicle.
fn scaled_gain(bytes: &mut Bytes) -> Option<f64> {
    bytes.optional([0.0, 2.0], [0.0, 1e6])
}
