//! The curve that headings and curvatures of a planner's own make of a path.

use popsteer_core::path::preview::Preview;
use popsteer_core::path::{Follow, Path};
use popsteer_core::vehicle::VehicleState;
use popsteer_core::{PathError, Vehicle};

const RADIUS: f64 = 20.0;

/// Waypoints on a circle, some 5 m apart, with the direction of the circle there.
fn circle(count: u32) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let angles: Vec<f64> = (0..count)
        .map(|k| std::f64::consts::TAU * f64::from(k) / f64::from(count))
        .collect();
    let x = angles.iter().map(|angle| RADIUS * angle.sin()).collect();
    let y = angles
        .iter()
        .map(|angle| RADIUS * (1.0 - angle.cos()))
        .collect();
    (x, y, angles)
}

fn wrap(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}

#[test]
fn test_shape_of_a_circle_is_the_circle_forwards_and_backwards() {
    let (x, y, yaw) = circle(25);
    let bends = vec![1.0 / RADIUS; x.len()];
    let plain = Path::new(&x, &y, None, true).unwrap();
    let against: Vec<f64> = yaw.iter().map(|yaw| yaw + std::f64::consts::PI).collect();
    let backwards = plain.clone().with_reverse(&vec![true; x.len()]).unwrap();
    let negative: Vec<f64> = bends.iter().map(|bend| -bend).collect();
    let paths = [
        (
            plain.clone().with_yaw(Some(&yaw), Some(&bends)).unwrap(),
            5e-3,
        ),
        (plain.clone().with_yaw(Some(&yaw), None).unwrap(), 5e-3),
        (plain.clone().with_yaw(None, Some(&bends)).unwrap(), 5e-3),
        (plain.clone().with_yaw(None, None).unwrap(), 5e-3),
        (
            backwards.with_yaw(Some(&against), Some(&negative)).unwrap(),
            5e-3,
        ),
        (plain, 0.2),
    ];
    let follow = Follow::of(&Vehicle::PAPER, 0.0, 0.0);
    for (path, most) in &paths {
        let view = path.view();
        let mut worst: (f64, f64, f64) = (0.0, 0.0, 0.0);
        for k in 0..500 {
            let angle = 0.0125 * f64::from(k);
            let sign = if view.is_reverse(0) { -1.0 } else { 1.0 };
            let pose = VehicleState {
                x: (RADIUS - 0.5) * angle.sin(),
                y: RADIUS - (RADIUS - 0.5) * angle.cos(),
                yaw: if sign < 0.0 {
                    angle + std::f64::consts::PI
                } else {
                    angle
                },
                speed: 5.0 * sign,
            };
            let at = follow.locate(&view, None, pose, 0.05);
            worst.0 = worst.0.max((at.closest.cross_track_error() - 0.5).abs());
            worst.1 = worst.1.max(wrap(at.closest.path_yaw() - angle).abs());
            let (segment, arc) = (at.closest.segment, at.closest.arc_length(&view));
            let yaw = Preview::yaw_at(&view, 2.0, segment, arc);
            worst.2 = worst.2.max(wrap(yaw - angle).abs());
            let mut turns = [0.0; 4];
            Preview::new(&view, 2.0, segment, arc, 4.0).turns(arc, 1.0, &mut turns);
            // Chords are shorter than their arcs, by half a percent.
            assert!(*most > 0.1 || turns.iter().all(|turn| (turn - 0.05).abs() < 1e-3));
        }
        let (error, heading, smoothed) = worst;
        assert!(
            error < *most && heading < *most && smoothed < *most,
            "{worst:?} {most}"
        );
    }
    let (_, plain) = paths.last().map(|(path, most)| (path, most)).unwrap();
    assert!(*plain > 0.1);
}

