"""The closest point of a segment, and the path's arc length, direction and speed there."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign, inf
from typing import TYPE_CHECKING

from popsteer.reference.geometry import Point, squared_distance
from popsteer.reference.math import atan2, saturate, sqrt

if TYPE_CHECKING:
    from popsteer.reference.path.view import PathView


@dataclass(frozen=True)
class Projection:
    """A position projected onto the path: the closest point, and what the path says there.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> Path([(0.0, 0.0), (10.0, 0.0)]).project(4.0, 1.5).cross_track_error
    1.5
    """

    segment: int  # of the closest point
    fraction: float  # where on the segment: 0 at its start, 1 at its end; beyond on an extension
    point: Point  # the closest point [m]
    arc_length: float  # there [m]
    cross_track_error: float  # distance to the closest point [m], positive left of the path
    path_yaw: float  # direction of the segment [rad]


def nearest_waypoint(path: PathView, position: Point) -> int:
    """Find the waypoint nearest to `position`; the first of several."""
    nearest = 0
    least = inf
    for index, waypoint in enumerate(zip(path.x, path.y, strict=True)):
        distance = squared_distance(position, waypoint)
        if distance < least:
            least = distance
            nearest = index
    return nearest


@dataclass(frozen=True)
class ClosestPoint:
    """The closest point of one segment.

    It holds what is needed to choose between segments; the rest is computed on request.
    """

    segment: int
    fraction: float  # as in a `Projection`
    point: Point  # [m]
    squared_distance: float  # to the point [m²]
    along: Point  # from the start of the segment to its end [m]
    squared_length: float  # of the segment [m²]
    side: float  # positive where the position is left of the segment

    def projection(self, path: PathView) -> Projection:
        """Return the point with arc length, cross-track error and direction."""
        return Projection(
            segment=self.segment,
            fraction=self.fraction,
            point=self.point,
            arc_length=self.arc_length(path),
            cross_track_error=self.cross_track_error(),
            path_yaw=self.path_yaw(),
        )

    def arc_length(self, path: PathView) -> float:
        """Return the arc length at the closest point [m]."""
        return path.s[self.segment] + self.fraction * sqrt(self.squared_length)

    def cross_track_error(self) -> float:
        """Return the distance to the closest point [m], positive left of the path."""
        return copysign(sqrt(self.squared_distance), self.side)

    def path_yaw(self) -> float:
        """Return the direction of the segment [rad]."""
        return atan2(self.along[1], self.along[0])

    def nearest_waypoint(self, path: PathView) -> int:
        """Return the nearer end of the segment; its start where both are as near."""
        following = path.next(self.segment)
        return following if self.fraction > 0.5 and following is not None else self.segment

    def cost(self, heading: Point, opposite_distance: float) -> float:
        """Return distance + opposite_distance (1 - cos d) / 2 [m], d from heading to segment."""
        length = sqrt(self.squared_length)
        along = (heading[0] * self.along[0] + heading[1] * self.along[1]) / length
        return sqrt(self.squared_distance) + 0.5 * opposite_distance * (1.0 - along)


def find_closest_point(path: PathView, segment: int, position: Point) -> ClosestPoint:
    """Find the closest point of one segment.

    At an end of the path and at a cusp the segment goes on as a straight line.
    """
    low = -inf if path.preceding(segment) is None else 0.0
    high = inf if path.following(segment) is None else 1.0
    return find_closest_point_between(path, segment, position, low, high)


def find_closest_point_between(
    path: PathView, segment: int, position: Point, low: float, high: float
) -> ClosestPoint:
    """Find the closest point between two fractions of a segment."""
    start, end = path.segment(segment)
    along = (end[0] - start[0], end[1] - start[1])
    to = (position[0] - start[0], position[1] - start[1])
    squared_length = along[0] * along[0] + along[1] * along[1]
    fraction = saturate((to[0] * along[0] + to[1] * along[1]) / squared_length, low, high)
    point = (start[0] + fraction * along[0], start[1] + fraction * along[1])
    return ClosestPoint(
        segment=segment,
        fraction=fraction,
        point=point,
        squared_distance=squared_distance(position, point),
        along=along,
        squared_length=squared_length,
        side=along[0] * to[1] - along[1] * to[0],
    )


def project(path: PathView, nearest: int, position: Point) -> Projection:
    """Project `position` onto the two segments that meet at waypoint `nearest`.

    Returns the nearer point; that of the segment ahead if both are equally near. Beyond the ends of
    an open path the end segments go on as straight lines, so that the cross-track error remains the
    lateral offset.
    """
    closest = find_closest_point(path, path.segment_at(nearest), position)
    incoming = path.previous(nearest)
    if incoming is not None:
        behind = find_closest_point(path, incoming, position)
        closest = behind if behind.squared_distance < closest.squared_distance else closest
    return closest.projection(path)


def path_yaw_behind(path: PathView, nearest: int) -> float:
    """Give the direction of the segment that ends at waypoint `nearest` [rad].

    Of the one that starts there if none ends there. The published code takes it for the path's
    heading. It lies up to one and a half segments behind the closest point.
    """
    previous = path.previous(nearest)
    start, end = path.segment(nearest if previous is None else previous)
    return atan2(end[1] - start[1], end[0] - start[0])


def reference_speed(path: PathView, projection: Projection) -> float | None:
    """Interpolate the waypoints' reference speeds at a projection [m/s].

    Magnitudes are interpolated linearly. Negative where the path is driven backwards, None if it
    has no speeds.
    """
    following = path.next(projection.segment)
    if path.speed is None or following is None:
        return None
    here = abs(path.speed[projection.segment])
    there = abs(path.speed[following])
    magnitude = here + saturate(projection.fraction, 0.0, 1.0) * (there - here)
    return -magnitude if path.is_reverse(projection.segment) else magnitude
