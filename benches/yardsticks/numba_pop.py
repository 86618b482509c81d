"""POP's step as the reference takes it, compiled by numba.

What a compiled language alone would give: the loops of `popsteer.reference` over arrays, with none
of the shortcuts of the Rust core. The place on the path is looked for on every segment of the
stretch around the last one, the candidates are tried one after the other. The reference makes lists
on its way, here the same numbers are taken in the same order as they come; without `fastmath` numba
neither reorders nor fuses, and takes sin and cos from the same libm as Python, so the angle is the
same to the last bit.

It takes POP's default reading, the exact lookahead, paths that are driven forward, and vehicles
whose commands go to the wheels as they are: no course of the benchmark is driven backwards, and its
vehicle has no dead time and no limit but that of the angle.
"""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, cast

import numba
import numpy as np

from benches.latency.timing import Drive, Driver
from popsteer.reference import PopParams, Vehicle
from popsteer.reference.geometry import squared_distance
from popsteer.reference.math import saturate

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    _Array: TypeAlias = NDArray[np.float64]
    # Abscissas, ordinates, arc lengths, whether it is closed, its length.
    _Path: TypeAlias = tuple[_Array, _Array, _Array, bool, float]
    _Point: TypeAlias = tuple[float, float]
    # Segment, the closest point itself, its squared distance, the segment from its start to its
    # end, and where on it the closest point lies.
    _ClosestPoint: TypeAlias = tuple[int, _Point, float, _Point, float]

_F = TypeVar("_F")
_EPSILON = 2.0**-52


def _jit(function: _F) -> _F:
    """Compile, with IEEE 754's division in place of Python's, which checks for zero each time."""
    return cast("_F", numba.njit(error_model="numpy")(function))


_squared_distance, _saturate = _jit(squared_distance), _jit(saturate)


def prepare(drive: Drive) -> Callable[[], Driver]:
    """Compile the step; give a maker of drivers for a drive.

    Vehicle, parameters and shape of the path become constants of the machine code. The step takes
    the state, the path's x, y and s, and what every step takes; numba turns no class into machine
    code, so they are arrays.
    """
    path, car = drive.path, Vehicle(**drive.vehicle.as_dict())
    if path.reverse is not None:
        raise ValueError("this step drives forward only, and the path is driven backwards in parts")
    limits = (car.max_steer_rate, car.max_lateral_acceleration)
    if car.dead_time > 0.0 or car.steer_offset != 0.0 or limits != (None, None):
        raise ValueError("this step gives POP's angle to the wheels as it is")
    params: Any = PopParams().resolved(car)
    columns = (np.array(path.x), np.array(path.y), np.array(path.s))
    closed, length = path.closed, path.length
    base, offset, opposite = car.rear_axle, car.front_axle, car.wheelbase * 10.0 / 3.0
    search, lost = params.search_distance, params.lost_distance
    min_lookahead, lookahead_gain = params.min_lookahead, params.lookahead_gain
    span, count, max_steer = params.steer_span, params.candidate_count, car.max_steer

    @_jit
    def step(
        state: _Array,
        columns: tuple[_Array, _Array, _Array],
        x: float,
        y: float,
        yaw: float,
        speed: float,
        dt: float,
    ) -> float:
        # The bounds that every step of popsteer checks; a NaN is within none.
        inside = abs(x) <= 1e9 and abs(y) <= 1e9 and abs(yaw) <= 1e6 and abs(speed) <= 1e4
        if not (inside and 1e-6 <= dt <= 1e3):
            raise ValueError("the input is out of its bounds")
        path = (columns[0], columns[1], columns[2], closed, length)
        heading = (math.cos(yaw), math.sin(yaw))
        position = (x + offset * heading[0], y + offset * heading[1])
        axle = (x + base * heading[0], y + base * heading[1])
        start = int(state[0])
        if start < 0:
            start = _relocalise(path, axle, heading, opposite)
        # Since the last step it may have driven faster than now.
        reach = search + max(abs(speed), state[2]) * dt
        closest = _locate(path, start, position, heading, reach, opposite)
        if closest[2] > lost * lost:
            start = _relocalise(path, axle, heading, opposite)
            anew = _locate(path, start, position, heading, reach, opposite)
            if anew[2] < closest[2]:
                closest = anew
        forward = max(speed, 0.0)
        target = _cross(path, closest, position, min_lookahead + lookahead_gain * forward)
        seen = (target[0] - position[0], target[1] - position[1])
        steer = _choose(seen, yaw, forward, state[1], dt, (span, count, max_steer))
        state[0], state[1], state[2] = closest[0], steer, abs(speed)
        return steer

    def make() -> Driver:
        begun = np.array([-1.0, 0.0, 0.0])  # last segment, -1 for none yet; last angle; speed
        state = begun.copy()
        return Driver(partial(step, state, columns), partial(np.copyto, state, begun))

    make().call(*drive.states[0], 0.05)  # numba compiles at the first call
    return make


