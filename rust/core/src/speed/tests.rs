use super::*;
use crate::Path;
use crate::math::{PI, cos, from_count, sin};
use alloc::vec::Vec;

#[test]
fn test_coupled_at_rest_full_throttle_and_brakes_beyond_the_limit() {
    let law = CoupledLongitudinal::new(CoupledLongitudinalParams::DEFAULT).unwrap();
    assert_eq!(
        law.step(0.0, 0.0),
        Ok(Pedals {
            throttle: 1.0,
            brake: 0.0
        })
    );
    let fast = law.step(4.0 * 69.44, 0.0).unwrap();
    assert_eq!(
        fast,
        Pedals {
            throttle: 0.0,
            brake: 1.0
        }
    );
    assert_eq!(law.step(f64::NAN, 0.0).unwrap_err().field, "speed");
}

#[test]
fn test_speed_pid_too_slow_throttles_and_too_fast_brakes() {
    let law = SpeedPid::new(SpeedPidParams::DEFAULT).unwrap();
    let mut state = SpeedPidState::default();
    assert_eq!(law.step(&mut state, 0.0, 20.0, 0.05).unwrap().throttle, 1.0);
    assert_eq!(law.step(&mut state, 20.0, 5.0, 0.05).unwrap().brake, 1.0);
    let before = state;
    assert!(law.step(&mut state, 20.0, f64::INFINITY, 0.05).is_err());
    assert_eq!(state, before);
}

fn circle(radius: f64, count: usize) -> Path {
    let angle = |k: usize| from_count(k) * 2.0 * PI / from_count(count);
    let (x, y): (Vec<_>, Vec<_>) = (0..count)
        .map(|k| (radius * cos(angle(k)), radius * sin(angle(k))))
        .unzip();
    Path::new(&x, &y, None, true).unwrap()
}

#[test]
fn test_curvature_of_a_circle_is_that_of_its_radius_at_any_spacing() {
    for count in [6, 60, 600, 6000] {
        let path = circle(20.0, count);
        for value in path_curvature(&path.view(), 2.0) {
            assert!((value - 0.05).abs() < 1e-3, "{count}: {value}");
        }
    }
}

#[test]
fn test_curvature_is_scaled_with_the_path() {
    let x: Vec<f64> = (0..60).map(from_count).collect();
    let y: Vec<f64> = x.iter().map(|x| 4.0 * sin(0.2 * x)).collect();
    let doubled = |values: &[f64]| values.iter().map(|v| 2.0 * v).collect::<Vec<_>>();
    let one = Path::new(&x, &y, None, false).unwrap();
    let two = Path::new(&doubled(&x), &doubled(&y), None, false).unwrap();
    let ones = path_curvature(&one.view(), 2.0);
    let twos = path_curvature(&two.view(), 4.0);
    for (one, two) in ones.iter().zip(&twos) {
        assert_eq!(*one, 2.0 * two);
    }
}

#[test]
fn test_curvature_does_not_reach_across_a_cusp() {
    // Forward along x, then backwards on a bend to the left of the way back.
    let angle = |k: usize| 0.05 * from_count(k);
    let (mut x, mut y): (Vec<_>, Vec<_>) = (0..30).map(|k| (from_count(k), 0.0)).unzip();
    for k in 1..30 {
        x.push(29.0 - 20.0 * sin(angle(k)));
        y.push(20.0 - 20.0 * cos(angle(k)));
    }
    let path = Path::new(&x, &y, None, false).unwrap();
    let reverse: Vec<bool> = (0..59).map(|k| k >= 29).collect();
    let path = path.with_reverse(&reverse).unwrap();
    let found = path_curvature(&path.view(), 2.0);
    for value in found.iter().take(29) {
        assert!(value.abs() < 1e-9, "{value}");
    }
    for value in found.iter().skip(29) {
        assert!((value + 0.05).abs() < 2e-3, "{value}");
    }
}

#[test]
fn test_short_paths_have_a_curvature() {
    let path = Path::new(&[0.0, 1.0], &[0.0, 0.0], None, false).unwrap();
    assert_eq!(path_curvature(&path.view(), 2.0), [0.0; 2]);
    let path = Path::new(&[0.0, 3.0, 3.0], &[0.0, 0.0, 3.0], None, false).unwrap();
    let found = path_curvature(&path.view(), 2.0);
    for value in &found {
        assert!((value - 2.0_f64.sqrt() / 3.0).abs() < 1e-12, "{value}");
    }
}
