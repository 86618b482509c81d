//! Pedals of runs by the equations of their controllers, forwards and backwards, and batches that
//! change.

use std::sync::Arc;

use popsteer_core::laws::{Pop, PopParams, Stanley, StanleyParams};
use popsteer_core::speed::{
    SpeedPid, SpeedPidParams, SpeedTracker, SpeedTrackerParams, SpeedTrackerState,
};
use popsteer_core::tracker::Reported;
use popsteer_core::{Path, Point, Status, Tracker, Vehicle, VehicleState};
use popsteer_sim::batch::{Batch, Member, OnError};
use popsteer_sim::longitudinal::Tracked;
use popsteer_sim::plant::{CarlaIdentified, KinematicBicycle, PedalMap};
use popsteer_sim::{
    Control, Controller, Longitudinal, Noise, Perception, Plant, Record, Settings, Simulation,
    Weights, closed_loop,
};

const CAR: Vehicle = KinematicBicycle::VEHICLE;

/// 500 m along x at 7 m/s, driven forwards or backwards.
fn straight(reverse: bool) -> Arc<Path> {
    let x: Vec<f64> = (0..=100).map(|k| 5.0 * f64::from(k)).collect();
    let speed = if reverse { -7.0 } else { 7.0 };
    let path = Path::new(&x, &[0.0; 101], Some(&[speed; 101]), false).unwrap();
    if reverse {
        Arc::new(path.with_reverse(&[true; 101]).unwrap())
    } else {
        Arc::new(path)
    }
}

/// The first records of a run along the path that begins at 4 m/s.
fn records(path: &Arc<Path>, reverse: bool, longitudinal: &Longitudinal) -> Vec<Record> {
    let law = Stanley::new(CAR, StanleyParams::DEFAULT).unwrap();
    let tracker = Tracker::of(law);
    let (yaw, speed) = if reverse {
        (std::f64::consts::PI, -4.0)
    } else {
        (0.0, 4.0)
    };
    let start = VehicleState {
        x: 50.0,
        y: 0.3,
        yaw,
        speed,
    };
    let plant: Arc<dyn Plant> = Arc::new(KinematicBicycle::DEFAULT);
    let settings = Settings::DEFAULT;
    let follow = *tracker.follow();
    let mut run = Simulation::new(Arc::clone(path), plant, start, follow, settings).unwrap();
    let mut controller = Controller::new(&tracker);
    let go_on = |run: &Simulation| run.records().len() < 100;
    closed_loop::run(
        &mut run,
        &mut controller,
        longitudinal,
        Perception::EXACT,
        go_on,
    )
    .unwrap();
    run.records().to_vec()
}

/// `a = drive throttle - braking brake - drag v - air_drag v |v|` along the direction of driving.
#[test]
fn test_pedals_of_a_plan_give_its_accelerations_in_both_directions() {
    let pedals = PedalMap {
        drive: 6.0,
        braking: 9.0,
        drag: 0.28,
        air_drag: 0.01,
    };
    for reverse in [false, true] {
        let path = straight(reverse);
        let law = SpeedTracker::new(CAR, SpeedTrackerParams::DEFAULT).unwrap();
        let plan: Arc<[f64]> = law.plan(&path.view()).unwrap().into();
        let tracked = Tracked {
            law,
            path: Arc::clone(&path),
            plan: Arc::clone(&plan),
            pedals,
        };
        let longitudinal = Longitudinal::Tracked(Arc::new(tracked));
        let mut state = SpeedTrackerState::default();
        let records = records(&path, reverse, &longitudinal);
        assert_eq!(records.len(), 100);
        for record in &records {
            let &Record {
                x, y, yaw, speed, ..
            } = record;
            let vehicle = VehicleState { x, y, yaw, speed };
            let command = law
                .step(&path.view(), &plan, &mut state, vehicle, 0.05)
                .unwrap();
            let along = if reverse { -speed } else { speed };
            let given = 6.0 * record.throttle
                - 9.0 * record.brake
                - 0.28 * along
                - 0.01 * along * along.abs();
            assert!((given - command.acceleration).abs() < 1e-9, "{record:?}");
            assert!(record.throttle < 1.0 && record.brake < 1.0);
        }
        let last = records[99].speed.abs();
        // The plant has no drag of the air, which the integral makes up for slowly.
        assert!((last - 7.0).abs() < 0.5, "{last}");
    }
}

