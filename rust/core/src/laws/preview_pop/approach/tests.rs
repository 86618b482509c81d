use super::*;

/// A car of 2.7 m at 25 m/s within 4 m/s², wheels of 0.4 rad/s with 0.15 s of lag.
const FAST: Straightening = Straightening {
    curvature: 4.0 / 625.0,
    rate: 0.4 / (2.7 * 25.0),
    lag: 0.15 * 25.0,
    unlimited: 8.2,
};

#[test]
fn test_approach_is_straightened_on_the_way_that_remains() {
    for error in [0.5, 1.0, 3.0, 5.0] {
        let angle = FAST.steepest(0.25, error);
        assert!(angle < 0.25, "{error}");
        let turning = (0.5 * FAST.curvature / FAST.rate + 2.0 * FAST.lag).min(8.2);
        let way = angle * angle / (2.0 * FAST.curvature) + angle * turning;
        assert!((way - error).abs() < 1e-12, "{error} {way}");
    }
}

#[test]
fn test_approach_from_afar_is_the_approach_angle() {
    assert!((FAST.steepest(0.25, 20.0) - 0.25).abs() < 1e-15);
    assert!((FAST.steepest(0.25, 1e9) - 0.25).abs() < 1e-15);
}

#[test]
fn test_approach_close_to_the_path_is_that_of_the_unlimited_law() {
    let late = Straightening { lag: 1e3, ..FAST };
    let angle = late.steepest(0.25, 1e-6);
    assert!((angle * 8.2e6 - 1.0).abs() < 1e-5, "{angle}");
    assert!(late.steepest(0.25, 0.0) == 0.0);
}

#[test]
fn test_wheels_that_turn_slowly_straighten_by_the_curvature_that_they_reach() {
    // Out and back at their rate: the way is angle^1.5 / sqrt(rate) where the largest
    // curvature is just reached at the approach angle.
    let slow = Straightening {
        curvature: 1.0,
        rate: 0.01,
        lag: 0.0,
        unlimited: 1e3,
    };
    let way = 0.25 * (0.25_f64 / 0.01).sqrt();
    assert!((slow.steepest(0.25, way * (1.0 - 1e-9)) - 0.25).abs() < 1e-8);
    assert!(slow.steepest(0.25, 0.9 * way) < 0.24);
}

const RATED: Approach = Approach {
    rate: 0.4,
    rate_is_the_vehicles: true,
    max_tangent: 0.5,
    horizon: 1.0,
    angle: 0.25,
    min_speed: 5.0,
};

#[test]
fn test_horizon_is_as_long_as_the_wheels_need() {
    let car = Vehicle {
        steer_lag: 0.2,
        ..Vehicle::PAPER
    };
    for pace in [1.0_f64, 5.0, 25.0, 100.0] {
        let needed = 3.0 * 0.2 + 1.5 * (0.25 * 3.0 / (pace * 0.4)).sqrt();
        let found = RATED.horizon_at(&car, pace);
        assert!((found - needed.clamp(1.0, 2.0)).abs() < 1e-12, "{pace}");
    }
    let chosen = Approach {
        rate_is_the_vehicles: false,
        ..RATED
    };
    assert!((chosen.horizon_at(&car, 5.0) - 1.0).abs() < 1e-15);
}

#[test]
fn test_approach_is_flatter_for_a_vehicle_with_limits_alone() {
    let limited = Vehicle {
        max_lateral_acceleration: Some(4.0),
        ..Vehicle::PAPER
    };
    let chosen = Approach {
        rate_is_the_vehicles: false,
        ..RATED
    };
    let flat = FAST.steepest(0.25, 1.0);
    assert!(flat < 0.2);
    for error in [1.0, -1.0] {
        assert!((RATED.angle_at(&Vehicle::PAPER, error, &FAST) - flat).abs() < 1e-15);
        assert!((chosen.angle_at(&limited, error, &FAST) - flat).abs() < 1e-15);
        assert!((chosen.angle_at(&Vehicle::PAPER, error, &FAST) - 0.25).abs() < 1e-15);
    }
}

#[test]
fn test_widest_curvature_is_the_lesser_of_wheels_and_lateral_acceleration() {
    let car = |most| Vehicle {
        max_lateral_acceleration: most,
        ..Vehicle::PAPER
    };
    let widest = |most, pace| RATED.widest(&car(most), pace, 2.5);
    assert!((widest(None, 20.0) - 0.2).abs() < 1e-15);
    assert!((widest(Some(4.0), 20.0) - 0.01).abs() < 1e-15);
    assert!((widest(Some(4.0), 2.0) - 0.2).abs() < 1e-15);
}
