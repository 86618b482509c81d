//! A simulation as numbers, and back.

use popsteer_core::math::{from_count, to_count};

use crate::delay::Delay;
use crate::follower::Follower;
use crate::record::Record;
use crate::simulation::Simulation;

/// All that a simulation remembers beside its path, its plant and its settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Saved {
    /// The numbers, in an order of their own.
    pub numbers: Vec<f64>,
    /// The commands that have not reached the plant: angle [rad] and duration [s].
    pub commands: Vec<(f64, f64)>,
    /// The records.
    pub records: Vec<Record>,
}

fn visit_flag(flag: &mut bool, visit: &mut impl FnMut(&mut f64)) {
    let mut number = if *flag { 1.0 } else { 0.0 };
    visit(&mut number);
    *flag = number > 0.5;
}

fn visit_place(follower: &mut Follower, segments: usize, visit: &mut impl FnMut(&mut f64)) {
    let mut number = follower.waypoint.map_or(-1.0, from_count);
    visit(&mut number);
    let place = to_count(number);
    follower.waypoint = (number >= 0.0 && place < segments).then_some(place);
}

impl Simulation {
    /// Shows every number, to be read or replaced.
    fn visit(&mut self, visit: &mut impl FnMut(&mut f64)) {
        let segments = self.path.view().segments();
        for follower in [&mut self.reference, &mut self.rear, &mut self.leading] {
            visit_place(follower, segments, visit);
        }
        for flag in [&mut self.reverse, &mut self.finished, &mut self.lost] {
            visit_flag(flag, visit);
        }
        let mut steps = from_count(self.steps);
        visit(&mut steps);
        self.steps = to_count(steps);
        let state = &mut self.state;
        for number in [
            &mut self.leading_arc,
            &mut self.travelled,
            &mut state.vehicle.x,
            &mut state.vehicle.y,
            &mut state.vehicle.yaw,
            &mut state.vehicle.speed,
            &mut state.yaw_rate,
            &mut state.wheel,
            &mut state.throttle,
        ] {
            visit(number);
        }
        self.gatherer.visit(visit);
    }

    /// All that the simulation remembers.
    pub fn save(&self) -> Saved {
        let mut numbers = Vec::new();
        self.clone().visit(&mut |number| numbers.push(*number));
        Saved {
            numbers,
            commands: self.delay.commands().collect(),
            records: self.records().to_vec(),
        }
    }

    /// This simulation at its start, as it was when it was saved.
    #[must_use]
    pub fn restored(mut self, saved: Saved) -> Self {
        let mut numbers = saved.numbers.into_iter();
        self.visit(&mut |number| *number = numbers.next().unwrap_or(*number));
        self.delay = Delay::restored(saved.commands.into_iter());
        self.records = saved.records;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::{Controller, run};
    use crate::plant::KinematicBicycle;
    use crate::settings::Settings;
    use crate::{Longitudinal, Perception};
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
    }
}
