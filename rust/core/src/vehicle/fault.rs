//! Which signal or actuator is not believed.
//!
//! A fault shows in the residuals that its signal is part of, so the set of residuals that are beyond
//! their noise names it (structured residuals: J. Gertler, *Fault Detection and Diagnosis in
//! Engineering Systems*, 1998, chapter 6):
//!
//! | residual                                   | position | heading | speed | steering |
//! |--------------------------------------------|----------|---------|-------|----------|
//! | distance between poses - distance by speed | x        |         | x     |          |
//! | direction between poses - heading          | x        | x       |       |          |
//! | turn of the heading - turn by the wheels   |          | x       | (x)   | x        |

use core::fmt;

/// A signal or an actuator that is not believed. The first of several is the one to act by: without
/// a position nothing that follows a path is believed, without the steering no path is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Fault {
    /// The position: it repeats, jumps about, or moves otherwise than everything else says.
    Position,
    /// The heading: it turns otherwise than the position and the wheels.
    Heading,
    /// The speed: the distance between poses is another one.
    Speed,
    /// The steering: the vehicle turns otherwise than commanded.
    Steering,
}

impl Fault {
    /// Its name in status texts and diagnostics.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Heading => "heading",
            Self::Speed => "speed",
            Self::Steering => "steering",
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
