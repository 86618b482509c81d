"""Pathological paths for path trackers: crossings, near misses, odd spacings, and cusps.

Each function returns the waypoints of one path, for tests and for tables of what controllers do in
hard cases; the paths are not meant for comparing accuracy. Spacings are rounded so that they
divide the path. A dimension that is out of its range raises ConfigError.

Those with cusps, `three_point_turn` and `parallel_parking`, live in `popsteer.tracks.cusps`, which
says how they tell the direction of driving.

Examples
--------
>>> import popsteer
>>> from popsteer.tracks import edges
>>> eight = edges.figure8(spacing=0.5)
>>> popsteer.Path(eight.xy, speed=eight.speed, closed=eight.closed).closed
True
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from popsteer.ranges import check_in_range
from popsteer.tracks.cusps import parallel_parking, three_point_turn
from popsteer.tracks.geometry import (
    Piece,
    Sampled,
    Waypoints,
    equal_steps,
    lemniscate,
    placed,
    profile,
    straight,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = [
    "Waypoints",
    "dense_straight",
    "figure8",
    "near_duplicates",
    "out_and_back",
    "parallel_parking",
    "polygon",
    "spiral",
    "three_point_turn",
    "touching",
]


def figure8(size: float = 40.0, spacing: float = 1.0) -> Waypoints:
    """Make a closed path that crosses itself at a right angle: the lemniscate of Bernoulli.

    It begins at the tip of the right loop, `size` [m] from the crossing; the least radius is a
    third of that. Raises ConfigError where the spacing [m] leaves fewer than eight waypoints.

    Examples
    --------
    >>> figure8(size=40.0, spacing=5.0).xy[0].tolist()
    [40.0, 0.0]
    """
    check_in_range("size", size, 0.1, 1e4)
    # The whole curve is 5.244 times its size long.
    check_in_range("spacing", spacing, 0.01, 5.244 * size / 8.0)
    return _driven(lemniscate(size, spacing), closed=True)


def out_and_back(offset: float = 0.5, length: float = 60.0, spacing: float = 0.5) -> Waypoints:
    """Make a path that leads out, turns left in a semicircle, and comes back alongside.

    The branches are `length` long and `offset` apart [m], twice the radius of the semicircle. No
    car can drive a small one; the question is on which branch the tracker is afterwards. A coarse
    spacing [m] cuts the semicircle.

    Examples
    --------
    >>> back = out_and_back(offset=0.5, length=60.0)
    >>> back.xy[0].tolist(), back.xy[-1].round(9).tolist()
    ([0.0, 0.0], [0.0, 0.5])
    """
    check_in_range("offset", offset, 0.01, 1e3)
    check_in_range("length", length, 1.0, 1e5)
    curvature = 2.0 / offset
    branch = straight(length)
    turn = Piece(0.5 * math.pi * offset, curvature, curvature)
    return _driven(placed([*branch, turn, *branch], spacing))


def spiral(
    pitch: float = 1.0, inner_radius: float = 8.0, turns: float = 4.0, spacing: float = 1.0
) -> Waypoints:
    """Make a spiral outward, each turn close to the one before: Archimedes' r = r₀ + p φ / 2π.

    It turns to the left. `pitch` is p, the distance of neighbouring turns, `inner_radius` is r₀,
    `spacing` the distance of neighbours along the curve [m].

    Examples
    --------
    >>> float(np.hypot(*spiral(pitch=1.0, inner_radius=8.0, turns=4.0).xy[-1]).round(9))
    12.0
    """
    check_in_range("pitch", pitch, 0.01, 1e3)
    check_in_range("inner_radius", inner_radius, 0.1, 1e4)
    check_in_range("turns", turns, 0.1, 100.0)
    check_in_range("spacing", spacing, 0.01, 100.0)
    growth = pitch / (2.0 * math.pi)

    def curve(phi: NDArray[np.float64]) -> NDArray[np.float64]:
        radius = inner_radius + growth * phi
        return np.column_stack((radius * np.cos(phi), radius * np.sin(phi)))

    fine = np.linspace(0.0, 2.0 * math.pi * turns, 400_001)
    phi, step = equal_steps(curve(fine), fine, spacing)
    squared = (inner_radius + growth * phi) ** 2
    curvature = (squared + 2.0 * growth**2) / (squared + growth**2) ** 1.5
    return _driven(Sampled(curve(phi), curvature, step))


def touching(radius: float = 12.0, length: float = 40.0, spacing: float = 1.0) -> Waypoints:
    """Make a path that touches itself: a straight, a full circle, and the same straight on.

    The circle, to the left, leaves and meets the straight at the same point in the same direction.
    There position and heading fit both branches, and only the distance travelled tells them apart.
    `radius` is that of the circle, `length` that of each straight, `spacing` the distance of
    neighbours [m].

    Examples
    --------
    >>> touching(radius=12.0, length=40.0).xy[-1, 0].round(6).item()
    80.0
    """
    check_in_range("radius", radius, 0.1, 1e4)
    check_in_range("length", length, 1.0, 1e5)
    along = straight(length)
    circle = Piece(2.0 * math.pi * radius, 1.0 / radius, 1.0 / radius)
    return _driven(placed([*along, circle, *along], spacing))


def polygon(sides: int = 12, side: float = 100.0) -> Waypoints:
    """Make a closed regular polygon without waypoints between its corners, to the left.

    The heading turns by 2π / sides at each corner; `side` is the length of a side [m]. The
    reference speed is what the inscribed circle allows.

    Examples
    --------
    >>> polygon(4, 100.0).xy.round(9).tolist()
    [[0.0, 0.0], [100.0, 0.0], [100.0, 100.0], [0.0, 100.0]]
    """
    check_in_range("sides", sides, 3, 100_000)
    check_in_range("side", side, 0.01, 1e5)
    heading = 2.0 * math.pi / sides * np.arange(sides - 1)
    steps = side * np.column_stack((np.cos(heading), np.sin(heading)))
    xy = np.concatenate((np.zeros((1, 2)), np.cumsum(steps, axis=0)))
    curvature = np.full(sides, 2.0 * math.tan(math.pi / sides) / side)
    return _driven(Sampled(xy, curvature, side), closed=True)


def dense_straight(length: float = 50.0, spacing: float = 0.01) -> Waypoints:
    """Make a straight along x of waypoints that are close together; length and spacing in [m].

    Examples
    --------
    >>> len(dense_straight(50.0, 0.01).xy)
    5001
    """
    check_in_range("length", length, 0.1, 1e4)
    return _driven(placed(straight(length), spacing))


def near_duplicates(
    length: float = 60.0, radius: float = 30.0, spacing: float = 1.0, gap: float = 1e-6
) -> Waypoints:
    """Make a straight and an arc with each waypoint nearly twice, as in careless recordings.

    Both are `length` long [m], the arc with a `radius` [m]. The twin of each waypoint lies `gap`
    ahead of it, the next waypoint `spacing` [m].

    Examples
    --------
    >>> near_duplicates(gap=1e-6).xy[:4].round(9).tolist()
    [[0.0, 0.0], [1e-06, 0.0], [1.0, 0.0], [1.000001, 0.0]]
    """
    check_in_range("length", length, 1.0, 1e5)
    check_in_range("radius", radius, 0.1, 1e5)
    check_in_range("gap", gap, 1e-8, 0.5 * spacing)
    pieces = [*straight(length), Piece(length, 1.0 / radius, 1.0 / radius)]
    line, speed, _ = _driven(placed(pieces, spacing))
    ahead = np.diff(line, axis=0)
    ahead = np.concatenate((ahead, ahead[-1:]))
    ahead *= gap / np.sqrt((ahead * ahead).sum(axis=1, keepdims=True))
    xy = np.stack((line, line + ahead), axis=1).reshape(-1, 2)
    return Waypoints(xy, np.repeat(speed, 2), closed=False)


def _driven(line: Sampled, *, closed: bool = False) -> Waypoints:
    """Put to a line the speeds at which it is driven forward."""
    return Waypoints(line.xy, profile(line, closed=closed), closed)
