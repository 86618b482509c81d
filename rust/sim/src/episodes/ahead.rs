//! Points of the path ahead.

use popsteer_core::{PathView, Point};

/// Segments that are tried one after the other before the search halves.
const WALK: usize = 16;

/// The point of the path at `arc` [m], looked for from segment `near` on, and its segment. Both
/// ends of an open path go on as straight lines; a closed one goes round.
pub(super) fn point_at(path: &PathView<'_>, arc: f64, near: usize) -> (Point, usize) {
    let length = path.length();
    let arc = if path.is_closed() {
        arc - length * (arc / length).floor()
    } else {
        arc
    };
    let s = path.s();
    let last = path.segments() - 1;
    let starts_before = |segment: usize| s.get(segment).is_some_and(|&start| start <= arc);
    let mut segment = near.min(last);
    if starts_before(segment) {
        for _ in 0..WALK {
            if segment == last || !starts_before(segment + 1) {
                break;
            }
            segment += 1;
        }
    }
    let holds = starts_before(segment) && (segment == last || !starts_before(segment + 1));
    if !holds {
        segment = s.partition_point(|&start| start <= arc);
        segment = segment.saturating_sub(1).min(last);
    }
    let next = (segment + 1) % path.len();
    let at = |index: usize| match (path.x().get(index), path.y().get(index)) {
        (Some(&x), Some(&y)) => Point::new(x, y),
        _ => Point::new(0.0, 0.0),
    };
    let begin = s.get(segment).copied().unwrap_or(0.0);
    let end = s.get(segment + 1).copied().unwrap_or(length);
    let share = (arc - begin) / (end - begin);
    let (from, to) = (at(segment), at(next));
    let point = Point::new(
        from.x + share * (to.x - from.x),
        from.y + share * (to.y - from.y),
    );
    (point, segment)
}
