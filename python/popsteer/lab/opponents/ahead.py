"""The curve through the waypoints: one reference for error, heading and curvature ahead.

A polygon's heading jumps at each waypoint. A controller that is told an error against the segment
and plans along a reference without jumps sees a sawtooth that is not there. So the path is given
tangents, and `Path` makes the curve of them: its errors and its headings are those of one line.
"""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

from popsteer._core import Path, _path_cusps, _path_headings

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from popsteer._core import Projection, Vehicle

    Floats = NDArray[np.float64]

# Length of path over which the direction of dense waypoints is taken, in wheelbases: as preview
# POP's `smoothing_length` has it by default, so that neither sees more of their noise.
SMOOTHING = 2.0 / 3.0


class Ahead:
    """A path with tangents; its own where it has some.

    The tangent at a waypoint is that of the circle through it and two others: its neighbours, or,
    where waypoints are dense, the nearest that are half of the smoothing length away.
    """

    def __init__(self, path: Path, vehicle: Vehicle) -> None:
        self._base = SMOOTHING * vehicle.wheelbase
        self.path = path if path.yaw is not None else _with_tangents(path, 0.5 * self._base)
        self._yaw = np.asarray(self.path.yaw)
        xy = np.column_stack((path.x, path.y))
        self._xy = np.vstack((xy, xy[:1])) if path.closed else xy
        self._s = np.append(path.s, path.length) if path.closed else np.asarray(path.s)

    def headings(self, segment: int, arc: float, distances: Floats) -> Floats:
        """Give the curve's headings [rad] at distances ahead of an arc length [m]: continuous.

        As preview POP knows them: past a cusp the path goes straight on, past the end it bends on.
        """
        return _path_headings(self.path, self._base, segment, arc, distances)

    def cross_track(self, at: Projection) -> float:
        """Give the cross-track error from the curve [m] of what is projected onto the segment."""
        within = min(max(at.fraction, 0.0), 1.0)
        return at.cross_track_error - self._aside(at.segment, within)

    def place(self, arc: float) -> tuple[float, float]:
        """Give the curve's point [m] at an arc length of the path."""
        arc = arc % self.path.length if self.path.closed else arc
        last = len(self._s) - 2
        k = min(max(int(np.searchsorted(self._s, arc, side="right")) - 1, 0), last)
        start, along = self._xy[k], self._xy[k + 1] - self._xy[k]
        length = float(self._s[k + 1] - self._s[k])
        t = min(max((arc - float(self._s[k])) / length, 0.0), 1.0)
        left = self._aside(k, t) / length
        return (
            float(start[0] + t * along[0] - left * along[1]),
            float(start[1] + t * along[1] + left * along[0]),
        )

    def _aside(self, segment: int, share: float) -> float:
        """Give how far the curve lies left of a segment [m]: the parabola that turns as far."""
        turn = float(self._yaw[(segment + 1) % len(self._yaw)] - self._yaw[segment])
        length = float(self._s[segment + 1] - self._s[segment])
        return -0.5 * length * math.remainder(turn, math.tau) * share * (1.0 - share)

    def turning(self, segment: int, *, reverse: bool) -> int:
        """Find the first segment from the last one on that is driven so; itself where none is."""
        count = len(self._s) - 1
        if self.reverse(segment) == reverse:
            return segment
        rest = range(segment + 1, segment + count if self.path.closed else count)
        return next((k % count for k in rest if self.reverse(k % count) == reverse), segment)

    def reverse(self, segment: int) -> bool:
        """Whether a segment is driven backwards."""
        return self.path.reverse is not None and bool(self.path.reverse[segment])


def _with_tangents(path: Path, reach: float) -> Path:
    """Give a path the vehicle's headings along the curve through its waypoints."""
    xy, s = np.column_stack((path.x, path.y)), np.asarray(path.s)
    count, cusps = len(xy), np.flatnonzero(_path_cusps(path))
    sines = np.zeros((count, 2))
    backwards = np.zeros(count, bool) if path.reverse is None else np.asarray(path.reverse)
    if path.closed and not len(cusps):
        # Once around, with as much before and behind as the chords reach.
        more = min(count, 1 + max(_within(s, reach), _within(path.length - s[::-1], reach)))
        at = np.arange(-more, count + more)
        arcs = s[at % count] + path.length * (at // count)
        yaw = _tangents(xy[at % count], arcs, reach)[more : more + count]
    else:
        ends = np.append(cusps, cusps[:1] + count) if path.closed else [0, *cusps, count - 1]
        for first, last in itertools.pairwise(ends):
            at = np.arange(first, last + 1)
            arcs = s[at % count] + path.length * (at // count)
            yaw = _tangents(xy[at % count], arcs, reach) + math.pi * backwards[first % count]
            # At a cusp the vehicle's heading is the mean of those that it comes and goes with.
            sines[at % count] += np.column_stack((np.cos(yaw), np.sin(yaw)))
        yaw = np.arctan2(sines[:, 1], sines[:, 0])
    return Path(
        xy, speed=path.speed, closed=path.closed, reverse=path.reverse, grade=path.grade, yaw=yaw
    )


def _within(s: Floats, reach: float) -> int:
    return int(np.searchsorted(s, s[0] + reach))


def _tangents(xy: Floats, s: Floats, reach: float) -> Floats:
    """Give the direction at each waypoint of a stretch [rad], continuous.

    With chords of length a from behind and b ahead, which differ by a turn of φ, that of the circle
    through the three is the first one's and φ a / (a + b); at an end it is that of the last circle.
    """
    count = len(xy)
    at = np.arange(count)
    behind = np.minimum(np.searchsorted(s, s - reach, side="right") - 1, at - 1).clip(0)
    ahead = np.maximum(np.searchsorted(s, s + reach), at + 1).clip(None, count - 1)
    back, on = xy - xy[behind], xy[ahead] - xy
    first, last = at == behind, at == ahead
    inner = np.flatnonzero(~(first | last))
    if not len(inner):  # shorter than the chords: the circle through the ends and the middle
        inner, behind, ahead = at[1:-1], np.zeros(count, int), np.full(count, count - 1)
        back, on = xy - xy[0], xy[-1] - xy
    a, b = np.hypot(*back.T), np.hypot(*on.T)
    cross, dot = back[:, 0] * on[:, 1] - back[:, 1] * on[:, 0], (back * on).sum(axis=1)
    turn = np.arctan2(cross, dot)
    yaw = np.empty(count)
    if not len(inner):
        yaw[:] = math.atan2(*(xy[-1] - xy[0])[::-1])
        return yaw
    low, high = inner[0], inner[-1]
    yaw[inner] = np.arctan2(back[inner, 1], back[inner, 0])
    yaw[inner] += turn[inner] * a[inner] / (a[inner] + b[inner])
    for outer, centre in ((at[:low], low), (at[high + 1 :], high)):
        bend = 2.0 * turn[centre] / (a[centre] + b[centre])
        yaw[outer] = yaw[centre] + bend * (s[outer] - s[centre])
    return np.unwrap(yaw)
