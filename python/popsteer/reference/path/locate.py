"""Where am I? The nearest waypoint, and the exact projection beside it."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign, inf
from typing import TYPE_CHECKING

from popsteer.reference.math import atan2, saturate, sqrt
from popsteer.reference.path.view import squared_distance

if TYPE_CHECKING:
    from popsteer.reference.path.view import PathView, Point

__all__ = [
    "Projection",
    "locate",
    "nearest_waypoint",
    "path_yaw_behind",
    "project",
    "reference_speed",
    "walk",
]


@dataclass(frozen=True)
class Projection:
    """The foot of a position on the path.

    Attributes
    ----------
    segment : int
        The segment that carries the foot.
    fraction : float
        Where on the segment: 0 at its start, 1 at its end; beyond both on the extensions.
    point : tuple of float
        The foot, (x, y) [m].
    arc_length : float
        Arc length at the foot [m].
    cross_track_error : float
        Signed distance to the foot [m], positive left of the path.
    path_yaw : float
        Direction of the segment [rad].

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> Path([(0.0, 0.0), (10.0, 0.0)]).project(4.0, 1.5).cross_track_error
    1.5
    """

    segment: int
    fraction: float
    point: Point
    arc_length: float
    cross_track_error: float
    path_yaw: float


def nearest_waypoint(path: PathView, position: Point) -> int:
    """Find the waypoint nearest to `position` of all; the first of several.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> nearest_waypoint(Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]), (14.0, 3.0))
    1
    """
    nearest = 0
    least = inf
    for index, waypoint in enumerate(zip(path.x, path.y, strict=True)):
        distance = squared_distance(position, waypoint)
        if distance < least:
            least = distance
            nearest = index
    return nearest


def walk(path: PathView, start: int, position: Point) -> int:
    """Walk from waypoint `start` to a waypoint with no nearer neighbour.

    The paper's near neighbourhood. The walk goes on as long as it gets strictly nearer, forward
    first.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> walk(Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]), 0, (14.0, 3.0))
    1
    """
    nearest = start
    least = squared_distance(position, path.waypoint(nearest))
    while (following := path.next(nearest)) is not None:
        distance = squared_distance(position, path.waypoint(following))
        if distance < least:
            least = distance
            nearest = following
        else:
            break
    while (previous := path.previous(nearest)) is not None:
        distance = squared_distance(position, path.waypoint(previous))
        if distance < least:
            least = distance
            nearest = previous
        else:
            break
    return nearest


def locate(path: PathView, last: int | None, position: Point) -> int:
    """Find the waypoint to go on from: a walk from the last one, the nearest of all without.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> locate(Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]), None, (14.0, 3.0))
    1
    """
    if last is not None and last < len(path):
        return walk(path, last, position)
    return nearest_waypoint(path, position)


def project(path: PathView, nearest: int, position: Point) -> Projection:
    """Project `position` exactly onto the two segments at waypoint `nearest`.

    The nearer foot counts, the segment ahead where both are as near. Before the first and beyond
    the last waypoint of an open path the end segments go on as straight lines, so the
    cross-track error stays the offset to the side.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> path = Path([(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)])
    >>> foot = project(path, 1, (12.0, 5.0))
    >>> foot.segment, foot.point, foot.arc_length, foot.cross_track_error
    (1, (10.0, 5.0), 15.0, -2.0)
    """
    incoming = path.previous(nearest)
    outgoing = None if path.next(nearest) is None else nearest
    if incoming is not None and outgoing is not None:
        behind = _project_on(path, incoming, position)
        ahead = _project_on(path, outgoing, position)
        if squared_distance(position, behind.point) < squared_distance(position, ahead.point):
            return behind
        return ahead
    return _project_on(path, nearest if incoming is None else incoming, position)


def _project_on(path: PathView, segment: int, position: Point) -> Projection:
    """Find the foot of `position` on one segment."""
    start, end = path.segment(segment)
    along_x, along_y = end[0] - start[0], end[1] - start[1]
    to_x, to_y = position[0] - start[0], position[1] - start[1]
    squared_length = along_x * along_x + along_y * along_y
    low = -inf if not path.closed and segment == 0 else 0.0
    high = inf if not path.closed and segment + 1 == path.segments else 1.0
    fraction = saturate(
        (to_x * along_x + to_y * along_y) / squared_length,
        low,
        high,
    )
    point = (start[0] + fraction * along_x, start[1] + fraction * along_y)
    side = along_x * to_y - along_y * to_x
    return Projection(
        segment=segment,
        fraction=fraction,
        point=point,
        arc_length=path.s[segment] + fraction * sqrt(squared_length),
        cross_track_error=copysign(sqrt(squared_distance(position, point)), side),
        path_yaw=atan2(along_y, along_x),
    )


def path_yaw_behind(path: PathView, nearest: int) -> float:
    """Give the direction of the segment that leads to waypoint `nearest` [rad].

    Of the one that leaves it where none does. The path's heading as the published code takes
    it, up to a waypoint and a half behind the foot.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> path_yaw_behind(Path([(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)]), 1)
    0.0
    """
    previous = path.previous(nearest)
    start, end = path.segment(nearest if previous is None else previous)
    return atan2(end[1] - start[1], end[0] - start[0])


def reference_speed(path: PathView, projection: Projection) -> float | None:
    """Interpolate the waypoints' reference speeds at a projection [m/s].

    Linearly; None where the path has no speeds.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> path = Path([(0.0, 0.0), (10.0, 0.0)], speed=[2.0, 4.0])
    >>> reference_speed(path, project(path, 0, (5.0, 1.0)))
    3.0
    """
    following = path.next(projection.segment)
    if path.speed is None or following is None:
        return None
    here = path.speed[projection.segment]
    there = path.speed[following]
    return here + saturate(projection.fraction, 0.0, 1.0) * (there - here)
