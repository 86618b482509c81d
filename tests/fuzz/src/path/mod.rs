//! Paths: made, measured, projected upon, searched.

mod aim;
mod place;

use crate::bytes::Bytes;
use crate::scene::{Waypoints, vehicle};
use popsteer_core::bounds::MAX_COORDINATE;
use popsteer_core::geometry::get_distance;
use popsteer_core::path::measure::COINCIDING;
use popsteer_core::path::sound::distinct_waypoints;
use popsteer_core::{Path, PathError, PathView, Point};

/// Makes a path and asks it everything from a few places.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let waypoints = Waypoints::draw(&mut bytes);
    check_distinct(&waypoints);
    let path = match waypoints.path() {
        Ok(path) => path,
        Err(error) => return check_refusal(&waypoints, &error),
    };
    let view = path.view();
    check_measure(&view);
    check_reverse(&waypoints, &path);
    check_borrowed(&waypoints, &view, &mut bytes);
    for _ in 0..4 {
        let Ok(vehicle) = vehicle(&mut bytes, &view).checked() else {
            continue;
        };
        place::check_follow(&view, vehicle, &mut bytes);
        let position = vehicle.point_ahead(bytes.parameter(0.0, [-3.0, 3.0], [-1e3, 1e3]));
        // No law asks about a place farther off than this; there it is enough that all returns.
        let farthest = MAX_COORDINATE + 1e3;
        if !(position.x.abs() <= farthest && position.y.abs() <= farthest) {
            place::ask_beyond(&view, position, vehicle.yaw, &mut bytes);
            continue;
        }
        let closest = place::check_locate(&view, position, vehicle.yaw, &mut bytes);
        place::check_projection(&view, position);
        place::check_relocalise(&view, position, vehicle.yaw);
        aim::check_crossing(&view, &closest, position, &mut bytes);
        aim::check_lookahead(&view, closest.nearest_waypoint(&view), position, &mut bytes);
        aim::check_preview(&view, &closest, &mut bytes);
        if bytes.is_empty() {
            break;
        }
    }
}

/// More than rounding can be off at these coordinates [m].
fn slack(view: &PathView<'_>, position: Point) -> f64 {
    let size = view
        .x()
        .iter()
        .chain(view.y())
        .fold(1.0, |most: f64, value| most.max(value.abs()));
    64.0 * f64::EPSILON * (size + position.x.abs() + position.y.abs())
}

fn waypoint(view: &PathView<'_>, index: usize) -> Point {
    Point::new(view.x()[index], view.y()[index])
}

/// From the start of a segment to its end.
fn along(view: &PathView<'_>, segment: usize) -> Point {
    waypoint(view, (segment + 1) % view.len()) - waypoint(view, segment)
}

/// The segment after another one, where the vehicle keeps its direction.
fn following(view: &PathView<'_>, segment: usize) -> Option<usize> {
    let next = (segment + 1) % view.len();
    let exists = view.is_closed() || segment + 1 < view.segments();
    (exists && view.is_reverse(next) == view.is_reverse(segment)).then_some(next)
}

/// The segment before another one, where the vehicle keeps its direction.
fn preceding(view: &PathView<'_>, segment: usize) -> Option<usize> {
    let last = (segment + view.len() - 1) % view.len();
    let exists = view.is_closed() || segment > 0;
    (exists && view.is_reverse(last) == view.is_reverse(segment)).then_some(last)
}

/// Of neighbours at one place the last is kept, and no more than those are lost.
fn check_distinct(waypoints: &Waypoints) {
    let Waypoints { x, y, closed, .. } = waypoints;
    let kept = distinct_waypoints(x, y, *closed);
    let apart = |a: usize, b: usize| {
        let (a, b) = (Point::new(x[a], y[a]), Point::new(x[b], y[b]));
        // What is no number lies nowhere, and coincides with nothing.
        let distance = get_distance(a, b);
        distance.is_nan() || distance > COINCIDING
    };
    assert!(
        kept.windows(2)
            .all(|pair| pair[0] < pair[1] && apart(pair[0], pair[1]))
    );
    if let (true, [first, .., last]) = (*closed, kept.as_slice()) {
        assert!(apart(*first, *last));
    }
    assert_eq!(kept.is_empty(), x.is_empty());
    let mut lost = (0..x.len()).filter(|k| !kept.contains(k));
    assert!(lost.all(|k| (0..x.len()).any(|other| other != k && !apart(k, other))));
}

