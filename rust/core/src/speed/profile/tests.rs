use super::*;
use crate::speed::limits::OverSpeed;
use crate::speed::limits::tests::{LIMITS, TWO, level};
use crate::vehicle::Vehicle;
use alloc::vec;
use alloc::vec::Vec;

fn plan(course: &Course<'_>, limits: &SpeedLimits<'_>) -> (Vec<f64>, Vec<Limit>) {
    let mut speed = vec![0.0; course.curvature.len()];
    let mut limit = vec![Limit::default(); speed.len()];
    plan_speeds(course, limits, &mut speed, &mut limit).unwrap();
    (speed, limit)
}

const STRAIGHT: Course<'static> = Course {
    curvature: &[0.0; 5],
    sharp: None,
    spacing: &[1.0; 4],
    closed: false,
    cusps: None,
    speed_limits: None,
    grade: None,
    start_speed: Some(0.0),
    end_speed: Some(0.0),
};

#[test]
fn test_straight_from_rest_to_rest_drives_then_brakes() {
    let (speed, limit) = plan(&STRAIGHT, &LIMITS);
    assert_eq!(speed, [0.0, 2.0, sqrt(8.0), 2.0, 0.0]);
    assert_eq!(limit[1], Limit::Driving);
    assert_eq!(limit[3], Limit::Braking);
    assert_eq!(limit[4], Limit::Stop);
}

#[test]
fn test_acceleration_holds_at_both_ends_of_each_segment() {
    let curvature: Vec<f64> = (0..200)
        .map(|k: u32| 0.1 * crate::math::sin(0.07 * f64::from(k)))
        .collect();
    let table = OverSpeed {
        speeds: &[0.0, 5.0, 15.0],
        values: &[1.0, 4.0, 0.5],
    };
    for acceleration in [TWO, table] {
        for exponent in [1.0, 1.5, 2.0, f64::INFINITY] {
            let limits = SpeedLimits {
                acceleration,
                exponent,
                ..LIMITS
            };
            let course = Course {
                curvature: &curvature,
                spacing: &[0.5; 199],
                ..STRAIGHT
            };
            let (speed, _) = plan(&course, &limits);
            for k in 0..199 {
                let (v, w) = (speed[k] * speed[k], speed[k + 1] * speed[k + 1]);
                let along = w - v; // over 0.5 m: the acceleration
                for (end, bend) in [(v, curvature[k]), (w, curvature[k + 1])] {
                    let up = limits.available(&level(&limits.acceleration), end, bend);
                    let down = limits.available(&level(&limits.deceleration), end, bend);
                    assert!(along <= up + 1e-9 && -along <= down + 1e-9, "{k} {along}");
                }
            }
        }
    }
}

#[test]
fn test_closed_lap_is_the_same_wherever_it_begins() {
    let curvature: Vec<f64> = (0..100)
        .map(|k: u32| 0.1 * crate::math::sin(0.062_831_853 * f64::from(k)))
        .collect();
    let lap = |shift: usize| {
        let mut curvature = curvature.clone();
        curvature.rotate_left(shift);
        let course = Course {
            curvature: &curvature,
            spacing: &[1.0; 100],
            closed: true,
            start_speed: None,
            end_speed: None,
            ..STRAIGHT
        };
        let mut speed = plan(&course, &LIMITS).0;
        speed.rotate_right(shift);
        speed
    };
    assert_eq!(lap(0), lap(37));
}

#[test]
fn test_wheels_turn_no_faster_than_their_rate() {
    let curvature: Vec<f64> = (0..60)
        .map(|k: u32| 0.15 * crate::math::sin(0.2 * f64::from(k)))
        .collect();
    for understeer in [0.0, 0.004] {
        let vehicle = Vehicle {
            max_steer_rate: Some(0.3),
            understeer,
            ..Vehicle::DEFAULT
        };
        let limits = SpeedLimits { vehicle, ..LIMITS };
        let course = Course {
            curvature: &curvature,
            spacing: &[1.0; 59],
            ..STRAIGHT
        };
        let (speed, limit) = plan(&course, &limits);
        assert!(limit.contains(&Limit::SteerRate));
        let wheel = |k: usize| crate::math::atan(curvature[k] * vehicle.turning_length(speed[k]));
        for k in 0..59 {
            let time = 2.0 / (speed[k] + speed[k + 1]);
            assert!((wheel(k + 1) - wheel(k)).abs() <= 0.3 * time + 1e-9);
        }
    }
}

/// How far wheels that turn by `jump` [1/m] at `rate` [1/m/s] from a cusp on shift a vehicle that drives
/// the speeds between waypoints `spacing` apart [m], by steps of time.
fn shift(speed: &[f64], spacing: f64, jump: f64, rate: f64) -> f64 {
    let (mut gone, mut time, mut heading, mut aside) = (1e-9_f64, 0.0, 0.0, 0.0);
    while rate * time < jump {
        let place = gone / spacing;
        let (at, share) = (crate::math::to_count(place), place.fract());
        let (from, to) = (speed[at] * speed[at], speed[at + 1] * speed[at + 1]);
        let step = 1e-5;
        let way = step * sqrt(from + (to - from) * share);
        heading += (jump - rate * time) * way;
        aside += heading * way;
        gone += way;
        time += step;
    }
    aside
}

#[test]
fn test_wheels_that_turn_behind_a_cusp_shift_the_vehicle_by_a_share_of_its_wheelbase() {
    let vehicle = Vehicle {
        wheelbase: 2.0,
        max_steer: 0.6,
        max_steer_rate: Some(0.8),
        ..Vehicle::PAPER
    };
    let limits = SpeedLimits { vehicle, ..LIMITS };
    let (cusps, spacing) = ([false, false, true, false, false, false, false], [0.25; 6]);
    // To the left forwards and backwards: the wheels turn from one side to the other.
    let left = [0.2; 7];
    let course = |curvature| Course {
        curvature,
        spacing: &spacing,
        cusps: Some(&cusps),
        ..STRAIGHT
    };
    let (speed, limit) = plan(&course(&left), &limits);
    assert_eq!(limit[3], Limit::SteerRate);
    let length = vehicle.turning_length(0.0);
    let shifted = shift(&speed[2..], 0.25, 0.4, 0.8 / length);
    assert!((shifted - 0.003 * 2.0).abs() < 1e-4, "{shifted}");
    // As fast as it may where they stay: the other way round a bend, on a straight, or turned at rest.
    let right = [0.2, 0.2, -0.2, -0.2, -0.2, -0.2, -0.2];
    let free = SpeedLimits {
        vehicle: Vehicle {
            steers_at_rest: true,
            ..vehicle
        },
        ..LIMITS
    };
    for (speed, _) in [
        plan(&course(&right), &limits),
        plan(&course(&[0.0; 7]), &limits),
        plan(&course(&left), &free),
    ] {
        assert!(shift(&speed[2..], 0.25, 0.4, 0.8 / length) > 5.0 * shifted);
    }
    // A cusp before a last leg of one segment slows no other waypoint.
    let last = [false, false, false, false, false, true, false];
    let short = Course {
        cusps: Some(&last),
        spacing: &[0.25; 6],
        start_speed: None,
        ..course(&left)
    };
    let (speed, _) = plan(&short, &SpeedLimits { vehicle, ..LIMITS });
    assert_eq!(speed[..6], plan(&short, &free).0[..6]);
}
