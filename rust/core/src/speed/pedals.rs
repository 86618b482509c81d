//! Throttle and brake.

use crate::math::saturate;

/// Throttle and brake, each in 0 to 1; never both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pedals {
    /// Throttle, 0 to 1.
    pub throttle: f64,
    /// Brake, 0 to 1.
    pub brake: f64,
}

impl Pedals {
    /// Throttle where `command` is positive, brake where it is negative.
    #[inline]
    pub fn from_command(command: f64) -> Self {
        Self {
            throttle: saturate(command, 0.0, 1.0),
            brake: saturate(-command, 0.0, 1.0),
        }
    }
}
