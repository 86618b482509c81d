"""What limits the speed, and how far a limit lets the speed change."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, NamedTuple

from popsteer.ranges import check_in_range
from popsteer.reference.math import sqrt

if TYPE_CHECKING:
    from collections.abc import Sequence

    from popsteer.reference.vehicle import Vehicle

__all__ = ["Limits", "OverSpeed"]

ROOT_STEPS = 60
"""The most steps towards a root."""
ROOT_TOLERANCE = 1e-13
"""How near to a root is near enough, as a share of the square of the speed."""
BISECTIONS = 40
"""Halvings of a speed."""


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
            check_in_range(field, speed, 0.0, 1e4)
            # Speeds that do not increase are refused by the least that would do.
            check_in_range(field, speed, max(0.0, before + 1e-6), 1e4)
            before = speed
        for value in self.values:
            check_in_range(field, value, 1e-3, 1e3)
        check_in_range(field, self.most(), 1e-3, 1e3)


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
        check_in_range("max_speed", self.max_speed, 1e-3, 1e4)
        check_in_range("max_lateral_acceleration", self.max_lateral_acceleration, 1e-3, 1e3)
        self.acceleration.check("max_acceleration")
        self.deceleration.check("max_deceleration")
        if self.longitudinal_grip is not None:
            check_in_range("longitudinal_grip", self.longitudinal_grip, 1e-3, 1e3)
        check_in_range("exponent", self.exponent, 1.0, inf)

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
