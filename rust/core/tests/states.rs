//! States as data: out and in again they are the same, and the drive goes on to the bit.

use core::fmt::Debug;

use popsteer_core::laws::{
    LateralLaw, Pid, PidParams, Pop, PopParams, PreviewPop, PreviewPopParams, PreviewPopState,
    PurePursuit, PurePursuitParams, Stanley, StanleyParams,
};
use popsteer_core::tracker::TrackerState;
use popsteer_core::vehicle::Past;
use popsteer_core::{Path, Reported, Tracker, Vehicle, VehicleState};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, from_value, json, to_value};

const DT: f64 = 0.05;

fn car() -> Vehicle {
    Vehicle {
        dead_time: 0.15,
        steer_lag: 0.1,
        max_steer_rate: Some(0.5),
        rear_axle: -1.2,
        ..Vehicle::DEFAULT
    }
}

fn wave() -> Path {
    let x: Vec<f64> = (0..200).map(f64::from).collect();
    let y: Vec<f64> = x.iter().map(|x| 2.0 * (0.1 * x).sin()).collect();
    Path::new(&x, &y, None, false).unwrap()
}

/// Steps `count` times from the step `first` on; the angles' bits.
fn drive<L: LateralLaw>(
    tracker: &Tracker<L>,
    path: &Path,
    state: &mut TrackerState<L::State>,
    steps: core::ops::Range<u32>,
) -> Vec<u64> {
    steps
        .map(|k| {
            let x = 5.0 + 0.3 * f64::from(k);
            let vehicle = VehicleState {
                x,
                y: 2.0 * (0.1 * x).sin() + 0.3,
                yaw: 0.2 * (0.1 * x).cos(),
                speed: 6.0,
            };
            let steer = tracker.steer(&path.view(), state, vehicle, DT, Reported::NOTHING);
            steer.unwrap().to_bits()
        })
        .collect()
}

/// Takes a state out and in again in the midst of a drive; what it was as data.
fn through_data<L: LateralLaw>(tracker: &Tracker<L>) -> Value
where
    L::State: Serialize + DeserializeOwned + PartialEq + Debug,
{
    let path = wave();
    let mut state = tracker.initial_state();
    drive(tracker, &path, &mut state, 0..40);
    let data = to_value(&state).unwrap();
    let mut back: TrackerState<L::State> = from_value(data.clone()).unwrap();
    assert_eq!(back, state);
    assert_eq!(to_value(&back).unwrap(), data);
    let steps = 40..80;
    assert_eq!(
        drive(tracker, &path, &mut back, steps.clone()),
        drive(tracker, &path, &mut state, steps)
    );
    data
}

#[test]
fn test_states_go_out_and_in_again_in_the_midst_of_a_drive() {
    through_data(&Tracker::of(Pop::new(car(), PopParams::DEFAULT).unwrap()));
    through_data(&Tracker::of(
        PurePursuit::new(car(), PurePursuitParams::DEFAULT).unwrap(),
    ));
    through_data(&Tracker::of(
        Stanley::new(car(), StanleyParams::DEFAULT).unwrap(),
    ));
    through_data(&Tracker::of(Pid::new(car(), PidParams::DEFAULT).unwrap()));
    let preview = PreviewPop::new(car(), PreviewPopParams::DEFAULT).unwrap();
    let adapting = through_data(&Tracker::of(preview));
    let bare = through_data(&Tracker::new(preview, None).unwrap());
    assert_ne!(adapting["estimator"], bare["estimator"]);
}

#[test]
fn test_state_with_more_angles_than_a_ring_holds_is_refused() {
    let law = PreviewPop::new(car(), PreviewPopParams::DEFAULT).unwrap();
    // Its dead time is the given one: three periods.
    let tracker = Tracker::new(law, None).unwrap();
    let mut state = tracker.initial_state();
    drive(&tracker, &wave(), &mut state, 0..40);
    let mut data = to_value(state).unwrap();
    let row = data["in_flight"]["commands"].as_array_mut().unwrap();
    let (angle, kept) = (row[0].clone(), row.len());
    row.extend(vec![angle; 1000]);
    let refused = from_value::<TrackerState<PreviewPopState>>(data).unwrap_err();
    let said = refused.to_string();
    assert!(kept == 3 && said.contains("at most"), "{kept} {said}");
}

#[test]
fn test_past_that_no_wheels_can_have_is_refused() {
    let restored = |angle: f64, time: f64, wheel: f64, since: f64| {
        let angles = [(0.0, 0.5), (angle, time)];
        let data = json!({"angles": angles, "wheel": wheel, "since": since});
        from_value::<Past>(data).unwrap().check()
    };
    assert!(restored(0.1, 0.2, 0.1, 0.05).is_ok());
    for (angle, time, wheel, since, field) in [
        (1.6, 0.2, 0.1, 0.05, "past.angles"),
        (0.1, -0.2, 0.1, 0.05, "past.angles"),
        (0.1, 0.2, -1.6, 0.05, "past.wheel"),
        (0.1, 0.2, 0.1, -0.1, "past.since"),
    ] {
        let refused = restored(angle, time, wheel, since).unwrap_err();
        assert_eq!(refused.field, field);
    }
}

#[test]
fn test_state_outside_the_vehicle_is_refused_by_name() {
    let tracker = Tracker::of(Pop::new(car(), PopParams::DEFAULT).unwrap());
    let mut state = tracker.initial_state();
    state.law.previous_steer = 2.0;
    let refused = tracker.check_state(&wave().view(), &state).unwrap_err();
    assert_eq!((refused.field, refused.value), ("law.previous_steer", 2.0));
}

#[test]
fn test_a_parameters_unit_stands_in_its_text() {
    let unit = |name: &str| {
        let fields = PopParams::fields();
        fields
            .iter()
            .find(|field| field.name == name)
            .unwrap()
            .unit()
    };
    assert_eq!(unit("min_lookahead"), Some("m"));
    assert_eq!(unit("lookahead_gain"), Some("s"));
    assert_eq!(unit("candidate_count"), None);
}
