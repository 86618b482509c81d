//! What was mended in waypoints, in numbers and in words.

use core::fmt;

/// What was mended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Waypoints at the place of the next one, or so close to it that the direction is noise.
    Coinciding,
    /// The start of a closed path, repeated as its end.
    Repeated,
    /// Two neighbours in the wrong order.
    Swapped,
    /// A few waypoints in the opposite order.
    Reversed,
    /// A step back over what the path has passed, and passes again.
    StepBack,
    /// A vehicle that stood in the noise of its position.
    Standstill,
    /// A first or last stretch shorter than the spacing that points aside.
    End,
    /// A first or last stretch that turns as no vehicle of the size does.
    Undrivable,
    /// A change of gear a waypoint beside its cusp.
    Gear,
}

impl Fault {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Coinciding,
        Self::Repeated,
        Self::Swapped,
        Self::Reversed,
        Self::StepBack,
        Self::Standstill,
        Self::End,
        Self::Undrivable,
        Self::Gear,
    ];
}

/// A kind of fault that was mended, and how often.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mend {
    /// The kind.
    pub fault: Fault,
    /// How many there were.
    pub times: usize,
    /// How many waypoints were left out because of them.
    pub left_out: usize,
    /// The waypoint, as given, at which the first of them is.
    pub index: usize,
}

impl fmt::Display for Mend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (times, left_out, index) = (self.times, self.left_out, self.index);
        let many = if times > 1 { "s" } else { "" };
        match self.fault {
            Fault::Coinciding => {
                write!(
                    f,
                    "left out {times} waypoint{many} at the place of a neighbour"
                )?;
            }
            Fault::Repeated => write!(f, "left out the start repeated at the end of the lap")?,
            Fault::Swapped => write!(f, "put {times} swapped pair{many} of waypoints in order")?,
            Fault::Reversed => write!(f, "put {times} run{many} of waypoints in order")?,
            Fault::StepBack => write!(f, "left out {times} step{many} back")?,
            Fault::Standstill => write!(f, "left out {times} standstill{many} in noise")?,
            Fault::Undrivable => write!(f, "smoothed {times} end{many} over a wheelbase")?,
            Fault::Gear => write!(f, "moved {times} change{many} of gear to the cusp beside")?,
            Fault::End => write!(f, "left out {times} short end{many} that pointed aside")?,
        }
        if left_out > times {
            write!(f, " ({left_out} waypoints)")?;
        }
        let first = if times > 1 { "the first " } else { "" };
        write!(f, ", {first}at waypoint {index}")
    }
}
