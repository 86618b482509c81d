//! The ends of a path for a vehicle: smoothed where their last waypoints are noise.

#[path = "sound/course.rs"]
mod course;

use self::course::{Xy, course, largest_turn};
use popsteer_core::path::sound::{Fault, Mend};
use popsteer_core::{Path, Vehicle};

fn waypoints(path: &Path) -> Xy {
    let view = path.view();
    let (x, y) = (view.x().iter(), view.y().iter());
    x.copied().zip(y.copied()).collect()
}

fn path(points: &Xy) -> Path {
    let (x, y): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
    Path::sound(&x, &y, None, None, false, false).unwrap()
}

#[test]
fn test_end_that_no_vehicle_of_the_size_drives_is_smoothed_and_others_stay() {
    let car = |wheelbase| Vehicle {
        wheelbase,
        max_steer: 0.6,
        ..Vehicle::DEFAULT
    };
    let clean = course(0.1);
    for wheelbase in [0.16, 0.33, 2.7, 12.0] {
        assert!(path(&clean).fitted(&car(wheelbase)).is_none());
    }
    let (&(x, y), &(from_x, from_y)) = (&clean[clean.len() - 1], &clean[clean.len() - 2]);
    let (ux, uy) = (x - from_x, y - from_y);
    let mut points = clean.clone();
    points.push((x + ux - 0.5 * uy, y + uy + 0.5 * ux));
    let fitted = path(&points).fitted(&car(2.7)).unwrap();
    let mends = fitted.mends();
    assert!(matches!(
        mends,
        [Mend {
            fault: Fault::Undrivable,
            times: 1,
            ..
        }]
    ));
    let kept = waypoints(&fitted);
    let from = points.len() - 30;
    assert_eq!(kept[..from], points[..from]);
    let end = (kept.last(), points.last());
    assert!((end.0.unwrap().0 - end.1.unwrap().0).abs() < 1e-12);
    assert!(largest_turn(&kept) < 0.02);
    // A corner is rounded within what noise explains, or stays.
    for leg in 2..30 {
        let mut corner = clean.clone();
        corner.extend((1..leg).map(|k| (x - f64::from(k) * uy, y + f64::from(k) * ux)));
        if let Some(fitted) = path(&corner).fitted(&car(2.7)) {
            let moved = fitted.view().x().iter().zip(fitted.view().y()).zip(&corner);
            let moved = moved.map(|((x, y), from)| (x - from.0).hypot(y - from.1));
            assert!(moved.fold(0.0, f64::max) < 0.05 * 2.7, "{leg}");
        }
    }
    // A path that is told how it is driven stays, and so does one as it stands.
    let (x, y): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
    let told = Path::sound(&x, &y, None, None, false, true).unwrap();
    assert_eq!(told.fitted(&car(2.7)), None);
    assert_eq!(
        Path::new(&x, &y, None, false).unwrap().fitted(&car(2.7)),
        None
    );
}

#[test]
fn test_last_waypoint_aside_turns_no_end() {
    let clean = course(0.1);
    let (&(x, y), &(from_x, from_y)) = (&clean[clean.len() - 1], &clean[clean.len() - 2]);
    let (ux, uy) = ((x - from_x) / 0.1, (y - from_y) / 0.1);
    for wheelbase in [0.8, 2.7, 12.0] {
        let car = Vehicle {
            wheelbase,
            ..Vehicle::DEFAULT
        };
        for aside in [0.001, 0.004, 0.02] {
            let goal = (x - aside * uy, y + aside * ux);
            let mut points = clean.clone();
            points.pop();
            points.push(goal);
            for _ in 0..2 {
                let fitted = path(&points).fitted(&car).unwrap();
                let kept = waypoints(&fitted);
                let usual = 0.1 / 15.0; // what the arc turns by
                assert!(largest_turn(&kept) < usual + 0.008, "{wheelbase} {aside}");
                let moved = kept
                    .iter()
                    .zip(&points)
                    .map(|(a, b)| (a.0 - b.0).hypot(a.1 - b.1));
                assert!(moved.fold(0.0, f64::max) < 1.1 * aside);
                points.reverse();
            }
        }
    }
}

#[test]
fn test_last_waypoint_aside_of_coarse_ones_or_of_a_small_vehicle_turns_no_end() {
    // Spacing, wheelbase, how far the last waypoint is ahead of the last but one, and aside.
    let cases = [
        (0.1, 0.33, 0.1, 0.05),
        (0.1, 1.0, 0.0, 0.05),
        (0.5, 1.0, 0.25, 0.05),
        (1.0, 2.7, 1.0, 0.05),
        (2.0, 2.7, 0.1, 0.002),
        (2.0, 5.0, 2.0, 0.05),
    ];
    for (spacing, wheelbase, ahead, aside) in cases {
        let car = Vehicle {
            wheelbase,
            max_steer: 0.6,
            ..Vehicle::DEFAULT
        };
        let mut points: Xy = (0..60).map(|k| (spacing * f64::from(k), 0.0)).collect();
        let end = points[59].0;
        assert!(path(&points).fitted(&car).is_none());
        points.push((end + ahead, aside));
        for _ in 0..2 {
            let kept = waypoints(&path(&points).fitted(&car).unwrap());
            let turned = largest_turn(&kept);
            assert!(
                turned < 6.0 * aside / wheelbase.max(4.0 * spacing),
                "{wheelbase}: {turned}"
            );
            points.reverse();
        }
    }
    // A last waypoint that is farther aside is a place to go to, and so is a corner of coarse ones.
    for (spacing, wheelbase, aside) in [(0.1, 0.16, 0.05), (0.5, 0.33, 0.2), (2.0, 2.7, 0.4)] {
        let car = Vehicle {
            wheelbase,
            max_steer: 0.6,
            ..Vehicle::DEFAULT
        };
        let mut points: Xy = (0..60).map(|k| (spacing * f64::from(k), 0.0)).collect();
        points.push((spacing * 60.0, aside));
        assert!(path(&points).fitted(&car).is_none(), "{wheelbase}");
    }
}
