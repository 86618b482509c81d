"""Finds a vehicle anywhere on the path: where it starts, and after a jump."""

from __future__ import annotations

from itertools import takewhile
from typing import TYPE_CHECKING

from popsteer.reference.math import cos, sin
from popsteer.reference.path.locate import least_cost
from popsteer.reference.path.projection import find_closest_point_between

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.projection import ClosestPoint
    from popsteer.reference.path.view import PathView


def relocalise(path: PathView, position: Point, yaw: float, opposite_distance: float) -> int:
    """Find the segment of least cost of all for a vehicle at `position` with heading `yaw` [rad].

    With the angle d from the heading, which is opposite where the path is driven backwards, to the
    segment, the cost [m] is distance + opposite_distance (1 - cos d) / 2; of several segments as
    good the first is taken.
    """
    places = _places(path, position, yaw)
    costs = [closest.cost(heading, opposite_distance) for closest, heading in places]
    return costs.index(min(costs))


def first_as_good(
    path: PathView, position: Point, yaw: float, opposite_distance: float, noise: float
) -> int:
    """Find where the path first passes at a cost of at most `noise` [m] more than the least.

    Of the segments in a row that cost no more than that, the first row along the path, the best. A
    cost is by a segment's own direction or by the path's smoothed one, whichever is less.
    """
    places = _places(path, position, yaw)
    limit = min(closest.cost(heading, opposite_distance) for closest, heading in places) + noise
    costs = [least_cost(path, *place, opposite_distance) for place in places]
    first = next(segment for segment, cost in enumerate(costs) if cost <= limit)
    row = list(takewhile(lambda cost: cost <= limit, costs[first:]))
    return first + row.index(min(row))


def _places(path: PathView, position: Point, yaw: float) -> list[tuple[ClosestPoint, Point]]:
    """Return each segment's closest point, and the heading as one that drives forward there."""
    forward = (cos(yaw), sin(yaw))
    backward = (-forward[0], -forward[1])
    return [
        (
            find_closest_point_between(path, segment, position, 0.0, 1.0),
            backward if path.is_reverse(segment) else forward,
        )
        for segment in range(path.segments)
    ]
