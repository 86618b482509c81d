//! Rewards and observations of episodes, by hand.

use std::sync::Arc;

use popsteer_core::path::Follow;
use popsteer_core::{Path, VehicleState};
use popsteer_sim::episodes::{Episode, Terms};
use popsteer_sim::plant::KinematicBicycle;
use popsteer_sim::{Episodes, Plant, Settings, Simulation, Weights};

const WEIGHTS: Weights = Weights {
    progress: 0.3,
    cross_track_error: 2.0,
    heading_error: 3.0,
    steer_rate: 0.05,
    off_path: 7.0,
};
const START: VehicleState = VehicleState {
    x: 20.0,
    y: 1.0,
    yaw: 0.2,
    speed: 6.0,
};

fn begun() -> Episodes {
    let x: Vec<f64> = (0..100).map(f64::from).collect();
    let path = Path::new(&x, &[0.0; 100], None, false).unwrap();
    let plant = KinematicBicycle::DEFAULT;
    let tracked = Follow::of(&plant.vehicle, 0.0, 0.0);
    let plant: Arc<dyn Plant> = Arc::new(plant);
    let settings = Settings::DEFAULT;
    let simulation = Simulation::new(Arc::new(path), plant, START, tracked, settings).unwrap();
    let terms = Terms {
        longitudinal: None,
        preview: vec![4.0, 9.0, 15.0],
        weights: WEIGHTS,
        stall_time: f64::INFINITY,
    };
    let mut batch = Episodes::new(2, terms).unwrap();
    batch.begin(0, simulation);
    batch
}

fn one(batch: &Episodes) -> &Episode {
    batch.episodes().next().unwrap().unwrap()
}

fn step(batch: &mut Episodes, action: [f64; 2]) {
    let actions = [action[0], action[1], 0.0, 0.0];
    batch.step(&actions, &[false; 2], false).unwrap();
}

#[test]
fn test_reward_is_the_documented_sum_in_every_step() {
    let mut batch = begun();
    assert!(!batch.is_empty() && batch.len() == 2);
    assert!(Episodes::new(0, batch.terms().clone()).unwrap().is_empty());
    let most = KinematicBicycle::DEFAULT.vehicle.max_steer;
    let front = |episode: &Episode| {
        let [x, _, yaw, ..] = episode.info;
        x + 3.0 * yaw.cos()
    };
    let (mut before, mut last) = (front(one(&batch)), 0.0);
    for action in [[0.1, 0.2], [-0.2, 0.0], [-0.2, 1.0], [0.3, -0.5]] {
        step(&mut batch, action);
        let now = one(&batch);
        let [_, y, yaw, ..] = now.info;
        let rate = most * (action[0] - last) / 0.05;
        let cost = 2.0 * y * y + 3.0 * yaw * yaw + 0.05 * rate * rate;
        let expected = 0.3 * (front(now) - before) - 0.05 * cost;
        assert!(
            (now.reward - expected).abs() < 1e-9,
            "{}, not {expected}",
            now.reward
        );
        (before, last) = (front(now), action[0]);
    }
    // At rest there is no reward, and nothing moves.
    let info = one(&batch).info;
    batch.step(&[0.0; 4], &[true; 2], false).unwrap();
    assert!(one(&batch).reward.abs() <= 0.0);
    assert_eq!(one(&batch).info.map(f64::to_bits), info.map(f64::to_bits));
}

#[test]
fn test_observation_turns_with_the_vehicle() {
    let batch = begun();
    let observed = &one(&batch).observation;
    assert_eq!(observed.len(), 13);
    // The path ahead of the closest point, (20, 0), seen from (20, 1) at 0.2 rad.
    let (sin, cos) = 0.2_f64.sin_cos();
    for (k, distance) in [4.0, 9.0, 15.0].into_iter().enumerate() {
        let ahead = distance * cos - sin;
        let left = -cos - distance * sin;
        assert!((f64::from(observed[7 + 2 * k]) - ahead).abs() < 1e-5);
        assert!((f64::from(observed[8 + 2 * k]) - left).abs() < 1e-5);
    }
}

#[test]
fn test_brake_slows_and_a_failure_costs_once() {
    let mut batch = begun();
    step(&mut batch, [0.0, -0.5]);
    let braked = one(&batch).info[3];
    let mut rolling = begun();
    step(&mut rolling, [0.0, 0.0]);
    assert!(braked < one(&rolling).info[3] - 0.1);

    let reward = one(&batch).reward;
    batch.fail(0);
    assert!((one(&batch).reward - (reward - 7.0)).abs() < 1e-12);
    assert!(one(&batch).is_terminated() && !one(&batch).is_truncated());
    batch.fail(0);
    assert!((one(&batch).reward - (reward - 7.0)).abs() < 1e-12);
    // It is over: nothing moves any more, and nothing is rewarded.
    let info = one(&batch).info;
    step(&mut batch, [0.3, 1.0]);
    assert!(one(&batch).reward.abs() <= 0.0);
    assert_eq!(one(&batch).info.map(f64::to_bits), info.map(f64::to_bits));
}

#[test]
fn test_heading_error_is_that_against_the_path() {
    let points: Vec<f64> = (0..100).map(f64::from).collect();
    let along = |part: f64| points.iter().map(|s| s * part).collect::<Vec<_>>();
    let path = Path::new(&along(0.8), &along(0.6), None, false).unwrap();
    let plant = KinematicBicycle::DEFAULT;
    let tracked = Follow::of(&plant.vehicle, 0.0, 0.0);
    let yaw = 0.6_f64.atan2(0.8);
    let start = VehicleState {
        x: 16.0,
        y: 12.0,
        yaw: yaw + 0.25,
        speed: 3.0,
    };
    let plant: Arc<dyn Plant> = Arc::new(plant);
    let settings = Settings::DEFAULT;
    let simulation = Simulation::new(Arc::new(path), plant, start, tracked, settings).unwrap();
    let mut batch = begun();
    batch.begin(1, simulation);
    let other = batch.episodes().nth(1).unwrap().unwrap();
    assert!((other.info[5] - 0.25).abs() < 1e-9, "{:?}", other.info);
}
