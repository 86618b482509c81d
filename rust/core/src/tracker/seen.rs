//! What the first half of a step comes to.

use crate::laws::Belief;
use crate::path::Located;
use crate::status::Status;
use crate::vehicle::VehicleState;

/// What the first half of a step comes to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// The vehicle as it is believed to be now.
    pub(crate) here: VehicleState,
    /// That on the path.
    pub(crate) located: Located,
    /// The vehicle on the path when the next command reaches the wheels, where that is another place.
    pub(crate) predicted: Option<Located>,
    /// What else is believed.
    pub(crate) belief: Belief,
    /// The time in which the wheels turn to the next command [s].
    pub(crate) period: f64,
    /// What is wrong.
    pub(crate) status: Status,
}

impl Seen {
    /// The vehicle that the controller sees: as predicted for its command, or as it is.
    #[inline]
    pub(crate) fn at(&self) -> &Located {
        self.predicted.as_ref().unwrap_or(&self.located)
    }
}
