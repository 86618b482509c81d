//! The smoothed direction of the path at distances along it.

use super::view::PathView;
use crate::geometry::{Point, get_distance, squared_distance};
use crate::math::{atan, atan2, larger, remainder, saturate, smaller};
use crate::vehicle::Vehicle;

/// The direction of a path, smoothed over `base` [m] of it.
///
/// The direction at an arc length is that of the chord from half a base behind to half a base
/// ahead: on a bend it is the tangent, where the direction of the segments would jump. Where
/// segments are longer than half a base, the chord reaches one segment's length either way instead,
/// up to five bases, so coarse waypoints turn as evenly as fine ones. Where the path doubles back
/// within the chord, the direction is that of the segment. Beyond an open path's ends, and where
/// the vehicle turns round to go on the other way, it goes straight on; a closed path wraps.
///
/// A query costs a bisection at worst, and next to nothing on the segment of the last query or the
/// next one.
#[derive(Clone, Copy, Debug)]
pub struct Preview<'a> {
    path: &'a PathView<'a>,
    base: f64,
    /// Longest reach of a chord on each side [m].
    reach: f64,
    stretch: Option<Stretch>,
    /// The segments of the last places: behind, at, and ahead of the arc length asked for.
    hints: [usize; 3],
}

/// A stretch without a cusp: from the start of the first segment to the end of the last, with the
/// arc lengths [m] of both, which are infinite where neither is near.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    first: usize,
    start: f64,
    last: usize,
    end: f64,
}

impl<'a> Preview<'a> {
    /// The direction of `path`, smoothed over `base` [m], from `arc_length` on segment `segment`
    /// as far as `distance` [m] ahead.
    pub fn new(
        path: &'a PathView<'a>,
        base: f64,
        segment: usize,
        arc_length: f64,
        distance: f64,
    ) -> Self {
        Self::reaching(path, base, 5.0 * base, segment, arc_length, distance)
    }

    /// The same with chords that reach at most so far [m] either way.
    #[inline]
    fn reaching(
        path: &'a PathView<'a>,
        base: f64,
        reach: f64,
        segment: usize,
        arc_length: f64,
        distance: f64,
    ) -> Self {
        let stretch = path.reverse().is_some().then(|| {
            let farthest = arc_length + distance + reach;
            Stretch::about(path, segment, arc_length - reach, farthest)
        });
        Self {
            path,
            base,
            reach,
            stretch,
            hints: [segment; 3],
        }
    }

    /// The direction of `path` [rad], smoothed over `base` [m], at `arc_length` on segment
    /// `segment`: that of one place, where [`new`](Self::new) is for several.
    ///
    /// The chord reaches at most one base on each side. A longer one makes a vehicle that steers by
    /// this direction alone cut the corners of coarse waypoints; a plan over several places does
    /// not.
    #[inline]
    pub fn yaw_at(path: &'a PathView<'a>, base: f64, segment: usize, arc_length: f64) -> f64 {
        Self::reaching(path, base, base, segment, arc_length, 0.0).path_yaw(arc_length)
    }

    /// Direction of the path at `arc_length` [rad].
    #[inline]
    pub fn path_yaw(&mut self, arc_length: f64) -> f64 {
        let (x, y) = self.chord(arc_length);
        atan2(y, x)
    }

    /// The chord about `arc_length`, as far as it goes in x and in y [m].
    #[inline]
    fn chord(&mut self, arc_length: f64) -> (f64, f64) {
        let [behind, here, ahead] = self.hints;
        let (here, _) = self.place_at(arc_length, here);
        let (start, end) = self.path.segment(here);
        let length = get_distance(start, end);
        let mut reach = saturate(length, 0.5 * self.base, self.reach);
        if self.path.is_closed() && reach > 0.25 * self.path.length() {
            reach = 0.25 * self.path.length();
        }
        let (tail, behind) = self.point_at(arc_length - reach, behind);
        let (head, ahead) = self.point_at(arc_length + reach, ahead);
        self.hints = [behind, here, ahead];
        let (from, to) = if squared_distance(tail, head) > reach * reach {
            (tail, head)
        } else {
            (start, end)
        };
        (to.x - from.x, to.y - from.y)
    }

    /// How far the path turns over each of several steps of `step` [m] from `arc_length` on
    /// [rad], into `turns`, and its direction at the start [rad].
    #[inline]
    pub fn turns(&mut self, arc_length: f64, step: f64, turns: &mut [f64]) -> f64 {
        let first = self.chord(arc_length);
        let mut here = first;
        let mut travelled = 0.0;
        for turn in turns {
            travelled += step;
            let next = self.chord(arc_length + travelled);
            *turn = angle_between(here, next);
            here = next;
        }
        let (x, y) = first;
        atan2(y, x)
    }

