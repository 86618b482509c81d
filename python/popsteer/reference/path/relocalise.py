"""Where am I after a jump? The segment of least distance and heading error of all."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

from popsteer.reference.math import cos, sin
from popsteer.reference.path.locate import OPPOSITE, find_foot_between

if TYPE_CHECKING:
    from popsteer.reference.path.view import PathView, Point

__all__ = ["relocalise"]


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
    forward = (cos(yaw), sin(yaw))
    backward = (-forward[0], -forward[1])
    best, least = 0, inf
    for segment in range(path.segments):
        foot = find_foot_between(path, segment, position, 0.0, 1.0)
        heading = backward if path.is_reverse(segment) else forward
        cost = foot.cost(heading, opposite_distance)
        if cost < least:
            best, least = segment, cost
    return best
