//! What is refused, and why: small `Copy` values that name the field and carry the value.

use core::fmt;

/// What a value has to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Requirement {
    /// A finite number from the first bound to the second, both included.
    InRange(f64, f64),
    /// A count from the first bound to the second.
    CountInRange(usize, usize),
    /// An odd count from the first bound to the second.
    OddInRange(usize, usize),
    /// A whole number below this count.
    Below(usize),
}

impl fmt::Display for Requirement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::InRange(low, high) => write!(f, "in [{low:?}, {high:?}]"),
            Self::CountInRange(low, high) => write!(f, "a count in [{low}, {high}]"),
            Self::OddInRange(low, high) => write!(f, "odd and in [{low}, {high}]"),
            Self::Below(count) => write!(f, "below {count}"),
        }
    }
}

macro_rules! refusal {
    ($(#[$doc:meta])* $error:ident, $check:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $error {
            /// The name of the parameter or of the argument.
            pub field: &'static str,
            /// Its value.
            pub value: f64,
            /// What it has to be.
            pub requirement: Requirement,
        }

        impl fmt::Display for $error {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let Self { field, value, requirement } = self;
                write!(f, "{field} must be {requirement}, got {value:?}")
            }
        }

        impl core::error::Error for $error {}

        /// `value`, or the error that names it where it is not in `[low, high]`.
        ///
        /// # Errors
        ///
        #[doc = concat!("[`", stringify!($error), "`].")]
        #[inline]
        pub fn $check(field: &'static str, value: f64, low: f64, high: f64) -> Result<f64, $error> {
            if in_range(value, low, high) {
                Ok(value)
            } else {
                let requirement = Requirement::InRange(low, high);
                Err($error { field, value, requirement })
            }
        }
    };
}

refusal! {
    /// A parameter that a constructor refuses.
    ConfigError, config_in_range
}
refusal! {
    /// An input of a step, or a state to restore, that is refused. The controller's state is
    /// unchanged.
    InputError, input_in_range
}

/// `value` where it lies within `most` either way, as [`input_in_range`].
#[inline]
pub(crate) fn input_within(field: &'static str, value: f64, most: f64) -> Result<f64, InputError> {
    input_in_range(field, value, -most, most)
}

/// Waypoints that do not make a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathError {
    /// Fewer than two waypoints (three for a closed path).
    TooFewWaypoints {
        /// How many were given.
        count: usize,
        /// How many are needed.
        least: usize,
    },
    /// `x`, `y`, `speed`, `grade` or the room for arc lengths differ in length.
    LengthMismatch {
        /// The odd one out.
        field: &'static str,
        /// Its length.
        length: usize,
        /// The number of waypoints.
        waypoints: usize,
    },
    /// A coordinate, a reference speed or a slope that is not a number or beyond its bound.
    OutOfRange {
        /// `x`, `y`, `speed` or `grade`.
        field: &'static str,
        /// The index of the waypoint.
        index: usize,
        /// The value.
        value: f64,
        /// The bounds.
        requirement: Requirement,
    },
    /// A heading or a curvature that the waypoints do not bear out.
    Contradicting {
        /// `yaw` or `curvature`.
        field: &'static str,
        /// The index of the waypoint.
        index: usize,
        /// The value.
        value: f64,
        /// About what the waypoints say.
        expected: f64,
    },
    /// Two neighbours at one place: the path has no direction there.
    Coinciding {
        /// The index of the first of the two waypoints.
        index: usize,
        /// The index of the second: 0 where a closed path repeats its start.
        next: usize,
    },
    /// A path that turns back on itself, though nothing says that it is driven backwards.
    Fold {
        /// The index of the waypoint at which it does.
        index: usize,
    },
    /// Two neighbours far farther apart than the others, where the path turns.
    Gap {
        /// The index of the first of the two waypoints.
        index: usize,
        /// The index of the second.
        next: usize,
        /// How far apart they are [m].
        length: f64,
        /// How far the others are [m].
        spacing: f64,
    },
    /// Waypoints that are not in the order in which they are driven.
    Unordered {
        /// At how many of them the path turns back.
        folds: usize,
        /// How many there are.
        waypoints: usize,
    },
    /// A grid over a window of the path that would not fit into memory.
    GridTooLarge {
        /// How many points it would have.
        points: usize,
        /// How many are made at most.
        most: usize,
    },
}

impl fmt::Display for PathError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewWaypoints { count, least } => {
                write!(f, "a path needs at least {least} waypoints, got {count}")
            }
            Self::LengthMismatch {
                field,
                length,
                waypoints,
            } => {
                write!(f, "{field} has {length} entries for {waypoints} waypoints")
            }
            Self::OutOfRange {
                field,
                index,
                value,
                requirement,
            } => {
                write!(
                    f,
                    "{field} of waypoint {index} must be {requirement}, got {value:?}"
                )
            }
            Self::Contradicting {
                field,
                index,
                value,
                expected,
            } => {
                write!(
                    f,
                    "{field} of waypoint {index} is {value:?}, but by the waypoints it is about \
                     {expected:.3}"
                )
            }
            Self::Coinciding { index, next } => {
                write!(f, "waypoints {index} and {next} coincide")
            }
            Self::Fold { .. } | Self::Gap { .. } | Self::Unordered { .. } => self.unsound(f),
            Self::GridTooLarge { points, most } => {
                write!(f, "the grid would have {points} points, more than {most}")
            }
        }
    }
}

impl PathError {
    /// What is wrong with waypoints that are no path, and the remedy.
    fn unsound(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fold { index } => write!(
                f,
                "the path turns back on itself at waypoint {index}: say where it is driven \
                 backwards (reverse, negative speeds), or leave out what is not driven"
            ),
            Self::Gap {
                index,
                next,
                length,
                spacing,
            } => write!(
                f,
                "waypoints {index} and {next} are {length:.1} m apart, the others {spacing:.3} m, \
                 and the path turns there: split it, or give waypoints between them"
            ),
            Self::Unordered { folds, waypoints } => write!(
                f,
                "{folds} of {waypoints} waypoints turn back: put them in the order in which they \
                 are driven, or smooth them where noise is larger than the spacing"
            ),
            _ => Ok(()),
        }
    }
}

impl core::error::Error for PathError {}

/// Whether `value` is a number in `[low, high]`; false for NaN.
#[inline]
pub(crate) fn in_range(value: f64, low: f64, high: f64) -> bool {
    low <= value && value <= high
}
