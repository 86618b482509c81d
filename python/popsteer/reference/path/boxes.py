"""Bounding boxes along a path.

Neighbours on a path are neighbours in the plane. So each run of `RUN` segments gets a bounding
box, two of those a box around both, and so on up to the whole path: a binary tree in one flat
list, in the order of the arc. Node 1 holds the whole path and nodes 2k and 2k + 1 what node k
holds; the last half of the list are the runs, one each.
"""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, NamedTuple

from popsteer.reference.math import saturate

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point

__all__ = ["RUN", "Bounds", "build", "power_of_two"]

RUN = 32
"""Segments in a run, which share a box."""
SCANNED = 512
"""A path of at most this many segments has no index."""


class Bounds(NamedTuple):
    """A rectangle along the axes.

    Examples
    --------
    >>> Bounds(0.0, 0.0, 2.0, 1.0).squared_distance((5.0, 5.0))
    25.0
    """

    low_x: float
    low_y: float
    high_x: float
    high_y: float

    def squared_distance(self, position: Point) -> float:
        """Return the square of the distance from `position` to the box [m²]."""
        dx = position[0] - saturate(position[0], self.low_x, self.high_x)
        dy = position[1] - saturate(position[1], self.low_y, self.high_y)
        return dx * dx + dy * dy


def build(x: tuple[float, ...], y: tuple[float, ...], *, closed: bool) -> tuple[Bounds, ...] | None:
    """Make the boxes of a path with these waypoints; None where a scan is as quick.

    Examples
    --------
    >>> boxes = build(tuple(float(k) for k in range(600)), (0.0,) * 600, closed=False)
    >>> len(boxes), boxes[1]
    (38, Bounds(low_x=0.0, low_y=0.0, high_x=599.0, high_y=0.0))
    """
    segments = len(x) if closed else len(x) - 1
    if segments <= SCANNED:
        return None
    runs = -(-segments // RUN)
    first_run = power_of_two(runs)
    boxes = [Bounds(inf, inf, -inf, -inf)] * (2 * runs)
    for run in range(runs):
        # A run ends at the waypoint to which its last segment leads.
        end = min(RUN * (run + 1), segments)
        held = [index % len(x) for index in range(RUN * run, end + 1)]
        xs, ys = [x[index] for index in held], [y[index] for index in held]
        node = first_run + run
        boxes[node if node < 2 * runs else node - runs] = Bounds(min(xs), min(ys), max(xs), max(ys))
    for node in range(runs - 1, 0, -1):
        left, right = boxes[2 * node], boxes[2 * node + 1]
        boxes[node] = Bounds(
            min(left.low_x, right.low_x),
            min(left.low_y, right.low_y),
            max(left.high_x, right.high_x),
            max(left.high_y, right.high_y),
        )
    return tuple(boxes)


def power_of_two(count: int) -> int:
    """Return the least power of two that is not below `count`."""
    return 1 << (count - 1).bit_length()
