"""The near neighbourhood of the vehicle, interpolated linearly and re-discretised.

The paper's waypoints, about 1 m apart, are too sparse to steer by; those around the vehicle are
joined by straight lines and cut into a grid of 0.01 m.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from popsteer.errors import PathError
from popsteer.reference.geometry import Point, get_distance
from popsteer.reference.math import ceil

if TYPE_CHECKING:
    from collections.abc import Iterator

    from popsteer.reference.path.view import PathView

MAX_GRID_POINTS = 10_000_000
"""The most points that a grid may have where all of them are stored or visited."""


class Window(NamedTuple):
    """A stretch of consecutive segments.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> Path([(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]).window(1, ahead=5.0)
    Window(first=0, segments=2)
    """

    first: int
    """The first segment, which starts at the waypoint of the same index."""
    segments: int
    """How many segments follow each other, across the seam of a closed path too."""


def window(path: PathView, nearest: int, ahead: float) -> Window:
    """Choose the segments around waypoint `nearest`.

    From one waypoint behind it to the first that lies `ahead` [m] of arc beyond it; at most to
    the end of an open path, and once around a closed one.
    """
    previous = path.previous(nearest)
    first, behind = (nearest, 0) if previous is None else (previous, 1)
    segments = behind
    last = nearest
    lap = 0.0
    while segments < path.segments:
        following = path.next(last)
        if following is None:
            break
        if following < last:
            lap = path.length
        segments += 1
        last = following
        if path.s[last] + lap - path.s[nearest] >= ahead:
            break
    return Window(first, segments)


def segment_grid(path: PathView, segment: int, spacing: float) -> Iterator[Point]:
    """Cut one segment evenly, no two neighbours farther apart than `spacing` [m].

    Its start is the first point; its end is left to the next segment.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> list(segment_grid(Path([(0.0, 0.0), (1.0, 0.0)]), 0, 0.25))
    [(0.0, 0.0), (0.25, 0.0), (0.5, 0.0), (0.75, 0.0)]
    """
    (start_x, start_y), (end_x, end_y) = start, end = path.segment(segment)
    along_x, along_y = end_x - start_x, end_y - start_y
    count = ceil(get_distance(start, end) / spacing)
    for index in range(count):
        fraction = index / count
        yield (start_x + fraction * along_x, start_y + fraction * along_y)


def grid(path: PathView, window: Window, spacing: float) -> Iterator[Point]:
    """Make the fine grid over a window: the points of each segment, then the last waypoint.

    Nothing is stored: the points are made one after the other, as far as they are asked for.
    """
    for k in range(window.segments):
        yield from segment_grid(path, (window.first + k) % len(path), spacing)
    yield path.waypoint((window.first + window.segments) % len(path))


def checked_grid(path: PathView, window: Window, spacing: float) -> Iterator[Point]:
    """Make the grid where it has at most `MAX_GRID_POINTS`; else raise `PathError`."""
    points = 1
    for k in range(window.segments):
        start, end = path.segment((window.first + k) % len(path))
        points += ceil(get_distance(start, end) / spacing)
    if points > MAX_GRID_POINTS:
        raise PathError.grid_too_large(points, MAX_GRID_POINTS)
    return grid(path, window, spacing)
