use super::*;
use crate::math::{sin, tan};
use crate::vehicle::InFlight;
use crate::vehicle::bicycle::advance;

fn car(wheelbase: f64, dead_time: f64, steer_offset: f64) -> Vehicle {
    Vehicle {
        wheelbase,
        steer_offset,
        dead_time,
        ..Vehicle::DEFAULT
    }
}

/// What is estimated of a vehicle with a wheelbase of 3 m, 0.2 s of dead time and a lag of
/// 0.1 s in 60 s of bends at 10 m/s and more, where `given` is believed.
fn estimated(given: &Vehicle, steer_offset: f64, acceleration: f64, jump: f64) -> Estimator {
    estimated_in(&[0.05], given, steer_offset, acceleration, jump)
}

/// The same in periods that take turns.
fn estimated_in(
    periods: &[f64],
    given: &Vehicle,
    steer_offset: f64,
    acceleration: f64,
    jump: f64,
) -> Estimator {
    estimated_of(
        &car(3.0, 0.2, steer_offset),
        periods,
        given,
        acceleration,
        jump,
    )
}

/// The same of the vehicle `real`.
fn estimated_of(
    real: &Vehicle,
    periods: &[f64],
    given: &Vehicle,
    acceleration: f64,
    jump: f64,
) -> Estimator {
    let (mut there, mut known) = (InFlight::settled(real, 0.0), InFlight::settled(given, 0.0));
    let mut estimator = Estimator::default();
    let mut vehicle = VehicleState {
        x: 0.0,
        y: 0.0,
        yaw: 0.0,
        speed: 10.0,
    };
    let (mut time, mut jumps) = (0.0, true);
    for &dt in periods.iter().cycle() {
        if time > 60.0 {
            break;
        }
        let command = 0.1 * sin(time);
        for _ in 0..10 {
            let step = 0.1 * dt;
            there.elapse(real, command, step, 0.0);
            let curvature = tan(there.wheel()) / 3.0;
            vehicle = advance(vehicle, vehicle.speed * step, curvature, 0.0);
            vehicle.speed += acceleration * step;
        }
        time += dt;
        if jumps && time > 45.0 {
            vehicle.yaw += jump;
            jumps = false;
        }
        let before = estimator.estimate;
        let quicker = before.quicker(given);
        let wheeled = quicker.as_ref().unwrap_or(given);
        let reached = known.wheel_integrals(wheeled, command, dt);
        estimator.observe_turn(&AdaptParams::DEFAULT, given, vehicle, reached, dt);
        let longer = estimator.estimate.dead_time(given) - before.dead_time(given);
        estimator.last_measured = Some(vehicle);
        known.elapse(wheeled, command, dt, longer);
    }
    estimator
}

#[test]
fn test_wheels_that_lag_less_than_told_leave_gain_and_offset_alone() {
    let given = car(3.0, 0.0, 0.0);
    let real = Vehicle {
        steer_lag: 0.0,
        ..given
    };
    let found = estimated_of(&real, &[0.05], &given, 0.0, 0.0);
    // No command acts before it is given.
    assert_eq!(found.estimate.dead_time(&given), 0.0);
    assert!(found.estimate.steer_lag(&given) < 0.01, "{found:?}");
    assert!((found.estimate.gain - 1.0).abs() < 0.01, "{found:?}");
    assert!(found.estimate.steer_offset.abs() < 0.002, "{found:?}");
    assert!(found.checked(&given).is_ok());
}

#[test]
fn test_slip_of_a_vehicle_that_hardly_moves_is_a_number() {
    let given = car(3.0, 0.0, 0.0);
    let params = AdaptParams::DEFAULT;
    for speed in [5e-324, 1e-320, 1e-300, 1e-9, -1e-308] {
        let state = |y| VehicleState {
            x: 0.0,
            y,
            yaw: 0.0,
            speed,
        };
        let mut estimator = Estimator {
            last_measured: Some(state(0.0)),
            ..Estimator::default()
        };
        estimator.observe_slip(&params, &given, state(0.1), 1e300, 0.05);
        assert!(estimator.checked(&given).is_ok(), "{estimator:?}");
    }
}

