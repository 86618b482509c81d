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
/// up to five bases, so coarse waypoints turn as evenly as fine ones, but not past the next segment
/// where that is shorter. Where the path doubles back within the chord, the direction is that of the
/// segment. Before an open path's start and where the vehicle turns round to go on the other way, it
/// goes straight on, and so it does beyond its end, but for a [bend](EndBend) there, which goes on for
/// a chord's reach; a closed path wraps.
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
    bend: Option<EndBend>,
    /// The segments of the last places: behind, at, and ahead of the arc length asked for.
    hints: [usize; 3],
}

/// A stretch without a cusp: from the start of the first segment to the end of the last, with the
/// arc lengths [m] of both, which are infinite where a closed path has no cusp.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    first: usize,
    start: f64,
    last: usize,
    end: f64,
}

/// The bend in which an open path ends, and which is taken to go on from there, so that a vehicle does
/// not straighten its wheels before it stands.
///
/// Its curvature is that between the last three chords of one length: the smaller of both turns
/// over that length, or none where they are to different sides, as noise is.
#[derive(Clone, Copy, Debug)]
struct EndBend {
    /// Arc length of the end [m].
    end: f64,
    point: Point,
    /// Direction of the path there [rad].
    yaw: f64,
    /// To the left [1/m].
    curvature: f64,
    /// How far it goes on [m], straight from there on.
    length: f64,
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
        let reach = 5.0 * base;
        let mut preview = Self::reaching(path, base, reach, segment);
        let end = match &preview.stretch {
            Some(stretch) if stretch.last + 1 < path.segments() => f64::INFINITY,
            Some(stretch) => stretch.end,
            None => path.length(),
        };
        if arc_length + distance + reach > end && !path.is_closed() {
            preview.bend = preview.bend_at(end);
        }
        preview
    }

    /// The same with chords that reach at most so far [m] either way.
    #[inline]
    fn reaching(path: &'a PathView<'a>, base: f64, reach: f64, segment: usize) -> Self {
        let reverse = path.reverse();
        Self {
            path,
            base,
            reach,
            stretch: reverse.map(|_| Stretch::about(path, segment)),
            bend: None,
            hints: [segment; 3],
        }
    }

    /// The bend in which the path ends at the arc length `end` [m]; None where it is straight or
    /// shorter than the chords.
    fn bend_at(&self, end: f64) -> Option<EndBend> {
        let [_, _, hint] = self.hints;
        let (last, _) = self.place_at(end, hint);
        let segment = smaller(self.path.segment_length(last), self.reach);
        let length = larger(segment, self.reach / 3.0);
        let start = end - 3.0 * length;
        let first = self.stretch.map_or(0.0, |stretch| stretch.start);
        if start < first {
            return None;
        }
        let (a, _) = self.point_at(start, last);
        let (b, _) = self.point_at(end - 2.0 * length, last);
        let (c, _) = self.point_at(end - length, last);
        let (point, _) = self.point_at(end, last);
        let (middle, last) = (c - b, point - c);
        let before = angle_between(b - a, middle);
        let turn = angle_between(middle, last);
        if before * turn <= 0.0 {
            return None;
        }
        let turn = if before.abs() < turn.abs() {
            before
        } else {
            turn
        };
        Some(EndBend {
            end,
            point,
            yaw: atan2(last.y, last.x) + 0.5 * turn,
            curvature: turn / length,
            length: self.reach,
        })
    }

    /// The direction of `path` [rad], smoothed over `base` [m], at `arc_length` on segment
    /// `segment`: that of one place, where [`new`](Self::new) is for several.
    ///
    /// The chord reaches at most one base on each side. A longer one makes a vehicle that steers by
    /// this direction alone cut the corners of coarse waypoints; a plan over several places does
    /// not.
    #[inline]
    pub fn yaw_at(path: &'a PathView<'a>, base: f64, segment: usize, arc_length: f64) -> f64 {
        Self::reaching(path, base, base, segment).path_yaw(arc_length)
    }

    /// Direction of the path at `arc_length` [rad].
    #[inline]
    pub fn path_yaw(&mut self, arc_length: f64) -> f64 {
        if let Some(yaw) = self.given(arc_length) {
            return yaw;
        }
        let chord = self.chord(arc_length);
        atan2(chord.y, chord.x)
    }

    /// The direction that the path's own headings have at `arc_length` [rad]; None without any.
    #[inline]
    fn given(&mut self, arc_length: f64) -> Option<f64> {
        self.path.yaw()?;
        let [_, here, _] = self.hints;
        let (here, along) = self.place_at(arc_length, here);
        self.hints = [here; 3];
        let yaw = self.path.direction(here, along)?;
        Some(yaw + self.bend.map_or(0.0, |bend| bend.turn(arc_length)))
    }

    /// The chord about `arc_length`, from its tail to its head [m].
    #[inline]
    fn chord(&mut self, arc_length: f64) -> Point {
        let [behind, before, ahead] = self.hints;
        let (here, along) = self.place_at(arc_length, before);
        // After a long step both ends are nearer to the middle than to the last ends.
        let is_far = here > before + 2;
        let (behind, ahead) = if is_far {
            (here, here)
        } else {
            (behind, ahead)
        };
        let mut reach = saturate(self.spacing(here, along), 0.5 * self.base, self.reach);
        if self.path.is_closed() && reach > 0.25 * self.path.length() {
            reach = 0.25 * self.path.length();
        }
        let (tail, behind) = self.point_at(arc_length - reach, behind);
        let (head, ahead) = self.point_at(arc_length + reach, ahead);
        self.hints = [behind, here, ahead];
        if squared_distance(tail, head) > reach * reach {
            head - tail
        } else {
            let (start, end) = self.path.segment(here);
            end - start
        }
    }

    /// How far apart the waypoints are about a place `along` [m] a segment: its length, less where a
    /// shorter one is near, so that no chord from a long straight segment cuts off a bend of short ones.
    #[inline]
    fn spacing(&self, segment: usize, along: f64) -> f64 {
        let path = self.path;
        let length = path.segment_length(segment);
        if length <= self.base {
            return length; // What it cuts off is no longer than what is smoothed.
        }
        let beyond =
            |next: Option<usize>| next.map_or(f64::INFINITY, |next| path.segment_length(next));
        let behind = along + beyond(path.preceding(segment));
        let ahead = length - along + beyond(path.following(segment));
        smaller(length, smaller(behind, ahead))
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
        (first.x, first.y)
    }

    /// The segment that holds `arc_length`, and how far along it [m].
    #[inline]
    fn place_at(&self, arc_length: f64, hint: usize) -> (usize, f64) {
        if let Some(stretch) = &self.stretch {
            if arc_length >= stretch.end {
                let length = self.path.segment_length(stretch.last);
                return (stretch.last, length + (arc_length - stretch.end));
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
        if let Some(bend) = &self.bend
            && arc_length > bend.end
        {
            return (bend.point_at(arc_length), segment);
        }
        let (start, end) = self.path.segment(segment);
        let fraction = along / get_distance(start, end);
        (start + (end - start) * fraction, segment)
    }
}

impl EndBend {
    /// How far it turns from the end to `arc_length` [rad].
    fn turn(&self, arc_length: f64) -> f64 {
        self.curvature * saturate(arc_length - self.end, 0.0, self.length)
    }

    /// The point at `arc_length`: on the arc, then straight on.
    fn point_at(&self, arc_length: f64) -> Point {
        let beyond = arc_length - self.end;
        let along = smaller(beyond, self.length);
        let half = 0.5 * self.curvature * along;
        let sinc = if half.abs() > 1e-9 {
            sin(half) / half
        } else {
            1.0
        };
        let chord = along * sinc;
        let (towards, on) = (self.yaw + half, self.yaw + 2.0 * half);
        let rest = beyond - along;
        Point::new(
            self.point.x + chord * cos(towards) + rest * cos(on),
            self.point.y + chord * sin(towards) + rest * sin(on),
        )
    }
}

impl Stretch {
    /// The stretch about `segment`.
    fn about(path: &PathView<'_>, segment: usize) -> Self {
        let section = path.section(segment);
        let (first, last) = section.unwrap_or((segment, segment));
        let seam = if first > segment { path.length() } else { 0.0 };
        Self {
            first,
            start: section.map_or(f64::NEG_INFINITY, |_| path.arc(first) - seam),
            last,
            end: section.map_or(f64::INFINITY, |_| path.end_ahead(segment, last)),
        }
    }
}

/// The angle at which the wheels of a `vehicle` at rest lead along `path` [rad], from `arc` [m] on
/// segment `segment`; that of the vehicle as one that drives forward.
///
/// The path's curvature is taken over two chords of a quarter of the wheelbase just ahead, or the last
/// two before a cusp or the end.
pub fn wheel_at_rest(vehicle: &Vehicle, path: &PathView<'_>, segment: usize, arc: f64) -> f64 {
    let length = 0.25 * vehicle.wheelbase;
    // However far past the end: the last two chords are those before it.
    let arc = smaller(arc, path.arc(segment) + path.segment_length(segment));
    let mut preview = Preview::new(path, length, segment, arc - 2.0 * length, 4.0 * length);
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
fn angle_between(from: Point, to: Point) -> f64 {
    let (cross, dot) = (from.perp(&to), from.dot(&to));
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
