//! The smoothed direction of the path at distances along it.

use super::view::PathView;
use crate::geometry::{Point, get_distance, squared_distance};
use crate::math::{atan, atan2, cos, larger, remainder, saturate, sin, smaller, wrap};
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
        if let Some(yaw) = self.given(arc_length) {
            return yaw;
        }
        let (x, y) = self.chord(arc_length);
        atan2(y, x)
    }

    /// The direction that the path's own headings have at `arc_length` [rad]; None without any.
    #[inline]
    fn given(&mut self, arc_length: f64) -> Option<f64> {
        self.path.yaw()?;
        let [_, here, _] = self.hints;
        let (here, along) = self.place_at(arc_length, here);
        self.hints = [here; 3];
        self.path.direction(here, along)
    }

    /// The chord about `arc_length`, as far as it goes in x and in y [m].
    #[inline]
    fn chord(&mut self, arc_length: f64) -> (f64, f64) {
        let [behind, before, ahead] = self.hints;
        let (here, _) = self.place_at(arc_length, before);
        // After a long step both ends are nearer to the middle than to the last ends.
        let is_far = here > before + 2;
        let (behind, ahead) = if is_far {
            (here, here)
        } else {
            (behind, ahead)
        };
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
    /// [rad], into `turns`. Returns its direction at the start, as the x and y [m] of a chord.
    #[inline]
    pub fn turns(&mut self, arc_length: f64, step: f64, turns: &mut [f64]) -> (f64, f64) {
        if let Some(first) = self.given(arc_length) {
            let (mut here, mut travelled) = (first, 0.0);
            for turn in turns {
                travelled += step;
                let next = self.given(arc_length + travelled).unwrap_or(here);
                *turn = wrap(next - here);
                here = next;
            }
            return (cos(first), sin(first));
        }
        let first = self.chord(arc_length);
        let mut here = first;
        let mut travelled = 0.0;
        for turn in turns {
            travelled += step;
            let next = self.chord(arc_length + travelled);
            *turn = angle_between(here, next);
            here = next;
        }
        first
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
mod tests;
