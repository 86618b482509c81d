"""The smoothed direction of the path at distances along it."""

from __future__ import annotations

from dataclasses import dataclass
from math import fmod, inf
from typing import TYPE_CHECKING

from popsteer.reference.geometry import Point, get_distance, squared_distance
from popsteer.reference.math import atan, atan2, cos, saturate, sin

if TYPE_CHECKING:
    from popsteer.reference.path.view import PathView
    from popsteer.reference.vehicle import Vehicle


@dataclass(frozen=True)
class Stretch:
    """What is driven without a change of direction."""

    first: int  # the segment at whose start it begins
    start: float  # arc length there [m]; -inf where a closed path has no cusp
    last: int  # the segment at whose end it ends
    end: float  # arc length there [m]; inf where a closed path has no cusp

    @classmethod
    def about(cls, path: PathView, segment: int) -> Stretch:
        """Return that about `segment`."""
        first, last = path.section(segment)
        if path.following(last) is not None:
            return cls(segment, -inf, segment, inf)
        before = path.length if first > segment else 0.0
        after = path.length if last < segment else 0.0
        return cls(first, path.s[first] - before, last, path.segment_end(last) + after)


@dataclass(frozen=True)
class EndBend:
    """The bend in which an open path ends, and which is taken to go on from there.

    Its curvature is that between the last three chords of one length: the smaller of both turns
    over that length, or none where they are to different sides, as noise is.
    """

    end: float  # arc length of the end [m]
    point: Point
    yaw: float  # direction of the path there [rad]
    curvature: float  # to the left [1/m]
    length: float  # how far it goes on [m], straight from there on

    def point_at(self, arc_length: float) -> Point:
        """Return the point at `arc_length`: on the arc, then straight on."""
        beyond = arc_length - self.end
        along = min(beyond, self.length)
        half = 0.5 * self.curvature * along
        chord = along * (sin(half) / half if abs(half) > 1e-9 else 1.0)
        towards, on = self.yaw + half, self.yaw + 2.0 * half
        rest = beyond - along
        return (
            self.point[0] + chord * cos(towards) + rest * cos(on),
            self.point[1] + chord * sin(towards) + rest * sin(on),
        )


