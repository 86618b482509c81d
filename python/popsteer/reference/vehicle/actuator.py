"""What lies between a command and the wheels: dead time, a first-order lag, a rate limit.

A law that steers by the vehicle of now while its last commands are still under way steers too
late. `predict` rolls the vehicle forward through them, so that the law sees it as it will be when
the next command arrives.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from popsteer import errors
from popsteer.reference.error import config_in_range, input_in_range
from popsteer.reference.math import PI, ceil, decay, saturate
from popsteer.reference.vehicle.predict import kinematic_bicycle
from popsteer.reference.vehicle.state import VehicleState

__all__ = ["CAPACITY", "Actuator", "UnderWay", "elapse", "limit", "predict", "restore", "settled"]

RESOLUTION = 128
"""Commands are remembered apart down to this share of the dead time."""
CAPACITY = 2 * RESOLUTION + 4
"""The most commands under way."""
STEP = 0.05
"""The longest step of the prediction [s]."""

UnderWay: TypeAlias = tuple[tuple[float, float], ...]
"""Commands on their way to the wheels, oldest first: angle [rad] and duration [s]."""


@dataclass(frozen=True, kw_only=True)
class Actuator:
    """How commands come to the wheels, and what the vehicle does meanwhile.

    Attributes
    ----------
    dead_time : float
        Time from a command to its first effect on the wheels [s].
    lag : float
        Time constant with which the wheels then follow it [s]; a lag of the yaw rate counts here
        as well.
    max_rate : float or None
        Fastest move of the wheels [rad/s]; None for no limit.
    wheelbase : float
        Distance of the axles of the vehicle that is predicted [m].
    understeer : float
        Understeer of that vehicle [s²/m]: its yaw rate is v tan δ / (L + K v²).

    Raises
    ------
    ConfigError
        Naming the parameter that is out of its range.

    Examples
    --------
    >>> Actuator(dead_time=0.2).lag
    0.0
    """

    dead_time: float = 0.0
    lag: float = 0.0
    max_rate: float | None = None
    wheelbase: float = 3.0
    understeer: float = 0.0

    def __post_init__(self) -> None:
        config_in_range(self, "dead_time", 0.0, 10.0)
        config_in_range(self, "lag", 0.0, 10.0)
        if self.max_rate is not None:
            config_in_range(self, "max_rate", 1e-3, 1e6)
        config_in_range(self, "wheelbase", 1e-3, 1e3)
        config_in_range(self, "understeer", 0.0, 1e3)


def settled(actuator: Actuator, steer: float) -> UnderWay:
    """Return what is under way while the wheels rest at the angle `steer` [rad].

    Examples
    --------
    >>> settled(Actuator(dead_time=0.2), 0.1)
    ((0.1, 0.2),)
    """
    return ((steer, actuator.dead_time),) if actuator.dead_time > 0.0 else ()


def restore(actuator: Actuator, under_way: UnderWay, wheel: float) -> tuple[UnderWay, float]:
    """Return commands under way and the angle of the wheels, where they can have been so.

    Raises
    ------
    InputError
        Naming what cannot.
    """
    quarter = PI / 2.0
    if len(under_way) > CAPACITY:
        raise errors.InputError("under_way", len(under_way), errors.count_in_range(0, CAPACITY))
    wheel = input_in_range("wheel", wheel, -quarter, quarter)
    slack = 1e-9 * (1.0 + actuator.dead_time)
    total = 0.0
    for steer, duration in under_way:
        input_in_range("under_way", steer, -quarter, quarter)
        input_in_range("under_way", duration, 0.0, actuator.dead_time + slack)
        total += duration
    input_in_range("under_way", total, actuator.dead_time - slack, actuator.dead_time + slack)
    return tuple((float(steer), float(duration)) for steer, duration in under_way), wheel


def limit(actuator: Actuator, last: float, wanted: float, dt: float) -> float:
    """Return the angle to command where `wanted` is wanted `dt` [s] after `last`.

    Examples
    --------
    >>> limit(Actuator(max_rate=0.5), 0.0, -1.0, 0.1)
    -0.05
    """
    if actuator.max_rate is None:
        return wanted
    move = actuator.max_rate * dt
    return saturate(wanted, last - move, last + move)


def predict(
    actuator: Actuator,
    under_way: UnderWay,
    wheel: float,
    last: float,
    vehicle: VehicleState,
    dt: float,
) -> VehicleState:
    """Predict the vehicle at the time when a command given now reaches the wheels.

    At its present speed, rolled forward through the commands `under_way` and `last`, the one
    given `dt` [s] ago, by a kinematic bicycle whose wheels follow them with the lag.

    Examples
    --------
    >>> actuator = Actuator(dead_time=0.2)
    >>> vehicle = VehicleState(0.0, 0.0, 0.0, 10.0)
    >>> predict(actuator, settled(actuator, 0.0), 0.0, 0.0, vehicle, 0.05).x
    2.0
    """
    speed = vehicle.speed
    wheelbase = actuator.wheelbase + actuator.understeer * speed * speed
    # What reached the wheels since the last step moved them, and the vehicle is where it is.
    gone = dt
    for steer, duration in (*under_way, (last, dt)):
        part = min(duration, gone)
        wheel = _follow(actuator, wheel, steer, part)
        gone -= part
        left = duration - part
        if left > 0.0:
            steps = ceil(left / STEP)
            step = left / steps
            for _ in range(steps):
                middle = _follow(actuator, wheel, steer, 0.5 * step)
                x, y, yaw, _ = kinematic_bicycle(
                    vehicle.x, vehicle.y, vehicle.yaw, speed, middle, 0.0, wheelbase, step
                )
                vehicle = VehicleState(x, y, yaw, speed)
                wheel = _follow(actuator, wheel, steer, step)
    return vehicle


def elapse(
    actuator: Actuator, under_way: UnderWay, wheel: float, last: float, dt: float
) -> tuple[UnderWay, float]:
    """Let `dt` [s] pass since `last` was commanded; return what is under way, and the wheels.

    `last` goes on its way, and the oldest commands reach the wheels. Commands shorter than a
    128th of the dead time are joined to their mean.

    Examples
    --------
    >>> elapse(Actuator(dead_time=0.25), ((0.1, 0.125), (0.2, 0.125)), 0.0, 0.3, 0.125)
    (((0.2, 0.125), (0.3, 0.125)), 0.1)
    """
    line = list(under_way)
    joined = actuator.dead_time / RESOLUTION
    if line and line[-1][1] + dt <= joined:
        steer, duration = line[-1]
        total = duration + dt
        line[-1] = ((steer * duration + last * dt) / total, total)
    else:
        line.append((last, dt))
    gone = dt
    while gone > 0.0 and line:
        steer, duration = line[0]
        if duration > gone:
            wheel = _follow(actuator, wheel, steer, gone)
            line[0] = (steer, duration - gone)
            break
        wheel = _follow(actuator, wheel, steer, duration)
        line.pop(0)
        gone -= duration
    return tuple(line), wheel


def _follow(actuator: Actuator, wheel: float, steer: float, time: float) -> float:
    """Return the wheels from `wheel` after `time` [s] of the command `steer`."""
    reached = steer + (wheel - steer) * decay(time, actuator.lag)
    return limit(actuator, wheel, reached, time) if time > 0.0 else wheel
