"""The best of several segments by distance and heading, for a vehicle that may be anywhere."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

from popsteer.reference.math import cos, sin
from popsteer.reference.path.projection import find_closest_point_between

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.view import PathView

__all__ = ["Best"]


class Best:
    """The best segment of those visited, in any order."""

    def __init__(self, position: Point, yaw: float, opposite_distance: float) -> None:
        self.position = position
        """Where it looks from [m]."""
        self.opposite_distance = opposite_distance
        """How much farther off a segment counts that leads the opposite way [m]."""
        self._forward = (cos(yaw), sin(yaw))
        self._backward = (-self._forward[0], -self._forward[1])
        # Cost and index, so that of several as good the first is the least.
        self._least = (inf, 0)

    @property
    def cost(self) -> float:
        """The least cost found [m]."""
        return self._least[0]

    @property
    def segment(self) -> int:
        """The segment of it."""
        return self._least[1]

    def visit(self, path: PathView, segment: int) -> None:
        """Take a segment into account."""
        closest = find_closest_point_between(path, segment, self.position, 0.0, 1.0)
        heading = self._backward if path.is_reverse(segment) else self._forward
        self._least = min(self._least, (closest.cost(heading, self.opposite_distance), segment))
