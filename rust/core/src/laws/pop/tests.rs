use super::*;
use crate::math::{cos, sin};
use proptest::prelude::*;

fn law(steer_span: f64, half: usize, max_steer: f64) -> Pop {
    let vehicle = Vehicle {
        max_steer,
        ..Vehicle::DEFAULT
    };
    let params = PopParams {
        steer_span,
        candidate_count: 2 * half + 1,
        ..PopParams::DEFAULT
    };
    Pop::new(vehicle, params).unwrap()
}

/// A bearing relative to the last wheel heading: anywhere, on a candidate, or half way
/// between two, where they tie.
fn bearings() -> impl Strategy<Value = (f64, f64)> {
    let nudge = prop_oneof![Just(0.0), -1e-15..1e-15, -1e-9..1e-9, -0.5..0.5];
    prop_oneof![
        (-3.2..3.2, Just(f64::NAN)),
        ((-30_i32..=30).prop_map(f64::from), nudge.clone()),
        ((-30_i32..=30).prop_map(|k| f64::from(k) + 0.5), nudge),
    ]
}

fn travels() -> impl Strategy<Value = f64> {
    prop_oneof![
        0.01..2.0,
        (-12.0..2.0).prop_map(|e| f64::powf(10.0, e)),
        Just(0.0)
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn test_choice_in_closed_form_is_that_of_the_loop(
        (place, nudge) in bearings(),
        travel in travels(),
        range in prop_oneof![1.0..20.0, (-6.0..4.0).prop_map(|e| f64::powf(10.0, e))],
        yaw in prop_oneof![-3.2..3.2, -1e6..1e6, Just(0.0)],
        previous in prop_oneof![-1.22..1.22, Just(0.0), Just(-0.0), Just(1.22), Just(-1.22)],
        span in prop_oneof![Just(3.0_f64.to_radians()), 1e-6..3.1],
        half in prop_oneof![Just(10_usize), 1_usize..60],
        max_steer in prop_oneof![Just(1.22), 0.01..1.57],
    ) {
        let law = law(span, half, max_steer);
        let previous = saturate(previous, -max_steer, max_steer);
        let step = span / from_count(half);
        let relative = if nudge.is_nan() { place } else { (place + nudge) * step };
        let bearing = yaw + previous + relative;
        let target = Point::new(range * cos(bearing), range * sin(bearing));
        let vehicle = VehicleState { x: 0.0, y: 0.0, yaw, speed: travel };
        if let Some(steer) = law.choose_in_closed_form(target, vehicle, previous, 1.0) {
            let by_loop = law.choose_by_loop(target, vehicle, previous, 1.0);
            prop_assert_eq!(steer.to_bits(), by_loop.to_bits());
        }
    }
}

#[test]
fn test_closed_form_decides_in_plain_driving() {
    let law = law(3.0_f64.to_radians(), 10, 1.22);
    let vehicle = VehicleState {
        x: 0.0,
        y: 0.0,
        yaw: 0.0,
        speed: 10.0,
    };
    let mut decided = 0;
    for k in 0..1000 {
        let bearing = -0.1 + 0.0002 * f64::from(k);
        let target = Point::new(8.0 * cos(bearing), 8.0 * sin(bearing));
        let steer = law.choose_in_closed_form(target, vehicle, 0.0, 0.05);
        decided += usize::from(steer.is_some());
    }
    assert!(decided > 990);
}
