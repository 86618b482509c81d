"""Where do I aim? The paper's search for the lookahead point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer.reference.path.view import Point, get_distance

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["Lookahead", "get_lookahead_point", "get_lookahead_point_index"]


@dataclass(frozen=True)
class Lookahead:
    """What the search came back with.

    Attributes
    ----------
    index : int
        The index of the point in the grid.
    point : tuple of float
        The point itself, (x, y) [m].
    found : bool
        Whether it lies on the circle; otherwise it is the last point of the grid.

    Examples
    --------
    >>> get_lookahead_point([(0.0, 0.0), (5.0, 0.0)], (0.0, 0.0), 5.0, 0.01)
    Lookahead(index=1, point=(5.0, 0.0), found=True)
    """

    index: int
    point: Point
    found: bool


def get_lookahead_point_index(
    waypoints: Sequence[Point], position: Point, lookahead: float, tolerance: float
) -> int:
    """Find the first waypoint almost at the lookahead distance, else the last: Equation 5.

    The equation prints only the distance; the text, "almost equal to the lookahead distance",
    says what is compared: d, to within ε, with ld.

    Parameters
    ----------
    waypoints : sequence of points
        The waypoints w, a fine grid [m].
    position : tuple of float
        The vehicle's reference point [m].
    lookahead : float
        Lookahead distance ld [m].
    tolerance : float
        Threshold ε [m].

    Returns
    -------
    int
        Index of the waypoint, lp_i.

    Examples
    --------
    >>> get_lookahead_point_index([(0.0, 0.0), (5.0, 0.0), (9.0, 0.0)], (0.0, 0.0), 5.0, 0.01)
    1
    """
    for i, waypoint in enumerate(waypoints):
        if abs(get_distance(position, waypoint) - lookahead) <= tolerance:
            return i
    return len(waypoints) - 1


def get_lookahead_point(
    waypoints: Sequence[Point], position: Point, lookahead: float, tolerance: float
) -> Lookahead:
    """Return the waypoint that `get_lookahead_point_index` finds, and whether it fits.

    Parameters
    ----------
    waypoints, position, lookahead, tolerance
        As `get_lookahead_point_index` takes them.

    Returns
    -------
    Lookahead
        Index, point, and whether it is almost at the lookahead distance.

    Examples
    --------
    >>> get_lookahead_point([(0.0, 0.0), (5.0, 0.0)], (0.0, 0.0), 50.0, 0.01)
    Lookahead(index=1, point=(5.0, 0.0), found=False)
    """
    index = get_lookahead_point_index(waypoints, position, lookahead, tolerance)
    point = waypoints[index]
    found = abs(get_distance(position, point) - lookahead) <= tolerance
    return Lookahead(index, point, found)
