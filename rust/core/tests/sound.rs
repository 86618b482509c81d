//! Faults put into paths that are known: what is left is the path without them.

#[path = "sound/course.rs"]
mod course;

use self::course::{Xy, course, largest_turn};
use popsteer_core::math::from_count;
use popsteer_core::path::sound::{Fault, Sound, sound};
use popsteer_core::{Path, PathError};

fn mend(points: &Xy, closed: bool) -> Result<Sound, PathError> {
    let (x, y): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
    sound(&x, &y, closed, false)
}

/// The points that are kept, and what was mended.
fn mended(points: &Xy, closed: bool) -> (Xy, Vec<Fault>) {
    let sound = mend(points, closed).unwrap();
    let kept = sound.kept.map_or(points.clone(), |kept| {
        kept.iter().map(|&index| points[index]).collect()
    });
    (kept, sound.mends.iter().map(|mend| mend.fault).collect())
}

const SPACINGS: [f64; 3] = [0.1, 0.5, 2.0];

#[test]
fn test_sound_path_stays_as_it_is() {
    for spacing in SPACINGS {
        assert_eq!(mend(&course(spacing), false).unwrap(), Sound::default());
    }
    let triangle = vec![(0.0, 0.0), (10.0, 0.0), (5.0, 8.0)];
    assert_eq!(mend(&triangle, true).unwrap(), Sound::default());
    // Twins ahead of each waypoint along the path tell the direction well.
    let twins: Xy = (0..40)
        .map(|k| (f64::from(k / 2) + 1e-6 * f64::from(k % 2), 0.0))
        .collect();
    assert_eq!(mend(&twins, false).unwrap(), Sound::default());
}

/// Ahead, back beside it, and ahead again: the gears with the changes at, before or behind the cusps.
#[test]
fn test_change_of_gear_a_waypoint_beside_its_cusp_is_moved_there() {
    let ahead = (0..20).map(|k| (f64::from(k), 0.0));
    let back = (1..15).map(|k| (19.0 - f64::from(k), 0.002 * f64::from(k * k)));
    let again = (1..12).map(|k| (5.0 + f64::from(k), 0.392));
    let (x, y): (Vec<f64>, Vec<f64>) = ahead.chain(back).chain(again).unzip();
    let gears = |off: usize| -> Vec<f64> {
        let reverse = |k: usize| (19 + off..33 + off).contains(&(k + 1));
        (0..x.len())
            .map(|k| if reverse(k) { -1.0 } else { 1.0 })
            .collect()
    };
    let of = |off: usize| Path::sound(&x, &y, Some(&gears(off)), None, false, false).unwrap();
    let right = of(1);
    assert_eq!(right.mends(), []);
    for off in [0, 2] {
        let path = of(off);
        let mends: Vec<_> = path.mends().iter().map(ToString::to_string).collect();
        assert_eq!(
            mends,
            ["moved 2 changes of gear to the cusp beside, the first at waypoint 19"]
        );
        assert_eq!(path.view().reverse(), right.view().reverse(), "{off}");
    }
    // Farther off it is no slip: it stays as it is given.
    assert_eq!(of(3).mends(), []);
}

#[test]
fn test_swapped_waypoints_are_put_in_order_anywhere() {
    for spacing in SPACINGS {
        let clean = course(spacing);
        let count = clean.len();
        for place in [
            0,
            1,
            2,
            count / 3,
            count / 2,
            count - 4,
            count - 3,
            count - 2,
        ] {
            let mut points = clean.clone();
            points.swap(place, place + 1);
            assert_eq!(
                mended(&points, false),
                (clean.clone(), vec![Fault::Swapped]),
                "{place}"
            );
        }
    }
}

#[test]
fn test_waypoints_in_the_opposite_order_are_turned_round() {
    for spacing in SPACINGS {
        let clean = course(spacing);
        for place in [2, clean.len() / 3, clean.len() / 2] {
            for run in [3, 4, 8] {
                let mut points = clean.clone();
                points[place..place + run].reverse();
                assert_eq!(
                    mended(&points, false),
                    (clean.clone(), vec![Fault::Reversed]),
                    "{spacing} {place} {run}"
                );
            }
        }
    }
}

