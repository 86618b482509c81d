//! What the parts of a run do by themselves.

use crate::closed_loop::{Controller, run};
use crate::delay::Delay;
use crate::noise::{Noise, Perception};
use crate::plant::{CarlaIdentified, Control, KinematicBicycle, PedalMap, Plant, PlantState};
use crate::simulation::Settings;
use crate::{Longitudinal, Simulation};
use popsteer_core::laws::{Pop, PopParams};
use popsteer_core::math::wrap;
use popsteer_core::path::Follow;
use popsteer_core::{Path, Tracker, Vehicle, VehicleState};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use std::sync::Arc;

fn passed(dead_time: f64, commands: &[f64]) -> Vec<(f64, usize)> {
    let mut delay = Delay::new(dead_time);
    let mut seen = Vec::new();
    for &command in commands {
        delay.pass(command, 0.01, 5, |command, count| {
            seen.push((command, count));
        });
    }
    seen
}

#[test]
fn test_delay_of_nothing_passes_on_at_once() {
    assert_eq!(passed(0.0, &[0.1, 0.2]), [(0.1, 5), (0.2, 5)]);
}

#[test]
fn test_delay_of_whole_periods_shifts_by_them() {
    let seen = passed(0.1, &[0.1, 0.2, 0.3, 0.4]);
    assert_eq!(seen, [(0.0, 5), (0.0, 5), (0.1, 5), (0.2, 5)]);
}

#[test]
fn test_delay_within_a_period_changes_in_it() {
    let seen = passed(0.03, &[0.1, 0.2]);
    assert_eq!(seen, [(0.0, 3), (0.1, 2), (0.1, 3), (0.2, 2)]);
    let seen = passed(0.025, &[0.1]);
    assert_eq!(seen[0], (0.0, 2));
    assert!((seen[1].0 - 0.05).abs() < 1e-12 && seen[1].1 == 1);
    assert_eq!(seen[2], (0.1, 2));
}

#[test]
fn test_delay_keeps_its_length_over_a_long_run() {
    let mut delay = Delay::new(0.152);
    for k in 0..100_000_u32 {
        delay.pass(f64::from(k), 0.005, 10, |_, _| ());
    }
    let total: f64 = delay.commands().map(|(_, duration)| duration).sum();
    assert!((total - 0.152).abs() < 1e-6, "{total}");
}

#[test]
fn test_noise_every_quantity_has_its_own_deviation() {
    let noise = Noise {
        position: 0.3,
        yaw: 0.01,
        speed: 2.0,
    };
    let mut perception = Perception::new(noise, 1, 2);
    let here = VehicleState::ORIGIN;
    let count = 20_000;
    let mut sums = [0.0; 4];
    for _ in 0..count {
        let seen = perception.of(here);
        for (sum, value) in sums.iter_mut().zip([seen.x, seen.y, seen.yaw, seen.speed]) {
            *sum += value * value;
        }
    }
    for (sum, expected) in sums.iter().zip([0.3, 0.3, 0.01, 2.0]) {
        let deviation = (sum / f64::from(count)).sqrt();
        assert!((deviation / expected - 1.0).abs() < 0.03, "{sums:?}");
    }
}

#[test]
fn test_noise_is_what_the_generator_draws_added_in_the_order_of_the_fields() {
    let noise = Noise {
        position: 0.3,
        yaw: 0.01,
        speed: 2.0,
    };
    let here = VehicleState {
        x: 10.0,
        y: 20.0,
        yaw: 0.1,
        speed: 5.0,
    };
    let mut random = Pcg64::new(1, 2);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let seen = Perception::new(noise, 1, 2).of(here);
    let expected = [
        10.0 + 0.3 * draw(),
        20.0 + 0.3 * draw(),
        wrap(0.1 + 0.01 * draw()),
        5.0 + 2.0 * draw(),
    ];
    let got = [seen.x, seen.y, seen.yaw, seen.speed];
    assert_eq!(got.map(f64::to_bits), expected.map(f64::to_bits));
}

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
    saved.rear = Some(1_000_000);
    assert_eq!(fresh().restored(saved).save().rear, None);
}

