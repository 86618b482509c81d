//! The curvature of noisy waypoints is that of the penalised least squares that define it, solved
//! densely, and of circles through the smoothed points.

mod dense;

use dense::solve;
use popsteer_core::Path;
use popsteer_core::speed::path_curvature;

type Places = Vec<(f64, f64)>;

/// Smoothing length [m]; waypoints closer together than a quarter of it are averaged.
const LENGTH: f64 = 1.6;

/// The third derivative of the cubic through four values, a row over them: six times the third
/// divided difference.
fn third_derivative(s: [f64; 4]) -> [f64; 4] {
    let unit = |k: usize| {
        let value = |j: usize| if j == k { 1.0 } else { 0.0 };
        let first = |j: usize| (value(j + 1) - value(j)) / (s[j + 1] - s[j]);
        let second = |j: usize| (first(j + 1) - first(j)) / (s[j + 2] - s[j]);
        6.0 * (second(1) - second(0)) / (s[3] - s[0])
    };
    [unit(0), unit(1), unit(2), unit(3)]
}

/// `minimise sum w |q - p|^2 + length^6 sum h |q'''|^2`: the normal equations, whole. `lap` is the
/// length of a closed path [m].
fn smoothed(arcs: &[f64], places: &Places, lap: Option<f64>) -> Places {
    let count = arcs.len();
    if count < 4 {
        return places.clone();
    }
    // The arc and the place of waypoints beyond the ends of a lap.
    let arc =
        |k: usize| arcs[k % count] + lap.map_or(0.0, |lap| if k >= count { lap } else { 0.0 });
    let mut matrix = vec![vec![0.0; count]; count];
    let mut weights = vec![0.0; count];
    let segments = if lap.is_some() { count } else { count - 1 };
    for k in 0..segments {
        // Half of a segment belongs to each of its ends.
        let half = 0.5 * (arc(k + 1) - arc(k));
        weights[k] += half;
        weights[(k + 1) % count] += half;
    }
    for (k, weight) in weights.iter().enumerate() {
        matrix[k][k] += weight;
    }
    let fours = if lap.is_some() { count } else { count - 3 };
    for k in 0..fours {
        let s = [k, k + 1, k + 2, k + 3].map(arc);
        let row = third_derivative(s);
        let weight = LENGTH.powi(6) * (s[3] - s[0]) / 3.0;
        for (i, one) in row.iter().enumerate() {
            for (j, other) in row.iter().enumerate() {
                matrix[(k + i) % count][(k + j) % count] += weight * one * other;
            }
        }
    }
    let solved = |axis: &dyn Fn(&(f64, f64)) -> f64| {
        let mut rows = matrix.clone();
        for (row, (place, weight)) in rows.iter_mut().zip(places.iter().zip(&weights)) {
            row.push(weight * axis(place));
        }
        solve(rows)
    };
    let (x, y) = (solved(&|place| place.0), solved(&|place| place.1));
    x.into_iter().zip(y).collect()
}

/// The curvature of the circle through three points: `2 sin(turn) / chord`.
fn circle(a: (f64, f64), b: (f64, f64), c: (f64, f64)) -> f64 {
    let heading = |from: (f64, f64), to: (f64, f64)| (to.1 - from.1).atan2(to.0 - from.0);
    let turn = heading(b, c) - heading(a, b);
    2.0 * turn.sin() / (c.0 - a.0).hypot(c.1 - a.1)
}

/// The curvature at each node of a section; at its ends that of the nodes beside them.
fn section(arcs: &[f64], places: &Places) -> Vec<f64> {
    let smooth = smoothed(arcs, places, None);
    let last = smooth.len() - 1;
    if last < 2 {
        return vec![0.0; smooth.len()];
    }
    (0..=last)
        .map(|k| k.clamp(1, last - 1))
        .map(|k| circle(smooth[k - 1], smooth[k], smooth[k + 1]))
        .collect()
}

