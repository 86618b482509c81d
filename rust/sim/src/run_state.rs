//! What a simulation remembers, as a value.

use crate::delay::Delay;
use crate::metrics::Gatherer;
use crate::plant::PlantState;
use crate::record::Record;

/// All that a simulation remembers beside its path, its plant and its settings.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RunState {
    pub(crate) plant: PlantState,
    /// The segments that points of the vehicle were last projected to; None before.
    pub(crate) reference: Option<usize>,
    pub(crate) rear: Option<usize>,
    pub(crate) leading: Option<usize>,
    /// Whether the path is driven backwards where the rear axle is.
    pub(crate) reverse: bool,
    pub(crate) leading_arc: f64,
    pub(crate) delay: Delay,
    pub(crate) travelled: f64,
    pub(crate) steps: usize,
    pub(crate) finished: bool,
    pub(crate) lost: bool,
    pub(crate) gatherer: Gatherer,
    pub(crate) records: Vec<Record>,
}
