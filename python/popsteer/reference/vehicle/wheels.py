"""The wheels: their response to a command."""

from __future__ import annotations

from math import copysign
from typing import TYPE_CHECKING, NamedTuple

from popsteer.reference.math import decay

if TYPE_CHECKING:
    from popsteer.reference.vehicle import Vehicle


class Moved(NamedTuple):
    """The wheels' angle after a move, and their mean angle during it."""

    wheel: float  # angle at the end [rad]
    mean: float  # mean angle [rad]


def move_wheel(vehicle: Vehicle, wheel: float, command: float, time: float) -> Moved:
    """Move the wheels from the angle `wheel` [rad] under a command that reaches them.

    A first-order response whose rate is limited, solved exactly. Farther from the commanded angle
    than max_steer_rate steer_lag the wheels turn at their rate, nearer they approach it
    exponentially.

    The `command` [rad] acts for `time` [s].

    Examples
    --------
    >>> from popsteer.reference import Vehicle
    >>> move_wheel(Vehicle(steer_lag=0.0, max_steer_rate=0.5), 0.0, 1.0, 0.5)
    Moved(wheel=0.25, mean=0.125)
    """
    lag, rate = vehicle.steer_lag, vehicle.max_steer_rate
    target = vehicle.at_wheels(command + vehicle.steer_offset)
    if time <= 0.0:
        return Moved(wheel, wheel)
    gap = target - wheel
    if rate is not None and abs(gap) > rate * lag:
        knee = copysign(rate * lag, gap)
        ramp = abs(gap - knee) / rate
        if ramp >= time:
            turned = copysign(rate * time, gap)
            return Moved(wheel + turned, wheel + 0.5 * turned)
        start = target - knee
        rest = _approach(lag, start, target, time - ramp)
        share = ramp / time
        mean = share * (0.5 * (wheel + start)) + (1.0 - share) * rest.mean
        return Moved(rest.wheel, mean)
    return _approach(lag, wheel, target, time)


def _approach(lag: float, wheel: float, target: float, time: float) -> Moved:
    """Solve the exponential part of the response."""
    kept = decay(time, lag)
    excess = wheel - target
    return Moved(target + excess * kept, target + excess * (lag * (1.0 - kept) / time))