#[test]
fn test_estimator_finds_gain_dead_time_offset_and_acceleration() {
    for (wheelbase, dead_time) in [(3.0, 0.2), (2.55, 0.2), (3.45, 0.15), (3.0, 0.25)] {
        for offset in [0.0, 0.0175] {
            let found = estimated(&car(wheelbase, dead_time, 0.0), offset, 0.2, 0.0).estimate;
            assert!((found.gain - wheelbase / 3.0).abs() < 0.012, "{found:?}");
            assert!((found.steer_offset - offset).abs() < 0.0006, "{found:?}");
            let known = dead_time + found.longer_dead_time;
            assert!((known - 0.2).abs() < 0.011, "{found:?}");
            assert!((found.acceleration - 0.2).abs() < 1e-6, "{found:?}");
        }
    }
}

#[test]
fn test_estimator_learns_the_same_in_unequal_periods_and_at_every_rate() {
    // A dead time that is not given at all is a longer one too.
    for given in [car(2.7, 0.12, 0.0), car(2.7, 0.0, 0.0)] {
        let equal = estimated(&given, 0.02, 0.0, 0.0).estimate;
        assert!((given.dead_time + equal.longer_dead_time - 0.2).abs() < 0.02);
        for periods in [
            &[0.02, 0.03][..],
            &[0.04, 0.06],
            &[0.025, 0.075, 0.05],
            &[0.05, 0.05, 0.05, 0.2],
            &[0.1],
            &[0.02],
            &[0.01],
            &[0.005],
        ] {
            let found = estimated_in(periods, &given, 0.02, 0.0, 0.0).estimate;
            let apart = found.longer_dead_time - equal.longer_dead_time;
            assert!(apart.abs() < 6e-3, "{periods:?} {found:?} {equal:?}");
            assert!(
                (found.gain - equal.gain).abs() < 5e-3,
                "{periods:?} {found:?}"
            );
            let apart = found.steer_offset / equal.steer_offset - 1.0;
            assert!(apart.abs() < 0.02, "{periods:?} {found:?}");
        }
    }
}

#[test]
fn test_estimator_takes_no_offset_for_a_gain_on_a_straight() {
    // The driver holds the car straight against the offset of its wheels: nothing turns.
    let given = car(3.0, 0.2, 0.0);
    for offset in [0.02, 0.05, -0.05] {
        let mut line = InFlight::settled(&given, -offset);
        let mut estimator = Estimator::default();
        let mut vehicle = VehicleState {
            x: 0.0,
            y: 0.0,
            yaw: 0.0,
            speed: 20.0,
        };
        for _ in 0..800 {
            let reached = line.wheel_integrals(&given, -offset, 0.05);
            estimator.observe_turn(&AdaptParams::DEFAULT, &given, vehicle, reached, 0.05);
            estimator.last_measured = Some(vehicle);
            line.elapse(&given, -offset, 0.05, 0.0);
            vehicle.x += 1.0;
        }
        let found = estimator.estimate;
        // An understeer, at 20 m/s, explains a part of what is not known better.
        assert!((found.gain - 1.0).abs() < 0.04, "{found:?}");
        assert!((found.steer_offset - offset).abs() < 1e-3, "{found:?}");
    }
}

#[test]
fn test_estimator_takes_little_of_a_jump_of_the_heading() {
    let given = car(2.55, 0.25, 0.0);
    let calm = estimated(&given, 0.0, 0.0, 0.0).estimate;
    let jumped = estimated(&given, 0.0, 0.0, 2.0).estimate;
    assert!((calm.gain - jumped.gain).abs() < 0.03, "{jumped:?}");
    assert!(
        (calm.steer_offset - jumped.steer_offset).abs() < 0.003,
        "{jumped:?}"
    );
    assert!((calm.longer_dead_time - jumped.longer_dead_time).abs() < 0.02);
}

