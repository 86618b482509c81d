//! What a simulation remembers, as a value.

use popsteer_core::path::{Follow, Located};
use popsteer_core::{Path, VehicleState};

use crate::delay::Delay;
use crate::metrics::Gatherer;
use crate::plant::PlantState;
use crate::record::Record;

/// All that a simulation remembers beside its path, its plant and its settings.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RunState {
    pub(crate) plant: PlantState,
    pub(crate) reference: Place,
    pub(crate) rear: Place,
    pub(crate) leading: Place,
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

/// The segment that a point of the vehicle was last projected to; None before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Place(pub(crate) Option<usize>);

impl Place {
    pub(crate) fn find(
        self,
        follow: &Follow,
        path: &Path,
        vehicle: VehicleState,
        dt: f64,
    ) -> Located {
        follow.locate(&path.view(), self.0, vehicle, dt)
    }

    pub(crate) fn follow(
        &mut self,
        follow: &Follow,
        path: &Path,
        vehicle: VehicleState,
        dt: f64,
    ) -> Located {
        let at = self.find(follow, path, vehicle, dt);
        self.0 = Some(at.closest.segment);
        at
    }
}

impl RunState {
    /// The same on a path of so many segments: a place that it does not have is none.
    pub(crate) fn on(mut self, segments: usize) -> Self {
        for place in [&mut self.reference, &mut self.rear, &mut self.leading] {
            place.0 = place.0.filter(|&segment| segment < segments);
        }
        self
    }
}
