"""Finds the segment of least distance and heading error on the whole path, after a jump."""

from __future__ import annotations

from typing import TYPE_CHECKING

from popsteer.reference.path import index
from popsteer.reference.path.best import Best
from popsteer.reference.path.index import Found
from popsteer.reference.path.locate import OPPOSITE

if TYPE_CHECKING:
    from popsteer.reference.geometry import Point
    from popsteer.reference.path.view import PathView

__all__ = ["relocalise", "relocalise_within"]


def relocalise(
    path: PathView, position: Point, yaw: float, opposite_distance: float = OPPOSITE
) -> int:
    """Find the segment to start from after a jump to `position` with heading `yaw` [rad].

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
    best = Best(position, yaw, opposite_distance)
    for segment in range(path.segments):
        best.visit(path, segment)
    return best.segment


def relocalise_within(
    path: PathView, position: Point, yaw: float, opposite_distance: float, budget: int
) -> Found:
    """Find it with at most `budget` boxes of the path's index visited.

    Where that is not enough it is the best of the segments in those. A path without an index is
    scanned.
    """
    if path.index is None:
        segment = relocalise(path, position, yaw, opposite_distance)
        return Found(segment, is_exact=True, visits=0)
    best = Best(position, yaw, opposite_distance)
    return index.search(path, path.index, best, budget)
