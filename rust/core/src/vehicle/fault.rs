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
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Fault {
    /// The position: it repeats, jumps about, or moves otherwise than everything else says.
    Position,
    /// The heading: it turns otherwise than the position and the wheels.
    Heading,
    /// The speed: the distance between poses is another one.
    Speed,
    /// The steering: the vehicle turns otherwise than commanded.
    Steering,
    /// Inputs that do not come, or cannot be used.
    Input,
    /// The vehicle is farther from its path than its limit, once it was within.
    Deviation,
    /// The path: none, or one that is not where the vehicle is.
    Path,
    /// It overruns its stop, however hard it brakes.
    CannotStop,
}

impl Fault {
    /// Every fault, the first to act by first.
    pub const ALL: [Self; 8] = [
        Self::Position,
        Self::Heading,
        Self::Speed,
        Self::Steering,
        Self::Input,
        Self::Deviation,
        Self::Path,
        Self::CannotStop,
    ];

    /// Its name in status texts and diagnostics.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Heading => "heading",
            Self::Speed => "speed",
            Self::Steering => "steering",
            Self::Input => "input",
            Self::Deviation => "deviation",
            Self::Path => "path",
            Self::CannotStop => "cannot-stop",
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