class Preview:
    """The direction of a path, smoothed over `base` [m] of it.

    The direction at an arc length is that of the chord from half a base behind to half a base
    ahead: on a bend it is the tangent, where the direction of the segments would jump. Where
    segments are longer than half a base, the chord reaches one segment's length either way instead,
    up to five bases, so coarse waypoints turn as evenly as fine ones, but not past the next segment
    where that is shorter. Where the path doubles back within the chord, the direction is that of
    the segment. Before an open path's start and where the vehicle turns round to go on the other
    way, it goes straight on, and so it does beyond its end, but for a bend there, which goes on for
    a chord's reach; a closed path wraps.

    What is looked at begins at `arc_length` [m], on `segment`, and goes on for `distance` [m] at
    most; `reach` [m] is the farthest that a chord reaches either way, five bases by default.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> preview = Preview(Path([(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)]), 2.0, 0, 0.0, 30.0)
    >>> [round(preview.path_yaw(s), 4) for s in (-5.0, 10.0, 25.0)]
    [0.0, 0.7854, 1.5708]
    >>> yaw, turns = preview.turns(0.0, 10.0, 2)
    >>> yaw, [round(turn, 4) for turn in turns]
    (0.0, [0.7854, 0.7854])
    """

    def __init__(
        self,
        path: PathView,
        base: float,
        segment: int,
        arc_length: float,
        distance: float,
        reach: float | None = None,
    ) -> None:
        self.path = path
        self.base = base
        is_of_one_place = reach is not None
        self.reach = reach = 5.0 * base if reach is None else reach
        self.stretch: Stretch | None = None
        if path.reverse is not None:
            self.stretch = Stretch.about(path, segment)
        self.bend: EndBend | None = None
        if self.stretch is None:
            end = path.length
        else:
            end = self.stretch.end if self.stretch.last + 1 == path.segments else inf
        if arc_length + distance + reach > end and not path.closed and not is_of_one_place:
            self.bend = self._bend_at(end)

    @classmethod
    def yaw_at(cls, path: PathView, base: float, segment: int, arc_length: float) -> float:
        """Return the direction of `path` [rad] at one place, `arc_length` on segment `segment`.

        The chord reaches at most one base on each side. A longer one makes a vehicle that steers by
        this direction alone cut the corners of coarse waypoints; a plan over several places does
        not.
        """
        return cls(path, base, segment, arc_length, 0.0, base).path_yaw(arc_length)

    def _bend_at(self, end: float) -> EndBend | None:
        """Return the bend in which the path ends at `end` [m]; None where it is straight."""
        last, _ = self._place_at(end)
        segment = min(self.path.segment_length(last), self.reach)
        length = max(segment, self.reach / 3.0)
        start = end - 3.0 * length
        if start < (0.0 if self.stretch is None else self.stretch.start):
            return None
        a, b = self._point_at(start), self._point_at(end - 2.0 * length)
        c, point = self._point_at(end - length), self._point_at(end)
        middle, (x, y) = (c[0] - b[0], c[1] - b[1]), (point[0] - c[0], point[1] - c[1])
        before = _angle_between((b[0] - a[0], b[1] - a[1]), middle)
        turn = _angle_between(middle, (x, y))
        if before * turn <= 0.0:
            return None
        turn = before if abs(before) < abs(turn) else turn
        yaw = atan2(y, x) + 0.5 * turn
        return EndBend(end, point, yaw, turn / length, self.reach)

    def path_yaw(self, arc_length: float) -> float:
        """Return the direction of the path at `arc_length` [rad]."""
        x, y = self._chord(arc_length)
        return atan2(y, x)

    def _chord(self, arc_length: float) -> Point:
        """Return the chord about `arc_length`, as far as it goes in x and in y [m]."""
        path, base = self.path, self.base
        here, along = self._place_at(arc_length)
        reach = saturate(self._spacing(here, along), 0.5 * base, self.reach)
        if path.closed and reach > 0.25 * path.length:
            reach = 0.25 * path.length
        tail = self._point_at(arc_length - reach)
        head = self._point_at(arc_length + reach)
        if squared_distance(tail, head) > reach * reach:
            return head[0] - tail[0], head[1] - tail[1]
        start, end = path.segment(here)
        return end[0] - start[0], end[1] - start[1]

    def _spacing(self, segment: int, along: float) -> float:
        """Return how far apart the waypoints are about a place `along` [m] a segment.

        That is its length, or less where a shorter one is near, so that no chord from a long
        straight segment cuts off a bend of short ones.
        """
        path = self.path
        length = path.segment_length(segment)
        if length <= self.base:
            return length  # What it cuts off is no longer than what is smoothed.
        before, after = path.preceding(segment), path.following(segment)
        behind = along + (inf if before is None else path.segment_length(before))
        ahead = length - along + (inf if after is None else path.segment_length(after))
        return min(length, behind, ahead)

    def turns(self, arc_length: float, step: float, count: int) -> tuple[float, list[float]]:
        """Return the direction at `arc_length`, and how far it turns over each step on [rad]."""
        x, y = here = self._chord(arc_length)
        travelled = 0.0
        turns = []
        for _ in range(count):
            travelled += step
            following = self._chord(arc_length + travelled)
            turns.append(_angle_between(here, following))
            here = following
        return atan2(y, x), turns

    def _place_at(self, arc_length: float) -> tuple[int, float]:
        """Find the segment that holds `arc_length`, and how far along it [m]."""
        path, stretch = self.path, self.stretch
        if stretch is not None:
            if arc_length >= stretch.end:
                beyond = arc_length - stretch.end
                return stretch.last, path.segment_length(stretch.last) + beyond
            if arc_length < stretch.start:
                return stretch.first, arc_length - stretch.start
        arc_length = _on_path(path, arc_length)
        segment = path.segment_by_arc(arc_length)
        return segment, arc_length - path.s[segment]

    def _point_at(self, arc_length: float) -> Point:
        """Find the point at `arc_length`."""
        segment, along = self._place_at(arc_length)
        if self.bend is not None and arc_length > self.bend.end:
            return self.bend.point_at(arc_length)
        start, end = self.path.segment(segment)
        fraction = along / get_distance(start, end)
        return start[0] + fraction * (end[0] - start[0]), start[1] + fraction * (end[1] - start[1])


def wheel_at_rest(vehicle: Vehicle, path: PathView, segment: int, arc: float) -> float:
    """Return the angle at which the wheels of a vehicle at rest lead along `path` [rad].

    From `arc` [m] on `segment` on, for a vehicle that drives forward. The curvature is taken over
    two chords of a quarter of the wheelbase just ahead, or the last two before a cusp or the end.
    """
    length = 0.25 * vehicle.wheelbase
    # However far past the end: the last two chords are those before it.
    arc = min(arc, path.s[segment] + path.segment_length(segment))
    preview = Preview(path, length, segment, arc - 2.0 * length, 4.0 * length)
    stretch = preview.stretch
    if stretch is not None:
        first, last = stretch.start, stretch.end
    else:
        first, last = (-inf, inf) if path.closed else (0.0, path.length)
    start = max(min(arc, last - 2.0 * length), first) + 0.5 * length
    _, (turn,) = preview.turns(start, length, 1)
    return vehicle.at_wheels(atan(turn / length * vehicle.turning_length(0.0)))


def _angle_between(before: Point, after: Point) -> float:
    """Return the angle from one direction to another [rad], in [-π, π].

    Up to 7 degrees by the series of the arc tangent, 2e-15 rad off at most.
    """
    cross = before[0] * after[1] - before[1] * after[0]
    dot = before[0] * after[0] + before[1] * after[1]
    if not abs(cross) < 0.125 * dot:
        return atan2(cross, dot)
    t = cross / dot
    s = t * t
    tail = 1.0 / 7.0 - s * (1.0 / 9.0 - s * (1.0 / 11.0 - s * (1.0 / 13.0)))
    return t - t * s * (1.0 / 3.0 - s * (0.2 - s * tail))


def _on_path(path: PathView, arc_length: float) -> float:
    """Bring `arc_length` onto a closed path; unchanged on an open one."""
    if not path.closed:
        return arc_length
    rest = fmod(arc_length, path.length)
    return rest + path.length if rest < 0.0 else rest
