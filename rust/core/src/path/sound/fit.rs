//! The two ends of a path for a vehicle: what no vehicle of its size drives there is noise, and so is
//! the direction of a last segment that turns unlike those before it.
//!
//! Controllers go on beyond an end in its direction. That is taken over a wheelbase: a parabola is
//! fitted to the waypoints before the last (least squares, by orthogonal polynomials, Forsythe 1957),
//! shifted so that it ends at the last waypoint, and gone over to along the wheelbase.

use alloc::vec::Vec;

use super::chain::turn;
use crate::geometry::{Point, get_distance};
use crate::math::{from_count, larger, smaller};

/// A turn that no vehicle drives is this many times that of its tightest circle, and [`SHARP`] more.
const TIMES: f64 = 2.0;
/// 6 degrees: what a tenth of the spacing turns a segment by.
const SHARP: f64 = 0.1;
/// A last segment that turns this many times as much as those before it, and [`AFTER`] more, has the
/// direction of the last waypoint's noise.
const UNLIKE: f64 = 3.0;
/// 0.3 degrees: what turns less is no farther aside than that by where a controller looks.
const AFTER: f64 = 0.005;
/// Noise moves a waypoint by less than this share of a wheelbase, or by less than [`MOST_NOISE`] up
/// to [`MOST_OF_SMALL`] of it.
const MOST_MOVED: f64 = 0.05;
const MOST_NOISE: f64 = 0.075;
const MOST_OF_SMALL: f64 = 0.23;
/// Fewer waypoints within a wheelbase of the end are corners, but for the last one.
const LEAST: usize = 4;
/// The waypoints that show that the last one lies aside are within so many wheelbases.
const FARTHEST: f64 = 8.0;

/// Where the last `reach` [m] of `count` waypoints begin and how long they are, if they turn as no
/// vehicle does whose largest curvature is `tightest` [1/m], or the last one lies aside of the others'
/// way. Allocates nothing.
pub(super) fn sharp_end(
    count: usize,
    at: impl Fn(usize) -> Point,
    reach: f64,
    tightest: f64,
) -> Option<(usize, f64)> {
    let step = |place: usize| at(place + 1) - at(place);
    let length = |place: usize| get_distance(at(place), at(place + 1));
    // From the last waypoint at least `reach` before the end on.
    let (mut first, mut passed) = (count - 1, 0.0);
    let mut coarse = false;
    while first > 0 && (passed < reach || count - first <= LEAST) {
        coarse |= passed >= reach;
        first -= 1;
        passed += length(first);
    }
    if passed < reach || count - first <= LEAST || passed > FARTHEST * reach {
        return None;
    }
    let turned = |place: usize| turn(step(place - 1), step(place));
    let sharp = !coarse
        && (first + 1..count - 1).any(|place| {
            let driven = 0.5 * tightest * (length(place - 1) + length(place));
            turned(place) > TIMES * driven + SHARP
        });
    let usual = (first + 1..count - 2).map(turned).fold(0.0, larger);
    let aside = turned(count - 2) > UNLIKE * usual + AFTER;
    (sharp || aside).then_some((first, passed))
}

/// Smooths the end of these waypoints over `reach` [m], if it is sharp, as [`sharp_end`] says. Returns
/// whether.
pub(super) fn fit_end(points: &mut [Point], reach: f64, tightest: f64) -> bool {
    let count = points.len();
    let at = |place: usize| points.get(place).copied().unwrap_or_default();
    let length = |place: usize| get_distance(at(place), at(place + 1));
    let Some((first, passed)) = sharp_end(count, at, reach, tightest) else {
        return false;
    };
    let mut travelled = 0.0;
    let shares: Vec<f64> = (first..count)
        .map(|place| {
            let share = travelled / passed;
            travelled += if place + 1 < count {
                length(place)
            } else {
                0.0
            };
            share
        })
        .collect();
    let window: Vec<Point> = (first..count).map(at).collect();
    let known = count - 1 - first;
    let fitted = parabola(shares.get(..known), window.get(..known));
    let shift = at(count - 1) - fitted(1.0);
    let smooth = |(&share, &given): (&f64, &Point)| {
        let weight = share * share * (3.0 - 2.0 * share);
        given + (fitted(share) + shift - given) * weight
    };
    let smoothed: Vec<Point> = shares.iter().zip(&window).map(smooth).collect();
    // What would move farther was meant.
    let mut both = smoothed.iter().zip(&window);
    let most = larger(
        MOST_MOVED * reach,
        smaller(MOST_NOISE, MOST_OF_SMALL * reach),
    );
    if both.any(|(&to, &from)| get_distance(to, from) > most) {
        return false;
    }
    for (point, to) in points.iter_mut().skip(first).zip(smoothed) {
        *point = to;
    }
    true
}

/// The parabola of least squares through points at these shares of the way.
fn parabola(shares: Option<&[f64]>, points: Option<&[Point]>) -> impl Fn(f64) -> Point + use<> {
    let (shares, points) = (shares.unwrap_or_default(), points.unwrap_or_default());
    let sum = |value: &dyn Fn(f64) -> f64| shares.iter().map(|&share| value(share)).sum::<f64>();
    let middle = sum(&|share| share) / from_count(shares.len().max(1));
    let first = move |share: f64| share - middle;
    let spread = sum(&|share| first(share) * first(share));
    let skew = sum(&|share| share * first(share) * first(share)) / spread;
    let mean = spread / from_count(shares.len().max(1));
    let second = move |share: f64| (share - skew) * first(share) - mean;
    let coefficient = |polynomial: &dyn Fn(f64) -> f64| {
        let squared = sum(&|share| polynomial(share) * polynomial(share));
        let mut total = Point::new(0.0, 0.0);
        for (&share, point) in shares.iter().zip(points) {
            total += point * polynomial(share);
        }
        total / squared
    };
    let coefficients = [
        coefficient(&|_| 1.0),
        coefficient(&first),
        coefficient(&second),
    ];
    move |share| {
        let [constant, linear, square] = coefficients;
        constant + linear * first(share) + square * second(share)
    }
}
