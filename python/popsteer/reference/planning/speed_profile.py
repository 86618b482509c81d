"""The greatest speeds along a path that a vehicle's limits allow.

The square of the speed is linear in the arc between waypoints, so that the acceleration is constant
there. Bounds at the waypoints come first: top speed, speed limits, the lateral acceleration in the
bend, the steering. A pass forward then lowers what driving cannot reach, and a pass backward what
braking cannot come down from (the forward-backward solver of A. Heilmeier et al., *Minimum
curvature trajectory planning and control for an autonomous race car*, Vehicle System Dynamics 58,
2020). An acceleration holds at both ends of its segment.
"""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, NamedTuple

from popsteer import errors
from popsteer.reference.error import in_range
from popsteer.reference.math import sqrt, tan

if TYPE_CHECKING:
    from collections.abc import Sequence

    from popsteer.reference.vehicle import Vehicle

__all__ = ["LIMITS", "Course", "Limits", "OverSpeed", "plan_speeds"]

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

ROOT_STEPS = 60
"""The most steps towards a root."""
ROOT_TOLERANCE = 1e-13
"""How near to a root is near enough, as a share of the square of the speed."""
SLIGHTLY = 0.999
"""What is lowered less than to this share still counts as limited by what it was."""
BISECTIONS = 40
"""Halvings of a speed."""
ROUNDS = 50
"""Passes forward and backward until nothing is lowered any more."""


class OverSpeed(NamedTuple):
    """What a limit of the acceleration is at a speed.

    Straight between points, constant beyond them.

    Examples
    --------
    >>> OverSpeed((0.0, 10.0), (3.0, 1.0)).at(25.0)
    2.0
    """

    speeds: Sequence[float]
    """Speeds [m/s], increasing."""
    values: Sequence[float]
    """The limit at each [m/s²]."""

    def at(self, squared: float) -> float:
        """Return the limit at the square of a speed [m²/s²]."""
        last = self.values[-1] if self.values else 0.0
        if len(self.values) < 2:
            return last
        speed = sqrt(squared)
        following = sum(1 for known in self.speeds if known <= speed)
        if following == 0:
            return self.values[0]
        if following == len(self.values):
            return last
        low, high = self.speeds[following - 1], self.speeds[following]
        before, after = self.values[following - 1], self.values[following]
        return before + (speed - low) / (high - low) * (after - before)

    def most(self) -> float:
        """Return the largest value [m/s²]."""
        most = 0.0
        for value in self.values:
            if value > most:
                most = value
        return most

    def check(self, field: str) -> None:
        """Raise `ConfigError` for a point that is out of its range."""
        before = -1.0
        for speed in self.speeds:
            _check(field, speed, 0.0, 1e4)
            # Speeds that do not increase are refused by the least that would do.
            _check(field, speed, max(0.0, before + 1e-6), 1e4)
            before = speed
        for value in self.values:
            _check(field, value, 1e-3, 1e3)
        _check(field, self.most(), 1e-3, 1e3)


class Limits(NamedTuple):
    """What limits the speed."""

    max_speed: float
    """Top speed [m/s]."""
    max_lateral_acceleration: float
    """Largest lateral acceleration [m/s²]."""
    acceleration: OverSpeed
    """Largest driving acceleration [m/s²]."""
    deceleration: OverSpeed
    """Largest braking deceleration [m/s²]."""
    longitudinal_grip: float | None
    """What the tyres hold along the vehicle [m/s²]; None: each limit above is its own half axis."""
    exponent: float
    """Exponent of the friction ellipse; infinite a rectangle."""
    vehicle: Vehicle
    """The vehicle, whose wheels have to turn in time for the bends."""

    def check(self) -> None:
        """Raise `ConfigError` naming the field that is not within its range."""
        _check("max_speed", self.max_speed, 1e-3, 1e4)
        _check("max_lateral_acceleration", self.max_lateral_acceleration, 1e-3, 1e3)
        self.acceleration.check("max_acceleration")
        self.deceleration.check("max_deceleration")
        if self.longitudinal_grip is not None:
            _check("longitudinal_grip", self.longitudinal_grip, 1e-3, 1e3)
        _check("exponent", self.exponent, 1.0, inf)

    def available(self, over: OverSpeed, squared: float, curvature: float) -> float:
        """Return the largest acceleration along the path within `over` [m/s²].

        `squared` is the square of the speed [m²/s²].
        """
        most = over.at(squared)
        used = squared * abs(curvature) / self.max_lateral_acceleration
        if self.exponent == inf or used <= 0.0:
            share = 1.0
        elif used >= 1.0:
            share = 0.0
        elif self.exponent == 2.0:
            share = sqrt(1.0 - used * used)
        elif self.exponent == 1.0:
            share = 1.0 - used
        else:
            share = (1.0 - used**self.exponent) ** (1.0 / self.exponent)
        if self.longitudinal_grip is None:
            return most * share
        held = self.longitudinal_grip * share
        return held if held < most else most

    def reach(self, over: OverSpeed, start: _Place, end: _Place, length: float) -> float:
        """Return the largest square of the speed that is reached over `length` [m]."""
        squared, curvature = start
        bound, at_end = end
        if bound <= squared:
            return bound
        room = 2.0 * self.available(over, squared, curvature) * length
        high = squared + room
        if high > bound:
            high = bound

        def beyond(end: float) -> float:
            # How far an end lies beyond what its own limit allows.
            return end - squared - 2.0 * self.available(over, end, at_end) * length

        above = beyond(high)
        if above <= ROOT_TOLERANCE * high:
            return high
        # The Illinois variant of false position. `low` always holds.
        low = squared
        below = beyond(low)
        side = 0
        for _ in range(ROOT_STEPS):
            if high - low <= ROOT_TOLERANCE * high or below >= 0.0:
                break
            middle = high - above * (high - low) / (above - below)
            value = beyond(middle)
            if value <= 0.0:
                low = middle
                below = value
                if side < 0:
                    above *= 0.5
                side = -1
            else:
                high = middle
                above = value
                if side > 0:
                    below *= 0.5
                side = 1
        return low

    def in_time(self, start: float, end: float, length: float, most: float) -> float:
        """Return the largest speed at which the wheels turn in time for a segment [m/s].

        wheel' = v (κ' L(v) + κ L'(v) a) / (1 + (κ L)²), bounded from above over the segment and
        over the acceleration; `most` where that is no limit.
        """
        rate = self.vehicle.max_steer_rate
        if rate is None:
            return most
        base = self.vehicle.turning_length(0.0)
        bend = abs(end - start) / length
        one, other = abs(start), abs(end)
        least, largest = (one, other) if one < other else (other, one)
        if not start * end > 0.0:
            least = 0.0
        easing = 1.0 + least * base * least * base
        understeer = self.vehicle.understeer
        driving, braking = self.acceleration.most(), self.deceleration.most()
        strongest = driving if driving > braking else braking
        shift = 2.0 * understeer * strongest * largest

        def turns(speed: float) -> float:
            return speed * (bend * (base + understeer * speed * speed) + shift) / easing

        if turns(most) <= rate:
            return most
        low, high = 0.0, most
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            if turns(middle) <= rate:
                low = middle
            else:
                high = middle
        return low


_Place = tuple[float, float]
"""The square of the speed at a waypoint [m²/s²], and the curvature there [1/m]."""


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


def _check(field: str, value: float, low: float, high: float) -> None:
    """Raise `ConfigError` for a number that is not in [low, high]."""
    if not in_range(value, low, high):
        raise errors.ConfigError(field, value, errors.in_range(low, high))