#[test]
fn test_step_back_over_waypoints_passed_again_is_left_out() {
    for spacing in SPACINGS {
        let clean = course(spacing);
        for place in [clean.len() / 3, clean.len() / 2] {
            for back in [2, 3, 5, 20] {
                if back >= place {
                    continue;
                }
                let mut points = clean[..place].to_vec();
                points.extend(&clean[place - back..]);
                assert_eq!(
                    mended(&points, false),
                    (clean.clone(), vec![Fault::StepBack])
                );
            }
        }
    }
}

#[test]
fn test_goal_behind_the_end_ends_the_path_and_start_ahead_begins_it() {
    for spacing in SPACINGS {
        let clean = course(spacing);
        let mut points = clean.clone();
        points.push(clean[clean.len() - 4]);
        let (kept, faults) = mended(&points, false);
        assert_eq!(
            (kept, faults),
            (clean[..clean.len() - 3].to_vec(), vec![Fault::StepBack])
        );
        let mut points = clean.clone();
        points.insert(0, clean[3]);
        assert_eq!(
            mended(&points, false),
            (clean[3..].to_vec(), vec![Fault::StepBack])
        );
    }
}

#[test]
fn test_standstill_in_noise_leaves_one_waypoint() {
    // A low-discrepancy sequence for noise of 2 cm.
    let noise = |k: u32| {
        let at = |step: f64| 0.04 * ((step * f64::from(k)).fract() - 0.5) * 2.0;
        (at(0.754_877_666), at(0.569_840_291))
    };
    for spacing in SPACINGS {
        let clean = course(spacing);
        for place in [0, clean.len() / 2, clean.len() - 1] {
            let mut points = clean[..=place].to_vec();
            points.extend((1..200).map(|k| {
                let ((x, y), (dx, dy)) = (clean[place], noise(k));
                (x + dx, y + dy)
            }));
            points.extend(&clean[place + 1..]);
            let (kept, _) = mended(&points, false);
            // One waypoint, and perhaps some that happen to lie in line.
            assert!(kept.len().abs_diff(clean.len()) < 4, "{spacing} {place}");
            assert!(largest_turn(&kept) < 0.5, "{spacing} {place}");
            for (x, y) in kept {
                let off = |&(to_x, to_y): &(f64, f64)| (x - to_x).hypot(y - to_y);
                assert!(clean.iter().map(off).fold(f64::INFINITY, f64::min) < 0.06);
            }
        }
    }
}

#[test]
fn test_long_straight_between_bends_is_no_gap() {
    // Two bends of coarse waypoints, which begin at its ends.
    let arc = |k: i32| (f64::from(k) * 0.25).sin_cos();
    let mut points: Xy = (-8..=0)
        .map(|k| (48.0 * arc(k).0, 48.0 * (1.0 - arc(k).1)))
        .collect();
    points.extend((0..9).map(|k| (140.0 + 48.0 * arc(k).0, 48.0 * (1.0 - arc(k).1))));
    for directed in [false, true] {
        let (x, y): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
        assert_eq!(sound(&x, &y, false, directed), Ok(Sound::default()));
    }
}

#[test]
fn test_jump_between_two_drives_is_refused_also_where_directions_are_told() {
    let clean = course(0.5);
    let mut points = clean.clone();
    points.extend(clean.iter().map(|(x, y)| (x - 40.0, y + 90.0)));
    let (x, y): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
    for directed in [false, true] {
        let found = sound(&x, &y, false, directed);
        assert!(matches!(found, Err(PathError::Gap { .. })), "{found:?}");
    }
    // Back to where the first began, and on as it did.
    let mut again = clean[..50].to_vec();
    again.push((clean[49].0 - 1e-3, clean[49].1)); // It rolled back when it stood.
    again.push((clean[0].0 + 1e-3, clean[0].1));
    again.extend(&clean[..50]);
    let (x, y): (Vec<f64>, Vec<f64>) = again.into_iter().unzip();
    let found = sound(&x, &y, false, true);
    assert!(matches!(found, Err(PathError::Gap { .. })), "{found:?}");
    // A long way to a cusp was meant.
    let mut points = vec![(-30.0, 0.0)];
    points.extend((0..40).map(|k| (-0.5 * f64::from(k), 0.1 * f64::from(k * k) / 40.0)));
    let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
    assert!(sound(&x, &y, false, true).is_ok());
    assert!(sound(&x, &y, false, false).is_err());
}

