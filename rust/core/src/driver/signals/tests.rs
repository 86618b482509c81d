use super::*;

/// What is rolled on by a time and back by it is where it was, within what steps and one arc differ by,
/// however it accelerates meanwhile.
#[test]
fn test_expected_vehicle_rolled_on_and_back_is_itself() {
    let car = Vehicle {
        rear_axle: -1.35,
        steer_lag: 0.1,
        ..Vehicle::DEFAULT
    };
    for (speed, acceleration) in [(6.0, 0.0), (6.0, 1.5), (6.0, -3.0), (-6.0, 3.0)] {
        let start = VehicleState {
            x: 3.0,
            y: -2.0,
            yaw: 0.4,
            speed,
        };
        for steer in [0.0, 0.1] {
            let settled = InFlight::settled(&car, steer);
            let steered = Steered {
                car: &car,
                in_flight: Some(&settled),
                steer,
                estimate: Estimate {
                    acceleration,
                    ..Estimate::DEFAULT
                },
            };
            let back = steered.back(steered.roll(start, 0.4), 0.4);
            let apart = [
                back.x - start.x,
                back.y - start.y,
                back.yaw - start.yaw,
                back.speed - start.speed,
            ];
            let most = apart
                .iter()
                .fold(0.0_f64, |most, each| most.max(each.abs()));
            assert!(most < 2e-3, "{acceleration} {steer}: {apart:?}");
        }
    }
}
