//! Paths: made, measured, projected upon, searched.

use crate::bytes::Bytes;
use crate::scene::{Waypoints, vehicle};
use popsteer_core::path::jump::find_lookahead_point;
use popsteer_core::path::locate::{
    locate, nearest_waypoint, path_yaw_behind, project, reference_speed, walk,
};
use popsteer_core::path::lookahead::{get_lookahead_point, get_lookahead_point_index};
use popsteer_core::path::relocalise::{REACH, relocalise};
use popsteer_core::path::resample::{Grid, window};
use popsteer_core::path::view::{COINCIDING, MAX_COORDINATE, get_distance};
use popsteer_core::{PathError, PathView, Point, VehicleState};
use std::f64::consts::PI;

/// Makes a path and asks it everything from a few places.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let waypoints = Waypoints::draw(&mut bytes);
    let path = match waypoints.path() {
        Ok(path) => path,
        Err(error) => return check_refusal(&waypoints, &error),
    };
    let view = path.view();
    check_measure(&view);
    check_borrowed(&waypoints, &view, &mut bytes);
    for _ in 0..4 {
        let Ok(vehicle) = vehicle(&mut bytes, &view).checked() else {
            continue;
        };
        let position = vehicle.point_ahead(bytes.number([-3.0, 3.0], [-1e3, 1e3]));
        // No law asks about a place farther off than this; there it is enough that all returns.
        let farthest = MAX_COORDINATE + 1e3;
        if !(position.x.abs() <= farthest && position.y.abs() <= farthest) {
            ask_beyond(&view, position, vehicle.yaw, &mut bytes);
            continue;
        }
        let last = bytes.below(24);
        let nearest = check_locate(&view, position, last);
        check_projection(&view, nearest, position);
        check_relocalise(&view, position, vehicle);
        check_lookahead(&view, nearest, position, &mut bytes);
        if bytes.is_empty() {
            break;
        }
    }
}

fn ask_beyond(view: &PathView<'_>, position: Point, yaw: f64, bytes: &mut Bytes) {
    let nearest = locate(view, Some(bytes.below(24)), position);
    assert!(nearest < view.len());
    assert!(project(view, nearest, position).segment < view.segments());
    assert!(relocalise(view, position, yaw) < view.len());
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
        PathError::LengthMismatch { .. } => panic!("no reason to refuse: {error}"),
    }
}

fn check_measure(view: &PathView<'_>) {
    let s = view.s();
    assert_eq!(s[0].to_bits(), 0);
    assert!(s.windows(2).all(|pair| pair[0] <= pair[1]));
    assert!(view.length().is_finite() && s[s.len() - 1] <= view.length());
    assert!(view.length() > 0.0);
    assert_eq!(view.segments() + usize::from(!view.is_closed()), view.len());
}