@_jit
def _relocalise(path: _Path, position: _Point, heading: _Point, opposite: float) -> int:
    """Find the segment of least distance and heading error of all."""
    best, least = 0, math.inf
    for segment in range(_segments(path)):
        cost = _cost(_closest_point_between(path, segment, position, 0.0, 1.0), heading, opposite)
        if cost < least:
            best, least = segment, cost
    return best


@_jit
def _locate(
    path: _Path, start: int, position: _Point, heading: _Point, reach: float, opposite: float
) -> _ClosestPoint:
    """Find the local minima of the distance around a segment, and return the one of least cost."""
    first, count = _stretch(path, start, reach)
    here = _closest_point(path, first, position)
    best, least, behind = here, math.inf, math.inf
    for k in range(count):
        following, ahead = here, math.inf
        if k + 1 < count:
            following = _closest_point(path, (first + k + 1) % len(path[0]), position)
            ahead = following[2]
        if behind >= here[2] and here[2] < ahead:
            cost = _least_cost(path, here, heading, opposite)
            if cost < least:
                best, least = here, cost
        behind, here = here[2], following
    return best


@_jit
def _stretch(path: _Path, segment: int, reach: float) -> tuple[int, int]:
    """Choose the first segment to look at, and how many."""
    first, last, count = segment, segment, 1
    behind, ahead = 0.0, 0.0
    while count < _segments(path) and behind <= reach and (path[3] or first > 0):
        first = (first - 1) % len(path[0])
        behind += _length(path, first)
        count += 1
    while count < _segments(path) and ahead <= reach and (path[3] or last + 1 < _segments(path)):
        last = (last + 1) % len(path[0])
        ahead += _length(path, last)
        count += 1
    return first, count


@_jit
def _closest_point(path: _Path, segment: int, position: _Point) -> _ClosestPoint:
    """Find the closest point of a segment; the ends of an open path go on as straight lines."""
    low = 0.0 if path[3] or segment > 0 else -math.inf
    high = 1.0 if path[3] or segment + 1 < _segments(path) else math.inf
    return _closest_point_between(path, segment, position, low, high)


@_jit
def _closest_point_between(
    path: _Path, segment: int, position: _Point, low: float, high: float
) -> _ClosestPoint:
    """Find the closest point between two fractions of a segment."""
    start, end = _waypoint(path, segment), _waypoint(path, segment + 1)
    along = (end[0] - start[0], end[1] - start[1])
    to = (position[0] - start[0], position[1] - start[1])
    squared_length = along[0] * along[0] + along[1] * along[1]
    fraction = _saturate((to[0] * along[0] + to[1] * along[1]) / squared_length, low, high)
    point = (start[0] + fraction * along[0], start[1] + fraction * along[1])
    return segment, point, _squared_distance(position, point), along, fraction


@_jit
def _cost(closest: _ClosestPoint, heading: _Point, opposite: float) -> float:
    """Measure the distance, and more the less the path leads along the heading."""
    _, _, squared_distance, along, _ = closest
    squared_length = along[0] * along[0] + along[1] * along[1]
    share = (heading[0] * along[0] + heading[1] * along[1]) / math.sqrt(squared_length)
    return math.sqrt(squared_distance) + 0.5 * opposite * (1.0 - share)


@_jit
def _least_cost(path: _Path, closest: _ClosestPoint, heading: _Point, opposite: float) -> float:
    """Take the same, or that by the path's heading over a length, where that is less."""
    by_segment = _cost(closest, heading, opposite)
    segment, _, squared_distance, along, fraction = closest
    squared_length = along[0] * along[0] + along[1] * along[1]
    arc_length = path[2][segment] + fraction * math.sqrt(squared_length)
    yaw = _yaw_over(path, 0.2 * opposite, arc_length)
    share = heading[0] * math.cos(yaw) + heading[1] * math.sin(yaw)
    smoothed = math.sqrt(squared_distance) + 0.5 * opposite * (1.0 - share)
    return min(by_segment, smoothed)


@_jit
def _yaw_over(path: _Path, base: float, arc_length: float) -> float:
    """Give the direction of the chord over a length of the path."""
    segment, _ = _point_at(path, arc_length)
    start, end = _waypoint(path, segment), _waypoint(path, segment + 1)
    reach = _saturate(math.sqrt(_squared_distance(start, end)), 0.5 * base, 5.0 * base)
    if path[3]:
        reach = min(reach, 0.25 * path[4])
    _, tail = _point_at(path, arc_length - reach)
    _, head = _point_at(path, arc_length + reach)
    if _squared_distance(tail, head) > reach * reach:
        start, end = tail, head
    return math.atan2(end[1] - start[1], end[0] - start[0])


