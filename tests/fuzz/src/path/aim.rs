//! Where do I aim, and what lies ahead?

use super::{along, following, slack, waypoint};
use crate::bytes::Bytes;
use popsteer_core::geometry::get_distance;
use popsteer_core::math::{atan2, wrap};
use popsteer_core::path::ClosestPoint;
use popsteer_core::path::jump::find_lookahead_point;
use popsteer_core::path::lookahead::{get_crossing, get_lookahead_point};
use popsteer_core::path::preview::Preview;
use popsteer_core::path::resample::{Grid, window};
use popsteer_core::{PathView, Point};
use std::f64::consts::PI;

/// The longest lookahead that a law asks for [m].
const LONGEST: f64 = 1.001e7;

/// The point lies on the path ahead and on the circle, and all before it within.
pub(super) fn check_crossing(
    view: &PathView<'_>,
    closest: &ClosestPoint,
    position: Point,
    bytes: &mut Bytes,
) {
    let lookahead = draw_lookahead(view, position, 0.0, bytes);
    if !(0.0..=LONGEST).contains(&lookahead) {
        return;
    }
    let (point, found) = get_crossing(view, closest, position, lookahead);
    let slack = slack(view, position) + 64.0 * f64::EPSILON * lookahead;
    if closest.squared_distance >= lookahead * lookahead {
        assert_eq!((point, found), (closest.point, false));
        return;
    }
    let inside = |index: usize| get_distance(position, waypoint(view, index)) <= lookahead + slack;
    if !found {
        assert!((0..view.segments()).all(|segment| following(view, segment).is_some()));
        assert!((0..view.len()).all(inside));
        assert!((0..view.len()).any(|index| waypoint(view, index) == point));
        return;
    }
    assert!(
        (get_distance(position, point) - lookahead).abs() <= slack,
        "{position:?} {lookahead} {closest:?} {point:?} {slack} {view:?}"
    );
    let (mut from, mut segment) = (closest.point, closest.segment);
    for _ in 0..view.segments() {
        let unit = along(view, segment) / get_distance(Point::zeros(), along(view, segment));
        let to = point - from;
        let (ahead, aside) = (to.x * unit.x + to.y * unit.y, unit.x * to.y - unit.y * to.x);
        let end = (segment + 1) % view.len();
        let next = following(view, segment);
        let left = get_distance(from, waypoint(view, end));
        if aside.abs() <= slack && ahead >= -slack && (next.is_none() || ahead <= left + slack) {
            return;
        }
        assert!(inside(end));
        (from, segment) = (
            waypoint(view, end),
            next.expect("the point lies on the path"),
        );
    }
    panic!("{point:?} lies nowhere on the path ahead");
}

/// Directions are the same whichever place was asked for before, and no turn is more than half one.
pub(super) fn check_preview(view: &PathView<'_>, closest: &ClosestPoint, bytes: &mut Bytes) {
    let base = bytes.parameter(2.0, [0.0, 10.0], [0.0, 1e3]);
    let step = bytes.parameter(0.5, [0.05, 20.0], [1e-7, 1e7]);
    if !((0.0..=1e3).contains(&base) && (1e-7..=1e7).contains(&step)) {
        return;
    }
    let mut turns = [f64::NAN; 6];
    let arc_length = closest.arc_length(view);
    let new = || Preview::new(view, base, closest.segment, arc_length, 6.0 * step);
    let (along, aside) = new().turns(arc_length, step, &mut turns);
    let first = atan2(aside, along);
    let (mut here, mut travelled) = (new().path_yaw(arc_length), 0.0);
    assert_eq!(first.to_bits(), here.to_bits());
    assert!(first.abs() <= PI);
    for turn in turns {
        travelled += step;
        let next = new().path_yaw(arc_length + travelled);
        // A turn is taken between the chords, so the two angles round otherwise.
        let off = wrap(turn - (next - here)).abs();
        assert!(off <= 1e-14, "{turn} {next} {here}");
        here = next;
    }
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
    let along = along(view, index % view.segments());
    let to = position - at;
    let reach = if place & 1 == 0 {
        get_distance(position, at)
    } else {
        (along.x * to.y - along.y * to.x).abs() / get_distance(Point::zeros(), along)
    };
    reach + [0.0, tolerance, -tolerance][bytes.below(3)]
}

/// The search that jumps finds what the plain loop finds.
pub(super) fn check_lookahead(
    view: &PathView<'_>,
    nearest: usize,
    position: Point,
    bytes: &mut Bytes,
) {
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
}
