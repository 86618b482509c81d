"""Another path in mid-run: the place, the estimate and the angle carry on.

A planner gives a path many times a second, mostly the same one from a little farther on. So the
place on the new path is that of the last projection, and only a path that lies elsewhere makes a
hand-over.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from popsteer.reference.math import PI, atan2, sqrt
from popsteer.reference.path.index import STEP_BUDGET
from popsteer.reference.path.locate import find_foot, locate
from popsteer.reference.path.relocalise import relocalise_within
from popsteer.reference.path.view import get_distance

if TYPE_CHECKING:
    from popsteer.reference.path.follow import Follow
    from popsteer.reference.path.view import PathView, Point

__all__ = ["ELSEWHERE", "Found", "find_place", "goes_on"]

ELSEWHERE = 0.1
"""A path that passes the last projection farther off than this lies elsewhere, in wheelbases.

Smaller values fade in more of a planner's noise; larger ones let the angle jump by more.
"""
ELSEWHERE_COSINE = 0.8775825618903728
"""So does one whose direction there is another by more than half a radian: the cosine of that.

The segments of a noisy plan differ by less.
"""


@dataclass(frozen=True)
class Found:
    """The place of the last projection on another path.

    Attributes
    ----------
    waypoint : int
        Its segment.
    measured_waypoint : int or None
        That of the measured vehicle's, where there is a dead time.
    point : tuple of float
        The closest point of the new path [m].
    offset : float
        By how much the last cross-track error is larger there [m].
    is_turned : bool
        Whether the new path is driven in the other direction.
    is_askew : bool
        Whether it leads elsewhere.
    is_aside : bool
        Whether it lies elsewhere.
    """

    waypoint: int
    measured_waypoint: int | None
    point: Point
    offset: float
    is_turned: bool
    is_askew: bool
    is_aside: bool


def goes_on(old: PathView, new: PathView, waypoint: int) -> bool:
    """Tell whether `new` has the same segment at `waypoint`, driven in the same direction.

    Examples
    --------
    >>> from popsteer.reference import Path
    >>> old, new = Path([(0, 0), (5, 0), (9, 0)]), Path([(0, 0), (5, 0), (9, 1)])
    >>> goes_on(old, new, 0), goes_on(old, new, 1)
    (True, False)
    """
    segment = old.segment_at(waypoint)
    return (
        waypoint < len(new)
        and segment == new.segment_at(waypoint)
        and old.segment(segment) == new.segment(segment)
        and old.is_reverse(segment) == new.is_reverse(segment)
    )


def find_place(
    follow: Follow,
    wheelbase: float,
    old: PathView,
    new: PathView,
    last: tuple[int, int | None],
    place: tuple[float, float, float, float],
) -> Found:
    """Find on `new` the place that the vehicle had on `old`.

    `last` are the segments of the predicted and the measured vehicle, `place` their projections
    (x, y, x, y) [m].
    """
    predicted, measured = place[:2], place[2:]
    segment = old.segment_at(last[0])
    start, end = old.segment(segment)
    along = (end[0] - start[0], end[1] - start[1])
    yaw = atan2(along[1], along[0])
    is_reverse = old.is_reverse(segment)
    # Where the vehicle looks.
    heading = yaw + PI if is_reverse else yaw
    opposite = follow.opposite_distance
    found = relocalise_within(new, predicted, heading, opposite, STEP_BUDGET)
    foot = find_foot(new, found.segment, predicted)

    measured_waypoint = last[1]
    if measured_waypoint is not None:
        length = sqrt(along[0] * along[0] + along[1] * along[1])
        direction = (along[0] / length, along[1] / length)
        reach = follow.search_distance + get_distance(predicted, measured)
        there = locate(new, foot.segment, measured, direction, reach, opposite)
        measured_waypoint = there.segment

    ahead = foot.along
    lengths = sqrt(along[0] * along[0] + along[1] * along[1]) * sqrt(
        ahead[0] * ahead[0] + ahead[1] * ahead[1]
    )
    cosine = (along[0] * ahead[0] + along[1] * ahead[1]) / lengths
    limit = ELSEWHERE * wheelbase
    return Found(
        waypoint=foot.segment,
        measured_waypoint=measured_waypoint,
        point=foot.point,
        offset=foot.cross_track_error(),
        is_turned=new.is_reverse(foot.segment) != is_reverse,
        is_askew=cosine < ELSEWHERE_COSINE,
        is_aside=foot.squared_distance > limit * limit,
    )
