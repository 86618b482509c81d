//! Batches against single vehicles.

use super::*;
use popsteer_core::laws::{Pop, PopParams, PreviewPop, PreviewPopParams};
use popsteer_core::{Reported, Status, Tracker, Vehicle};

fn batch(count: usize) -> (Batch<Pop>, Tracker<Pop>, Arc<Path>) {
    let x: Vec<f64> = (0..300).map(f64::from).collect();
    let y: Vec<f64> = x.iter().map(|x| 5.0 * (x / 20.0).sin()).collect();
    let path = Path::new(&x, &y, None, false).unwrap();
    let reverse: Vec<bool> = (0..300).map(|k| k > 200).collect();
    let path = Arc::new(path.with_reverse(&reverse).unwrap());
    let tracker = Tracker::of(Pop::new(Vehicle::DEFAULT, PopParams::default()).unwrap());
    let member = || Member {
        tracker,
        path: Arc::clone(&path),
        state: tracker.initial_state(),
    };
    let batch = Batch::new(std::iter::repeat_with(member).take(count));
    (batch, tracker, path)
}

fn inputs(count: u32) -> Vec<VehicleState> {
    let vehicle = |k| VehicleState {
        x: f64::from(k % 250),
        y: f64::from(k % 7) - 3.0,
        yaw: 0.01 * f64::from(k % 40),
        speed: f64::from(k % 20),
    };
    (0..count).map(vehicle).collect()
}

#[test]
fn test_batch_steps_are_single_steps_bit_for_bit() {
    let (none, ..) = batch(0);
    let (mut batch, tracker, path) = batch(600);
    assert!(none.is_empty() && !batch.is_empty());
    let inputs = inputs(600);
    let mut angles = vec![0.0; 600];
    let mut states: Vec<_> = (0..600).map(|_| tracker.initial_state()).collect();
    for _ in 0..5 {
        batch
            .steer(&inputs, 0.05, OnError::Raise, &[], &mut angles)
            .unwrap();
        for ((state, &input), angle) in states.iter_mut().zip(&inputs).zip(&angles) {
            let single = tracker
                .steer(&path.view(), state, input, 0.05, Reported::NOTHING)
                .unwrap();
            assert_eq!(single.to_bits(), angle.to_bits());
        }
    }
    assert!(batch.states().eq(states));
}

#[test]
fn test_batch_keeps_little_of_a_vehicle_that_is_not_modelled() {
    assert!(size_of::<Kept<Pop>>() < 1024, "{}", size_of::<Kept<Pop>>());
    let (mut batch, tracker, path) = batch(2);
    let late = Vehicle {
        dead_time: 0.1,
        ..Vehicle::DEFAULT
    };
    let late = Tracker::of(Pop::new(late, PopParams::default()).unwrap());
    let member = |tracker: Tracker<Pop>| Member {
        tracker,
        path: Arc::clone(&path),
        state: tracker.initial_state(),
    };
    let mut mixed = Batch::new([member(tracker), member(late)]);
    let (mut angles, mut others) = ([0.0_f64; 2], [0.0_f64; 2]);
    let step = |batch: &mut Batch<Pop>, angles: &mut [f64]| {
        batch
            .steer(&inputs(2), 0.05, OnError::Raise, &[], angles)
            .unwrap();
    };
    step(&mut mixed, &mut angles);
    step(&mut batch, &mut others);
    assert_eq!(angles[0].to_bits(), others[0].to_bits());
    let states: Vec<_> = mixed.states().collect();
    assert!(states[0].model.is_empty() && states[1].model.in_flight.is_some());
    step(&mut mixed, &mut angles);
    mixed.set_states(states.clone());
    assert!(mixed.states().eq(states.clone()));
    mixed.reset();
    assert!(!mixed.states().eq(states));
}

#[test]
fn test_batch_keeps_late_vehicles_as_their_single_steps_have_them_in_3_kb_each() {
    let (_, _, path) = batch(1);
    let late = |dead_time| {
        let vehicle = Vehicle {
            dead_time,
            ..Vehicle::DEFAULT
        };
        Tracker::of(PreviewPop::new(vehicle, PreviewPopParams::default()).unwrap())
    };
    let trackers = [0.3, 0.0, 0.05].map(late);
    let mut states = trackers.map(|tracker| tracker.initial_state());
    let member = |k: usize| Member {
        tracker: trackers[k],
        path: Arc::clone(&path),
        state: states[k],
    };
    let mut batch = Batch::new((0..3).map(member));
    // Periods that join commands, poses with ages and without, and a gap.
    for step in 0..200_u32 {
        let dt = [0.002, 0.05, 0.03][(step % 3) as usize] * if step == 90 { 20.0 } else { 1.0 };
        let inputs = [VehicleState {
            x: 0.1 * f64::from(step),
            y: 5.0 * (0.005 * f64::from(step)).sin() + 0.1,
            yaw: 0.24,
            speed: 4.0,
        }; 3];
        let reported = [Reported {
            pose_age: if step > 50 { 0.12 } else { 0.0 },
            ..Reported::NOTHING
        }; 3];
        let mut angles = [0.0_f64; 3];
        batch
            .steer(&inputs, dt, OnError::Raise, &reported, &mut angles)
            .unwrap();
        for (k, (tracker, state)) in trackers.iter().zip(&mut states).enumerate() {
            let single = tracker.steer(&path.view(), state, inputs[k], dt, reported[k]);
            assert_eq!(single.unwrap().to_bits(), angles[k].to_bits(), "{step}");
        }
        assert!(batch.states().eq(states), "{step}");
        // Poses with an age take the wheels' last second besides.
        let most = if step <= 50 { 3000 } else { 4000 };
        assert!(most_bytes(&batch) <= most, "{}", most_bytes(&batch));
    }
}