#[test]
fn test_three_waypoints_in_a_circle_leave_two_out() {
    for spacing in SPACINGS {
        let clean = course(spacing);
        for place in [clean.len() / 4, clean.len() / 2, 3 * clean.len() / 4] {
            let mut points = clean.clone();
            points[place..place + 3].rotate_right(1);
            let (kept, faults) = mended(&points, false);
            assert_eq!(faults, vec![Fault::StepBack], "{spacing} {place}");
            assert!(kept.len() >= clean.len() - 2, "{spacing} {place}");
            assert!(largest_turn(&kept) < 0.5, "{spacing} {place}");
        }
    }
}

#[test]
fn test_recording_from_before_the_start_leaves_the_standstill_out() {
    // A car that stands for 10 s, and sets off slowly to 0.5 m/s, in noise of 1 cm; 20 rows a second.
    let mut points = Vec::new();
    for k in 0..600_u32 {
        let noise = |step: f64| 0.02 * ((step * f64::from(k)).fract() - 0.5);
        let since = (0.05 * f64::from(k) - 10.0).max(0.0);
        let gone = if since < 5.0 {
            0.05 * since * since
        } else {
            1.25 + 0.5 * (since - 5.0)
        };
        points.push((gone + noise(0.754_877_666), noise(0.569_840_291)));
    }
    for _ in 0..2 {
        let (kept, faults) = mended(&points, false);
        assert!(faults.contains(&Fault::Standstill));
        assert!(kept.len() < 400 && kept.len() > 320, "{}", kept.len());
        points.reverse();
    }
}

#[test]
fn test_end_aside_keeps_the_goal_and_the_direction() {
    for spacing in SPACINGS {
        let clean = course(spacing);
        let (&(x, y), &(from_x, from_y)) = (&clean[clean.len() - 1], &clean[clean.len() - 2]);
        let (ux, uy) = ((x - from_x) / spacing, (y - from_y) / spacing);
        for (ahead, aside) in [(0.0, 0.001), (0.1, 0.1), (-0.1, 0.05), (0.3, 0.2)] {
            let (ahead, aside) = (ahead * spacing, aside * spacing);
            let goal = (x + ahead * ux - aside * uy, y + ahead * uy + aside * ux);
            let mut points = clean.clone();
            points.push(goal);
            let (kept, _) = mended(&points, false);
            assert_eq!(kept.len(), clean.len(), "{ahead} {aside}");
            assert_eq!(kept.last(), Some(&goal));
        }
    }
}

#[test]
fn test_lap_that_repeats_its_start_ends_before_it() {
    let ring = |count: u32| -> Xy {
        let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(count);
        (0..count)
            .map(|k| (20.0 * angle(k).cos(), 20.0 * angle(k).sin()))
            .collect()
    };
    for count in [40, 200] {
        let clean = ring(count);
        let count = clean.len();
        let mut points = clean.clone();
        points.push(clean[0]);
        assert_eq!(
            mended(&points, true),
            (clean.clone(), vec![Fault::Repeated])
        );
        // Beyond its start, and all but at it.
        let mut points = clean.clone();
        points.extend(&clean[..3]);
        assert_eq!(mended(&points, true).0.len(), count);
        let mut points = clean.clone();
        points.push((clean[0].0 + 3e-4, clean[0].1 - 4e-4));
        assert_eq!(mended(&points, true).0.len(), count);
        let mut points = clean.clone();
        points.swap(0, count - 1);
        assert_eq!(mended(&points, true).1, [Fault::Swapped]);
    }
}