/// A bend that tightens, on waypoints that are off by some centimetres and uneven.
fn noisy(count: u32, spacing: f64) -> Places {
    (0..count)
        .map(|k| {
            let noise = |seed: f64| (seed * f64::from(k * k)).sin();
            let s = spacing * (f64::from(k) + 0.3 * noise(1.3));
            let angle = 0.03 * s + 0.001 * s * s;
            (
                100.0 + s * angle.cos() + 0.04 * noise(2.1),
                -50.0 + s * angle.sin() + 0.04 * noise(0.7),
            )
        })
        .collect()
}

fn arcs(places: &Places) -> Vec<f64> {
    let mut all = vec![0.0];
    for pair in places.windows(2) {
        let [(a, b), (c, d)] = [pair[0], pair[1]];
        all.push(all[all.len() - 1] + (c - a).hypot(d - b));
    }
    all
}

fn path(places: &Places, closed: bool) -> Path {
    let (x, y): (Vec<f64>, Vec<f64>) = places.iter().copied().unzip();
    Path::new(&x, &y, None, closed).unwrap()
}

#[track_caller]
fn assert_close(found: &[f64], expected: &[f64], nearly: f64) {
    assert_eq!(found.len(), expected.len());
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        let off = (found - expected).abs();
        assert!(off < nearly, "{k}: {found}, not {expected}");
    }
}

#[test]
fn test_curvature_of_noisy_waypoints_is_that_of_the_penalised_least_squares() {
    for count in [2, 3, 4, 5, 8, 40] {
        let places = noisy(count, 1.1);
        let expected = section(&arcs(&places), &places);
        let path = path(&places, false);
        assert_close(&path_curvature(&path.view(), LENGTH), &expected, 1e-9);
    }
}

#[test]
fn test_curvature_of_a_noisy_loop_is_that_of_the_periodic_least_squares() {
    for (count, size) in [(40_u32, 8.0), (12, 3.0)] {
        let places: Places = (0..count)
            .map(|k| {
                let angle = f64::from(k) * std::f64::consts::TAU / f64::from(count);
                let radius = size * (1.0 + 0.02 * f64::from(k * k).sin());
                (radius * angle.cos(), 0.8 * radius * angle.sin())
            })
            .collect();
        let mut arcs = arcs(&places);
        let (first, last) = (places[0], places[places.len() - 1]);
        let lap = arcs[arcs.len() - 1] + (first.0 - last.0).hypot(first.1 - last.1);
        arcs.truncate(places.len());
        let smooth = smoothed(&arcs, &places, Some(lap));
        let around = |k: usize| smooth[k % smooth.len()];
        let expected: Vec<f64> = (0..smooth.len())
            .map(|k| circle(around(k + smooth.len() - 1), around(k), around(k + 1)))
            .collect();
        let path = path(&places, true);
        // The loop is continued at its seam for 20 lengths and no farther.
        assert_close(&path_curvature(&path.view(), LENGTH), &expected, 1e-5);
    }
}

/// Waypoints closer together than a quarter of the length are averaged; between the means the
/// curvature is linear in the arc, and beyond the outermost constant.
#[test]
fn test_close_waypoints_have_the_curvature_of_their_means() {
    // Three by three: 0.3 m long, 0.25 m apart.
    let mut places = Places::new();
    for (x, y) in noisy(25, 0.55) {
        places.extend([(x, y), (x + 0.1, y + 0.02), (x + 0.25, y - 0.01)]);
    }
    // Some threes lie askew to the way on; their arc is what counts.
    let all = arcs(&places);
    let mut nodes: Vec<(f64, f64, (f64, f64), f64)> = Vec::new();
    for (&arc, &(x, y)) in all.iter().zip(&places) {
        match nodes.last_mut() {
            // First arc, then sums: of arcs, of places, their number.
            Some((first, sum, place, number)) if arc - *first < LENGTH / 4.0 => {
                *sum += arc;
                *place = (place.0 + x, place.1 + y);
                *number += 1.0;
            }
            _ => nodes.push((arc, arc, (x, y), 1.0)),
        }
    }
    assert!(nodes.len() > 20 && nodes.iter().any(|node| node.3 > 2.0));
    let means: Vec<f64> = nodes.iter().map(|node| node.1 / node.3).collect();
    let middles = nodes.iter().map(|n| (n.2.0 / n.3, n.2.1 / n.3)).collect();
    let bends = section(&means, &middles);
    let at = |arc: f64| {
        let next = means.partition_point(|&mean| mean <= arc);
        if next == 0 || next == means.len() {
            return bends[next.min(means.len() - 1)];
        }
        let share = (arc - means[next - 1]) / (means[next] - means[next - 1]);
        bends[next - 1] * (1.0 - share) + bends[next] * share
    };
    let expected: Vec<f64> = all.iter().map(|&arc| at(arc)).collect();
    let path = path(&places, false);
    assert_close(&path_curvature(&path.view(), LENGTH), &expected, 1e-8);
}

