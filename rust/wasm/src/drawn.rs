//! A track from a line that was drawn by hand.

use popsteer_core::Point;
use popsteer_core::error::input_in_range;
use popsteer_core::geometry::get_distance;
use popsteer_core::math::{from_count, to_count};

use crate::refusal::Refusal;

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

fn segments(points: &[Point], closed: bool) -> impl Iterator<Item = (Point, Point)> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(count: u32, radius: f64, turns: f64) -> Vec<Point> {
        (0..=count)
            .map(|k| {
                let angle = turns * std::f64::consts::TAU * f64::from(k) / f64::from(count);
                Point::new(radius * angle.cos(), radius * angle.sin())
            })
            .collect()
    }

    #[test]
    fn test_drawn_ring_is_a_lap_of_equal_steps() {
        let (line, closed) = smoothed(&ring(37, 40.0, 0.97)).unwrap();
        assert!(closed);
        for (from, to) in segments(&line, true) {
            assert!((get_distance(from, to) - 1.0).abs() < 0.05);
        }
        for point in &line {
            let radius = get_distance(*point, Point::new(0.0, 0.0));
            assert!((38.0..40.5).contains(&radius), "{radius}");
        }
    }

    #[test]
    fn test_drawn_corner_becomes_a_bend_and_the_ends_stay() {
        let corner = [(0.0, 0.0), (50.0, 0.0), (50.0, 50.0)].map(|(x, y)| Point::new(x, y));
        let (line, closed) = smoothed(&corner).unwrap();
        assert!(!closed);
        assert_eq!(line.first(), corner.first());
        assert_eq!(line.last(), corner.last());
        let sharpest = line
            .windows(3)
            .map(|at| {
                let (a, b) = (at[1] - at[0], at[2] - at[1]);
                (a.x * b.y - a.y * b.x).abs()
            })
            .fold(0.0, f64::max);
        assert!((0.1..0.19).contains(&sharpest), "{sharpest}");
    }

    #[test]
    fn test_drawn_line_that_is_none_is_refused() {
        let refused = |points: &[(f64, f64)]| {
            let points: Vec<Point> = points.iter().map(|&(x, y)| Point::new(x, y)).collect();
            smoothed(&points).unwrap_err().to_string()
        };
        assert!(refused(&[]).contains("at least 20 m"));
        assert!(refused(&[(1.0, 2.0)]).contains("at least 20 m"));
        assert!(refused(&[(0.0, 0.0); 9]).contains("is 0.0 m"));
        assert!(refused(&[(0.0, 0.0), (f64::NAN, 1.0)]).starts_with("x must be"));
        assert!(refused(&[(0.0, 0.0), (90.0, 1e9)]).starts_with("y must be"));
        assert!(refused(&[(0.0, 0.0), (9e4, 0.0)]).contains("at most 20000 m"));
    }

    #[test]
    fn test_drawn_scribble_makes_a_track_or_is_refused() {
        // There and back on one line, and points on top of each other.
        let mut scribble = Vec::new();
        for k in 0..60 {
            let x = f64::from(if k < 30 { k } else { 60 - k });
            scribble.extend([Point::new(x, 0.0); 3]);
        }
        if let Ok((line, closed)) = smoothed(&scribble) {
            assert!(segments(&line, closed).all(|(from, to)| get_distance(from, to) > 1e-6));
        }
    }
}
