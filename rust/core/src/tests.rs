use crate::geometry::{Point, get_distance};
use crate::math::*;
use crate::status::Status;
use core::f64::consts::TAU;
use std::format;

#[test]
fn test_wrap_odd_function_exactly() {
    for angle in [0.0, 1.0, PI, 3.5, TAU, 7.0, 1e3, 12_345.678, 1e6] {
        assert_eq!(wrap(-angle), -wrap(angle));
        assert!(wrap(angle).abs() <= PI);
    }
}

#[test]
fn test_wrap_turns_by_whole_turns_and_only_where_it_has_to() {
    let (above, below) = (PI.next_up(), PI.next_down());
    for unchanged in [0.0, -0.0, 5e-324, 1.0, below, PI, -below, -PI] {
        assert_eq!(wrap(unchanged).to_bits(), f64::to_bits(unchanged));
    }
    // Written out: each is the angle less a whole number of turns, to the last bit.
    for (angle, turned) in [
        (above, above - TAU),
        (TAU, 0.0),
        (TAU.next_down(), TAU.next_down() - TAU),
        (TAU.next_up(), TAU.next_up() - TAU),
        (3.0 * PI, PI),
        (7.0, 0.716_814_692_820_413_8),
        (1e6, -0.357_564_167_046_753_3),
        (1e6_f64.next_down(), -0.357_564_167_163_168_63),
        (1e6_f64.next_up(), -0.357_564_166_930_338),
    ] {
        assert_eq!(wrap(angle).to_bits(), turned.to_bits(), "{angle}");
        assert_eq!(wrap(-angle).to_bits(), (-turned).to_bits(), "{angle}");
    }
    for none in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(wrap(none).is_nan());
    }
}

#[test]
fn test_remainder_is_that_of_the_operator_to_the_bit() {
    for value in [
        0.0,
        5e-324,
        1.0,
        6.2,
        TAU,
        6.3,
        20.0,
        1e6,
        f64::INFINITY,
        f64::NAN,
    ] {
        for period in [TAU, 1e-3, 1.0, 1e7] {
            for value in [value, -value] {
                let (fast, plain) = (remainder(value, period), value % period);
                assert!(fast.to_bits() == plain.to_bits() || plain.is_nan() && fast.is_nan());
            }
        }
    }
}

#[test]
fn test_saturate_inside_and_outside() {
    assert_eq!(saturate(-2.0, -1.0, 1.0), -1.0);
    assert_eq!(saturate(0.25, -1.0, 1.0), 0.25);
    assert_eq!(saturate(2.0, -1.0, 1.0), 1.0);
}

#[test]
fn test_saturate_at_its_bounds() {
    for bound in [-1.0, 1.0_f64] {
        assert_eq!(saturate(bound, -1.0, 1.0), bound);
        let (up, down) = (bound.next_up(), bound.next_down());
        assert_eq!(
            saturate(up, -1.0, 1.0),
            if bound > 0.0 { bound } else { up }
        );
        assert_eq!(
            saturate(down, -1.0, 1.0),
            if bound > 0.0 { down } else { bound }
        );
    }
    assert_eq!(saturate(5.0, 2.0, 2.0), 2.0);
    assert_eq!(saturate(f64::INFINITY, -1.0, 1.0), 1.0);
    assert_eq!(saturate(f64::NEG_INFINITY, -1.0, 1.0), -1.0);
    // A zero keeps its sign within equal bounds, and what is no number passes.
    assert!(saturate(-0.0, 0.0, 1.0).is_sign_negative());
    assert!(saturate(f64::NAN, -1.0, 1.0).is_nan());
    assert_eq!(saturate(3.0, f64::NAN, f64::NAN), 3.0);
}

#[test]
fn test_distance_is_the_root_of_the_squares() {
    let of = |a: [f64; 2], b: [f64; 2]| get_distance(Point::from(a), Point::from(b));
    assert_eq!(of([0.0, 0.0], [3.0, 4.0]), 5.0);
    assert_eq!(of([1.0, -2.0], [1.0, -2.0]), 0.0);
    assert_eq!(of([-0.0, 0.0], [0.0, -0.0]), 0.0);
    assert_eq!(of([-3e8, 4e8], [3e8, -4e8]), 1e9);
    assert_eq!(of([1.0, 2.0], [2.0, 4.5]), sqrt(1.0 + 6.25));
    assert_eq!(of([2.0, 4.5], [1.0, 2.0]), of([1.0, 2.0], [2.0, 4.5]));
    assert!(of([f64::NAN, 0.0], [0.0, 0.0]).is_nan());
}

#[test]
fn test_counts_saturate() {
    assert_eq!(to_count(f64::NAN), 0);
    assert_eq!(to_count(2.9), 2);
    assert_eq!(to_count(-3.5), 0);
    assert!(to_count(f64::INFINITY) > usize::MAX / 4);
    assert_eq!([2.0, 2.1, -0.5].map(ceil_to_count), [2, 3, 0]);
    assert_eq!(from_count(21), 21.0);
}

#[test]
fn test_rough_direction_is_within_a_thousandth() {
    for k in -4000..4000 {
        let angle = 0.005 * f64::from(k);
        let (c, s) = rough_direction(angle);
        assert!(
            (c - cos(angle)).abs() < 1e-3 && (s - sin(angle)).abs() < 1e-3,
            "{angle}"
        );
    }
}

#[test]
fn test_tangent_is_within_a_hundredth_and_finite_up_to_a_right_angle() {
    for k in 1..=125 {
        let angle = 0.01 * f64::from(k);
        assert!(
            (rough_tangent(angle) / tan(angle) - 1.0).abs() < 0.01,
            "{angle}"
        );
    }
    let right = rough_tangent(core::f64::consts::FRAC_PI_2);
    assert!(right.is_finite() && right > 10.0);
}

#[test]
fn test_status_conditions_stand_side_by_side() {
    let both = Status::SATURATED | Status::END_OF_PATH;
    assert!(both.contains(Status::SATURATED) && both.contains(Status::END_OF_PATH));
    assert!(!both.contains(Status::OFF_PATH) && both.contains(Status::OK));
    assert_eq!(format!("{both} {}", Status::OK), "saturated|end-of-path ok");
    assert_eq!(both.faults(), Status::OK);
    assert_eq!((both | Status::INPUT_LOST).faults(), Status::INPUT_LOST);
    assert_eq!(Status::OK.faults(), Status::OK);
    assert_eq!(Status::from_bits(both.bits()), Some(both));
    assert_eq!(Status::from_bits(1 << 31), None);
}

#[test]
fn test_status_every_condition_has_a_bit_of_its_own() {
    let all = Status::NAMES.iter().fold(0, |all, (each, _)| {
        assert_eq!(each.bits().count_ones(), 1);
        assert_eq!(all & each.bits(), 0);
        all | each.bits()
    });
    assert_eq!(all.count_ones(), 15);
}