/// Where the vehicle turns round a section ends; the waypoint there belongs to the next one.
#[test]
fn test_sections_between_cusps_are_smoothed_by_themselves() {
    let places = noisy(30, 1.0);
    let sections = [(0, 9), (9, 11), (11, 29)];
    let mut expected = Vec::new();
    for (from, to) in sections {
        let part = places[from..=to].to_vec();
        let bends = section(&arcs(&part), &part);
        expected.extend_from_slice(&bends[..to - from]);
        if to == 29 {
            expected.push(bends[to - from]);
        }
    }
    let reverse: Vec<bool> = (0..30).map(|k| (9..11).contains(&k)).collect();
    let open = path(&places, false).with_reverse(&reverse).unwrap();
    assert_close(&path_curvature(&open.view(), LENGTH), &expected, 1e-9);
}

#[test]
fn test_section_across_the_start_of_a_lap_is_smoothed_as_one() {
    let places: Places = (0..24_u32)
        .map(|k| {
            let angle = f64::from(k) * std::f64::consts::TAU / 24.0;
            let radius = 6.0 + 0.1 * f64::from(k * k).sin();
            (radius * angle.cos(), radius * angle.sin())
        })
        .collect();
    // Forwards from 17 across the start to 5, and backwards from there to 17.
    let reverse: Vec<bool> = (0..24).map(|k| (5..17).contains(&k)).collect();
    let closed = path(&places, true).with_reverse(&reverse).unwrap();
    let mut expected = vec![0.0; 24];
    for (from, to) in [(5, 17), (17, 29)] {
        let part: Places = (from..=to).map(|k| places[k % 24]).collect();
        let bends = section(&arcs(&part), &part);
        for k in from..to {
            expected[k % 24] = bends[k - from];
        }
    }
    assert_close(&path_curvature(&closed.view(), LENGTH), &expected, 1e-9);
}

/// A path of more waypoints than are smoothed at once has the curvature of its parts.
#[test]
fn test_curvature_of_a_very_long_path_is_that_of_its_parts() {
    let place = |k: usize| {
        let x = 0.5 * popsteer_core::math::from_count(k);
        // Wobbles of 2 cm, as noise has them.
        (x, 9.0 * (x / 31.0).sin() + 0.02 * (2.0 * x).sin())
    };
    let count = 150_000;
    let part = |from: usize, to: usize, closed: bool| {
        let (x, y): (Vec<f64>, Vec<f64>) = (from..to).map(place).unzip();
        path_curvature(&Path::new(&x, &y, None, closed).unwrap().view(), LENGTH)
    };
    for closed in [false, true] {
        let whole = part(0, count, closed);
        for seam in [1 << 16, 1 << 17] {
            let alone = part(seam - 600, seam + 600, false);
            for k in 300..900 {
                let error = whole[seam - 600 + k] - alone[k];
                assert!(error.abs() < 1e-7, "{closed}, {k}: {error}");
            }
        }
    }
}
