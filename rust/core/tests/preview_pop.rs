//! Preview POP of any parameters and any vehicle, driven anywhere.

use popsteer_core::laws::{PreviewPop, PreviewPopParams};
use popsteer_core::vehicle::AdaptParams;
use popsteer_core::{Path, Reported, Tracker, Vehicle, VehicleState};
use proptest::prelude::*;

/// Usual values, and those towards the ends of a range.
fn within(low: f64, high: f64, usual: f64) -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(usual),
        Just(low),
        Just(high),
        (0.0..1.0).prop_map(move |share: f64| low + share * (high - low)),
        (0.0..1.0).prop_map(move |share: f64| low + share.powi(9) * (high - low)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn test_preview_pop_of_any_parameters_answers_numbers_within_the_limit(
        costs in (within(0.0, 1e3, 3.0), within(1e-3, 1e3, 0.25), within(1e-3, 1.5, 0.25)),
        times in (within(0.05, 100.0, 1.0), within(0.0, 1e6, 0.5), within(0.0, 10.0, 0.1)),
        car in (within(1e-3, 1e3, 3.0), within(0.0, 1e3, 0.0), within(-1e3, 1e3, 0.0)),
        limits in (within(1e-3, 1.57, 1.22), within(1e-3, 1e6, 15.0), within(0.1, 1e3, 5.0)),
        delay in (within(0.0, 10.0, 0.0), within(-0.5, 0.5, 0.0), within(1e-3, 1e6, 0.5)),
        speeds in proptest::collection::vec(within(-1e4, 1e4, 12.0), 6),
        spots in proptest::collection::vec(
            (within(-1e9, 1e9, 30.0), within(-1e9, 1e9, 2.0), within(-1e6, 1e6, 0.1)),
            6,
        ),
        periods in proptest::collection::vec(within(1e-6, 1e3, 0.05), 6),
        smoothing in within(0.0, 1e3, 2.0),
        closed: bool,
    ) {
        let car = Vehicle {
            wheelbase: car.0,
            understeer: car.1,
            no_slip_point: Some(car.2),
            steer_lag: times.2,
            dead_time: delay.0,
            steer_offset: delay.1,
            max_steer_rate: Some(delay.2),
            max_steer: limits.0,
            max_lateral_acceleration: Some(limits.1),
            ..Vehicle::DEFAULT
        };
        let law = PreviewPop::new(car, PreviewPopParams {
            heading_cost: Some(costs.0),
            steer_rate_cost: Some(costs.1),
            approach_angle: costs.2,
            horizon: times.0,
            min_speed: Some(limits.2),
            smoothing_length: Some(smoothing),
            ..PreviewPopParams::DEFAULT
        }).unwrap();
        let adapt = AdaptParams {
            turn_time: times.1,
            slip_time: times.1,
            min_speed: Some(limits.2),
        };
        let law = Tracker::new(law, Some(adapt)).unwrap();
        let (x, y) = ([0.0, 30.0, 60.0, 61.0, 20.0], [0.0, 2.0, 0.0, 20.0, 20.0]);
        let path = Path::new(&x, &y, None, closed).unwrap();
        let view = path.view();
        let mut state = law.initial_state();
        for ((&speed, &(x, y, yaw)), &dt) in speeds.iter().zip(&spots).zip(&periods) {
            let vehicle = VehicleState { x, y, yaw, speed };
            let command = law.step(&view, &mut state, vehicle, dt, Reported::NOTHING).unwrap();
            prop_assert!(command.steer.abs() <= limits.0, "{command:?}");
            prop_assert!(command.cross_track_error.is_finite(), "{command:?}");
            prop_assert!(command.predicted_cross_track_error.is_finite(), "{command:?}");
            prop_assert_eq!(law.check_state(&view, &state), Ok(()));
        }
    }
}