/// The path's speed, or what can still brake for the cusp at 50 m.
#[test]
fn test_stopping_speed_brakes_for_the_cusp_at_the_vehicles_deceleration() {
    let x: Vec<f64> = (0..100)
        .map(|k| f64::from(if k <= 50 { k } else { 100 - k }))
        .collect();
    let speed: Vec<f64> = (0..100).map(|k| if k < 50 { 9.0 } else { -9.0 }).collect();
    let cusp = Arc::new(Path::new(&x, &[0.0; 100], Some(&speed), false).unwrap());
    let forward = Arc::new(Path::new(&x[..50], &[0.0; 50], Some(&[9.0; 50]), false).unwrap());
    let at = |path: &Arc<Path>, x: f64, max_deceleration: Option<f64>| {
        let plant = KinematicBicycle {
            vehicle: Vehicle {
                max_deceleration,
                ..KinematicBicycle::VEHICLE
            },
            ..KinematicBicycle::DEFAULT
        };
        let start = VehicleState {
            x,
            y: 0.0,
            yaw: 0.0,
            speed: 5.0,
        };
        let follow = Follow::of(&plant.vehicle, 0.0, 0.0);
        let path = Arc::clone(path);
        let settings = Settings::DEFAULT;
        let run = Simulation::new(path, Arc::new(plant), start, follow, settings).unwrap();
        run.stopping_speed().unwrap()
    };
    for (x, deceleration, expected) in [
        (10.0, None, 9.0),
        (40.0, None, f64::sqrt(2.0 * 2.0 * 10.0)),
        (42.0, Some(0.5), f64::sqrt(2.0 * 0.5 * 8.0)),
    ] {
        let found = at(&cusp, x, deceleration);
        assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
    }
    assert!((at(&forward, 40.0, None) - 9.0).abs() < 1e-9);
}

#[test]
fn test_pedals_give_the_acceleration_or_all_there_is() {
    let map = PedalMap {
        drive: 6.0,
        braking: 9.0,
        drag: 0.3,
        air_drag: 0.0,
    };
    assert_eq!(map.of(3.0, 10.0), (1.0, 0.0));
    assert_eq!(map.of(-12.0, 0.0), (0.0, 1.0));
    assert_eq!(map.of(0.0, 0.0), (0.0, 0.0));
    let none = PedalMap { drive: 0.0, ..map };
    assert_eq!(none.of(0.0, 0.0), (1.0, 0.0));
}

#[test]
fn test_bicycle_brakes_to_rest_then_backs_up_with_the_wheels_mirrored() {
    let plant = KinematicBicycle::DEFAULT;
    let vehicle = VehicleState {
        x: 0.0,
        y: 0.0,
        yaw: 0.0,
        speed: 1.0,
    };
    let mut state = PlantState::settled(&plant.vehicle, vehicle);
    let control = Control {
        steer: 0.2,
        throttle: 0.0,
        brake: 1.0,
        reverse: true,
    };
    plant.advance(&mut state, control, 0.005, 100);
    assert!(state.vehicle.speed.abs() <= 0.0);
    let before = state.vehicle;
    let backwards = Control {
        throttle: 0.2,
        brake: 0.0,
        ..control
    };
    plant.advance(&mut state, backwards, 0.005, 200);
    assert!(state.vehicle.speed < -0.9);
    assert!(state.vehicle.x < before.x && state.vehicle.yaw < before.yaw);
}

#[test]
fn test_brakes_at_rest_drive_in_neither_gear() {
    let plant = KinematicBicycle::DEFAULT;
    let mut state = PlantState::settled(&plant.vehicle, VehicleState::ORIGIN);
    for reverse in [false, true, false] {
        let control = Control {
            brake: 1.0,
            reverse,
            ..Control::default()
        };
        plant.advance(&mut state, control, 0.5, 1);
        assert!(state.vehicle.speed.abs() <= 0.0 && state.vehicle.x.abs() <= 0.0);
    }
}

