"""The greatest speeds along a path that a vehicle's limits allow.

The square of the speed is linear in the arc between waypoints, so that the acceleration is constant
there. Bounds at the waypoints come first: top speed, speed limits, the lateral acceleration in the
bend, the steering. A pass forward then lowers what driving cannot reach, and a pass backward what
braking cannot come down from (the forward-backward solver of A. Heilmeier et al., *Minimum
curvature trajectory planning and control for an autonomous race car*, Vehicle System Dynamics 58,
2020). An acceleration holds at both ends of its segment.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from popsteer.reference.math import sqrt, tan

if TYPE_CHECKING:
    from collections.abc import Sequence

    from popsteer.reference.speed.limits import Limits, OverSpeed

__all__ = ["LIMITS", "Course", "plan_speeds"]

LIMITS = (
    "top speed",
    "speed limit",
    "lateral",
    "steer angle",
    "steer rate",
    "stop",
    "driving",
    "braking",
)
"""What limits the speed, by its number."""
_TOP, _LIMIT, _LATERAL, _ANGLE, _RATE, _STOP, _DRIVING, _BRAKING = range(8)

SLIGHTLY = 0.999
"""What is lowered less than to this share still counts as limited by what it was."""
ROUNDS = 50
"""Passes forward and backward until nothing is lowered any more."""


class Course(NamedTuple):
    """What is to be driven: N waypoints."""

    curvature: Sequence[float]
    """Curvature at each waypoint [1/m]."""
    spacing: Sequence[float]
    """Length of each segment [m]: N - 1 of an open path, N of a closed one."""
    closed: bool = False
    """Whether the last waypoint leads back to the first: the speeds are the same in each lap."""
    cusps: Sequence[bool] | None = None
    """Whether the vehicle turns round at each waypoint; nowhere without."""
    speed_limits: Sequence[float] | None = None
    """The speed limit at each waypoint [m/s]; none without."""
    start_speed: float | None = None
    """Largest speed at the first waypoint of an open path [m/s]."""
    end_speed: float | None = None
    """Largest speed at its last waypoint [m/s]."""

    def next(self, index: int) -> int:
        """Return the waypoint after `index`."""
        return index + 1 if index + 1 < len(self.curvature) else 0

    def is_cusp(self, index: int) -> bool:
        """Tell whether the vehicle turns round at waypoint `index`."""
        return self.cusps is not None and bool(self.cusps[index])


def plan_speeds(course: Course, limits: Limits) -> tuple[list[float], list[int]]:
    """Find the greatest speed at each waypoint [m/s], and the number of what limits it there.

    Raises
    ------
    ConfigError
        Naming the limit that is out of its range.
    """
    limits.check()
    squared, limit = _bound(course, limits)
    count = len(squared)
    segments = len(course.spacing)
    # At the slowest waypoint a lap neither drives nor brakes, so it can be cut open there.
    start = squared.index(min(squared)) if course.closed else 0
    varies = len(limits.acceleration.values) > 1 or len(limits.deceleration.values) > 1
    lower = _Lower(course, limits, squared, limit)
    for _ in range(ROUNDS if varies else 1):
        lowered = False
        for step in range(segments):
            index = (start + step) % count
            ends = (index, course.next(index))
            lowered |= lower(limits.acceleration, ends, index, _DRIVING)
        for step in range(segments - 1, -1, -1):
            index = (start + step) % count
            ends = (course.next(index), index)
            lowered |= lower(limits.deceleration, ends, index, _BRAKING)
        if not lowered:
            break
    return [sqrt(value) for value in squared], limit


class _Lower(NamedTuple):
    """Lowers the square of the speed at a waypoint to what can be reached from its neighbour."""

    course: Course
    limits: Limits
    squared: list[float]
    limit: list[int]

    def __call__(self, over: OverSpeed, ends: tuple[int, int], segment: int, by: int) -> bool:
        first, second = ends
        begin = (self.squared[first], self.course.curvature[first])
        end = (self.squared[second], self.course.curvature[second])
        if end[0] <= begin[0]:
            return False
        reached = self.limits.reach(over, begin, end, self.course.spacing[segment])
        if reached >= end[0]:
            return False
        self.squared[second] = reached
        if reached < SLIGHTLY * end[0]:
            self.limit[second] = by
        return True


def _bound(course: Course, limits: Limits) -> tuple[list[float], list[int]]:
    """Return the square of the speed that each waypoint allows by itself, and what bounds it."""
    squared: list[float] = []
    limit: list[int] = []
    for index in range(len(course.curvature)):
        value, by = limits.max_speed * limits.max_speed, _TOP
        for bound, cause in (*_in_bend(course, limits, index), *_at_stop(course, index)):
            if bound < value:
                value, by = bound, cause
        squared.append(value)
        limit.append(by)
    if limits.vehicle.max_steer_rate is None:
        return squared, limit
    for segment, length in enumerate(course.spacing):
        following = course.next(segment)
        if course.is_cusp(following):
            continue  # the curvature there is that of the way on
        start, end = course.curvature[segment], course.curvature[following]
        speed = limits.in_time(start, end, length, limits.max_speed)
        for index in (segment, following):
            if speed * speed < squared[index]:
                squared[index], limit[index] = speed * speed, _RATE
    return squared, limit


def _in_bend(course: Course, limits: Limits, index: int) -> list[tuple[float, int]]:
    """Return the bounds by the speed limit and by the bend, and their numbers."""
    car = limits.vehicle
    bounds: list[tuple[float, int]] = []
    if course.speed_limits is not None:
        bounds.append((course.speed_limits[index] * course.speed_limits[index], _LIMIT))
    bend = abs(course.curvature[index])
    if bend > 0.0:
        bounds.append((limits.max_lateral_acceleration / bend, _LATERAL))
        room = tan(car.max_steer) / bend - car.turning_length(0.0)
        if car.understeer > 0.0 and room > 0.0:
            bounds.append((room / car.understeer, _ANGLE))
    return bounds


def _at_stop(course: Course, index: int) -> list[tuple[float, int]]:
    """Return the bounds by the start, a cusp and the end."""
    bounds: list[tuple[float, int]] = []
    if course.is_cusp(index):
        bounds.append((0.0, _STOP))
    if not course.closed:
        if index == 0 and course.start_speed is not None:
            bounds.append((course.start_speed * course.start_speed, _STOP))
        if index == len(course.curvature) - 1 and course.end_speed is not None:
            bounds.append((course.end_speed * course.end_speed, _STOP))
    return bounds
