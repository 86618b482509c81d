//! Where am I?

use super::{along, following, preceding, slack, waypoint};
use crate::bytes::Bytes;
use crate::scene::dt;
use popsteer_core::geometry::get_distance;
use popsteer_core::path::locate::{OPPOSITE, locate, locate_by_scan};
use popsteer_core::path::projection::{
    ClosestPoint, nearest_waypoint, path_yaw_behind, project, reference_speed,
};
use popsteer_core::path::relocalise::{first_as_good_by_scan, relocalise};
use popsteer_core::path::{Follow, Located};
use popsteer_core::vehicle::state::checked_dt;
use popsteer_core::{PathView, Point, VehicleState};
use std::f64::consts::PI;

/// The farthest that a law looks around its last place [m].
const REACH: f64 = 1.1e7;

pub(super) fn ask_beyond(view: &PathView<'_>, position: Point, yaw: f64, bytes: &mut Bytes) {
    let heading = Point::new(yaw.cos(), yaw.sin());
    assert!(
        locate(view, bytes.below(24), position, heading, 6.0, OPPOSITE).segment < view.segments()
    );
    let nearest = nearest_waypoint(view, position);
    assert!(nearest < view.len());
    assert!(project(view, nearest, position).segment < view.segments());
    assert!(relocalise(view, position, yaw, OPPOSITE) < view.segments());
}

/// A bounded search, as its definition has it.
pub(super) fn check_locate(
    view: &PathView<'_>,
    position: Point,
    yaw: f64,
    bytes: &mut Bytes,
) -> ClosestPoint {
    let heading = Point::new(yaw.cos(), yaw.sin());
    let last = match bytes.byte() {
        255 => usize::MAX,
        place => usize::from(place) % view.len(),
    };
    let reach = bytes.parameter(6.0, [0.0, 100.0], [0.0, REACH]);
    let reach = if (0.0..=REACH).contains(&reach) {
        reach
    } else {
        6.0
    };
    let closest = locate(view, last, position, heading, reach, OPPOSITE);
    assert_eq!(
        closest,
        locate_by_scan(view, last, position, heading, reach, OPPOSITE)
    );
    let start = last.min(view.segments() - 1);
    assert!(closest.segment < view.segments());
    assert_eq!(view.is_reverse(closest.segment), view.is_reverse(start));
    assert!(closest.fraction >= 0.0 || preceding(view, closest.segment).is_none());
    assert!(closest.fraction <= 1.0 || following(view, closest.segment).is_none());
    let slack = slack(view, position);
    let error = closest.cross_track_error().abs();
    assert!((error - get_distance(position, closest.point)).abs() <= slack);
    assert!(closest.arc_length(view).is_finite() && closest.path_yaw().abs() <= PI);
    // Not beyond the stretch.
    if !view.is_closed() {
        let between = (view.s()[closest.segment] - view.s()[start]).abs();
        let slack = 64.0 * f64::EPSILON * view.length();
        assert!(between <= reach + 2.0 * view.longest() + slack);
    }
    closest
}

/// The closest point beside the nearest waypoint of all.
pub(super) fn check_projection(view: &PathView<'_>, position: Point) {
    let distance = |index| get_distance(position, waypoint(view, index));
    let nearest = nearest_waypoint(view, position);
    assert!((0..view.len()).all(|index| distance(index) >= distance(nearest)));
    let closest = project(view, nearest, position);
    let slack = slack(view, position);
    assert!(closest.segment < view.segments());
    assert!(closest.fraction.is_finite() && closest.arc_length.is_finite());
    assert!(closest.path_yaw.abs() <= PI && path_yaw_behind(view, nearest).abs() <= PI);
    let error = closest.cross_track_error.abs();
    assert!(error <= get_distance(position, waypoint(view, nearest)) + slack);
    assert!((error - get_distance(position, closest.point)).abs() <= slack);
    assert!(closest.fraction >= 0.0 || preceding(view, closest.segment).is_none());
    assert!(closest.fraction <= 1.0 || following(view, closest.segment).is_none());
    match (reference_speed(view, &closest), view.speed()) {
        (Some(speed), Some(speeds)) => {
            let ends =
                [closest.segment, (closest.segment + 1) % view.len()].map(|k| speeds[k].abs());
            let slack = 4.0 * f64::EPSILON * (ends[0] + ends[1]);
            assert!(speed.abs() >= ends[0].min(ends[1]) - slack);
            assert!(speed.abs() <= ends[0].max(ends[1]) + slack);
            assert_eq!(speed.is_sign_negative(), view.is_reverse(closest.segment));
        }
        (None, None) => {}
        mixed => panic!("{mixed:?}"),
    }
}