#[test]
fn test_shape_that_the_waypoints_contradict_is_refused_with_waypoint_and_value() {
    let (x, y, yaw) = circle(60);
    let plain = Path::new(&x, &y, None, true).unwrap();
    let refused = |yaw: Option<&[f64]>, curvature: Option<&[f64]>| {
        plain.clone().with_yaw(yaw, curvature).unwrap_err()
    };
    let mut one = yaw.clone();
    one[7] += 0.8;
    let error = refused(Some(&one), None);
    let PathError::Contradicting {
        field: "yaw",
        index: 7,
        value,
        expected,
    } = error
    else {
        panic!("{error}");
    };
    assert!((value - one[7]).abs() < 1e-12 && (expected - yaw[7]).abs() < 0.1);
    assert!(
        error.to_string().starts_with("yaw of waypoint 7 is 1.5"),
        "{error}"
    );
    for factor in [-1.0, 0.5, 2.0, 57.3] {
        let bends = vec![factor / RADIUS; 60];
        let error = refused(Some(&yaw), Some(&bends));
        assert!(
            matches!(
                error,
                PathError::Contradicting {
                    field: "curvature",
                    ..
                }
            ),
            "{error}"
        );
    }
    let degrees: Vec<f64> = yaw.iter().map(|yaw| yaw.to_degrees()).collect();
    let mirrored: Vec<f64> = yaw.iter().map(|yaw| -yaw).collect();
    let north: Vec<f64> = yaw
        .iter()
        .map(|yaw| std::f64::consts::FRAC_PI_2 - yaw)
        .collect();
    for wrong in [degrees, mirrored, north, vec![0.0; 60]] {
        let error = refused(Some(&wrong), None);
        assert!(
            matches!(error, PathError::Contradicting { field: "yaw", .. }),
            "{error}"
        );
    }
    one[7] = f64::NAN;
    let error = refused(Some(&one), None);
    assert!(matches!(
        error,
        PathError::OutOfRange {
            field: "yaw",
            index: 7,
            ..
        }
    ));
    let error = refused(Some(&one[1..]), None);
    assert!(matches!(
        error,
        PathError::LengthMismatch {
            field: "yaw",
            length: 59,
            ..
        }
    ));
    // Centimetres of noise, and a planner's direction to the next waypoint, are no contradiction.
    let noisy: Vec<f64> = yaw
        .iter()
        .zip(0..)
        .map(|(yaw, k)| yaw + 0.1 * f64::from(k % 3 - 1))
        .collect();
    plain.clone().with_yaw(Some(&noisy), None).unwrap();
    let next: Vec<f64> = yaw.iter().map(|yaw| yaw + 0.05).collect();
    plain
        .clone()
        .with_yaw(Some(&next), Some(&[1.0 / RADIUS; 60]))
        .unwrap();
}

#[test]
fn test_shape_at_a_cusp_is_the_vehicles_heading_on_both_sides() {
    let x: Vec<f64> = [0.0, 5.0, 10.0, 5.0, 0.0].into();
    let path = Path::new(&x, &[0.0; 5], None, false)
        .unwrap()
        .with_reverse(&[false, false, true, true, true])
        .unwrap();
    let path = path.with_yaw(Some(&[0.0; 5]), Some(&[0.0; 5])).unwrap();
    let spline = Path::new(&x, &[0.0; 5], None, false)
        .unwrap()
        .with_reverse(&[false, false, true, true, true])
        .unwrap()
        .with_yaw(None, None)
        .unwrap();
    let yaw = spline.view().yaw().unwrap();
    assert!(yaw.iter().all(|yaw| wrap(*yaw).abs() < 1e-12), "{yaw:?}");
    let follow = Follow::of(&Vehicle::PAPER, 0.0, 0.0);
    for (segment, direction) in [(0, 0.0), (2, std::f64::consts::PI)] {
        let pose = VehicleState {
            x: 3.0,
            y: 0.2,
            yaw: 0.0,
            speed: 1.0,
        };
        let at = follow.locate(&path.view(), Some(segment), pose, 0.05);
        assert!(wrap(at.closest.path_yaw() - direction).abs() < 1e-12);
        assert!((at.closest.cross_track_error().abs() - 0.2).abs() < 1e-12);
    }
}