    /// The segment that holds `arc_length`, and how far along it [m].
    #[inline]
    fn place_at(&self, arc_length: f64, hint: usize) -> (usize, f64) {
        if let Some(stretch) = &self.stretch {
            if arc_length >= stretch.end {
                let beyond = arc_length - stretch.end;
                return (
                    stretch.last,
                    self.path.segment_length(stretch.last) + beyond,
                );
            }
            if arc_length < stretch.start {
                return (stretch.first, arc_length - stretch.start);
            }
        }
        let arc_length = on_path(self.path, arc_length);
        let segment = self.path.segment_by_arc(arc_length, hint);
        (segment, arc_length - self.path.arc(segment))
    }

    /// The point at `arc_length`, and the segment that holds it.
    #[inline]
    fn point_at(&self, arc_length: f64, hint: usize) -> (Point, usize) {
        let (segment, along) = self.place_at(arc_length, hint);
        let (start, end) = self.path.segment(segment);
        let fraction = along / get_distance(start, end);
        let point = Point::new(
            start.x + fraction * (end.x - start.x),
            start.y + fraction * (end.y - start.y),
        );
        (point, segment)
    }
}

impl Stretch {
    /// The stretch about `segment`, searched for between two arc lengths, at most once around.
    fn about(path: &PathView<'_>, segment: usize, nearest: f64, farthest: f64) -> Self {
        let mut stretch = Self {
            first: segment,
            start: f64::NEG_INFINITY,
            last: segment,
            end: f64::INFINITY,
        };
        let mut start = path.arc(segment);
        let mut end = start + path.segment_length(segment);
        for _ in 0..path.segments() {
            if start < nearest {
                break;
            }
            let Some(before) = path.preceding(stretch.first) else {
                stretch.start = start;
                break;
            };
            stretch.first = before;
            start -= path.segment_length(before);
        }
        for _ in 0..path.segments() {
            if end > farthest {
                break;
            }
            let Some(next) = path.following(stretch.last) else {
                stretch.end = end;
                break;
            };
            stretch.last = next;
            end += path.segment_length(next);
        }
        stretch
    }
}

/// The angle at which the wheels of a `vehicle` at rest lead along `path` [rad], from `arc` [m] on
/// segment `segment`; that of the vehicle as one that drives forward.
///
/// The path's curvature is taken over two chords of a quarter of the wheelbase just ahead, or the last
/// two before a cusp or the end.
pub fn wheel_at_rest(vehicle: &Vehicle, path: &PathView<'_>, segment: usize, arc: f64) -> f64 {
    let length = 0.25 * vehicle.wheelbase;
    let mut preview = Preview::new(path, length, segment, arc - length, 3.0 * length);
    let (first, last) = match &preview.stretch {
        Some(stretch) => (stretch.start, stretch.end),
        None if path.is_closed() => (f64::NEG_INFINITY, f64::INFINITY),
        None => (0.0, path.length()),
    };
    let start = larger(smaller(arc, last - 2.0 * length), first) + 0.5 * length;
    let mut turn = [0.0];
    preview.turns(start, length, &mut turn);
    let [turn] = turn;
    vehicle.at_wheels(atan(turn / length * vehicle.turning_length(0.0)))
}

/// The angle from one direction to another [rad], in [-pi, pi].
///
/// Up to 7 degrees by the series of the arc tangent, 2e-15 rad off at most, which costs an eighth
/// of `atan2`.
#[inline]
fn angle_between(from: (f64, f64), to: (f64, f64)) -> f64 {
    let cross = from.0 * to.1 - from.1 * to.0;
    let dot = from.0 * to.0 + from.1 * to.1;
    if cross.abs() < 0.125 * dot {
        let t = cross / dot;
        let s = t * t;
        let tail = 1.0 / 7.0 - s * (1.0 / 9.0 - s * (1.0 / 11.0 - s * (1.0 / 13.0)));
        t - t * s * (1.0 / 3.0 - s * (0.2 - s * tail))
    } else {
        atan2(cross, dot)
    }
}