@_jit
def _point_at(path: _Path, arc_length: float) -> tuple[int, _Point]:
    """Give the segment and the point at an arc length."""
    if path[3]:
        if abs(arc_length) >= path[4]:
            arc_length = np.fmod(arc_length, path[4])
        if arc_length < 0.0:
            arc_length += path[4]
    found = int(np.searchsorted(path[2], arc_length, side="right")) - 1
    segment: int = min(max(found, 0), _segments(path) - 1)
    start, end = _waypoint(path, segment), _waypoint(path, segment + 1)
    fraction = (arc_length - path[2][segment]) / math.sqrt(_squared_distance(start, end))
    point = (start[0] + fraction * (end[0] - start[0]), start[1] + fraction * (end[1] - start[1]))
    return segment, point


@_jit
def _cross(path: _Path, closest: _ClosestPoint, position: _Point, lookahead: float) -> _Point:
    """Find the first point from the closest point on that is the lookahead away."""
    squared_lookahead = lookahead * lookahead
    segment, start, squared_distance, _, fraction = closest
    if squared_distance >= squared_lookahead:
        return start
    left = 1.0 - fraction
    for _ in range(_segments(path)):
        end = _waypoint(path, segment + 1)
        ends = not path[3] and segment + 1 == _segments(path)
        if ends or _squared_distance(position, end) >= squared_lookahead:
            begin = _waypoint(path, segment)
            along = (end[0] - begin[0], end[1] - begin[1])
            to_start = (start[0] - position[0], start[1] - position[1])
            fraction = _exit(to_start, along, squared_lookahead)
            if not ends:
                fraction = _saturate(fraction, 0.0, left)
            return start[0] + fraction * along[0], start[1] + fraction * along[1]
        start, left, segment = end, 1.0, (segment + 1) % len(path[0])
    return _quarter_round(path, closest[0])


@_jit
def _exit(start: _Point, along: _Point, squared_radius: float) -> float:
    """Tell where, in multiples of `along`, a line from within the circle leaves it."""
    a = along[0] * along[0] + along[1] * along[1]
    b = start[0] * along[0] + start[1] * along[1]
    c = start[0] * start[0] + start[1] * start[1] - squared_radius
    inside = b * b - a * c
    root = math.sqrt(inside) if inside > 0.0 else 0.0
    return -c / (b + root) if b > 0.0 else (root - b) / a


@_jit
def _quarter_round(path: _Path, segment: int) -> _Point:
    """Go at least a quarter round a closed path."""
    passed = 0.0
    for _ in range(_segments(path)):
        passed += _length(path, segment)
        segment = (segment + 1) % len(path[0])
        if passed >= 0.25 * path[4]:
            break
    return _waypoint(path, segment)


@_jit
def _choose(
    target: _Point,
    yaw: float,
    speed: float,
    previous: float,
    dt: float,
    params: tuple[float, int, float],
) -> float:
    """Choose the candidate that leads closest to the target, seen from the vehicle."""
    px, py = target
    span, count, max_steer = params
    if speed * dt * span * span <= 16.0 * _EPSILON * math.sqrt(px * px + py * py):
        return previous
    steer, least = previous, _distance_after(px, py, yaw + previous, speed, dt)
    half = count // 2
    for k in range(count):
        offset = span * ((k - half) / half)
        candidate = _saturate(previous + offset, -max_steer, max_steer)
        distance = _distance_after(px, py, yaw + candidate, speed, dt)
        if distance < least:
            steer, least = candidate, distance
    return steer


@_jit
def _segments(path: _Path) -> int:
    return len(path[0]) if path[3] else len(path[0]) - 1


@_jit
def _waypoint(path: _Path, index: int) -> _Point:
    k = index % len(path[0])
    return path[0][k], path[1][k]


@_jit
def _length(path: _Path, segment: int) -> float:
    end = path[2][segment + 1] if segment + 1 < len(path[2]) else path[4]
    length: float = end - path[2][segment]
    return length


@_jit
def _distance_after(px: float, py: float, heading: float, speed: float, dt: float) -> float:
    """Measure from where `dt` at a heading leads, from the origin, to a point."""
    x, y = 0.0 + math.cos(heading) * dt * speed, 0.0 + math.sin(heading) * dt * speed
    return math.sqrt(_squared_distance((x, y), (px, py)))
