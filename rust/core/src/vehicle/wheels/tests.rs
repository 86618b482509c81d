use super::*;
use crate::math::exp;

fn car(steer_lag: f64, max_steer_rate: Option<f64>) -> Vehicle {
    Vehicle {
        steer_lag,
        max_steer_rate,
        ..Vehicle::DEFAULT
    }
}

#[test]
fn test_move_wheel_is_a_first_order_response_with_a_limited_rate() {
    let lagging = car(0.1, None).move_wheel(0.0, 1.0, 0.1);
    assert!((lagging.wheel - (1.0 - exp(-1.0))).abs() < 1e-15);
    let slow = car(0.0, Some(0.5));
    assert_eq!(slow.move_wheel(0.0, 1.0, 0.1).wheel, 0.05);
    assert_eq!(slow.move_wheel(0.0, 0.01, 0.1).wheel, 0.01);
    // Against the differential equation in small steps.
    let both = car(0.2, Some(0.4));
    for (start, command, time) in [(0.0, 0.3, 0.5), (0.1, -0.6, 2.5), (0.2, 0.25, 0.3)] {
        let (mut wheel, mut sum) = (start, 0.0);
        let step = time / 1e5;
        for _ in 0..100_000 {
            let rate = saturate((command - wheel) / 0.2, -0.4, 0.4);
            sum += (wheel + 0.5 * rate * step) * step;
            wheel += rate * step;
        }
        let moved = both.move_wheel(start, command, time);
        assert!((moved.wheel - wheel).abs() < 1e-5, "{moved:?} {wheel}");
        assert!((moved.mean - sum / time).abs() < 1e-5, "{moved:?}");
    }
}
