"""What an opponent sees: of its vehicle, by popsteer's own prediction and estimates; of the path.

A polygon's heading jumps at each waypoint. A controller that is told an error against the segment
and plans along a reference without jumps sees a sawtooth that is not there. So the path is given
tangents, and `Path` makes the curve of them: its errors and its headings are those of one line.
"""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from popsteer._core import Path, PreviewPop, Projection, Vehicle, _path_cusps, _path_headings

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
        (x, y), (ahead, aside) = start.tolist(), along.tolist()
        return x + t * ahead - left * aside, y + t * aside + left * ahead

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
    given: Any = {each: getattr(path, each) for each in ("speed", "closed", "reverse", "grade")}
    return Path(xy, **given, yaw=yaw)


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


# Below this speed, in wheelbases a second, laws are computed for this one.
_LEAST_SPEED = 1.0 / 3.0


class Seen(NamedTuple):
    """The no-slip point when the next command reaches the wheels, of a vehicle that drives forward.

    Where the path is driven backwards, it is the vehicle mirrored about that point.
    """

    error: float
    """Cross-track error [m], positive left of the path."""
    heading: float
    """Direction of its motion less that of the path [rad]; of the mirrored vehicle, too."""
    speed: float
    """Speed [m/s]; positive."""
    wheel: float
    """Angle of the wheels, offset and all [rad]."""
    length: float
    """Speed over turning rate, for small angles of the wheels [m]: wheelbase and understeer."""
    slope: float
    """How much the motion turns from the heading with the curvature [m]."""
    arc: float
    """Arc length of the path there [m]."""
    segment: int
    """Segment of the path there."""
    dt: float
    """Control period [s]."""
    left: float
    """Path that is left to the next cusp or to the end [m]; ``inf`` on a lap."""


