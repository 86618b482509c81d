"""Where am I after a jump? The nearest waypoint where the path leads the vehicle's way."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

from popsteer.reference.math import cos, sin, sqrt
from popsteer.reference.path.view import squared_distance

if TYPE_CHECKING:
    from popsteer.reference.path.view import PathView, Point

__all__ = ["REACH", "relocalise"]

REACH = 10.0
"""How much farther off than the nearest waypoint of all one whose direction fits may be [m]."""


def relocalise(path: PathView, position: Point, yaw: float) -> int:
    """Find the waypoint to go on from after a jump to `position` with heading `yaw` [rad].

    Of those at most `REACH` farther off than the nearest of all, the nearest where the path leads
    at most 90 degrees off `yaw`; the first of several. The nearest of all where it does so
    nowhere. The heading thus tells branches apart that cross or lie alongside, where it points
    against one of them.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> path = Path([(0.0, 0.0), (9.0, 0.0), (9.0, 2.0), (0.0, 2.0)])
    >>> relocalise(path, (0.5, 0.9), 0.1), relocalise(path, (0.5, 0.9), 3.1)
    (0, 3)
    """
    heading = (cos(yaw), sin(yaw))
    nearest, least = 0, inf
    fitting, least_fitting = 0, inf
    for index, waypoint in enumerate(zip(path.x, path.y, strict=True)):
        distance = squared_distance(position, waypoint)
        if distance < least:
            least = distance
            nearest = index
        if distance < least_fitting and _fits(path, index, heading):
            least_fitting = distance
            fitting = index
    if sqrt(least_fitting) <= sqrt(least) + REACH:
        return fitting
    return nearest


def _fits(path: PathView, index: int, heading: Point) -> bool:
    """Whether the path leads at most 90 degrees off a heading at waypoint `index`.

    The path's direction is that of the segment that leaves the waypoint, at the end of an open
    path that of the last segment.
    """
    start, end = path.segment(index - 1 if path.next(index) is None else index)
    return heading[0] * (end[0] - start[0]) + heading[1] * (end[1] - start[1]) >= 0.0
