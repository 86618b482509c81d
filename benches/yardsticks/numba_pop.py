"""POP's step as the reference takes it, compiled by numba.

What a compiled language alone would give: the loops of `popsteer.reference`, over arrays, with none
of the shortcuts of the Rust core. One thing is not as it stands there: the grid of the window is
searched while it is cut, and no further than the point that is found, where the reference makes the
whole list first. The points, their order and what is compared are the same, so the angle is too,
to the last bit: without `fastmath` numba neither reorders nor fuses, and takes sin and cos from the
same libm as Python.
"""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, TypeAlias, TypeVar, cast

import numba
import numpy as np

from popsteer.bench.laws import Driver
from popsteer.reference import PopParams

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from popsteer.bench.states import Drive

    _Array: TypeAlias = NDArray[np.float64]

_F = TypeVar("_F")
_EPSILON = 2.0**-52


def _jit(function: _F) -> _F:
    """Compile, with IEEE 754's division in place of Python's, which checks for zero each time."""
    return cast("_F", numba.njit(error_model="numpy")(function))


def prepare(drive: Drive) -> Callable[[], Driver]:
    """Compile the step; give a maker of drivers for a drive."""
    path = drive.path
    columns = tuple(np.array(column) for column in (path.x, path.y, path.s))
    step = compiled(PopParams(reference_offset=drive.front_offset), path.closed, path.length)

    def make() -> Driver:
        state = np.array([-1.0, 0.0])  # the nearest waypoint, -1 for none yet; the last angle

        def reset() -> None:
            state[:] = -1.0, 0.0

        return Driver(partial(step, state, columns), reset)

    make().call(*drive.states[0], 0.05)  # numba compiles at the first call
    return make


def compiled(params: PopParams, closed: bool, length: float) -> Callable[..., float]:  # noqa: FBT001
    """Compile the step; parameters and shape become constants of the machine code.

    It takes the state, the path's x, y and s, and what every step takes; numba turns no class into
    machine code, so they are arrays.
    """
    offset = params.wheelbase if params.reference_offset is None else params.reference_offset
    min_lookahead, lookahead_gain = params.min_lookahead, params.lookahead_gain
    tolerance, spacing = params.lookahead_tolerance, params.grid_spacing
    ahead, max_steer = params.window_ahead, params.max_steer
    span, count = params.steer_span, params.candidate_count

    @_jit
    def step(
        state: _Array,
        path: tuple[_Array, _Array, _Array],
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
        wx, wy, s = path
        x, y = x + offset * math.cos(yaw), y + offset * math.sin(yaw)
        nearest = _locate(wx, wy, int(state[0]), x, y, closed)
        forward = max(speed, 0.0)
        first, segments = _window(s, nearest, ahead, closed, length)
        lookahead = min_lookahead + lookahead_gain * forward
        px, py = _aim((wx, wy), (first, segments), x, y, lookahead, tolerance, spacing)
        steer = _choose((px - x, py - y), yaw, forward, state[1], dt, (span, count, max_steer))
        state[0], state[1] = nearest, steer
        return steer

    return step


@_jit
def _locate(wx: _Array, wy: _Array, last: int, x: float, y: float, closed: bool) -> int:  # noqa: FBT001
    """Walk to the nearest waypoint, or search all for the first one."""
    if last < 0:
        nearest, least = 0, math.inf
        for k in range(len(wx)):
            distance = _squared_distance(x, y, wx[k], wy[k])
            if distance < least:
                nearest, least = k, distance
        return nearest
    nearest, least = last, _squared_distance(x, y, wx[last], wy[last])
    for direction in (1, -1):
        while True:
            k = _neighbour(nearest, direction, len(wx), closed)
            if k < 0:
                break
            distance = _squared_distance(x, y, wx[k], wy[k])
            if not distance < least:
                break
            nearest, least = k, distance
    return nearest


@_jit
def _window(s: _Array, nearest: int, ahead: float, closed: bool, length: float) -> tuple[int, int]:  # noqa: FBT001
    """Choose the first segment to search, and how many."""
    previous = _neighbour(nearest, -1, len(s), closed)
    first, segments = (nearest, 0) if previous < 0 else (previous, 1)
    last, lap = nearest, 0.0
    while segments < (len(s) if closed else len(s) - 1):
        following = _neighbour(last, 1, len(s), closed)
        if following < 0:
            break
        if following < last:
            lap = length
        segments += 1
        last = following
        if s[last] + lap - s[nearest] >= ahead:
            break
    return first, segments


@_jit
def _aim(
    waypoints: tuple[_Array, _Array],
    window: tuple[int, int],
    x: float,
    y: float,
    lookahead: float,
    tolerance: float,
    spacing: float,
) -> tuple[float, float]:
    """Find the first point of the grid on the lookahead circle, else the last."""
    wx, wy = waypoints
    first, segments = window
    for k in range(segments):
        start, end = (first + k) % len(wx), (first + k + 1) % len(wx)
        along_x, along_y = wx[end] - wx[start], wy[end] - wy[start]
        distance = math.sqrt(_squared_distance(wx[start], wy[start], wx[end], wy[end]))
        points = math.ceil(distance / spacing)
        for index in range(points):
            fraction = index / points
            px, py = wx[start] + fraction * along_x, wy[start] + fraction * along_y
            if abs(math.sqrt(_squared_distance(x, y, px, py)) - lookahead) <= tolerance:
                return px, py
    last = (first + segments) % len(wx)
    return wx[last], wy[last]


@_jit
def _choose(
    target: tuple[float, float],
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
        candidate = previous + span * ((k - half) / half)
        candidate = min(max(candidate, -max_steer), max_steer)
        distance = _distance_after(px, py, yaw + candidate, speed, dt)
        if distance < least:
            steer, least = candidate, distance
    return steer


@_jit
def _squared_distance(ax: float, ay: float, bx: float, by: float) -> float:
    dx, dy = bx - ax, by - ay
    return dx * dx + dy * dy


@_jit
def _neighbour(index: int, direction: int, count: int, closed: bool) -> int:  # noqa: FBT001
    """Give the waypoint after or before `index`, -1 for none."""
    k = index + direction
    if 0 <= k < count:
        return k
    return k % count if closed else -1


@_jit
def _distance_after(px: float, py: float, heading: float, speed: float, dt: float) -> float:
    """Measure from where `dt` at a heading leads, from the origin, to a point."""
    x, y = 0.0 + math.cos(heading) * dt * speed, 0.0 + math.sin(heading) * dt * speed
    return math.sqrt(_squared_distance(x, y, px, py))
