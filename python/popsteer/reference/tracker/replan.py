"""A new path during a run: place, estimates and angle continue.

A planner sends a path many times a second, mostly the last one shifted a little. The place on the
new path is therefore that of the last projection, and only a path that lies elsewhere starts a
hand-over.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

from popsteer.reference.bounds import MIN_DT
from popsteer.reference.geometry import get_distance
from popsteer.reference.math import PI, atan2, saturate, sqrt
from popsteer.reference.path.index import STEP_BUDGET
from popsteer.reference.path.locate import locate
from popsteer.reference.path.projection import find_closest_point
from popsteer.reference.path.relocalise import relocalise_within
from popsteer.reference.tracker.state import (
    HANDOVER_TIME,
    Place,
    TrackerState,
    hands_over,
)

if TYPE_CHECKING:
    from popsteer.reference.laws.law import LateralLaw
    from popsteer.reference.path.follow import Follow
    from popsteer.reference.path.view import PathView

__all__ = ["ELSEWHERE", "carry_over", "goes_on", "hand_over"]

ELSEWHERE = 0.1
"""A path that passes the last projection farther off than this lies elsewhere, in wheelbases.

Smaller values fade in more of a planner's noise; larger ones let the angle jump by more.
"""
ELSEWHERE_COSINE = 0.8775825618903728
"""So does one whose direction there is another by more than half a radian: the cosine of that.

The segments of a noisy plan differ by less.
"""


StateT = TypeVar("StateT", bound=TrackerState)


def carry_over(
    law: LateralLaw[Any, StateT], follow: Follow, state: StateT, old: PathView, new: PathView
) -> StateT:
    """Return the state of a controller that follows `new` from now on, in place of `old`.

    See `Tracker.set_path`.
    """
    last, measured = state.waypoint, state.measured_waypoint
    if last is None:
        return replace(state, measured_waypoint=None)
    if goes_on(old, new, last) and (measured is None or goes_on(old, new, measured)):
        return state
    if state.place is None:
        # After a jump it is not known where on the old path the vehicle was.
        state = replace(state, waypoint=None, measured_waypoint=None)
        return hand_over(law, law.change_path(state, None))
    x, y, *there = state.place
    last = old.segment_at(last)
    start, end = old.segment(last)
    along = (end[0] - start[0], end[1] - start[1])
    yaw = atan2(along[1], along[0])
    is_reverse = old.is_reverse(last)
    # Where the vehicle looks.
    heading = yaw + PI if is_reverse else yaw
    opposite = follow.opposite_distance
    found = relocalise_within(new, (x, y), heading, opposite, STEP_BUDGET)
    closest = find_closest_point(new, found.segment, (x, y))

    if measured is not None:
        length = sqrt(along[0] * along[0] + along[1] * along[1])
        direction = (along[0] / length, along[1] / length)
        position = (there[0], there[1])
        reach = follow.search_distance + get_distance((x, y), position)
        measured = locate(new, closest.segment, position, direction, reach, opposite).segment
    place = Place(*closest.point, *there)
    state = replace(state, waypoint=closest.segment, measured_waypoint=measured, place=place)

    changes_direction = new.is_reverse(closest.segment) != is_reverse
    ahead = closest.along
    lengths = sqrt(along[0] * along[0] + along[1] * along[1]) * sqrt(
        ahead[0] * ahead[0] + ahead[1] * ahead[1]
    )
    cosine = (along[0] * ahead[0] + along[1] * ahead[1]) / lengths
    is_askew = cosine < ELSEWHERE_COSINE
    if changes_direction:
        state = law.forget_path(state)
    else:
        state = law.change_path(state, None if is_askew else closest.cross_track_error())
    limit = ELSEWHERE * law.vehicle.wheelbase
    if changes_direction or is_askew or closest.squared_distance > limit * limit:
        return hand_over(law, state)
    return state


def hand_over(law: LateralLaw[Any, StateT], state: StateT) -> StateT:
    """Go on from the present angle.

    Its difference to the controller's angle fades in the remaining time of a hand-over in progress,
    or within `HANDOVER_TIME`.
    """
    remaining = state.handover_remaining if hands_over(state) else HANDOVER_TIME
    if state.handover_offset is not None:
        # Less than all of its time remains once a hand-over has begun.
        remaining = saturate(remaining, 0.0, HANDOVER_TIME - MIN_DT)
    state, goes_on_from_it = law.set_steer(state, state.steer)
    if state.monitor is not None:
        # A new path is a new task: the vehicle may start it beyond the limit.
        state = replace(state, monitor=state.monitor._replace(within=False))
    return replace(
        state, handover_offset=None, handover_remaining=0.0 if goes_on_from_it else remaining
    )


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