/// The same path of lent slices is the same; too little room is refused.
fn check_borrowed(waypoints: &Waypoints, view: &PathView<'_>, bytes: &mut Bytes) {
    let Waypoints {
        x,
        y,
        speed,
        closed,
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

fn check_locate(view: &PathView<'_>, position: Point, last: usize) -> usize {
    let distance = |index| get_distance(position, waypoint(view, index));
    let least = nearest_waypoint(view, position);
    assert!((0..view.len()).all(|index| distance(index) >= distance(least)));
    assert_eq!(locate(view, None, position), least);
    assert_eq!(locate(view, Some(usize::MAX), position), least);
    let nearest = locate(view, Some(last), position);
    if last < view.len() {
        assert_eq!(nearest, walk(view, last, position));
        assert!(distance(nearest) <= distance(last));
    } else {
        assert_eq!(nearest, least);
    }
    nearest
}

fn check_projection(view: &PathView<'_>, nearest: usize, position: Point) {
    let foot = project(view, nearest, position);
    let slack = slack(view, position);
    assert!(foot.segment < view.segments());
    assert!(foot.fraction.is_finite() && foot.arc_length.is_finite());
    assert!(foot.path_yaw.abs() <= PI && path_yaw_behind(view, nearest).abs() <= PI);
    let error = foot.cross_track_error.abs();
    assert!(error <= get_distance(position, waypoint(view, nearest)) + slack);
    assert!((error - get_distance(position, foot.point)).abs() <= slack);
    let first = foot.segment == 0 && !view.is_closed();
    let last = foot.segment + 1 == view.segments() && !view.is_closed();
    assert!(foot.fraction >= 0.0 || first);
    assert!(foot.fraction <= 1.0 || last);
    match (reference_speed(view, &foot), view.speed()) {
        (Some(speed), Some(speeds)) => {
            let ends = [foot.segment, (foot.segment + 1) % view.len()].map(|k| speeds[k]);
            let slack = 4.0 * f64::EPSILON * (ends[0].abs() + ends[1].abs());
            assert!(speed >= ends[0].min(ends[1]) - slack);
            assert!(speed <= ends[0].max(ends[1]) + slack);
        }
        (None, None) => {}
        mixed => panic!("{mixed:?}"),
    }
}

/// Against the definition, waypoint by waypoint.
fn check_relocalise(view: &PathView<'_>, position: Point, vehicle: VehicleState) {
    let distance = |index| get_distance(position, waypoint(view, index));
    let heading = Point::new(vehicle.yaw.cos(), vehicle.yaw.sin());
    let fits = |index: usize| {
        let from = if index == view.segments() {
            index - 1
        } else {
            index
        };
        let along = waypoint(view, (from + 1) % view.len()) - waypoint(view, from);
        heading.x * along.x + heading.y * along.y >= 0.0
    };
    let found = relocalise(view, position, vehicle.yaw);
    let nearest = distance(nearest_waypoint(view, position));
    let fitting = (0..view.len())
        .filter(|&index| fits(index))
        .map(distance)
        .fold(f64::INFINITY, f64::min);
    let wanted = if fitting <= nearest + REACH {
        fitting
    } else {
        nearest
    };
    assert!(distance(found) <= wanted);
    assert!(fits(found) || fitting > nearest + REACH);
}

/// A lookahead of any length, or one whose circle, or an edge of whose threshold, touches a segment
/// or goes through a waypoint: there a jump can miss by a rounding.
fn draw_lookahead(view: &PathView<'_>, position: Point, tolerance: f64, bytes: &mut Bytes) -> f64 {
    let place = bytes.byte();
    if place < 128 {
        return bytes.number([0.0, 15.0], [0.0, 1e7 + 1e4]);
    }
    let index = bytes.below(view.len());
    let at = waypoint(view, index);
    let along = waypoint(view, (index + 1) % view.len()) - at;
    let to = position - at;
    let reach = if place & 1 == 0 {
        get_distance(position, at)
    } else {
        (along.x * to.y - along.y * to.x).abs() / get_distance(Point::zeros(), along)
    };
    reach + [0.0, tolerance, -tolerance][bytes.below(3)]
}

/// The search that jumps finds what the plain loop finds.
fn check_lookahead(view: &PathView<'_>, nearest: usize, position: Point, bytes: &mut Bytes) {
    let tolerance = bytes.parameter(0.01, [1e-3, 0.5], [1e-9, 1e3]);
    let ahead = bytes.parameter(20.0, [0.1, 40.0], [1e-3, 1e6]);
    let spacing = bytes.parameter(0.2, [0.05, 2.0], [1e-4, 1e3]);
    let lookahead = draw_lookahead(view, position, tolerance, bytes);
    let valid = |value: f64, low: f64, high: f64| (low..=high).contains(&value);
    if !(valid(lookahead, 0.0, 1.001e7)
        && valid(tolerance, 1e-9, 1e3)
        && valid(ahead, 1e-3, 1e6)
        && valid(spacing, 1e-4, 1e3))
    {
        return;
    }
    let (point, found) = find_lookahead_point(
        view, nearest, ahead, spacing, position, lookahead, tolerance,
    );
    assert_eq!(
        found,
        (get_distance(position, point) - lookahead).abs() <= tolerance
    );
    let window = window(view, nearest, ahead);
    assert!(window.first < view.len());
    assert!((1..=view.segments()).contains(&window.segments));
    let grid = Grid::new(*view, window, spacing);
    let points = grid
        .segments()
        .fold(1_usize, |sum, segment| sum.saturating_add(segment.count));
    if points > 300 {
        return;
    }
    let plain = get_lookahead_point(&grid, position, lookahead, tolerance);
    assert_eq!((point, found), (plain.point, plain.found));
    assert!(plain.index < points);
    assert_eq!(
        get_lookahead_point_index(&grid, position, lookahead, tolerance),
        plain.index
    );
}
