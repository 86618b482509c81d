"""Searches the boxes along a path for the closest segments, within a budget.

It goes down the tree of `boxes`, the nearer box first, and leaves out each box that is farther off
than the best segment so far.
"""

from __future__ import annotations

from math import inf
from sys import float_info
from typing import TYPE_CHECKING, NamedTuple

from popsteer.reference.path.boxes import RUN, power_of_two

if TYPE_CHECKING:
    from popsteer.reference.path.best import Best
    from popsteer.reference.path.boxes import Bounds
    from popsteer.reference.path.view import PathView

__all__ = ["STEP_BUDGET", "Found", "search"]

MARGIN = 32.0 * float_info.epsilon
"""Bound of the rounding of a closest point, as a share of its coordinates."""
STEP_BUDGET = 2048
"""How many boxes a control step visits at most."""


class Found(NamedTuple):
    """What a search found, and how it went."""

    segment: int
    """The segment of least cost of those visited."""
    is_exact: bool
    """Whether no other segment costs less: the budget was enough."""
    visits: int
    """How many boxes were visited; 0 on a path without an index."""


def search(path: PathView, boxes: tuple[Bounds, ...], best: Best, budget: int) -> Found:
    """Visit the segments that can matter, until `budget` boxes are visited."""
    position = best.position
    runs = len(boxes) // 2
    first_run = power_of_two(runs)
    start = path.waypoint(0)
    size = path.length + abs(start[0]) + abs(start[1]) + abs(position[0]) + abs(position[1])
    margin = MARGIN * (size + best.opposite_distance)
    limit = inf
    pending = [(boxes[1].squared_distance(position), 1)]
    visits = 0
    while pending:
        squared_distance, node = pending.pop()
        if squared_distance > limit:
            continue
        if visits == budget:
            return Found(best.segment, is_exact=False, visits=visits)
        visits += 1
        if node < runs:
            left = (boxes[2 * node].squared_distance(position), 2 * node)
            right = (boxes[2 * node + 1].squared_distance(position), 2 * node + 1)
            # The nearer one is taken first.
            pending += [left, right] if right[0] < left[0] else [right, left]
            continue
        run = node + runs - first_run if node < first_run else node - first_run
        for segment in range(RUN * run, min(path.segments, RUN * (run + 1))):
            best.visit(path, segment)
        least = best.cost + margin
        limit = least * least
    return Found(best.segment, is_exact=True, visits=visits)