/// No other segment costs less, by arithmetic of its own.
pub(super) fn check_relocalise(view: &PathView<'_>, position: Point, yaw: f64) {
    let cost = |segment: usize| {
        let along = along(view, segment);
        let length = get_distance(Point::zeros(), along);
        let (to, unit) = (position - waypoint(view, segment), along / length);
        let ahead = (to.x * unit.x + to.y * unit.y).clamp(0.0, length);
        let distance = get_distance(to, ahead * unit);
        let forward = yaw.cos() * unit.x + yaw.sin() * unit.y;
        let looks = if view.is_reverse(segment) {
            -forward
        } else {
            forward
        };
        distance + 0.5 * OPPOSITE * (1.0 - looks)
    };
    let found = relocalise(view, position, yaw, OPPOSITE);
    let least = (0..view.segments()).map(cost).fold(f64::INFINITY, f64::min);
    assert!(cost(found) <= least + slack(view, position));
}

/// The walk of a law's point along the path, step by step as its page has it.
pub(super) fn check_follow(view: &PathView<'_>, vehicle: VehicleState, bytes: &mut Bytes) {
    let reference_offset = bytes.parameter(3.0, [-3.0, 4.0], [-1e3, 1e3]);
    let follow = Follow {
        base: bytes.parameter(0.0, [-3.0, 1.0], [-1e3, 1e3]),
        reference_offset,
        rear_axle: -0.5 * reference_offset,
        search_distance: bytes.parameter(6.0, [0.0, 20.0], [0.0, 1e6]),
        lost_distance: bytes.parameter(30.0, [1.0, 40.0], [1e-3, 1e9]),
        arrival_distance: bytes.parameter(0.15, [0.0, 1.0], [5e-5, 50.0]),
        opposite_distance: OPPOSITE,
    };
    let last = (bytes.byte() > 40).then(|| bytes.below(24));
    let valid = |value: f64, low: f64, high: f64| (low..=high).contains(&value);
    let Ok(dt) = checked_dt(dt(bytes)) else {
        return;
    };
    if !(valid(follow.base, -1e3, 1e3)
        && valid(follow.reference_offset, -1e3, 1e3)
        && valid(follow.search_distance, 0.0, 1e6)
        && valid(follow.lost_distance, 1e-3, 1e9)
        && valid(follow.arrival_distance, 0.0, 50.0))
    {
        return;
    }
    let at = follow.locate(view, last, vehicle, dt);
    assert_eq!(at, follow_plainly(&follow, view, last, vehicle, dt));
    assert_eq!(at.reverse, view.is_reverse(at.closest.segment));
    assert!(last.is_some() || !at.direction_changed);
    let driven = if at.reverse {
        -vehicle.speed
    } else {
        vehicle.speed
    };
    assert_eq!(at.vehicle.speed.to_bits(), driven.to_bits());
    assert_eq!(at.mirror(at.mirror(0.3)).to_bits(), 0.3_f64.to_bits());
}

/// The last segment before the vehicle turns round, where it ends near enough ahead of the closest
/// point.
fn last_segment_near(follow: &Follow, view: &PathView<'_>, at: &Located) -> Option<usize> {
    let sign = if at.reverse { -1.0 } else { 1.0 };
    let behind = sign * (follow.rear_axle - follow.base) - follow.reference_offset;
    let first = at.closest.segment;
    let mut last = first;
    for _ in 0..view.segments() {
        let Some(next) = following(view, last) else {
            break;
        };
        last = next;
    }
    let seam = if last < first { view.length() } else { 0.0 };
    let end = view.s().get(last + 1).copied().unwrap_or(view.length()) + seam;
    let near = behind.max(0.0) + 4.0 * follow.arrival_distance;
    (end - at.closest.arc_length(view) <= near).then_some(last)
}