#[test]
fn test_fold_that_may_be_a_cusp_is_refused_and_one_that_is_told_stays() {
    for spacing in SPACINGS {
        let clean = course(spacing);
        let there = clean.len() / 2;
        let mut points = clean[..there].to_vec();
        points.extend(clean[there / 2..there - 1].iter().rev());
        assert_eq!(
            mend(&points, false),
            Err(PathError::Fold { index: there - 1 })
        );
        let (x, y): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
        assert_eq!(sound(&x, &y, false, true), Ok(Sound::default()));
        // A way back of several steps was driven, though the path goes on as before.
        points.extend(&clean[there / 2..]);
        assert!(matches!(mend(&points, false), Err(PathError::Fold { .. })));
    }
}

#[test]
fn test_gap_aside_is_refused_and_a_straight_one_is_not() {
    for spacing in SPACINGS {
        let clean = course(spacing);
        let half = clean.len() / 2;
        let mut points = clean.clone();
        for point in &mut points[half..] {
            point.1 += 40.0 * spacing;
        }
        let error = mend(&points, false).unwrap_err();
        assert!(matches!(error, PathError::Gap { index, .. } if index == half - 1));
        let mut coarse = vec![(-60.0 * spacing, 0.0)];
        coarse.extend(&clean);
        assert_eq!(mend(&coarse, false).unwrap(), Sound::default());
    }
}

#[test]
fn test_waypoints_without_an_order_are_refused() {
    let clean = course(0.5);
    let count = clean.len();
    let points: Xy = (0..count).map(|k| clean[k * 77 % count]).collect();
    assert!(matches!(
        mend(&points, false),
        Err(PathError::Unordered { .. })
    ));
}

#[test]
fn test_list_that_goes_on_a_spacing_aside_and_a_bit_back_loses_one_waypoint() {
    let mut points: Xy = (0..80).map(|k| (0.0, 0.035 * f64::from(k))).collect();
    points.extend((0..40).map(|k| (-0.03, 2.76 + 0.035 * f64::from(k))));
    let (kept, faults) = mended(&points, false);
    assert_eq!(faults, [Fault::StepBack]);
    assert!(kept.len() + 2 >= points.len(), "{}", kept.len());
}

#[test]
fn test_corners_that_turn_back_are_driven() {
    // Drawn by hand: at 4 and 16 the way goes back beside where it came, a spacing aside.
    let x = [
        0.0, -27.0, -53.0, -39.0, 33.0, 11.0, 41.0, 60.0, 71.0, 64.0, 83.0, 95.0, 83.0, 25.0,
    ];
    let y = [
        -95.0, -93.0, -14.0, 17.0, 26.0, 48.0, 72.0, 58.0, 66.0, 82.0, 87.0, 50.0, 8.0, -4.0,
    ];
    let mut points: Xy = x.into_iter().zip(y).collect();
    points.extend([
        (-10.0, -12.0),
        (-9.0, -39.0),
        (9.0, -55.0),
        (-8.0, -75.0),
        (-3.0, -87.0),
    ]);
    assert_eq!(mend(&points, false).unwrap(), Sound::default());
}

#[test]
fn test_list_of_places_is_no_standstill_and_no_step_back() {
    // Sorted by x, as a list of places is: it goes up and down at each, with long steps.
    for count in [16_usize, 40] {
        let points: Xy = (0..count)
            .map(|k| {
                (
                    20.0 * from_count(k),
                    30.0 * from_count((k * k * 7 + 3 * k) % 11),
                )
            })
            .collect();
        let found = mend(&points, false);
        assert!(
            matches!(found, Err(PathError::Unordered { waypoints, .. }) if waypoints == count),
            "{found:?}"
        );
    }
    // A recording that jumps out of the map: its spacing is that of the jumps.
    let jumps: Xy = (0..32)
        .map(|k| {
            let way = 0.5 * f64::from(k);
            let aside = f64::from(k * k % 5);
            match k % 8 {
                5 => (65.0, aside),
                6 => (way, 65.0),
                _ => (way - 0.4 * aside, aside),
            }
        })
        .collect();
    let found = mend(&jumps, false);
    assert!(
        matches!(
            found,
            Err(PathError::Unordered { .. } | PathError::Fold { .. })
        ),
        "{found:?}"
    );
}
