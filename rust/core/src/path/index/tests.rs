use super::super::relocalise::{relocalise, relocalise_by_scan, relocalise_within};
use super::*;
use crate::Path;
use crate::geometry::Point;
use crate::math::{cos, from_count, sin};
use alloc::vec::Vec;
use core::f64::consts::{FRAC_PI_2, TAU};
use proptest::prelude::*;

/// A path, and places to ask for: its waypoints, beside them, and anywhere.
fn check(xs: &[f64], ys: &[f64], closed: bool, opposite: f64, spots: &[(f64, f64, f64)]) {
    let ends_meet = xs.first() == xs.last() && ys.first() == ys.last();
    let Ok(path) = Path::new(xs, ys, None, closed && !ends_meet) else {
        return;
    };
    let backwards: Vec<bool> = (0..xs.len()).map(|k| k % 200 > 150).collect();
    let turning = path.clone().with_reverse(&backwards).unwrap();
    for path in [path, turning] {
        let view = path.view();
        assert_eq!(
            view.index.is_some(),
            view.segments() > crate::path::boxes::SCANNED
        );
        for (k, &(aside_x, aside_y, yaw)) in spots.iter().enumerate() {
            let at = view.waypoint(37 * k % xs.len());
            let position = Point::new(at.x + aside_x, at.y + aside_y);
            assert_eq!(
                relocalise(&view, position, yaw, opposite),
                relocalise_by_scan(&view, position, yaw, opposite),
                "{position} {yaw}"
            );
        }
    }
}

fn spots() -> impl Strategy<Value = Vec<(f64, f64, f64)>> {
    let aside = || {
        prop_oneof![
            Just(0.0),
            (-6..=6_i32).prop_map(|k| 0.5 * f64::from(k)),
            -30.0..30.0,
            -1e5..1e5,
        ]
    };
    let quarters = (-4..=4_i32).prop_map(|k| f64::from(k) * FRAC_PI_2);
    let yaw = prop_oneof![quarters, -7.0..7.0];
    proptest::collection::vec((aside(), aside(), yaw), 8)
}

fn origins() -> impl Strategy<Value = (f64, f64)> {
    prop_oneof![
        Just((0.0, 0.0)),
        Just((1e7, -1e7)),
        Just((-7.3e6, 0.1)),
        Just((9.9e8, -9.9e8)),
    ]
}

fn opposites() -> impl Strategy<Value = f64> {
    prop_oneof![Just(10.0), Just(0.0), 0.0..40.0]
}

/// Waypoints from steps of a length and a turn.
fn waypoints(steps: &[(f64, f64)], bend: f64, origin: (f64, f64)) -> (Vec<f64>, Vec<f64>) {
    let (mut x, mut y, mut yaw) = (origin.0, origin.1, 0.3_f64);
    let next = |&(length, turn): &(f64, f64)| {
        yaw += bend * turn;
        x += length * cos(yaw);
        y += length * sin(yaw);
        (x, y)
    };
    steps.iter().map(next).unzip()
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        cases: 500,
        ..Default::default()
    })]

    #[test]
    fn test_index_on_random_paths_finds_what_the_scan_finds(
        steps in proptest::collection::vec((0.01..3.0_f64, -3.2..3.2_f64), 500..2000),
        bend in prop_oneof![Just(0.02), Just(0.3), Just(1.0)],
        origin in origins(),
        closed in any::<bool>(),
        opposite in opposites(),
        spots in spots(),
    ) {
        let (xs, ys) = waypoints(&steps, bend, origin);
        check(&xs, &ys, closed, opposite, &spots);
    }

    /// Laps that all but coincide, each shifted by next to nothing.
    #[test]
    fn test_index_on_laps_that_nearly_coincide_finds_what_the_scan_finds(
        lap in 3..200_u32,
        laps in 4..20_u32,
        shift in prop_oneof![Just(0.0), Just(1e-9), Just(1e-7), Just(0.3)],
        radius in prop_oneof![Just(0.5), Just(30.0), Just(1e6)],
        closed in any::<bool>(),
        origin in origins(),
        opposite in opposites(),
        spots in spots(),
    ) {
        let (xs, ys): (Vec<_>, Vec<_>) = (0..lap * laps)
            .map(|k| {
                let (turn, at) = (f64::from(k / lap), f64::from(k % lap));
                let angle = TAU * at / f64::from(lap);
                let x = origin.0 + radius * cos(angle) + shift * turn;
                (x, origin.1 + radius * sin(angle))
            })
            .unzip();
        check(&xs, &ys, closed, opposite, &spots);
    }

    /// Waypoints that come back to the same places again and again, with ties all over.
    #[test]
    fn test_index_on_a_lattice_finds_what_the_scan_finds(
        steps in proptest::collection::vec(0..4_usize, 500..2000),
        size in 2..40_i32,
        origin in origins(),
        closed in any::<bool>(),
        opposite in opposites(),
        spots in spots(),
    ) {
        let (mut x, mut y) = (0, 0);
        let (xs, ys): (Vec<_>, Vec<_>) = steps
            .iter()
            .map(|&way| {
                let (dx, dy) = match way {
                    0 => (1, 0),
                    1 => (0, 1),
                    2 => (-1, 0),
                    _ => (0, -1),
                };
                // The walls of the lattice throw the walk back.
                x += if (0..size).contains(&(x + dx)) { dx } else { -dx };
                y += if (0..size).contains(&(y + dy)) { dy } else { -dy };
                (origin.0 + f64::from(x), origin.1 + f64::from(y))
            })
            .unzip();
        check(&xs, &ys, closed, opposite, &spots);
    }

    /// All on one line, there and back over the same places.
    #[test]
    fn test_index_on_one_line_finds_what_the_scan_finds(
        run in 100..300_u32,
        laps in 1..8_u32,
        along in prop_oneof![Just((1.0, 0.0)), Just((0.0, 2.5)), Just((0.3, 0.4))],
        origin in origins(),
        opposite in opposites(),
        spots in spots(),
    ) {
        let places = (0..=laps * run).map(|k| {
            let (lap, k) = (k / run, k % run);
            f64::from(if lap % 2 == 0 { k } else { run - k })
        });
        let (xs, ys): (Vec<_>, Vec<_>) = places
            .map(|place| (origin.0 + place * along.0, origin.1 + place * along.1))
            .unzip();
        check(&xs, &ys, false, opposite, &spots);
    }
}

