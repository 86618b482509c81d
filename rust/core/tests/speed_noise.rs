//! What is believed of a speed that is measured in noise, by hand.

mod straight;

use popsteer_core::Vehicle;
use popsteer_core::speed::{SpeedTracker, SpeedTrackerParams, SpeedTrackerState};
use popsteer_core::vehicle::noise::Jitter;
use straight::{CAR, assert_close, beside, straight};

/// `v = z + r / (r + m^2) (v' - z)` of a measured `z`, an expected `v'`, the noise `r`, and `m` that the model
/// leaves open.
#[test]
fn test_speed_in_noise_is_the_mean_of_the_measured_and_the_expected_one() {
    let car = Vehicle {
        max_deceleration: Some(3.0),
        ..CAR
    };
    let params = SpeedTrackerParams {
        // Nothing else pushes.
        disturbance_time: 1e3,
        ..SpeedTrackerParams::DEFAULT
    };
    let tracker = SpeedTracker::new(car, params).unwrap();
    let (path, plan) = (straight(), vec![8.0; 100]);
    for (noise, measured) in [(0.0, 7.9), (0.03, 7.9), (0.03, 7.96), (0.3, 7.8)] {
        let mut state = SpeedTrackerState::default();
        let step = |along, speed, state: &mut SpeedTrackerState| {
            let vehicle = beside(along, 0.4, 0.0, speed);
            tracker.step(&path.view(), &plan, state, vehicle, 0.05)
        };
        step(32.1, 8.0, &mut state).unwrap();
        let gate = state.gate.as_mut().unwrap();
        gate.pace = Jitter {
            variance: noise * noise,
            ..Jitter::default()
        };
        let command = step(32.5, measured, &mut state).unwrap();
        // Nothing was commanded, so it is expected to be as fast as before.
        let believed = measured + noise * noise / (noise * noise + 0.03 * 0.03) * (8.0 - measured);
        assert_close(command.reference_speed, 8.0);
        let found = command.acceleration - 1.5 * (8.0 - believed);
        assert!(found.abs() < 1e-5, "{found}");
    }
}
