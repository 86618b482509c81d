"""Which segments can be the closest? Bounding boxes along the path, for a bounded search.

Neighbours on a path are neighbours in the plane. So each run of `RUN` segments gets a bounding
box, two of those a box around both, and so on up to the whole path: a binary tree in one flat
list, in the order of the arc. A search goes down it, the nearer box first, and leaves out each box
that is farther off than the best segment so far.
"""

from __future__ import annotations

from math import inf
from sys import float_info
from typing import TYPE_CHECKING, NamedTuple

from popsteer.reference.math import saturate

if TYPE_CHECKING:
    from popsteer.reference.path.relocalise import Search
    from popsteer.reference.path.view import PathView, Point

__all__ = ["STEP_BUDGET", "Bounds", "Found", "build", "search"]

RUN = 32
"""Segments in a run, which share a box."""
SCANNED = 512
"""A path of at most this many segments has no index."""
MARGIN = 32.0 * float_info.epsilon
"""More than rounding moves a closest point, as a share of the numbers in it."""
STEP_BUDGET = 2048
"""How many boxes a control step visits at most."""


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


class Found(NamedTuple):
    """What a search found, and how it went."""

    segment: int
    """The segment of least cost of those visited."""
    is_exact: bool
    """Whether no other segment costs less: the budget was enough."""
    visits: int
    """How many boxes were visited; 0 on a path without an index."""


def search(path: PathView, boxes: tuple[Bounds, ...], search: Search, budget: int) -> Found:
    """Visit the segments that can matter, until `budget` boxes are visited.

    Node 1 of the tree holds the whole path and nodes 2k and 2k + 1 what node k holds. The last
    half of the list are the runs, one each.
    """
    position = search.position
    runs = len(boxes) // 2
    first_run = _power_of_two(runs)
    start = path.waypoint(0)
    size = path.length + abs(start[0]) + abs(start[1]) + abs(position[0]) + abs(position[1])
    margin = MARGIN * (size + search.opposite_distance)
    limit = inf
    pending = [(boxes[1].squared_distance(position), 1)]
    visits = 0
    while pending:
        squared_distance, node = pending.pop()
        if squared_distance > limit:
            continue
        if visits == budget:
            return Found(search.segment, is_exact=False, visits=visits)
        visits += 1
        if node < runs:
            left = (boxes[2 * node].squared_distance(position), 2 * node)
            right = (boxes[2 * node + 1].squared_distance(position), 2 * node + 1)
            # The nearer one is taken first.
            pending += [left, right] if right[0] < left[0] else [right, left]
            continue
        run = node + runs - first_run if node < first_run else node - first_run
        for segment in range(RUN * run, min(path.segments, RUN * (run + 1))):
            search.visit(path, segment)
        least = search.cost + margin
        limit = least * least
    return Found(search.segment, is_exact=True, visits=visits)


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
    first_run = _power_of_two(runs)
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


def _power_of_two(count: int) -> int:
    """Return the least power of two that is not below `count`."""
    return 1 << (count - 1).bit_length()