#[test]
fn test_throttle_that_lags_less_than_a_step_is_the_pedal() {
    let control = Control {
        throttle: 0.2,
        ..Control::default()
    };
    for throttle_lag in [0.002, 0.02, 0.4] {
        let plant = CarlaIdentified {
            throttle_lag,
            ..CarlaIdentified::DEFAULT
        };
        let mut state = PlantState::settled(&plant.vehicle, VehicleState::ORIGIN);
        for _ in 0..1000 {
            plant.advance(&mut state, control, 0.005, 10);
            assert!((0.0..30.0).contains(&state.vehicle.speed), "{state:?}");
            assert!((0.0..=0.2).contains(&state.throttle));
        }
    }
}

/// A bicycle of `vehicle` after `time` [s] from 8 m/s, with its wheels commanded to 0.3 rad.
fn driven(vehicle: &Vehicle, time: f64) -> PlantState {
    let start = VehicleState {
        x: 0.0,
        y: 0.0,
        yaw: 0.0,
        speed: 8.0,
    };
    let plant = KinematicBicycle {
        vehicle: *vehicle,
        drag: 0.0,
        ..KinematicBicycle::DEFAULT
    };
    let mut state = PlantState::settled(vehicle, start);
    let control = Control {
        steer: 0.3,
        throttle: 0.5,
        ..Control::default()
    };
    let substeps = popsteer_core::math::to_count(time / 0.001 + 0.5);
    plant.advance(&mut state, control, 0.001, substeps);
    state
}

#[test]
fn test_bicycle_steers_as_its_vehicle_says() {
    let car = KinematicBicycle::VEHICLE;
    let lagging = driven(
        &Vehicle {
            steer_lag: 0.2,
            ..car
        },
        0.2,
    );
    assert!((lagging.wheel - 0.3 * (1.0 - (-1.0_f64).exp())).abs() < 1e-9);
    let slow = Vehicle {
        max_steer_rate: Some(0.4),
        ..car
    };
    assert!((driven(&slow, 0.5).wheel - 0.2).abs() < 1e-9);
    let narrow = Vehicle {
        max_steer: 0.1,
        ..car
    };
    assert!((driven(&narrow, 0.5).wheel - 0.1).abs() <= 0.0);
    let heavy = Vehicle {
        understeer: 0.05,
        ..car
    };
    let curvature = |state: PlantState| state.yaw_rate / state.vehicle.speed;
    let speed = driven(&heavy, 1.0).vehicle.speed;
    let expected = 0.3_f64.tan() / (3.0 + 0.05 * speed * speed);
    assert!((curvature(driven(&heavy, 1.0)) - expected).abs() < 1e-4);
    let longer = Vehicle {
        turning_wheelbase: Some(4.0),
        ..car
    };
    assert!((curvature(driven(&longer, 1.0)) - 0.3_f64.tan() / 4.0).abs() < 1e-4);
}

#[test]
fn test_bicycle_moves_as_its_vehicle_says() {
    let car = KinematicBicycle::VEHICLE;
    let governed = Vehicle {
        max_speed: Some(9.0),
        ..car
    };
    assert!((driven(&governed, 1.0).vehicle.speed - 9.0).abs() <= 0.0);
    let late = driven(
        &Vehicle {
            drive_lag: 0.5,
            ..car
        },
        0.5,
    );
    assert!((late.throttle - 0.5 * (1.0 - (-1.0_f64).exp())).abs() < 1e-9);
    // The point that does not slip moves where the vehicle looks, here 1 m behind the pose's.
    let behind = driven(
        &Vehicle {
            rear_axle: -1.0,
            ..car
        },
        1.0,
    );
    let rear = driven(&car, 1.0).vehicle;
    let point = rear.ahead(1.0);
    assert!((behind.vehicle.yaw - rear.yaw).abs() < 1e-12);
    // The runs start 1 m apart along x.
    assert!((behind.vehicle.x + 1.0 - point.x).abs() < 1e-9);
    assert!((behind.vehicle.y - point.y).abs() < 1e-9);
}
