use std::sync::Arc;

use popsteer_core::path::Follow;
use popsteer_core::{Path, Point, VehicleState};

use super::episode::point_at;
use super::*;
use crate::plant::{KinematicBicycle, Plant};
use crate::simulation::Settings;

fn begun(start: VehicleState) -> Simulation {
    let x: Vec<f64> = (0..100).map(f64::from).collect();
    let path = Path::new(&x, &vec![0.0; 100], Some(&[5.0; 100]), false).unwrap();
    let plant = KinematicBicycle::DEFAULT;
    let rear = plant.vehicle.rear_axle;
    let settings = Settings {
        keep_records: false,
        give_up_distance: 2.0,
        time_limit: 5.0,
        ..Settings::DEFAULT
    };
    let tracked = Follow::of(&plant.vehicle, rear, 0.0);
    let plant: Arc<dyn Plant> = Arc::new(plant);
    Simulation::new(Arc::new(path), plant, start, tracked, settings).unwrap()
}

fn at(y: f64, speed: f64) -> VehicleState {
    VehicleState {
        x: 0.0,
        y,
        yaw: 0.0,
        speed,
    }
}

fn batch(count: usize) -> Episodes {
    let terms = Terms {
        longitudinal: None,
        preview: vec![5.0, 10.0],
        weights: Weights::DEFAULT,
        stall_time: 2.0,
    };
    let mut batch = Episodes::new(count, terms).unwrap();
    for k in 0..count {
        let y = 0.01 * popsteer_core::math::from_count(k % 100);
        batch.begin(k, begun(at(y, 5.0)));
    }
    batch
}

fn states(batch: &Episodes) -> Vec<([f64; 8], Vec<f32>, f64)> {
    let each = batch.episodes().flatten();
    each.map(|one| (one.info, one.observation.clone(), one.reward))
        .collect()
}

#[test]
fn test_episodes_in_parallel_are_those_one_by_one() {
    let (mut many, mut single) = (batch(300), batch(300));
    let actions: Vec<f64> = (0..600).map(|k| (f64::from(k) * 0.7).sin()).collect();
    for _ in 0..20 {
        many.step(&actions, &[false; 300], true).unwrap();
        single.step(&actions, &[false; 300], false).unwrap();
    }
    assert_eq!(states(&many), states(&single));
}

#[test]
fn test_observation_has_the_errors_and_the_path_ahead_in_the_vehicles_frame() {
    let mut batch = batch(1);
    batch.begin(0, begun(at(0.5, 5.0)));
    let one = batch.episodes().flatten().next().unwrap();
    let expected = [0.5, 0.0, 5.0, 0.0, 0.0, 0.0, 5.0, 5.0, -0.5, 10.0, -0.5];
    assert_eq!(one.observation, expected);
}

#[test]
fn test_reward_is_progress_less_errors_and_leaving_costs() {
    let mut batch = batch(1);
    batch.begin(0, begun(at(1.0, 5.0)));
    batch.step(&[0.0, 0.0], &[false], true).unwrap();
    let one = batch.episodes().flatten().next().unwrap();
    let expected = 0.1 * one.info[0] - 0.05 * 1.0;
    assert!((one.reward - expected).abs() < 1e-12, "{}", one.reward);
    let mut last = 0.0;
    for _ in 0..100 {
        let one = batch.episodes().flatten().next().unwrap();
        if one.is_terminated() {
            break;
        }
        batch.step(&[1.0, 0.0], &[false], true).unwrap();
        last = batch.episodes().flatten().next().unwrap().reward;
    }
    let one = batch.episodes().flatten().next().unwrap();
    assert!(one.is_terminated() && !one.is_truncated());
    assert!((-11.0..-9.0).contains(&last), "{last}");
    // What is over stays where it is.
    let before = one.info;
    batch.step(&[1.0, 1.0], &[false], true).unwrap();
    let one = batch.episodes().flatten().next().unwrap();
    assert_eq!((one.info, one.reward), (before, 0.0));
}

#[test]
fn test_episode_out_of_time_is_truncated() {
    let mut batch = batch(1);
    batch.begin(0, begun(at(0.0, 1.0)));
    for _ in 0..100 {
        batch.step(&[0.0, 0.0], &[false], true).unwrap();
    }
    let one = batch.episodes().flatten().next().unwrap();
    assert!(one.is_truncated() && !one.is_terminated());
}

#[test]
fn test_episode_without_progress_is_truncated_before_the_time_is_out() {
    let mut batch = batch(2);
    batch.begin(0, begun(at(0.0, 0.0)));
    batch.begin(1, begun(at(0.0, 1.0)));
    for _ in 0..41 {
        batch
            .step(&[0.0, 0.0, 0.0, 0.0], &[false; 2], true)
            .unwrap();
    }
    let [standing, driving] = [0, 1].map(|k| batch.episodes().flatten().nth(k).unwrap());
    assert!(standing.is_truncated() && standing.is_stalled() && !standing.is_terminated());
    assert!(!driving.is_truncated());
}

#[test]
fn test_action_that_is_no_number_is_refused_and_nothing_moves() {
    let mut batch = batch(3);
    let before = states(&batch);
    let refused = batch.step(&[0.0, 0.0, 0.1, 0.0, 0.0, f64::NAN], &[false; 3], true);
    assert_eq!(refused.unwrap_err().vehicle, 2);
    assert_eq!(states(&batch), before);
    let resting = [false, false, true];
    let held = batch.step(&[2.0, 0.0, 0.1, 0.0, 0.0, f64::NAN], &resting, true);
    assert_eq!(held, Ok(()));
    assert_ne!(states(&batch)[0], before[0]);
    assert_eq!(states(&batch)[2], before[2]);
}

#[test]
fn test_point_ahead_lies_on_the_path_goes_on_beyond_its_ends_and_round_a_closed_one() {
    let (x, y) = ([0.0, 4.0, 4.0, 0.0], [0.0, 0.0, 4.0, 4.0]);
    let open = Path::new(&x, &y, None, false).unwrap();
    let closed = Path::new(&x, &y, None, true).unwrap();
    for near in 0..4 {
        let at = |path: &Path, arc| point_at(&path.view(), arc, near).0;
        assert_eq!(at(&open, 5.0), Point::new(4.0, 1.0));
        assert_eq!(at(&open, -2.0), Point::new(-2.0, 0.0));
        assert_eq!(at(&open, 14.0), Point::new(-2.0, 4.0));
        assert_eq!(at(&closed, 14.0), Point::new(0.0, 2.0));
        assert_eq!(at(&closed, 17.0), Point::new(1.0, 0.0));
        assert_eq!(at(&closed, -1.0), Point::new(0.0, 1.0));
    }
}

#[test]
fn test_point_far_ahead_is_found_by_halves() {
    let x: Vec<f64> = (0..1000).map(f64::from).collect();
    let path = Path::new(&x, &vec![0.0; 1000], None, false).unwrap();
    for (arc, near) in [(900.5, 3), (3.25, 900), (20.0, 2)] {
        assert_eq!(
            point_at(&path.view(), arc, near).0,
            Point::new(arc, 0.0),
            "{arc} from {near}"
        );
    }
}