class Observer:
    """Looks through a `PreviewPop` that is given the opponent's commands as those that are applied.

    From it come the vehicle's prediction through the dead time, the direction of travel and the
    estimates: steering offset, gain, dead time, slip.
    """

    def __init__(self, path: Path, vehicle: Vehicle) -> None:
        self.vehicle = vehicle
        self._ahead = Ahead(path, vehicle)
        self.eye = PreviewPop(self._ahead.path, vehicle)
        point = vehicle.no_slip_point
        self._point = vehicle.rear_axle if point is None else point
        self._segment = -1
        self.steer, self.wheel, self.reverse = 0.0, 0.0, False

    def set_path(self, path: Path) -> None:
        """Follow another path from the next step on, from the place where the vehicle is."""
        self._ahead, self._segment = Ahead(path, self.vehicle), -1
        self.eye.set_path(self._ahead.path)

    def see(self, x: float, y: float, yaw: float, speed: float, dt: float) -> Seen:
        """Take a pose [m, m, rad], a speed [m/s] and the time since the last one [s]."""
        command = self.eye.step(x, y, yaw, speed, dt, applied_steer=self.steer)
        estimate, car, path = self.eye.estimate, self.vehicle, self._ahead.path
        speed *= estimate.speed_scale
        self._move_wheels(dt)
        if self._segment < 0:
            state = self.eye.state
            self._segment = state.waypoint if (at := state.measured_waypoint) is None else at
        if command.reverse is not self.reverse:
            self.reverse = command.reverse
            self._segment = self._ahead.turning(self._segment, reverse=self.reverse)
        x, y = x + self._point * math.cos(yaw), y + self._point * math.sin(yaw)
        reach = 2.0 * car.wheelbase + abs(speed) * dt
        found = path.locate(x, y, yaw, self._segment, reach)
        self._segment = found.segment
        speed = max(abs(speed), _LEAST_SPEED * car.wheelbase)
        side = -1.0 if self.reverse else 1.0
        return Seen(
            command.predicted_cross_track_error,
            command.predicted_heading_error + estimate.slip,
            speed,
            side * (self.wheel + estimate.steer_offset),
            car.turning_length(speed) / estimate.gain,
            side * estimate.slip_length,
            found.arc_length + speed * estimate.dead_time,
            found.segment,
            dt,
            command.distance_to_stop,
        )

    def curvature(self, seen: Seen, distances: NDArray[np.float64]) -> NDArray[np.float64]:
        """Give the path's mean curvatures [1/m] between distances ahead [m]."""
        headings = self._ahead.headings(seen.segment, seen.arc, distances)
        return np.diff(headings) / np.diff(distances)

    def bend(self, seen: Seen, ahead: float) -> float:
        """Give the curve's curvature so far ahead [1/m], over a tenth of the wheelbase."""
        ends = np.array([ahead, ahead + 0.1 * self.vehicle.wheelbase])
        return float(self.curvature(seen, ends)[0])

    def towards(self, seen: Seen, distance: float) -> tuple[float, float]:
        """Give distance and bearing [m, rad], from the vehicle, of the path's point so far ahead.

        Past the next cusp, or the end, the path is taken to go straight on.
        """
        within = min(distance, max(seen.left, 0.0))
        ends = np.array([0.0, within])
        yaw, far = self._ahead.headings(seen.segment, seen.arc, ends).tolist()
        (x, y), (to_x, to_y) = self._ahead.place(seen.arc), self._ahead.place(seen.arc + within)
        x, y = x - seen.error * math.sin(yaw), y + seen.error * math.cos(yaw)
        to_x += (distance - within) * math.cos(far)
        to_y += (distance - within) * math.sin(far)
        bearing = math.atan2(to_y - y, to_x - x) - yaw - seen.heading
        return math.hypot(to_x - x, to_y - y), math.remainder(bearing, math.tau)

    def commanded(self, wheel: float, seen: Seen) -> float:
        """Give the command that turns the wheels there [rad], within what the vehicle can do."""
        car = self.vehicle
        if car.max_lateral_acceleration is not None:
            most = math.atan(car.max_lateral_acceleration * seen.length / seen.speed**2)
            wheel = min(max(wheel, -most), most)
        steer = (-wheel if self.reverse else wheel) - self.eye.estimate.steer_offset
        if car.max_steer_rate is not None:
            change = car.max_steer_rate * seen.dt
            steer = min(max(steer, self.steer - change), self.steer + change)
        self.steer = min(max(steer, -car.max_steer), car.max_steer)
        return self.steer

    def _move_wheels(self, dt: float) -> None:
        """Move the wheels as their lag and their rate have it, to when the next command arrives."""
        car = self.vehicle
        share = 1.0 - math.exp(-dt / car.steer_lag) if car.steer_lag > 0.0 else 1.0
        turned = share * (self.steer - self.wheel)
        if car.max_steer_rate is not None:
            turned = min(max(turned, -car.max_steer_rate * dt), car.max_steer_rate * dt)
        self.wheel += turned


class Opponent:
    """What they have in common: a path, a vehicle, parameters, an observer."""

    def __init__(self, path: Path, vehicle: Vehicle, params: object) -> None:
        self.path, self.vehicle, self.params = path, vehicle, params
        self.reset()

    def reset(self) -> None:
        """Forget the steps taken so far."""
        self.observer = Observer(self.path, self.vehicle)
        self.tracked_point = self.observer.eye.tracked_point

    def set_path(self, path: Path) -> None:
        """Follow another path from the next step on."""
        self.path = path
        self.observer.set_path(path)

    def step(self, x: float, y: float, yaw: float, speed: float, dt: float, /) -> float:
        """Answer a pose [m, m, rad] and a speed [m/s] with the angle of the wheels [rad]."""
        seen = self.observer.see(x, y, yaw, speed, dt)
        return self.observer.commanded(self.wheels(seen), seen)

    def wheels(self, seen: Seen) -> float:
        """Give the angle that the wheels shall have [rad]; the law."""
        raise NotImplementedError