#[test]
fn test_shape_of_tight_arcs_is_taken_at_their_ends_and_where_they_turn_over() {
    for radius in [0.2, 0.3, 0.5, 1.0, 5.0] {
        for spacing in [0.02, 0.05] {
            // An S: half of it to the left, then to the right.
            let count = popsteer_core::math::to_count(2.4 * radius / spacing);
            let (mut x, mut y, mut yaw, mut bends) = (vec![0.0], vec![0.0], vec![0.0], vec![]);
            for k in 0..count {
                let curvature = if k < count / 2 { 1.0 } else { -1.0 } / radius;
                let middle = yaw[k] + 0.5 * spacing * curvature;
                x.push(x[k] + spacing * f64::cos(middle));
                y.push(y[k] + spacing * f64::sin(middle));
                yaw.push(yaw[k] + spacing * curvature);
                bends.push(curvature);
            }
            bends.push(-1.0 / radius);
            let plain = Path::new(&x, &y, None, false).unwrap();
            for curvature in [None, Some(&bends[..])] {
                let shaped = plain.clone().with_yaw(Some(&yaw), curvature);
                assert!(shaped.is_ok(), "{radius} {spacing}: {shaped:?}");
            }
            let mirrored: Vec<f64> = yaw.iter().map(|yaw| -yaw).collect();
            let turned: Vec<f64> = yaw.iter().map(|yaw| yaw + 1.5).collect();
            for wrong in [mirrored, turned] {
                let refused = plain.clone().with_yaw(Some(&wrong), None);
                assert!(refused.is_err(), "{radius} {spacing}");
            }
        }
    }
}

/// A waypoint a centimetre beside another divides the noise of a heading by a centimetre. The direction
/// stays within that of the headings beside it, as without.
#[test]
fn test_shape_is_as_smooth_with_a_waypoint_close_to_another() {
    for gap in [0.5, 0.1, 0.01, 0.001] {
        let mut x: Vec<f64> = (0..20).map(|k| 2.0 * f64::from(k)).collect();
        x.insert(10, x[9] + gap);
        let yaw: Vec<f64> = (0..21)
            .map(|k| 0.01 * f64::from(k % 3 - 1) + if k == 10 { 0.02 } else { 0.0 })
            .collect();
        let path = Path::new(&x, &[0.0; 21], None, false).unwrap();
        let path = path.with_yaw(Some(&yaw), None).unwrap();
        let most = yaw.iter().fold(0.0, |most: f64, yaw| most.max(yaw.abs()));
        for k in 0..380 {
            let arc = 0.1 * f64::from(k);
            let yaw = Preview::yaw_at(&path.view(), 2.0, 0, arc);
            assert!(yaw.abs() < 1.4 * most, "{yaw} at {arc} with {gap}");
        }
    }
}

/// Before its start and beyond its end a path goes on straight, in the direction that it has there.
#[test]
fn test_shape_goes_on_beyond_its_ends_in_its_own_direction() {
    let (x, y, yaw) = circle(25);
    let plain = Path::new(&x, &y, None, false).unwrap();
    let path = plain.with_yaw(Some(&yaw), None).unwrap();
    let follow = Follow::of(&Vehicle::PAPER, 0.0, 0.0);
    for (place, sign) in [(0, -1.0), (24, 1.0)] {
        for (beyond, aside) in [(0.5, 0.0), (3.0, 0.0), (3.0, 0.7), (10.0, -2.0)] {
            let (sin, cos) = yaw[place].sin_cos();
            let vehicle = VehicleState {
                x: x[place] + sign * beyond * cos - aside * sin,
                y: y[place] + sign * beyond * sin + aside * cos,
                yaw: yaw[place],
                speed: 1.0,
            };
            let at = follow.locate(&path.view(), Some(place), vehicle, 0.05);
            let (error, heading) = (at.closest.cross_track_error(), at.closest.path_yaw());
            assert!(
                (error - aside).abs() < 1e-9,
                "{place} {beyond} {aside}: {error}"
            );
            assert!(wrap(heading - yaw[place]).abs() < 1e-9 && (at.past_end || at.before_start));
        }
    }
}
