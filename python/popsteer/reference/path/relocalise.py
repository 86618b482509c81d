"""Where am I after a jump? The segment of least distance and heading error of all."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

from popsteer.reference.math import cos, sin
from popsteer.reference.path import index
from popsteer.reference.path.index import Found
from popsteer.reference.path.locate import OPPOSITE, find_foot_between

if TYPE_CHECKING:
    from popsteer.reference.path.view import PathView, Point

__all__ = ["Search", "relocalise", "relocalise_within"]


def relocalise(
    path: PathView, position: Point, yaw: float, opposite_distance: float = OPPOSITE
) -> int:
    """Find the segment to go on from after a jump to `position` with heading `yaw` [rad].

    The one of least distance, which counts up to `opposite_distance` [m] more the less the vehicle
    would look along it; the first of several. The heading thus tells branches apart that cross or
    lie alongside. Where the path is driven backwards the vehicle looks against it.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> path = Path([(0.0, 0.0), (9.0, 0.0), (9.0, 2.0), (0.0, 2.0)])
    >>> relocalise(path, (0.5, 0.9), 0.1), relocalise(path, (0.5, 0.9), 3.1)
    (0, 2)
    """
    search = Search(position, yaw, opposite_distance)
    for segment in range(path.segments):
        search.visit(path, segment)
    return search.segment


def relocalise_within(
    path: PathView, position: Point, yaw: float, opposite_distance: float, budget: int
) -> Found:
    """Find it with at most `budget` boxes of the path's index visited.

    Where that is not enough it is the best of the segments in those. A path without an index is
    scanned.
    """
    if path.index is None:
        segment = relocalise(path, position, yaw, opposite_distance)
        return Found(segment, is_exact=True, visits=0)
    search = Search(position, yaw, opposite_distance)
    return index.search(path, path.index, search, budget)


class Search:
    """The best segment of those visited, in any order."""

    def __init__(self, position: Point, yaw: float, opposite_distance: float) -> None:
        self.position = position
        """Where it looks from [m]."""
        self.opposite_distance = opposite_distance
        """How much farther off a segment counts that leads the opposite way [m]."""
        self._forward = (cos(yaw), sin(yaw))
        self._backward = (-self._forward[0], -self._forward[1])
        # Cost and index, so that of several as good the first is the least.
        self._best = (inf, 0)

    @property
    def cost(self) -> float:
        """The least cost found [m]."""
        return self._best[0]

    @property
    def segment(self) -> int:
        """The segment of it."""
        return self._best[1]

    def visit(self, path: PathView, segment: int) -> None:
        """Take a segment into account."""
        foot = find_foot_between(path, segment, self.position, 0.0, 1.0)
        heading = self._backward if path.is_reverse(segment) else self._forward
        self._best = min(self._best, (foot.cost(heading, self.opposite_distance), segment))
