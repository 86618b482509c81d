use super::*;

#[test]
fn test_modelled_wheels_respond_as_the_vehicles_within_a_thirtieth_of_the_move() {
    for steer_lag in [0.0, 0.05, 0.2] {
        for (dt, max_steer_rate) in [(0.05, None), (0.01, None), (0.05, Some(0.6))] {
            let car = Vehicle {
                steer_lag,
                max_steer_rate,
                steer_offset: 0.02,
                ..Vehicle::PAPER
            };
            for (wheel, command) in [(0.1, 0.4), (0.3, -0.5), (-0.2, 0.1)] {
                let exact = car.move_wheel(wheel, command, dt);
                let (now, mean) = respond(&car, wheel, command, dt);
                let most = if steer_lag > 0.0 && max_steer_rate.is_some() {
                    // The rate limits the move of the whole period, not its quickest part.
                    0.6 * dt
                } else {
                    0.033
                        * (exact.wheel - wheel)
                            .abs()
                            .max((command + 0.02 - wheel).abs())
                };
                assert!(
                    (now - exact.wheel).abs() <= most,
                    "{now}, not {}",
                    exact.wheel
                );
                assert!(
                    (mean - exact.mean).abs() <= most,
                    "{mean}, not {}",
                    exact.mean
                );
                if let Some(rate) = max_steer_rate {
                    assert!((now - wheel).abs() <= rate * dt + 1e-12);
                }
                if steer_lag <= 0.0 && max_steer_rate.is_some() {
                    let turned = (0.6 * dt).copysign(command - wheel);
                    assert!((now - wheel - turned).abs() < 1e-12);
                    assert!((mean - wheel - 0.5 * turned).abs() < 1e-12);
                }
            }
        }
    }
}