/// What the widest vehicle of a batch takes.
fn most_bytes(batch: &Batch<PreviewPop>) -> usize {
    let bytes = |kept: &Kept<PreviewPop>| {
        let packed = kept.model.as_ref().map_or(0, |packed| {
            size_of_val(&**packed) + packed.timed.capacity() * size_of::<(f64, f64)>()
        });
        size_of_val(kept) + packed
    };
    batch.members.iter().map(bytes).max().unwrap()
}

#[test]
fn test_batch_one_bad_vehicle_refuses_all_or_is_marked() {
    let (mut batch, ..) = batch(5);
    let mut inputs = inputs(5);
    inputs[3].speed = f64::NAN;
    let mut angles = vec![0.0; 5];
    let before: Vec<_> = batch.states().collect();
    let refused = batch
        .steer(&inputs, 0.05, OnError::Raise, &[], &mut angles)
        .unwrap_err();
    assert_eq!((refused.vehicle, refused.error.field), (Some(3), "speed"));
    assert!(batch.states().eq(before));
    batch
        .steer(&inputs, 0.05, OnError::Mark, &[], &mut angles)
        .unwrap();
    let nan: Vec<bool> = angles.iter().map(|angle| angle.is_nan()).collect();
    assert_eq!(nan, [false, false, false, true, false]);
    let bad_dt = batch.steer(&inputs, f64::NAN, OnError::Mark, &[], &mut angles);
    assert!(bad_dt.is_err());
}

#[test]
fn test_batch_holds_where_no_time_passes_whatever_is_done_on_an_error() {
    let (mut batch, ..) = batch(2);
    let good = VehicleState {
        x: 1.0,
        y: 0.5,
        yaw: 0.1,
        speed: 3.0,
    };
    let mut step = |dt, on_error| {
        let mut out = [None; 2];
        let write = |place: &mut Option<Command>, command| *place = Some(command);
        batch
            .step(&[good; 2], dt, on_error, &[], &mut out, write)
            .unwrap();
        out.map(Option::unwrap)
    };
    let last = step(0.05, OnError::Raise);
    for (on_error, status) in [
        (OnError::Raise, Status::INPUT_HELD),
        (OnError::Mark, Status::INPUT_HELD),
        (OnError::Hold(3), Status::INPUT_HELD),
        (OnError::Hold(3), Status::INPUT_LOST),
    ] {
        let held = step(-60.0, on_error);
        assert_eq!(held, last.map(|command| Command { status, ..command }));
    }
}

#[test]
fn test_batch_refused_vehicle_keeps_its_direction_or_all_of_its_command() {
    let (mut batch, ..) = batch(2);
    let good = VehicleState {
        x: 230.0,
        y: -4.0,
        yaw: std::f64::consts::PI,
        speed: -3.0,
    };
    let bad = VehicleState {
        x: f64::NAN,
        ..good
    };
    let mut step = |input, on_error| {
        let mut out = [None; 2];
        let write = |place: &mut Option<Command>, command| *place = Some(command);
        batch
            .step(&[good, input], 0.05, on_error, &[], &mut out, write)
            .unwrap();
        out.map(Option::unwrap)
    };
    let [_, last] = step(good, OnError::Raise);
    assert!(last.reverse && last.status != Status::INPUT_HELD);
    let [other, marked] = step(bad, OnError::Mark);
    assert!(marked.steer.is_nan() && marked.reverse && !other.steer.is_nan());
    assert_eq!(marked.status, Status::INPUT_HELD);
    for status in [Status::INPUT_HELD, Status::INPUT_LOST] {
        // The one that was marked is the first of those in a row.
        let [_, held] = step(bad, OnError::Hold(2));
        assert_eq!(held, Command { status, ..last });
    }
}

#[test]
fn test_batch_old_poses_of_some_vehicles_are_theirs_alone() {
    let (mut batch, tracker, path) = batch(5);
    let mut states: Vec<_> = batch.states().collect();
    let old = Reported {
        pose_age: 0.1,
        ..Reported::NOTHING
    };
    let mut angles = vec![0.0; 5];
    for aged in [vec![1, 3], vec![], vec![3, 4]] {
        let reports: Vec<_> = (0..5)
            .map(|k| {
                if aged.contains(&k) {
                    old
                } else {
                    Reported::NOTHING
                }
            })
            .collect();
        let inputs = inputs(5);
        batch
            .steer(&inputs, 0.05, OnError::Raise, &reports, &mut angles)
            .unwrap();
        for ((state, &input), &report) in states.iter_mut().zip(&inputs).zip(&reports) {
            let single = tracker.steer(&path.view(), state, input, 0.05, report);
            single.unwrap();
        }
        assert!(batch.states().eq(states.iter().copied()));
        let with_past = states.iter().map(|state| state.model.past.is_some());
        assert!(with_past.take(5).any(|past| past) && states[0].model.is_empty());
    }
}

#[test]
fn test_batch_keeps_estimates_that_a_state_brings_along() {
    let (mut batch, ..) = batch(2);
    let mut states: Vec<_> = batch.states().collect();
    states[1].model.estimator.estimate.gain = 1.1;
    batch.set_states(states.clone());
    assert!(batch.states().eq(states));
}

#[test]
fn test_vehicle_without_a_dead_time_takes_little_memory() {
    // A large batch waits for its memory; copies share their tracker, which is as large again. All is
    // stepped in place; what is modelled of a vehicle lies elsewhere, at the cost of a pointer.
    let size = size_of::<Kept<Pop>>();
    assert!(size <= 816, "{size} bytes");
}
