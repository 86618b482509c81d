"""The next stop: its distance, and the speed until there.

A vehicle stops at the end of an open path, and at each cusp, where it changes its direction. The
rear axle decides, whatever point a controller tracks, so both numbers here are those beside the
rear axle.
"""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, NamedTuple

from popsteer.reference.math import saturate, sqrt

if TYPE_CHECKING:
    from popsteer.reference.path.follow import Follow, Located
    from popsteer.reference.path.view import PathView

__all__ = ["CREEP", "Ahead", "section_end"]

CREEP = 2.0
"""The speed that a speed of 0 at a cusp or at the end counts as, in arrival distances a second.

A tenth of the wheelbase a second. More: the vehicle arrives faster; less: the last centimetres take
longer, and at 0 it would never start again from a cusp.
"""


class Ahead(NamedTuple):
    """Reference speed and distance to the next stop, beside the rear axle."""

    reference_speed: float | None
    """Reference speed [m/s], negative where the path is driven backwards."""
    distance_to_stop: float
    """Distance along the path to the next cusp, or to the end [m]; negative past it."""

    @classmethod
    def of(cls, path: PathView, follow: Follow, at: Located) -> Ahead:
        """Take it from a vehicle that `follow` has located."""
        # Distance of the tracked point ahead of the rear axle, in the direction of driving.
        lead = follow.reference_offset - at.mirror(follow.rear_axle - follow.base)
        segment = at.closest.segment
        arc = at.closest.arc_length(path) - lead
        end = section_end(path, segment)
        if end is None:
            distance_to_stop = inf
        else:
            seam = path.length if end < segment else 0.0
            distance_to_stop = path.segment_end(end) + seam - arc
        if path.speed is None:
            return cls(None, distance_to_stop)
        creep = CREEP * follow.arrival_distance
        magnitude = _speed_beside(path, path.speed, end, arc, lead, creep)
        return cls(-magnitude if at.reverse else magnitude, distance_to_stop)


def _speed_beside(
    path: PathView,
    speed: tuple[float, ...],
    end: int | None,
    arc: float,
    lead: float,
    creep: float,
) -> float:
    """Return the magnitude of the reference speed at `arc` [m].

    In the section that ends with segment `end`; beyond the section, that at its nearer end. Between
    waypoints the square of the speed is linear in the arc, as under a constant acceleration. A
    speed of 0 at an end of the section counts as `creep` [m/s], so that no vehicle stops before it
    or stays there.
    """
    if path.closed and arc < 0.0:
        arc += path.length
    elif path.closed and arc > path.length:
        arc -= path.length
    segment = path.segment_by_arc(arc)
    share = (arc - path.s[segment]) / path.segment_length(segment)
    if path.reverse is not None:
        # The rear axle may not have come to this section yet, or be past it.
        if lead > 0.0:
            for _ in range(path.segments):
                last = section_end(path, segment)
                following = None if last is None else path.next_segment(last)
                if last == end or following is None:
                    break
                segment, share = following, 0.0
        elif end is not None and section_end(path, segment) != end:
            segment, share = end, 1.0
    after = path.next(segment)
    start, finish = abs(speed[segment]), abs(speed[segment if after is None else after])
    here = _at_stop(start, finish, creep) if path.preceding(segment) is None else start
    there = _at_stop(finish, start, creep) if path.following(segment) is None else finish
    here, there = here * here, there * there
    return sqrt(here + saturate(share, 0.0, 1.0) * (there - here))


def _at_stop(speed: float, other: float, creep: float) -> float:
    """Return a speed at an end of a section.

    At least `creep`, or the faster one at the ends of the segment where that is slower.
    """
    faster = max(speed, other)
    return max(speed, creep if faster <= 0.0 else min(faster, creep))


def section_end(path: PathView, index: int) -> int | None:
    """Return the last segment of the section that segment `index` is in.

    Where the vehicle turns round, or the path ends. None where neither comes.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> path = Path([(0.0, 0.0), (9.0, 0.0), (5.0, 0.0)], reverse=[False, True, True])
    >>> section_end(path, 0), section_end(path, 1)
    (0, 1)
    """
    last = index
    for _ in range(path.segments):
        following = path.following(last)
        if following is None:
            return last
        last = following
    return None
