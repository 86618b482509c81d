//! A course that is known, for faults to be put into.

/// Waypoints [m].
pub(crate) type Xy = Vec<(f64, f64)>;

/// A straight, an arc of a radius of 15 m, and a straight, with a spacing [m].
pub(crate) fn course(spacing: f64) -> Xy {
    let (mut x, mut y, mut yaw) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut points = Vec::new();
    let mut travelled = 0.0;
    while travelled < 90.0 {
        points.push((x, y));
        let turn = if travelled > 30.0 && travelled < 50.0 {
            spacing / 15.0
        } else {
            0.0
        };
        yaw += 0.5 * turn;
        x += spacing * yaw.cos();
        y += spacing * yaw.sin();
        yaw += 0.5 * turn;
        travelled += spacing;
    }
    points
}

/// The largest turn at a waypoint [rad].
pub(crate) fn largest_turn(points: &Xy) -> f64 {
    let turns = points.windows(3).map(|three| {
        let [a, b, c] = [three[0], three[1], three[2]];
        let [from, to] = [(b.0 - a.0, b.1 - a.1), (c.0 - b.0, c.1 - b.1)];
        let cross = from.0 * to.1 - from.1 * to.0;
        cross.atan2(from.0 * to.0 + from.1 * to.1).abs()
    });
    turns.fold(0.0, f64::max)
}
