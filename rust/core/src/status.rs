//! How a step went: a set of conditions, the same bits in Rust, Python, arrays and files.

use core::fmt;
use core::ops::{BitOr, BitOrAssign};

/// How many inputs in a row hold the last command before [`Status::INPUT_LOST`] where nobody says how
/// many.
pub const HOLD_LIMIT: usize = 10;

/// How a step went: a set of conditions, of which several may hold. The empty set is `OK`.
///
/// The bits are the same in Rust, Python, arrays and files.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Status(u32);

impl Status {
    /// As the controller wants it.
    pub const OK: Self = Self(0);
    /// Degraded: a larger angle, a larger lateral acceleration or a faster move of the wheels is
    /// wanted than the vehicle allows. The command is limited.
    pub const SATURATED: Self = Self(1);
    /// Degraded: no point ahead lies on the lookahead circle. The controller aims at a substitute.
    pub const LOOKAHEAD_LOST: Self = Self(1 << 1);
    /// Degraded: the tracked point is past the end of the path. The last segment is followed on as
    /// a straight line.
    pub const END_OF_PATH: Self = Self(1 << 2);
    /// Degraded: the vehicle was farther than `lost_distance` from its place, and was searched for
    /// on the whole path. The controller steers to the place that was found.
    pub const OFF_PATH: Self = Self(1 << 3);
    /// Degraded: the input was refused, or its `dt` is no control period. The last command is held.
    pub const INPUT_HELD: Self = Self(1 << 4);
    /// Fault: the same of more inputs in a row than `hold_limit`. The last command is repeated; stop.
    pub const INPUT_LOST: Self = Self(1 << 5);
    /// Fault: the measured cross-track error is beyond `deviation_limit`, once it was within.
    pub const DEVIATING: Self = Self(1 << 6);
    /// Fault: what is measured does not belong together. Within the last 2 s the vehicle turned
    /// otherwise than the commands explain (a wrong sign of the steering, stuck wheels, or an
    /// unknown dead time or lag), or its poses moved otherwise than its speed says, or not at all.
    pub const IMPLAUSIBLE: Self = Self(1 << 7);
    /// Degraded: the best plan within the vehicle's limits was not found in the time that a step
    /// may take. The command is that of the best plan found, which keeps them.
    pub const PLAN_CUT_SHORT: Self = Self(1 << 8);

    /// Degraded: the position repeats the last one, though the vehicle drives. The pose is rolled
    /// forward; for longer than 0.6 s that is [`Self::IMPLAUSIBLE`].
    pub const POSE_STALE: Self = Self(1 << 9);
    /// Degraded: the pose is farther off than speed and wheels explain. The expected one takes its
    /// place, until poses that agree with each other show that the localisation has jumped.
    pub const OUTLIER: Self = Self(1 << 10);

    /// Degraded, with [`Self::SATURATED`]: it is the largest angle of the wheels that limits.
    pub const STEER_LIMIT: Self = Self(1 << 11);
    /// Degraded, with [`Self::SATURATED`]: it is the rate of the wheels.
    pub const RATE_LIMIT: Self = Self(1 << 12);
    /// Degraded, with [`Self::SATURATED`]: it is the lateral acceleration.
    pub const LATERAL_LIMIT: Self = Self(1 << 13);
    /// Degraded: the vehicle's lateral acceleration is beyond its `max_lateral_acceleration` by the
    /// measured turn, or, for preview POP, will be in a bend ahead even if it brakes in comfort; or
    /// POP, Stanley or PID join the path faster than wheels of `max_steer_rate` can end the turn.
    pub const TOO_FAST: Self = Self(1 << 14);

    /// Every condition with its name, from the lowest bit up.
    pub const NAMES: [(Self, &'static str); 15] = [
        (Self::SATURATED, "saturated"),
        (Self::LOOKAHEAD_LOST, "lookahead-lost"),
        (Self::END_OF_PATH, "end-of-path"),
        (Self::OFF_PATH, "off-path"),
        (Self::INPUT_HELD, "input-held"),
        (Self::INPUT_LOST, "input-lost"),
        (Self::DEVIATING, "deviating"),
        (Self::IMPLAUSIBLE, "implausible"),
        (Self::PLAN_CUT_SHORT, "plan-cut-short"),
        (Self::POSE_STALE, "pose-stale"),
        (Self::OUTLIER, "outlier"),
        (Self::STEER_LIMIT, "steer-limit"),
        (Self::RATE_LIMIT, "rate-limit"),
        (Self::LATERAL_LIMIT, "lateral-limit"),
        (Self::TOO_FAST, "too-fast"),
    ];
    const FAULTS: Self = Self(Self::INPUT_LOST.0 | Self::DEVIATING.0 | Self::IMPLAUSIBLE.0);

    /// Of a command that is held for the `count`th time in a row, up to `limit` times.
    pub(crate) const fn held(count: usize, limit: usize) -> Self {
        if count > limit {
            Self::INPUT_LOST
        } else {
            Self::INPUT_HELD
        }
    }

    /// The bits.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// The conditions of these bits; None if a bit stands for no condition.
    pub fn from_bits(bits: u32) -> Option<Self> {
        let known = Self::NAMES.iter().fold(0, |all, (each, _)| all | each.0);
        (bits & !known == 0).then_some(Self(bits))
    }

    /// Whether all conditions of `other` hold.
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// These conditions if `holds`, else none.
    #[inline]
    pub const fn when(self, holds: bool) -> Self {
        if holds { self } else { Self::OK }
    }

    /// Those of the conditions that are faults.
    pub const fn faults(self) -> Self {
        Self(self.0 & Self::FAULTS.0)
    }

    /// The names of the conditions that hold.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        Self::NAMES
            .into_iter()
            .filter(move |(each, _)| self.contains(*each))
            .map(|(_, name)| name)
    }
}

impl BitOr for Status {
    type Output = Self;

    #[inline]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for Status {
    #[inline]
    fn bitor_assign(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Self::OK {
            return f.write_str("ok");
        }
        for (k, name) in self.names().enumerate() {
            f.write_str(if k == 0 { "" } else { "|" })?;
            f.write_str(name)?;
        }
        Ok(())
    }
}

impl fmt::Debug for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}