#[test]
fn test_estimator_keeps_within_its_bounds() {
    assert_eq!(
        estimated(&car(9.0, 0.2, 0.0), 0.0, 0.0, 0.0).estimate.gain,
        2.5
    );
    assert_eq!(
        estimated(&car(0.9, 0.2, 0.0), 0.0, 0.0, 0.0).estimate.gain,
        0.4
    );
    let given = car(3.0, 0.1, 0.0);
    let found = estimated(&given, 0.0, 0.0, 0.0);
    assert!((found.estimate.longer_dead_time - 0.1).abs() < 4e-3);
    assert!(found.checked(&given).is_ok());
    let mut shorter = found;
    shorter.estimate.longer_dead_time = -0.21;
    let refused = shorter.checked(&given).unwrap_err();
    assert_eq!(refused.field, "longer_dead_time");
    let mut slipping = found;
    slipping.sliding.mean.z = 1e41;
    assert_eq!(slipping.checked(&given).unwrap_err().value, 1e41);
    let mut noisy = found;
    noisy.turning.noise.variance = -1.0;
    assert_eq!(noisy.checked(&given).unwrap_err().field, "turning");
}

#[test]
fn test_slip_is_found_from_the_position_whichever_way_the_vehicle_drives() {
    let given = Vehicle::DEFAULT;
    for speed in [10.0, -10.0] {
        let mut estimator = Estimator::default();
        let mut vehicle = VehicleState {
            x: 0.0,
            y: 0.0,
            yaw: 0.3,
            speed,
        };
        for step in 0..2000 {
            estimator.last_measured = Some(vehicle);
            let curvature = match step / 20 % 3 {
                0 => 0.03,
                1 => 0.0,
                _ => -0.02,
            };
            let slip = 0.01 - 0.4 * curvature;
            vehicle = advance(vehicle, speed * 0.05, curvature, slip);
            let params = AdaptParams::DEFAULT;
            estimator.observe_slip(&params, &given, vehicle, curvature, 0.05);
        }
        let found = estimator.estimate;
        assert!((found.slip - 0.01).abs() < 1e-3, "{found:?}");
        assert!((found.slip_length + 0.4).abs() < 1e-2, "{found:?}");
    }
}

#[test]
fn test_speed_after_braking_stops() {
    let braking = |acceleration| Estimate {
        acceleration,
        ..Estimate::DEFAULT
    };
    assert_eq!(braking(-5.0).speed_after(1.0, 0.1), 0.5);
    assert_eq!(braking(-5.0).speed_after(1.0, 0.3), 0.0);
    assert_eq!(braking(5.0).speed_after(-1.0, 0.3), 0.0);
    assert_eq!(braking(-5.0).speed_after(-1.0, 0.2), -2.0);
    assert_eq!(braking(5.0).speed_after(MAX_SPEED, 1.0), MAX_SPEED);
    assert_eq!(braking(-5.0).speed_after(-MAX_SPEED, 1.0), -MAX_SPEED);
}

#[test]
fn test_estimates_outlast_a_stop_and_an_unmeasured_acceleration_does_not() {
    let given = car(2.7, 0.12, 0.0);
    let mut estimator = estimated(&given, 0.02, 0.5, 0.0);
    let before = estimator.estimate;
    assert!(before.acceleration > 0.4, "{before:?}");
    let standing = VehicleState::ORIGIN;
    estimator.last_measured = None;
    for _ in 0..40 {
        let nothing = WheelIntegrals::default();
        estimator.observe_turn(&AdaptParams::DEFAULT, &given, standing, nothing, 0.05);
    }
    assert!(estimator.estimate.acceleration.abs() < 1e-4);
    let mut known = InFlight::settled(&given, 0.1);
    for _ in 0..6000 {
        estimator.last_measured = Some(standing);
        let reached = known.wheel_integrals(&given, 0.1, 0.05);
        estimator.observe_turn(&AdaptParams::DEFAULT, &given, standing, reached, 0.05);
        known.elapse(&given, 0.1, 0.05, 0.0);
    }
    let after = estimator.estimate;
    assert!((after.gain - before.gain).abs() < 1e-3, "{after:?}");
    assert!((after.steer_offset - before.steer_offset).abs() < 1e-4);
    assert!((after.longer_dead_time - before.longer_dead_time).abs() < 1e-3);
}
