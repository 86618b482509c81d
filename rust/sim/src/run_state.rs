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
pub(crate) struct Place(Option<usize>);

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::{Controller, run};
    use crate::plant::KinematicBicycle;
    use crate::settings::Settings;
    use crate::{Longitudinal, Perception, Simulation};
    use popsteer_core::laws::{Pop, PopParams};
    use popsteer_core::{Path, Tracker, Vehicle, VehicleState};
    use std::sync::Arc;

    #[test]
    fn test_simulation_restored_goes_on_alike() {
        let plant = KinematicBicycle {
            vehicle: Vehicle {
                dead_time: 0.12,
                steer_lag: 0.1,
                ..KinematicBicycle::VEHICLE
            },
            ..KinematicBicycle::DEFAULT
        };
        let pop = Tracker::of(Pop::new(plant.vehicle, PopParams::default()).unwrap());
        let x: Vec<f64> = (0..200).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|x| 3.0 * (x / 20.0).sin()).collect();
        let path = Arc::new(Path::new(&x, &y, None, false).unwrap());
        let start = VehicleState {
            x: 0.0,
            y: 0.5,
            yaw: 0.0,
            speed: 3.0,
        };
        let fresh = || {
            let path = Arc::clone(&path);
            let settings = Settings::default();
            Simulation::new(path, Arc::new(plant), start, *pop.follow(), settings).unwrap()
        };
        let mut whole = fresh();
        let mut steps = 0;
        let half = |simulation: &mut Simulation, steps: &mut usize| {
            run(
                simulation,
                &mut Controller::new(&pop),
                &Longitudinal::default(),
                Perception::EXACT,
                |_| {
                    *steps += 1;
                    *steps < 60
                },
            )
            .unwrap();
        };
        half(&mut whole, &mut steps);
        let mut again = fresh().restored(whole.save());
        assert_eq!(again.save(), whole.save());
        for simulation in [&mut whole, &mut again] {
            let mut steps = 0;
            half(simulation, &mut steps);
        }
        assert_eq!(again.save(), whole.save());
        assert_eq!(again.metrics(), whole.metrics());
        // A place that the path does not have is none.
        let mut saved = whole.save();
        saved.rear = Place(Some(1_000_000));
        assert_eq!(fresh().restored(saved).save().rear, Place(None));
    }
}
