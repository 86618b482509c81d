"""What lies ahead? The direction of the path at distances along it."""

from __future__ import annotations

from bisect import bisect_right
from math import fmod
from typing import TYPE_CHECKING

from popsteer.reference.math import atan2, saturate, wrap
from popsteer.reference.path.view import get_distance, squared_distance

if TYPE_CHECKING:
    from popsteer.reference.path.view import PathView, Point

__all__ = ["path_yaw_at", "turns_ahead"]


def path_yaw_at(path: PathView, base: float, arc_length: float) -> float:
    """Direction of a path at `arc_length` [rad], smoothed over `base` [m] of it.

    It is that of the chord from half a base behind to half a base ahead: on a bend the tangent,
    where segments would turn by leaps. Where segments are longer than half a base, the chord
    reaches one segment's length either way instead, up to five bases, so coarse waypoints turn as
    evenly as fine ones. Where the path doubles back within the chord, the direction is that of the
    segment. Beyond an open path's ends it goes straight on; a closed one wraps.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> path = Path([(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)])
    >>> [round(path_yaw_at(path, 2.0, s), 4) for s in (-5.0, 10.0, 25.0)]
    [0.0, 0.7854, 1.5708]
    """
    start, end = path.segment(_segment_at(path, _on_path(path, arc_length)))
    length = get_distance(start, end)
    reach = saturate(length, 0.5 * base, 5.0 * base)
    if path.closed and reach > 0.25 * path.length:
        reach = 0.25 * path.length
    tail = _point_at(path, arc_length - reach)
    head = _point_at(path, arc_length + reach)
    if squared_distance(tail, head) > reach * reach:
        return atan2(head[1] - tail[1], head[0] - tail[0])
    return atan2(end[1] - start[1], end[0] - start[0])


def turns_ahead(
    path: PathView, base: float, arc_length: float, step: float, count: int
) -> tuple[float, list[float]]:
    """Direction of a path at `arc_length`, and how far it turns over each step from there [rad].

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> path = Path([(0.0, 0.0), (20.0, 0.0), (20.0, 20.0)])
    >>> yaw, turns = turns_ahead(path, 2.0, 10.0, 10.0, 2)
    >>> yaw, [round(turn, 4) for turn in turns]
    (0.0, [0.7854, 0.7854])
    """
    first = path_yaw_at(path, base, arc_length)
    here = first
    travelled = 0.0
    turns = []
    for _ in range(count):
        travelled += step
        following = path_yaw_at(path, base, arc_length + travelled)
        turns.append(wrap(following - here))
        here = following
    return first, turns


def _on_path(path: PathView, arc_length: float) -> float:
    """Bring `arc_length` onto a closed path; unchanged on an open one."""
    if not path.closed:
        return arc_length
    rest = fmod(arc_length, path.length)
    return rest + path.length if rest < 0.0 else rest


def _segment_at(path: PathView, arc_length: float) -> int:
    """Find the last segment whose start does not lie beyond `arc_length`, or the first of all."""
    return min(max(bisect_right(path.s, arc_length) - 1, 0), path.segments - 1)


def _point_at(path: PathView, arc_length: float) -> Point:
    """Find the point at `arc_length`."""
    arc_length = _on_path(path, arc_length)
    segment = _segment_at(path, arc_length)
    start, end = path.segment(segment)
    fraction = (arc_length - path.s[segment]) / get_distance(start, end)
    return start[0] + fraction * (end[0] - start[0]), start[1] + fraction * (end[1] - start[1])
