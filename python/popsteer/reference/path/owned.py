"""The path as a user makes it: waypoints, and the questions one asks them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from popsteer.reference.bounds import MAX_YAW
from popsteer.reference.error import input_below, input_in_range, input_within
from popsteer.reference.math import cos, sin
from popsteer.reference.path import locate, projection, relocalise, resample
from popsteer.reference.path.locate import OPPOSITE
from popsteer.reference.path.lookahead import Lookahead, get_crossing, get_lookahead_point
from popsteer.reference.path.view import PathView
from popsteer.reference.vehicle.state import checked_point

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.projection import Projection
    from popsteer.reference.path.resample import Window


class Path(PathView):
    """Waypoints to follow, validated once.

    Every method raises `InputError` naming the first of its arguments that is not finite or
    beyond its bound, and takes `nearest` as the waypoint near which to look; None is the nearest
    of all.

    Made as `popsteer.Path` is, from waypoints `xy` [m] of shape (N, 2), their reference speeds
    [m/s], and for each waypoint whether the segment that leaves it is driven backwards. Raises
    `PathError` where they are no path.

    Examples
    --------
    >>> path = Path([(0.0, 0.0), (3.0, 4.0)])
    >>> len(path), path.length
    (2, 5.0)
    >>> Path([(0.0, 0.0), (0.0, 0.0)])
    Traceback (most recent call last):
    popsteer.errors.PathError: waypoints 0 and 1 coincide
    """

    def nearest_waypoint(self, x: float, y: float) -> int:
        """Find the waypoint nearest to (x, y) [m] of all; the first of several."""
        return projection.nearest_waypoint(self, checked_point((x, y)))

    def locate(
        self,
        x: float,
        y: float,
        yaw: float,
        waypoint: int,
        reach: float,
        *,
        opposite_distance: float = OPPOSITE,
    ) -> Projection:
        """Project (x, y) [m] onto the path near the segment at `waypoint`; see `locate.locate`."""
        position = checked_point((x, y))
        yaw = input_within("yaw", yaw, MAX_YAW)
        waypoint = input_below("waypoint", waypoint, len(self))
        reach = input_in_range("reach", reach, 0.0, 1e9)
        opposite = input_in_range("opposite_distance", opposite_distance, 0.0, 1e9)
        heading = (cos(yaw), sin(yaw))
        closest = locate.locate(self, waypoint, position, heading, reach, opposite)
        return closest.projection(self)

    def get_crossing(
        self, x: float, y: float, lookahead: float, segment: int
    ) -> tuple[Point, bool]:
        """Find the first crossing of the lookahead circle; see `lookahead.get_crossing`."""
        position = checked_point((x, y))
        lookahead = input_in_range("lookahead", lookahead, 0.0, 1e6)
        segment = self.segment_at(input_below("segment", segment, len(self)))
        closest = projection.find_closest_point(self, segment, position)
        return get_crossing(self, closest, position, lookahead)

    def relocalise(
        self, x: float, y: float, yaw: float, *, opposite_distance: float = OPPOSITE
    ) -> int:
        """Find the segment to start from after a jump to (x, y) [m] with heading `yaw` [rad]."""
        position = checked_point((x, y))
        yaw = input_within("yaw", yaw, MAX_YAW)
        opposite = input_in_range("opposite_distance", opposite_distance, 0.0, 1e9)
        return relocalise.relocalise(self, position, yaw, opposite)

    def project(self, x: float, y: float, nearest: int | None = None) -> Projection:
        """Project (x, y) [m] exactly onto the two segments at waypoint `nearest`."""
        position = checked_point((x, y))
        return projection.project(self, self._near(nearest, position), position)

    def path_yaw_behind(self, nearest: int) -> float:
        """Give the direction of the segment that leads to waypoint `nearest` [rad]."""
        return projection.path_yaw_behind(self, input_below("nearest", nearest, len(self)))

    def reference_speed(self, x: float, y: float, nearest: int | None = None) -> float | None:
        """Give the reference speed beside (x, y) [m/s]; None where there are no speeds."""
        return projection.reference_speed(self, self.project(x, y, nearest))

    def window(self, nearest: int, ahead: float = 20.0) -> Window:
        """Choose the segments from one waypoint behind `nearest` to `ahead` [m] beyond it."""
        nearest = input_below("nearest", nearest, len(self))
        ahead = input_in_range("ahead", ahead, 1e-3, 1e6)
        return resample.window(self, nearest, ahead)

    def resample(self, nearest: int, ahead: float = 20.0, spacing: float = 0.01) -> list[Point]:
        """Cut the window around waypoint `nearest` into points at most `spacing` [m] apart."""
        window = self.window(nearest, ahead)
        spacing = input_in_range("spacing", spacing, 1e-4, 1e3)
        return list(resample.checked_grid(self, window, spacing))

    def get_lookahead_point_index(
        self,
        x: float,
        y: float,
        lookahead: float,
        **options: Any,  # noqa: ANN401 - those of the method below
    ) -> int:
        """Find the index of the lookahead point in the grid around (x, y): Equation 5.

        Parameters are those of `get_lookahead_point`.
        """
        return self.get_lookahead_point(x, y, lookahead, **options).index

    def get_lookahead_point(
        self,
        x: float,
        y: float,
        lookahead: float,
        *,
        nearest: int | None = None,
        tolerance: float = 0.01,
        window_ahead: float = 20.0,
        grid_spacing: float = 0.01,
    ) -> Lookahead:
        """Find the first point of the grid around (x, y) almost `lookahead` away, else the last.

        The grid is made around waypoint `nearest` and `window_ahead` [m] beyond it, with neighbours
        at most `grid_spacing` [m] apart; `tolerance` is the threshold ε [m].

        Examples
        --------
        >>> path = Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)])
        >>> path.get_lookahead_point(0.0, 0.0, 6.0, grid_spacing=0.5)
        Lookahead(index=12, point=(6.0, 0.0), found=True)
        """
        position = checked_point((x, y))
        nearest = self._near(nearest, position)
        lookahead = input_in_range("lookahead", lookahead, 0.0, 1e6)
        tolerance = input_in_range("tolerance", tolerance, 1e-9, 1e3)
        window_ahead = input_in_range("window_ahead", window_ahead, 1e-3, 1e6)
        grid_spacing = input_in_range("grid_spacing", grid_spacing, 1e-4, 1e3)
        window = resample.window(self, nearest, window_ahead)
        grid = resample.checked_grid(self, window, grid_spacing)
        return get_lookahead_point(grid, position, lookahead, tolerance)

    def _near(self, nearest: int | None, position: Point) -> int:
        """Return `nearest` checked; None is looked for."""
        if nearest is None:
            return projection.nearest_waypoint(self, position)
        return input_below("nearest", nearest, len(self))