/// Whether an open path that ends where it began is driven from its beginning by a vehicle at its end.
fn starts_a_lap(
    follow: &Follow,
    view: &PathView<'_>,
    found: usize,
    (position, yaw): (Point, f64),
) -> bool {
    let (first, last, reach) = (
        waypoint(view, 0),
        waypoint(view, view.len() - 1),
        follow.search_distance,
    );
    let ahead = waypoint(view, 1) - first;
    view.length() > 4.0 * reach
        && get_distance(first, last) <= 0.5 * reach
        && view.s()[found] >= view.length() - 2.0 * reach
        && get_distance(first, position) <= reach
        && ahead.x * yaw.cos() + ahead.y * yaw.sin() > 0.0
        && !view.is_reverse(0)
}

fn follow_plainly(
    follow: &Follow,
    view: &PathView<'_>,
    last: Option<usize>,
    vehicle: VehicleState,
    dt: f64,
) -> Located {
    let base = vehicle.ahead(follow.base);
    let anew = || relocalise(view, Point::new(base.x, base.y), vehicle.yaw, OPPOSITE);
    let from = |segment: usize| {
        let reverse = view.is_reverse(segment);
        let (turn, sign) = if reverse { (PI, -1.0) } else { (0.0, 1.0) };
        let driven = VehicleState {
            yaw: vehicle.yaw + turn,
            speed: sign * vehicle.speed,
            ..vehicle
        };
        let heading = Point::new(driven.yaw.cos(), driven.yaw.sin());
        let position = driven.point_ahead(follow.reference_offset + sign * follow.base);
        let reach = follow.search_distance + driven.speed.abs() * dt;
        let closest = locate_by_scan(view, segment, position, heading, reach, OPPOSITE);
        let is_last = !view.is_closed() && closest.segment + 1 == view.segments();
        Located {
            position,
            closest,
            vehicle: driven,
            heading,
            dt,
            reverse,
            direction_changed: false,
            off_path: false,
            past_end: is_last && closest.fraction > 1.0,
            before_start: !view.is_closed() && closest.segment == 0 && closest.fraction < 0.0,
        }
    };
    // A vehicle that was on no path before is at the first of the places that are as good.
    let first = || {
        let (found, noise) = (anew(), 0.075 * OPPOSITE);
        let position = Point::new(base.x, base.y);
        if view.is_closed() {
            found
        } else if starts_a_lap(follow, view, found, (position, vehicle.yaw)) {
            0
        } else {
            first_as_good_by_scan(view, position, vehicle.yaw, OPPOSITE, (found, noise))
        }
    };
    let start = last.map_or_else(first, |last| last.min(view.segments() - 1));
    let mut at = from(start);
    // At the place where it has to turn round, the vehicle goes on with the next section.
    if let Some(last_leg) = last_segment_near(follow, view, &at) {
        let next = (last_leg + 1) % view.len();
        let goes_on = view.is_closed() || last_leg + 1 < view.segments();
        if goes_on && view.is_reverse(next) != view.is_reverse(last_leg) {
            let along = along(view, last_leg);
            let to = waypoint(view, next) - vehicle.point_ahead(follow.rear_axle);
            let length = (along.x * along.x + along.y * along.y).sqrt();
            if (to.x * along.x + to.y * along.y) / length <= follow.arrival_distance {
                at = from(next);
            }
        }
    }
    if at.closest.squared_distance > follow.lost_distance * follow.lost_distance {
        let anew = from(anew());
        if anew.closest.squared_distance < at.closest.squared_distance {
            at = anew;
        }
        at.off_path = true;
    }
    at.direction_changed = last.is_some() && at.reverse != view.is_reverse(start);
    at
}
