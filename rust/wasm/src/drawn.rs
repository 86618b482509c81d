//! A track from a line that was drawn by hand.

use popsteer_core::Point;
use popsteer_core::error::input_in_range;
use popsteer_core::geometry::get_distance;
use popsteer_core::math::{from_count, to_count};

use crate::Refusal;

/// Distance of the track's waypoints [m].
const SPACING: f64 = 1.0;
/// The shortest and the longest track [m].
const LENGTHS: [f64; 2] = [20.0, 20_000.0];
/// Coordinates are no larger [m].
const MOST: f64 = 1e5;
/// Rounds of smoothing with the weights 1/4, 1/2, 1/4. They blur the line with a standard deviation
/// of 7 m, so that a corner becomes a bend of some 6 m radius. More: smoother, and small bends
/// vanish.
const ROUNDS: usize = 100;
/// Ends that are as close together as this [m], or as this share of the length, are joined.
const JOINED: (f64, f64) = (10.0, 0.05);
/// The shortest line whose ends are joined [m].
const SHORTEST_LAP: f64 = 60.0;

/// The waypoints of the smoothed line, and whether its last leads back to its first.
pub(crate) fn smoothed(drawn: &[Point]) -> Result<(Vec<Point>, bool), Refusal> {
    for point in drawn {
        input_in_range("x", point.x, -MOST, MOST)?;
        input_in_range("y", point.y, -MOST, MOST)?;
    }
    let [shortest, longest] = LENGTHS;
    let length = length(drawn, false);
    if length < shortest {
        return Err(format!(
            "a track is at least {shortest} m long, the line drawn is {length:.1} m: draw a longer one"
        )
        .into());
    }
    if length > longest {
        return Err(format!("a track is at most {longest} m long, got {length:.0} m").into());
    }
    let (Some(&first), Some(&last)) = (drawn.first(), drawn.last()) else {
        return Err("no line was drawn".into());
    };
    let (near, share) = JOINED;
    let gap = get_distance(first, last);
    let closed = length >= SHORTEST_LAP && gap <= near.max(share * length);
    let mut line = equally_spaced(drawn, closed);
    for _ in 0..ROUNDS {
        blur(&mut line, closed);
    }
    let line = equally_spaced(&line, closed);
    if line.len() < 3 {
        return Err("the line drawn leads back over itself: draw it as it is to be driven".into());
    }
    Ok((line, closed))
}

fn length(points: &[Point], closed: bool) -> f64 {
    let mut sum = 0.0;
    for (from, to) in segments(points, closed) {
        sum += get_distance(from, to);
    }
    sum
}

pub(crate) fn segments(points: &[Point], closed: bool) -> impl Iterator<Item = (Point, Point)> {
    let back = usize::from(closed);
    let next = points.iter().cycle().skip(1);
    let count = (points.len() + back).saturating_sub(1);
    points
        .iter()
        .zip(next)
        .map(|(&from, &to)| (from, to))
        .take(count)
}

/// Points on the same line about [`SPACING`] apart, its ends among them.
fn equally_spaced(points: &[Point], closed: bool) -> Vec<Point> {
    let total = length(points, closed);
    let count = to_count(total / SPACING + 0.5).max(1);
    let step = total / from_count(count);
    let mut spaced = Vec::with_capacity(count + 1);
    let mut behind = 0.0;
    for (from, to) in segments(points, closed) {
        let ahead = behind + get_distance(from, to);
        while spaced.len() < count {
            let station = from_count(spaced.len()) * step;
            if station >= ahead {
                break;
            }
            let share = (station - behind) / (ahead - behind);
            spaced.push(from + (to - from) * share);
        }
        behind = ahead;
    }
    if let (Some(&last), false) = (points.last(), closed) {
        spaced.push(last);
    }
    spaced
}

/// One round of smoothing; the ends of an open line stay.
fn blur(line: &mut [Point], closed: bool) {
    let (Some(&first), Some(&last)) = (line.first(), line.last()) else {
        return;
    };
    let mut before = if closed { last } else { first };
    for index in 0..line.len() {
        let here = line[index];
        let after = match line.get(index + 1) {
            Some(&after) => after,
            None if closed => first,
            None => here,
        };
        let is_end = !closed && (index == 0 || index + 1 == line.len());
        if !is_end {
            line[index] = (before + here * 2.0 + after) * 0.25;
        }
        before = here;
    }
}
