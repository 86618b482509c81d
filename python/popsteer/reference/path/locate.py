"""Where am I? The exact closest point on the path, looked for along the arc around the last one."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

from popsteer.reference.math import cos, sin, sqrt
from popsteer.reference.path.preview import Preview
from popsteer.reference.path.projection import find_closest_point

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.projection import ClosestPoint
    from popsteer.reference.path.view import PathView

__all__ = ["OPPOSITE", "locate"]

OPPOSITE = 10.0
"""How much farther off a closest point counts where the path leads the opposite way [m].

Unless another distance is given; right for a wheelbase of 3 m. Larger values hold on to the branch
of the heading farther off; smaller ones take a nearer branch that leads elsewhere.
"""

SMOOTHING = 0.2
"""Length of path whose heading tells branches apart: two thirds of a wheelbase.

As a part of the distance that the opposite branch counts as farther off.
"""


def locate(
    path: PathView,
    waypoint: int,
    position: Point,
    heading: Point,
    reach: float,
    opposite_distance: float = OPPOSITE,
) -> ClosestPoint:
    """Find the closest point of `position` near the segment at `waypoint`.

    Of the segments from the one at `waypoint` until more than `reach` [m] of arc before and
    behind it, each segment that is no farther off than the one before it and nearer than the one
    after it is a candidate. The candidate of least distance counts, each distance with up to
    `opposite_distance` [m] more the less the path leads along `heading`, by the segment or over a
    fifth of `opposite_distance`, whichever leads along it more; of several the first.

    The stretch ends where an open path does, where the vehicle has to change its direction, and
    once around a closed path. So the closest point cannot leap to another branch: farther along the
    path than `reach` it does not look, and within it the heading tells branches apart.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> path = Path([(0.0, 0.0), (9.0, 0.0), (9.0, 0.5), (0.0, 0.5)])
    >>> locate(path, 0, (7.0, 0.4), (1.0, 0.0), 6.0).segment
    0
    >>> locate(path, 0, (7.0, 0.4), (-1.0, 0.0), 6.0).segment
    2
    """
    closest_points = [
        find_closest_point(path, segment, position)
        for segment in _stretch(path, path.segment_at(waypoint), reach)
    ]
    best, least = closest_points[0], inf
    for k, closest in enumerate(closest_points):
        behind = closest_points[k - 1].squared_distance if k > 0 else inf
        ahead = closest_points[k + 1].squared_distance if k + 1 < len(closest_points) else inf
        if behind >= closest.squared_distance < ahead:
            cost = _least_cost(path, closest, heading, opposite_distance)
            if cost < least:
                best, least = closest, cost
    return best


def _stretch(path: PathView, segment: int, reach: float) -> list[int]:
    """List the segments of the stretch around `segment`, in their order."""
    found = [segment]
    behind, ahead = 0.0, 0.0
    while len(found) < path.segments and behind <= reach:
        previous = path.preceding(found[0])
        if previous is None:
            break
        behind += path.segment_length(previous)
        found.insert(0, previous)
    while len(found) < path.segments and ahead <= reach:
        following = path.following(found[-1])
        if following is None:
            break
        ahead += path.segment_length(following)
        found.append(following)
    return found


def _least_cost(
    path: PathView, closest: ClosestPoint, heading: Point, opposite_distance: float
) -> float:
    """Return the cost of a closest point: the lesser of two, by segment and by smoothed heading.

    One segment of noisy waypoints or of a staircase may lead anywhere, the path about it does not.
    """
    by_segment = closest.cost(heading, opposite_distance)
    arc_length = closest.arc_length(path)
    yaw = Preview.yaw_at(path, SMOOTHING * opposite_distance, closest.segment, arc_length)
    along = heading[0] * cos(yaw) + heading[1] * sin(yaw)
    smoothed = sqrt(closest.squared_distance) + 0.5 * opposite_distance * (1.0 - along)
    return smoothed if smoothed < by_segment else by_segment
