"""Projects a position onto the path, near the segment of the last projection."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING

from popsteer.reference.math import cos, sin, sqrt
from popsteer.reference.path.preview import Preview
from popsteer.reference.path.projection import ClosestPoint, find_closest_point

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.view import PathView

OPPOSITE = 10.0
"""The `opposite_distance` of a vehicle with a wheelbase of 3 m.

The cost of a path that leads opposite to the heading, as a distance [m]. Controllers scale it with
the wheelbase (`Follow`). Larger values keep to the branch along the heading from farther off.
Smaller values take a nearer branch that leads elsewhere.
"""

SMOOTHING = 0.2
"""Length of path over which its heading is smoothed, as a share of `opposite_distance`.

Two thirds of a wheelbase for the `opposite_distance` of the controllers.
"""


def locate(
    path: PathView,
    waypoint: int,
    position: Point,
    heading: Point,
    reach: float,
    opposite_distance: float = OPPOSITE,
) -> ClosestPoint:
    """Find the path's closest point to `position`, near the segment at `waypoint`.

    Finds the local minima of the distance to `position` within `reach` [m] of arc behind and ahead
    of the segment, and returns the one of least cost; of equal ones, the first along the path. A
    segment holds a local minimum if it is no farther off than the segment before it and nearer than
    the one after it; a missing neighbour, at an end of the stretch, counts as infinitely far. Its
    cost [m], with the angle d from the unit vector `heading`, the direction of driving, to the
    path, is::

        distance + opposite_distance (1 - cos d) / 2

    once with the direction of the segment and once with the path's smoothed direction about the
    closest point; the lesser counts.

    The stretch consists of whole segments, so it is longer than `reach` by up to a segment. It ends
    early at the end of an open path, at a cusp, and once around a closed path. The answer cannot
    leap to another branch of the path: beyond the stretch there is no search, and within it the
    heading tells branches apart.

    A segment that leads elsewhere, more than 60° off heading and smoothed direction, as the jitter
    of a recorded standstill does, has the latter: the vehicle is on the side of the path about it.
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
            cost = least_cost(path, closest, heading, opposite_distance)
            if cost < least:
                best, least = closest, cost
    length = sqrt(best.squared_length)
    towards = heading
    if heading[0] * best.along[0] + heading[1] * best.along[1] <= 0.5 * length:
        towards = _smoothed(path, best, opposite_distance)
    if towards[0] * best.along[0] + towards[1] * best.along[1] > 0.5 * length:
        return best
    to = (position[0] - best.point[0], position[1] - best.point[1])
    along = (towards[0] * length, towards[1] * length)
    return replace(best, along=along, side=towards[0] * to[1] - towards[1] * to[0])


def _stretch(path: PathView, segment: int, reach: float) -> list[int]:
    """List the segments around `segment` in order, each way until they exceed `reach` [m]."""
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


def least_cost(
    path: PathView, closest: ClosestPoint, heading: Point, opposite_distance: float
) -> float:
    """Return the cost of a closest point: the lesser of two, by segment and by smoothed direction.

    A single segment of noisy waypoints or of a staircase may lead anywhere; the path about it does
    not.
    """
    by_segment = closest.cost(heading, opposite_distance)
    towards = _smoothed(path, closest, opposite_distance)
    along = heading[0] * towards[0] + heading[1] * towards[1]
    smoothed = sqrt(closest.squared_distance) + 0.5 * opposite_distance * (1.0 - along)
    return smoothed if smoothed < by_segment else by_segment


def _smoothed(path: PathView, closest: ClosestPoint, opposite_distance: float) -> Point:
    """Return the path's direction, smoothed over a fifth of `opposite_distance`: a unit vector."""
    arc_length = closest.arc_length(path)
    yaw = Preview.yaw_at(path, SMOOTHING * opposite_distance, closest.segment, arc_length)
    return cos(yaw), sin(yaw)
