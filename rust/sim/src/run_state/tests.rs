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