/// A field driven up and down in rows of 1,000 m, 10 m apart, with a waypoint each metre.
fn field(count: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut x, mut y) = (0.0, 0.0);
    let next = |k: usize| {
        let (row, place) = (k / 1016, k % 1016);
        let side = if row % 2 == 0 { 1.0 } else { -1.0 };
        let heading = if place < 1000 {
            0.3 * sin(TAU * from_count(place) / 50.0)
        } else {
            FRAC_PI_2 * (from_count(place) - 999.5) / 8.0
        };
        x += side * cos(heading);
        y += if place < 1000 {
            side * sin(heading)
        } else {
            sin(heading)
        };
        (x, y)
    };
    (0..count).map(next).unzip()
}

#[test]
fn test_index_within_50_m_of_a_path_visits_few_boxes() {
    let straight = |count: usize| -> (Vec<f64>, Vec<f64>) {
        (0..count).map(|k| (0.1 * from_count(k), 0.0)).unzip()
    };
    for (count, most) in [(1_000, 60), (30_000, 80), (1_000_000, 100)] {
        for (xs, ys) in [field(count), straight(count)] {
            let path = Path::new(&xs, &ys, None, false).unwrap();
            let view = path.view();
            for k in 0..2000 {
                let (far, way, yaw) = (k % 50, 2.4 * from_count(k), 0.7 * from_count(k));
                let at = view.waypoint(k * (count - 1) / 2000);
                let aside = Point::new(cos(way), sin(way)) * from_count(far);
                let found = relocalise_within(&view, at + aside, yaw, 10.0, STEP_BUDGET);
                assert!(found.is_exact);
                assert!(found.visits <= most, "{count} {k} {}", found.visits);
            }
        }
    }
}

/// A circle of so many waypoints, 1 m apart.
fn circle(count: usize) -> Path {
    let radius = from_count(count) / TAU;
    let angle = |k| TAU * from_count(k) / from_count(count);
    let (xs, ys): (Vec<_>, Vec<_>) = (0..count)
        .map(|k| (radius * cos(angle(k)), radius * sin(angle(k))))
        .unzip();
    Path::new(&xs, &ys, None, true).unwrap()
}

#[test]
fn test_index_at_the_centre_of_a_circle_keeps_to_the_budget() {
    let path = circle(100_000);
    let (view, centre) = (path.view(), Point::new(0.0, 0.0));
    let found = relocalise_within(&view, centre, 0.0, 10.0, STEP_BUDGET);
    assert!(!found.is_exact);
    assert_eq!(found.visits, STEP_BUDGET);
    // Everywhere it is as far.
    let scanned = relocalise_by_scan(&view, centre, 0.0, 10.0);
    assert_eq!(relocalise(&view, centre, 0.0, 10.0), scanned);
    let enough = relocalise_within(&view, centre, 0.0, 10.0, 2 * 3125);
    assert!(enough.is_exact);
    assert_eq!(enough.segment, scanned);
}

#[test]
fn test_index_of_a_budget_of_nothing_gives_the_first_segment() {
    let path = circle(1000);
    let found = relocalise_within(&path.view(), Point::new(0.0, 9.0), 0.0, 10.0, 0);
    assert_eq!((found.segment, found.is_exact), (0, false));
}
