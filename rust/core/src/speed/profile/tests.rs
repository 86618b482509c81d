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
