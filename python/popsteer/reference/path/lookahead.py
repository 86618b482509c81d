"""The lookahead point: the paper's search, and an exact one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer.reference.geometry import Point, get_distance, squared_distance
from popsteer.reference.math import saturate, sqrt

if TYPE_CHECKING:
    from collections.abc import Iterable

    from popsteer.reference.path.projection import ClosestPoint
    from popsteer.reference.path.view import PathView


@dataclass(frozen=True)
class Lookahead:
    """The result of the search.

    Examples
    --------
    >>> get_lookahead_point([(0.0, 0.0), (5.0, 0.0)], (0.0, 0.0), 5.0, 0.01)
    Lookahead(index=1, point=(5.0, 0.0), found=True)
    """

    index: int  # of the point in the grid
    point: Point  # the point itself [m]
    found: bool  # whether it lies on the circle; otherwise it is the last point of the grid


def get_lookahead_point_index(
    waypoints: Iterable[Point], position: Point, lookahead: float, tolerance: float
) -> int:
    """Find the first waypoint almost at the lookahead distance, else the last: Equation 5.

    The equation prints only the distance; the text, "almost equal to the lookahead distance",
    says what is compared: d, to within ε, with ld.

    The waypoints w are a fine grid [m]; `position` [m] is the vehicle's, ld the `lookahead` [m],
    and ε the `tolerance` [m].
    """
    return get_lookahead_point(waypoints, position, lookahead, tolerance).index


def get_lookahead_point(
    waypoints: Iterable[Point], position: Point, lookahead: float, tolerance: float
) -> Lookahead:
    """Find that waypoint, and whether it fits, in one pass that stores nothing."""
    i, waypoint = 0, position
    for i, waypoint in enumerate(waypoints):
        if abs(get_distance(position, waypoint) - lookahead) <= tolerance:
            return Lookahead(i, waypoint, found=True)
    return Lookahead(i, waypoint, found=False)


def get_crossing(
    path: PathView, closest: ClosestPoint, position: Point, lookahead: float
) -> tuple[Point, bool]:
    """Find the first point after `closest` that is `lookahead` [m] away, and whether there is one.

    At an end of an open path and at a cusp the last segment goes on as a straight line, so there
    always is one while the closest point lies within the circle. If the closest point is at least
    `lookahead` away, it is the answer itself. On a closed path that lies within the circle the
    answer is the waypoint at least a quarter round.
    """
    squared_lookahead = lookahead * lookahead
    if closest.squared_distance >= squared_lookahead:
        return closest.point, False
    # Starts from the closest point itself, which keeps digits far beyond the end of the path.
    start = closest.point
    segment = closest.segment
    # Remaining share of the segment; more than 1 before the start of the path.
    remaining = 1.0 - closest.fraction
    for _ in range(path.segments):
        begin, end = path.segment(segment)
        following = path.following(segment)
        if following is None or squared_distance(position, end) >= squared_lookahead:
            along = (end[0] - begin[0], end[1] - begin[1])
            to_start = (start[0] - position[0], start[1] - position[1])
            fraction = _exit(to_start, along, squared_lookahead)
            if following is not None:
                fraction = saturate(fraction, 0.0, remaining)
            return (start[0] + fraction * along[0], start[1] + fraction * along[1]), True
        start = end
        remaining = 1.0
        segment = following
    return _quarter_round(path, closest), False


def _exit(start: Point, along: Point, squared_radius: float) -> float:
    """Tell where, in multiples of `along`, a line from within the circle leaves it."""
    a = along[0] * along[0] + along[1] * along[1]
    b = start[0] * along[0] + start[1] * along[1]
    c = start[0] * start[0] + start[1] * start[1] - squared_radius
    inside = b * b - a * c
    root = sqrt(inside) if inside > 0.0 else 0.0
    # The form that does not subtract.
    return -c / (b + root) if b > 0.0 else (root - b) / a


def _quarter_round(path: PathView, closest: ClosestPoint) -> Point:
    """Return the waypoint at least a quarter of a closed path on from `closest`."""
    segment = closest.segment
    passed = 0.0
    for _ in range(path.segments):
        passed += path.segment_length(segment)
        following = path.following(segment)
        segment = segment if following is None else following
        if passed >= 0.25 * path.length:
            break
    return path.waypoint(segment)
