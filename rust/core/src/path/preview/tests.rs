use super::*;
use crate::Path;
use crate::math::{PI, cos, sin};
use alloc::vec::Vec;
use proptest::prelude::*;

fn circle(radius: f64, count: u32) -> Path {
    let angle = |k: u32| f64::from(k) * 2.0 * PI / f64::from(count);
    let (x, y): (Vec<_>, Vec<_>) = (0..count)
        .map(|k| (radius * cos(angle(k)), radius * sin(angle(k))))
        .unzip();
    Path::new(&x, &y, None, true).unwrap()
}

#[test]
fn test_preview_on_a_circle_turns_evenly_fine_and_coarse() {
    for count in [2000, 200, 20] {
        let path = circle(20.0, count);
        let view = path.view();
        let mut turns = [0.0; 40];
        let mut preview = Preview::new(&view, 2.0, 3, 110.0, 20.0);
        preview.turns(110.0, 0.5, &mut turns); // across the seam
        let wanted = 0.5 * 2.0 * PI / view.length();
        for turn in turns {
            assert!((turn - wanted).abs() < 0.2 * wanted, "{count}: {turn}");
        }
    }
}

#[test]
fn test_preview_beyond_the_ends_goes_straight_on() {
    let path = Path::new(&[0.0, 10.0, 10.0], &[0.0, 0.0, 10.0], None, false).unwrap();
    let view = path.view();
    let mut preview = Preview::new(&view, 2.0, 0, -50.0, 120.0);
    assert_eq!(preview.path_yaw(-50.0), 0.0);
    assert!((preview.path_yaw(70.0) - 0.5 * PI).abs() < 1e-15);
    assert!((preview.path_yaw(10.0) - 0.25 * PI).abs() < 1e-12);
}

#[test]
fn test_direction_of_one_place_looks_one_base_far_and_a_plan_farther() {
    let path = Path::new(&[0.0, 100.0, 100.0], &[0.0, 0.0, 100.0], None, false).unwrap();
    let view = path.view();
    assert_eq!(Preview::yaw_at(&view, 2.0, 0, 97.9), 0.0);
    assert!(Preview::yaw_at(&view, 2.0, 0, 98.1) > 0.0);
    assert!(Preview::new(&view, 2.0, 0, 91.0, 10.0).path_yaw(91.0) > 0.0);
}

#[test]
fn test_preview_of_a_path_that_doubles_back_takes_the_segment() {
    let path = Path::new(&[0.0, 10.0, 0.0], &[0.0, 0.0, 0.0], None, false).unwrap();
    let view = path.view();
    let mut preview = Preview::new(&view, 2.0, 0, 9.9, 1.0);
    assert_eq!(preview.path_yaw(9.9), 0.0);
    assert_eq!(preview.path_yaw(10.1), PI);
}

#[test]
fn test_preview_goes_straight_on_where_the_vehicle_turns_round() {
    let (x, y) = ([0.0, 10.0, 20.0, 20.0, 20.0], [0.0, 0.0, 0.0, 10.0, 0.0]);
    let path = Path::new(&x, &y, None, false).unwrap();
    let path = path
        .with_reverse(&[false, false, true, false, false])
        .unwrap();
    let view = path.view();
    let mut forward = Preview::new(&view, 2.0, 0, 0.0, 60.0);
    assert_eq!(
        [0.0, 19.9, 20.0, 40.0].map(|s| forward.path_yaw(s)),
        [0.0; 4]
    );
    let mut back = Preview::new(&view, 2.0, 2, 20.0, 60.0);
    assert_eq!(
        [10.0, 20.0, 29.9, 40.0].map(|s| back.path_yaw(s)),
        [0.5 * PI; 4]
    );
}

