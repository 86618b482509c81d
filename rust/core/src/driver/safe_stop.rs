//! The stop that follows from a fault: what steers, and how hard it brakes.
//!
//! What a fault blames is no longer believed; the rest is, and the vehicle stops by it.
//!
//! | fault | steered by | braked |
//! |---|---|---|
//! | position | the expected position, by speed, heading and wheels | in comfort |
//! | heading | the expected heading, by speed and wheels | in comfort |
//! | speed | the speed by the poses | in comfort |
//! | input | the expected vehicle | in comfort |
//! | steering | straight wheels | as hard as the brakes can |
//! | deviation, path, cannot-stop | the controller | as hard as the brakes can |
//!
//! A vehicle that is believed to be at rest is held, until [`release`](super::Driver::release).

use crate::vehicle::Fault;

impl Fault {
    /// Whether it is safe to follow the path on while braking; else the wheels are set straight.
    pub(super) fn steers(self) -> bool {
        self != Self::Steering
    }

    /// Whether the vehicle leaves its path, or has: it is to brake with all that its brakes can do.
    pub(super) fn is_urgent(self) -> bool {
        !matches!(
            self,
            Self::Position | Self::Heading | Self::Speed | Self::Input
        )
    }
}
