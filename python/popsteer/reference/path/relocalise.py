"""Finds a vehicle anywhere on the path: where it starts, and after a jump."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

from popsteer.reference.math import cos, sin
from popsteer.reference.path.projection import find_closest_point_between

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.view import PathView


def relocalise(path: PathView, position: Point, yaw: float, opposite_distance: float) -> int:
    """Find the segment of least cost of all for a vehicle at `position` with heading `yaw` [rad].

    With the angle d from the heading, which is opposite where the path is driven backwards, to the
    segment, the cost [m] is distance + opposite_distance (1 - cos d) / 2; of several segments as
    good the first is taken.
    """
    forward = (cos(yaw), sin(yaw))
    backward = (-forward[0], -forward[1])
    found, least = 0, inf
    for segment in range(path.segments):
        closest = find_closest_point_between(path, segment, position, 0.0, 1.0)
        heading = backward if path.is_reverse(segment) else forward
        cost = closest.cost(heading, opposite_distance)
        if cost < least:
            found, least = segment, cost
    return found
