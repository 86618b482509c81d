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

/// Waypoints `spacing` apart on an arc of 5 m in radius; their angles.
fn arc(spacing: f64, count: u32) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let angles: Vec<f64> = (0..count).map(|k| spacing * f64::from(k) / 5.0).collect();
    let x = angles.iter().map(|&angle| 5.0 * sin(angle)).collect();
    let y = angles.iter().map(|&angle| 5.0 - 5.0 * cos(angle)).collect();
    (x, y, angles)
}

/// The direction of a path so far beyond its end, with chords that reach 3 m.
fn yaw_beyond(path: &Path, beyond: f64) -> f64 {
    let view = path.view();
    let end = view.length();
    let mut preview = Preview::new(
        &view,
        0.6,
        view.segments().saturating_sub(3),
        end - 0.5,
        9.0,
    );
    preview.path_yaw(end + beyond)
}

#[test]
fn test_preview_keeps_the_bend_of_an_end_for_a_reach() {
    let (x, y, angles) = arc(0.2, 30);
    let path = Path::new(&x, &y, None, false).unwrap();
    let given = path.clone().with_yaw(Some(&angles), None).unwrap();
    for (beyond, turn) in [(1.0, 0.2), (2.0, 0.4), (4.0, 0.6), (7.0, 0.6)] {
        for path in [&path, &given] {
            let found = yaw_beyond(path, beyond);
            assert!((found - (1.16 + turn)).abs() < 0.01, "{beyond}: {found}");
        }
    }
    // A controller that steers by the direction of one place alone sees the path go straight on.
    let view = path.view();
    let place = Preview::yaw_at(&view, 0.6, 26, view.length() + 2.0);
    assert!((place - 1.16).abs() < 0.03, "{place}");
}

#[test]
fn test_preview_makes_no_bend_of_noise_or_of_the_last_few_waypoints() {
    let x: Vec<f64> = (0..40).map(|k| 0.2 * f64::from(k)).collect();
    let noisy: Vec<f64> = (0..40)
        .map(|k| if k / 5 % 2 == 0 { 0.02 } else { -0.02 })
        .collect();
    let path = Path::new(&x, &noisy, None, false).unwrap();
    assert!(yaw_beyond(&path, 4.0).abs() < 0.03);
    // 0.6 m of a bend are less than the last chord.
    let y: Vec<f64> = x
        .iter()
        .map(|x| if *x > 7.2 { (x - 7.2) * (x - 7.2) } else { 0.0 })
        .collect();
    let path = Path::new(&x, &y, None, false).unwrap();
    assert!((yaw_beyond(&path, 4.0) - yaw_beyond(&path, 0.5)).abs() < 0.01);
    let short = Path::new(&[0.0, 1.0, 1.9], &[0.0, 0.0, 0.2], None, false).unwrap();
    assert!((yaw_beyond(&short, 4.0) - atan2(0.2, 0.9)).abs() < 1e-12);
}

#[test]
fn test_preview_keeps_the_bend_of_a_last_leg_but_none_before_a_cusp() {
    let (bend_x, bend_y, _) = arc(0.2, 30);
    let straight = (1..=10).rev().map(|k| (-0.4 * f64::from(k), 0.0));
    let bend = bend_x.into_iter().zip(bend_y);
    let points: Vec<(f64, f64)> = straight.chain(bend).collect();
    let back = (1..10).map(|k| {
        let (x, y) = *points.last().unwrap();
        let along = -0.4 * f64::from(k);
        (x + along * cos(1.16), y + along * sin(1.16))
    });
    let (x, y): (Vec<_>, Vec<_>) = points.iter().copied().unzip();
    let leg = Path::new(&x, &y, None, false).unwrap();
    let leg = leg.with_reverse(&[true; 40]).unwrap();
    assert!((yaw_beyond(&leg, 2.0) - 1.56).abs() < 0.01);

    let (x, y): (Vec<_>, Vec<_>) = points.iter().copied().chain(back).unzip();
    let reverse: Vec<bool> = (0..x.len()).map(|k| k < 39).collect();
    let path = Path::new(&x, &y, None, false).unwrap();
    let path = path.with_reverse(&reverse).unwrap();
    let view = path.view();
    let end = leg.view().length();
    let before_cusp = Preview::new(&view, 0.6, 30, end - 1.0, 9.0).path_yaw(end + 2.0);
    assert!((before_cusp - 1.16).abs() < 0.03, "{before_cusp}");
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
        let (from, to) = (Point::new(cos(from), sin(from)), Point::new(cos(to), sin(to)));
        let found = angle_between(from * a, to * b);
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

#[test]
fn test_preview_makes_no_bend_of_a_long_straight_segment_before_short_ones() {
    let (bend_x, bend_y, angles) = arc(0.2, 30);
    let (mut x, mut y) = (alloc::vec![-20.0], alloc::vec![0.0]);
    x.extend(&bend_x);
    y.extend(&bend_y);
    let back: Vec<f64> = bend_x.iter().rev().map(|x| -x).collect();
    let coming: Vec<f64> = bend_y.iter().rev().map(|y| -y).collect();
    let path = Path::new(&x, &y, None, false).unwrap();
    let view = path.view();
    let mut preview = Preview::new(&view, 2.0, 0, 10.0, 20.0);
    for before in [9.0, 5.0, 3.0] {
        assert!(preview.path_yaw(20.0 - before).abs() < 1e-3, "{before}");
    }
    // On the bend it is the bend's, from the first waypoint on.
    for (k, &angle) in angles.iter().enumerate().skip(6).take(15) {
        let yaw = preview.path_yaw(view.arc(k + 1));
        assert!((yaw - angle).abs() < 0.01, "{k}: {yaw}");
    }
    // The same where the bend comes first.
    let (mut x, mut y) = (back, coming);
    x.push(20.0);
    y.push(0.0);
    let path = Path::new(&x, &y, None, false).unwrap();
    let view = path.view();
    let start = view.length() - 20.0;
    let mut preview = Preview::new(&view, 2.0, 0, 0.0, 40.0);
    for beyond in [3.0, 5.0, 9.0] {
        assert!(preview.path_yaw(start + beyond).abs() < 1e-3, "{beyond}");
    }
}
