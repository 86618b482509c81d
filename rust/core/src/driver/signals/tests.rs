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
                noise: 0.0,
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

/// A heading that is blamed is put right by where the positions go, forwards and backwards; before, it
/// is what the wheels make of it.
#[test]
fn test_heading_that_is_blamed_is_found_by_the_positions() {
    let car = Vehicle::DEFAULT;
    for (speed, blamed, least, most) in [
        (8.0, Some(Fault::Heading), -0.01, 0.01),
        (-8.0, Some(Fault::Heading), -0.01, 0.01),
        (8.0, None, 0.29, 0.31),
    ] {
        let mut signals = Signals {
            believed: Some(VehicleState {
                x: 0.0,
                y: 0.0,
                yaw: 0.3,
                speed,
            }),
            ..Signals::default()
        };
        for k in 1..=40 {
            let sensed = VehicleState {
                x: 0.05 * speed * f64::from(k),
                y: 0.0,
                yaw: f64::NAN,
                speed,
            };
            let steered = || Steered {
                car: &car,
                noise: 0.02,
                in_flight: None,
                steer: 0.0,
                estimate: Estimate::DEFAULT,
            };
            let found = signals.complete(steered, sensed, (0.0, blamed), 0.05);
            signals.believed = Some(found);
        }
        let yaw = signals.believed.unwrap().yaw;
        assert!((least..=most).contains(&yaw), "{speed}: {yaw}");
    }
}
