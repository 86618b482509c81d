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