/// `arc_length` wrapped on a closed path; unchanged on an open one.
#[inline]
fn on_path(path: &PathView<'_>, arc_length: f64) -> f64 {
    if !path.is_closed() {
        return arc_length;
    }
    let rest = remainder(arc_length, path.length());
    if rest < 0.0 {
        rest + path.length()
    } else {
        rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Path;
    use crate::math::{PI, cos, sin};
    use alloc::vec::Vec;
    use proptest::prelude::*;

    fn circle(radius: f64, count: u32) -> Path {
        let angle = |k: u32| f64::from(k) * 2.0 * PI / f64::from(count);
        let (x, y): (Vec<_>, Vec<_>) = (0..count)
            .map(|k| (radius * cos(angle(k)), radius * sin(angle(k))))
            .unzip();
        Path::new(&x, &y, None, true).unwrap()
    }

    #[test]
    fn test_preview_on_a_circle_turns_evenly_fine_and_coarse() {
        for count in [2000, 200, 20] {
            let path = circle(20.0, count);
            let view = path.view();
            let mut turns = [0.0; 40];
            let mut preview = Preview::new(&view, 2.0, 3, 110.0, 20.0);
            preview.turns(110.0, 0.5, &mut turns); // across the seam
            let wanted = 0.5 * 2.0 * PI / view.length();
            for turn in turns {
                assert!((turn - wanted).abs() < 0.2 * wanted, "{count}: {turn}");
            }
        }
    }

    #[test]
    fn test_preview_beyond_the_ends_goes_straight_on() {
        let path = Path::new(&[0.0, 10.0, 10.0], &[0.0, 0.0, 10.0], None, false).unwrap();
        let view = path.view();
        let mut preview = Preview::new(&view, 2.0, 0, -50.0, 120.0);
        assert_eq!(preview.path_yaw(-50.0), 0.0);
        assert!((preview.path_yaw(70.0) - 0.5 * PI).abs() < 1e-15);
        assert!((preview.path_yaw(10.0) - 0.25 * PI).abs() < 1e-12);
    }

    #[test]
    fn test_direction_of_one_place_looks_one_base_far_and_a_plan_farther() {
        let path = Path::new(&[0.0, 100.0, 100.0], &[0.0, 0.0, 100.0], None, false).unwrap();
        let view = path.view();
        assert_eq!(Preview::yaw_at(&view, 2.0, 0, 97.9), 0.0);
        assert!(Preview::yaw_at(&view, 2.0, 0, 98.1) > 0.0);
        assert!(Preview::new(&view, 2.0, 0, 91.0, 10.0).path_yaw(91.0) > 0.0);
    }

    #[test]
    fn test_preview_of_a_path_that_doubles_back_takes_the_segment() {
        let path = Path::new(&[0.0, 10.0, 0.0], &[0.0, 0.0, 0.0], None, false).unwrap();
        let view = path.view();
        let mut preview = Preview::new(&view, 2.0, 0, 9.9, 1.0);
        assert_eq!(preview.path_yaw(9.9), 0.0);
        assert_eq!(preview.path_yaw(10.1), PI);
    }

    #[test]
    fn test_preview_goes_straight_on_where_the_vehicle_turns_round() {
        let (x, y) = ([0.0, 10.0, 20.0, 20.0, 20.0], [0.0, 0.0, 0.0, 10.0, 0.0]);
        let path = Path::new(&x, &y, None, false).unwrap();
        let path = path
            .with_reverse(&[false, false, true, false, false])
            .unwrap();
        let view = path.view();
        let mut forward = Preview::new(&view, 2.0, 0, 0.0, 60.0);
        assert_eq!(
            [0.0, 19.9, 20.0, 40.0].map(|s| forward.path_yaw(s)),
            [0.0; 4]
        );
        let mut back = Preview::new(&view, 2.0, 2, 20.0, 60.0);
        assert_eq!(
            [10.0, 20.0, 29.9, 40.0].map(|s| back.path_yaw(s)),
            [0.5 * PI; 4]
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

        #[test]
        fn test_angle_between_two_directions_is_the_difference_of_their_angles(
            yaw in -3.1..3.1_f64,
            angle in prop_oneof![-3.1..3.1_f64, -0.13..0.13_f64],
            (a, b) in (1e-6..1e6_f64, 1e-6..1e6_f64),
        ) {
            let (from, to) = (yaw, yaw + angle);
            let found = angle_between((a * cos(from), a * sin(from)), (b * cos(to), b * sin(to)));
            prop_assert!((found - angle).abs() < 4e-15, "{found} {angle}");
        }

        #[test]
        fn test_segment_near_any_other_is_that_by_definition(
            arc_length in prop_oneof![-30.0..160.0, (0_u8..140).prop_map(f64::from)],
            near in 0_usize..120,
            closed: bool,
        ) {
            let x: Vec<f64> = (0..100).map(|k: u32| f64::from(k) + 0.3 * sin(f64::from(k))).collect();
            let y: Vec<f64> = (0..100).map(|k: u32| 5.0 * sin(f64::from(k) / 9.0)).collect();
            let path = Path::new(&x, &y, None, closed).unwrap();
            let view = path.view();
            let plain = view.s().iter().rposition(|&s| s <= arc_length).unwrap_or(0);
            let plain = plain.min(view.segments() - 1);
            prop_assert_eq!(view.segment_by_arc(arc_length, near), plain);
        }
    }
}