/// Which segments are driven backwards: said outright, else by the signs of the speeds.
fn check_reverse(waypoints: &Waypoints, path: &Path) {
    let view = path.view();
    let sign = |k: usize| {
        let speeds = waypoints.speed.as_ref()?;
        let at_end = |k: usize| (k < view.len() || view.is_closed()).then(|| k % view.len());
        [Some(k), at_end(k + 1)]
            .into_iter()
            .flatten()
            .map(|k| speeds[k])
            .find(|speed| speed.abs() > 0.0)
    };
    let mut before = false;
    for k in 0..view.segments() {
        before = match &waypoints.reverse {
            Some(reverse) => reverse[k],
            None => sign(k).map_or(before, |speed| speed < 0.0),
        };
        assert_eq!(view.is_reverse(k), before);
    }
    let none = vec![false; view.len()];
    let forward = path
        .clone()
        .with_reverse(&none)
        .expect("as many as waypoints");
    assert!(forward.view().reverse().is_none());
    let wanted = PathError::LengthMismatch {
        field: "reverse",
        length: view.len() - 1,
        waypoints: view.len(),
    };
    assert_eq!(view.with_reverse(&none[1..]).err(), Some(wanted));
}

/// The error tells the truth.
fn check_refusal(waypoints: &Waypoints, error: &PathError) {
    let Waypoints { x, y, speed, .. } = waypoints;
    assert!(!error.to_string().is_empty());
    match *error {
        PathError::TooFewWaypoints { count, least } => {
            assert!(count == x.len() && count < least);
        }
        PathError::OutOfRange {
            field,
            index,
            value,
            ..
        } => {
            let (named, bound) = match field {
                "x" => (x[index], MAX_COORDINATE),
                "y" => (y[index], MAX_COORDINATE),
                _ => (speed.as_ref().expect("speeds are named")[index], 1e4),
            };
            assert_eq!(named.to_bits(), value.to_bits());
            assert!(value.is_nan() || value.abs() > bound);
        }
        PathError::Coinciding { index, next } => {
            let from = Point::new(x[index], y[index]);
            assert!(get_distance(from, Point::new(x[next], y[next])) <= COINCIDING);
        }
        PathError::LengthMismatch { .. }
        | PathError::GridTooLarge { .. }
        | PathError::Contradicting { .. }
        | PathError::Fold { .. }
        | PathError::Gap { .. }
        | PathError::Unordered { .. } => {
            panic!("no reason to refuse: {error}")
        }
    }
}

fn check_measure(view: &PathView<'_>) {
    let s = view.s();
    assert_eq!(s[0].to_bits(), 0);
    assert!(s.windows(2).all(|pair| pair[0] <= pair[1]));
    assert!(view.length().is_finite() && s[s.len() - 1] <= view.length());
    assert!(view.length() > 0.0);
    let segment = |k: usize| s.get(k + 1).copied().unwrap_or(view.length()) - s[k];
    let longest = (0..view.segments()).map(segment).fold(0.0, f64::max);
    assert_eq!(view.longest().to_bits(), longest.to_bits());
    assert_eq!(view.segments() + usize::from(!view.is_closed()), view.len());
}

/// The same path of lent slices is the same; too little room is refused.
fn check_borrowed(waypoints: &Waypoints, view: &PathView<'_>, bytes: &mut Bytes) {
    let Waypoints {
        x,
        y,
        speed,
        closed,
        ..
    } = waypoints;
    let room = if bytes.byte() < 250 {
        x.len()
    } else {
        bytes.below(32)
    };
    let mut s = vec![f64::NAN; room];
    match PathView::new(x, y, speed.as_deref(), *closed, &mut s) {
        Ok(lent) => {
            assert_eq!((lent.s(), room), (view.s(), x.len()));
            assert_eq!(lent.length().to_bits(), view.length().to_bits());
        }
        Err(error) => {
            let wanted = PathError::LengthMismatch {
                field: "s",
                length: room,
                waypoints: x.len(),
            };
            assert_eq!(error, wanted);
        }
    }
}