/// `command = kp e + ki integral(e)`, throttle where it is positive, in either direction.
#[test]
fn test_speed_pid_of_a_run_sums_its_errors_in_both_directions() {
    let params = SpeedPidParams {
        kp: 0.1,
        ki: 0.05,
        kd: 0.0,
    };
    for reverse in [false, true] {
        let path = straight(reverse);
        let law = SpeedPid::new(params).unwrap();
        let records = records(&path, reverse, &Longitudinal::Speed(law));
        let mut integral = 0.0;
        for record in &records {
            let error = 7.0 - record.speed.abs();
            integral += 0.05 * error * 0.05;
            let command = 0.1 * error + integral;
            let given = record.throttle - record.brake;
            assert!((given - command).abs() < 1e-9, "{record:?}, not {command}");
        }
        assert!(integral > 0.1, "{integral}");
    }
}

#[test]
fn test_reverse_gear_is_refused_by_a_plant_without_one_alone() {
    let back = Control {
        reverse: true,
        ..Control::default()
    };
    let start = VehicleState {
        x: 50.0,
        y: 0.0,
        yaw: 0.0,
        speed: 0.0,
    };
    let plants: [Arc<dyn Plant>; 2] = [
        Arc::new(KinematicBicycle::DEFAULT),
        Arc::new(CarlaIdentified::DEFAULT),
    ];
    for plant in plants {
        let follow = popsteer_core::path::Follow::of(plant.vehicle(), 0.0, 0.0);
        let reverses = plant.reverses();
        let path = straight(false);
        let settings = Settings::DEFAULT;
        let mut run = Simulation::new(path, plant, start, follow, settings).unwrap();
        let result = run.step(back, Point::new(0.0, 0.0), Status::OK);
        assert_eq!(result.err().map(|error| error.field), {
            (!reverses).then_some("reverse")
        });
    }
}

/// A vehicle that joins a batch, another path for one of them, and a driver in one of them.
#[test]
fn test_batch_that_changes_steps_as_its_vehicles_alone() {
    let tracker = Tracker::of(Pop::new(CAR, PopParams::DEFAULT).unwrap());
    let (old, new) = (straight(false), {
        let x = [0.0, 500.0];
        Arc::new(Path::new(&x, &[0.2; 2], None, false).unwrap())
    });
    let member = || Member {
        tracker,
        path: Arc::clone(&old),
        state: tracker.initial_state(),
    };
    let mut batch = Batch::new([member()]);
    batch.add(member(), 2);
    assert_eq!(batch.len(), 3);
    let mut states = vec![tracker.initial_state(); 3];
    let mut paths = [&old, &old, &old];
    let mut angles = [0.0; 3];
    let reported = [0.0, 0.1, 0.0].map(|steer: f64| Reported {
        applied_steer: (steer > 0.0).then_some(steer),
        ..Reported::NOTHING
    });
    for k in 0..10 {
        if k == 5 {
            batch.set_path(2, Arc::clone(&new));
            tracker.set_path(&mut states[2], &old.view(), &new.view());
            paths[2] = &new;
        }
        let vehicle = VehicleState {
            x: 30.0 + 0.4 * f64::from(k),
            y: 0.5,
            yaw: 0.05,
            speed: 8.0,
        };
        batch
            .steer(&[vehicle; 3], 0.05, OnError::Raise, &reported, &mut angles)
            .unwrap();
        for (n, state) in states.iter_mut().enumerate() {
            let path = paths[n].view();
            let expected = tracker
                .steer(&path, state, vehicle, 0.05, reported[n])
                .unwrap();
            assert!((angles[n] - expected).abs() <= 0.0, "{k} {n}");
        }
    }
    assert!((angles[0] - angles[1]).abs() > 1e-6 && (angles[0] - angles[2]).abs() > 1e-6);
}

#[test]
fn test_checked_settings_are_those_given() {
    let weights = Weights {
        progress: 0.7,
        off_path: 3.0,
        ..Weights::DEFAULT
    };
    assert_eq!(weights.checked(), Ok(weights));
    let noise = Noise {
        position: 0.1,
        ..Noise::DEFAULT
    };
    assert_eq!(noise.checked(), Ok(noise));
    let plant = CarlaIdentified {
        drive: 5.0,
        ..CarlaIdentified::DEFAULT
    };
    assert_eq!(plant.checked(), Ok(plant));
}