#[test]
fn test_preview_keeps_the_bend_of_an_end_for_a_reach_and_no_bend_of_noise() {
    let radius = 5.0;
    let along = |noise: f64| {
        let (x, y): (Vec<_>, Vec<_>) = (0..30)
            .map(|k: u32| {
                let angle = 0.2 * f64::from(k) / radius;
                let to = radius + if k % 2 == 0 { noise } else { -noise };
                (to * sin(angle), radius - to * cos(angle))
            })
            .unzip();
        Path::new(&x, &y, None, false).unwrap()
    };
    let bend = along(0.0);
    let end = bend.view().length();
    let turned = |path: &Path, distance: f64| {
        let view = path.view();
        let mut turn = [0.0];
        Preview::new(&view, 0.6, 20, end - 1.0, 9.0).turns(end - 1.0, 1.0 + distance, &mut turn);
        turn[0] - 1.0 / radius
    };
    // A chord's reach is 3 m; half a base about it the path bends by half.
    for (distance, wanted) in [(1.0, 0.2), (2.0, 0.4), (4.0, 0.6), (7.0, 0.6)] {
        let found = turned(&bend, distance);
        assert!((found - wanted).abs() < 0.01, "{distance}: {found}");
    }
    let place = |view| Preview::yaw_at(view, 0.6, 20, end + 1.0);
    assert!((place(&bend.view()) - end / radius).abs() < 0.03);

    let straight = |noise: [f64; 4]| {
        let y: Vec<f64> = (0..40_usize).map(|k| noise[k / 5 % 4]).collect();
        let x: Vec<f64> = (0..40_u32).map(|k| 0.2 * f64::from(k)).collect();
        Path::new(&x, &y, None, false).unwrap()
    };
    let noisy = straight([0.02, -0.02, 0.02, -0.02]);
    let view = noisy.view();
    let yaw = Preview::new(&view, 0.6, 30, 7.0, 9.0).path_yaw(12.0);
    assert!(yaw.abs() < 0.03, "{yaw}");
}

#[test]
fn test_preview_keeps_the_bend_of_headings_and_of_a_last_leg_but_none_before_a_cusp() {
    let angle = |k: u32| 0.04 * f64::from(k);
    let (mut x, mut y): (Vec<_>, Vec<_>) = (0..30)
        .map(|k| (5.0 * sin(angle(k)), 5.0 - 5.0 * cos(angle(k))))
        .unzip();
    let yaw: Vec<f64> = (0..30).map(angle).collect();
    let given = Path::new(&x, &y, None, false).unwrap();
    let given = given.with_yaw(Some(&yaw), None).unwrap();
    let view = given.view();
    let end = view.length();
    let found = Preview::new(&view, 0.6, 20, end - 1.0, 9.0).path_yaw(end + 2.0);
    assert!((found - angle(29) - 0.4).abs() < 0.01, "{found}");

    // The same backwards after 4 m along its first tangent, and on from there after a cusp.
    let (mut u, mut v): (Vec<_>, Vec<_>) =
        (1..=10).rev().map(|k| (-0.4 * f64::from(k), 0.0)).unzip();
    u.append(&mut x);
    v.append(&mut y);
    for k in 1..10 {
        x.push(u[39] - 0.4 * f64::from(k) * cos(angle(29)));
        y.push(v[39] - 0.4 * f64::from(k) * sin(angle(29)));
    }
    let leg = Path::new(&u, &v, None, false).unwrap();
    let leg = leg.with_reverse(&[true; 40]).unwrap();
    let view = leg.view();
    let end = view.length();
    let found = Preview::new(&view, 0.6, 30, end - 1.0, 9.0).path_yaw(end + 2.0);
    assert!((found - angle(29) - 0.4).abs() < 0.01, "{found}");

    u.append(&mut x);
    v.append(&mut y);
    let reverse: Vec<bool> = (0..u.len()).map(|k| k < 39).collect();
    let path = Path::new(&u, &v, None, false).unwrap();
    let path = path.with_reverse(&reverse).unwrap();
    let view = path.view();
    let found = Preview::new(&view, 0.6, 30, end - 1.0, 9.0).path_yaw(end + 2.0);
    assert!((found - angle(29)).abs() < 0.03, "{found}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn test_angle_between_two_directions_is_the_difference_of_their_angles(
        yaw in -3.1..3.1_f64,
        angle in prop_oneof![-3.1..3.1_f64, -0.13..0.13_f64],
        (a, b) in (1e-6..1e6_f64, 1e-6..1e6_f64),
    ) {
        let (from, to) = (yaw, yaw + angle);
        let found = angle_between((a * cos(from), a * sin(from)), (b * cos(to), b * sin(to)));
        prop_assert!((found - angle).abs() < 4e-15, "{found} {angle}");
    }

    #[test]
    fn test_segment_near_any_other_is_that_by_definition(
        arc_length in prop_oneof![-30.0..160.0, (0_u8..140).prop_map(f64::from)],
        near in 0_usize..120,
        closed: bool,
    ) {
        let x: Vec<f64> = (0..100).map(|k: u32| f64::from(k) + 0.3 * sin(f64::from(k))).collect();
        let y: Vec<f64> = (0..100).map(|k: u32| 5.0 * sin(f64::from(k) / 9.0)).collect();
        let path = Path::new(&x, &y, None, closed).unwrap();
        let view = path.view();
        let plain = view.s().iter().rposition(|&s| s <= arc_length).unwrap_or(0);
        let plain = plain.min(view.segments() - 1);
        prop_assert_eq!(view.segment_by_arc(arc_length, near), plain);
    }
}
