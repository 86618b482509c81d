"""What lies between a command and the wheels: dead time, a first-order lag, a rate limit.

A law that steers by the vehicle of now while its last commands are still under way steers too
late. `predict` rolls the vehicle forward through them, so that the law sees it as it will be when
the next command arrives.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from popsteer import errors
from popsteer.reference.error import config_in_range, input_in_range
from popsteer.reference.math import PI, ceil, decay, saturate, tan
from popsteer.reference.vehicle.predict import kinematic_bicycle
from popsteer.reference.vehicle.state import VehicleState

if TYPE_CHECKING:
    from popsteer.reference.vehicle.learning import Learnt

__all__ = [
    "CAPACITY",
    "Actuator",
    "UnderWay",
    "elapse",
    "learn",
    "limit",
    "predict",
    "restore",
    "settled",
]

RESOLUTION = 128
"""Commands are remembered apart down to this share of the dead time."""
CAPACITY = 3 * RESOLUTION + 4
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
    learning_time : float
        Time over which is learnt, from the way of the vehicle, how much more it turns than the
        model says, how much longer the dead time is, and how its speed changes [s]; 0 never.

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
    learning_time: float = 0.0

    def __post_init__(self) -> None:
        config_in_range(self, "dead_time", 0.0, 10.0)
        config_in_range(self, "lag", 0.0, 10.0)
        if self.max_rate is not None:
            config_in_range(self, "max_rate", 1e-3, 1e6)
        config_in_range(self, "wheelbase", 1e-3, 1e3)
        config_in_range(self, "understeer", 0.0, 1e3)
        config_in_range(self, "learning_time", 0.0, 1e6)

    @property
    def most_delay(self) -> float:
        """How far a learnt dead time may be from the one given [s]."""
        return 0.5 * self.dead_time


def settled(actuator: Actuator, steer: float) -> UnderWay:
    """Return what is under way while the wheels rest at the angle `steer` [rad].

    Examples
    --------
    >>> settled(Actuator(dead_time=0.2), 0.1)
    ((0.1, 0.2),)
    """
    return ((steer, actuator.dead_time),) if actuator.dead_time > 0.0 else ()


def restore(
    actuator: Actuator, under_way: UnderWay, wheel: float, learnt: Learnt
) -> tuple[UnderWay, float, Learnt]:
    """Return commands under way, the angle of the wheels and what was learnt, if they can be so.

    Raises
    ------
    InputError
        Naming what cannot.
    """
    quarter = PI / 2.0
    if len(under_way) > CAPACITY:
        raise errors.InputError("under_way", len(under_way), errors.count_in_range(0, CAPACITY))
    wheel = input_in_range("wheel", wheel, -quarter, quarter)
    learnt = learnt.checked(actuator.most_delay)
    dead_time = actuator.dead_time + learnt.delay
    slack = 1e-9 * (1.0 + dead_time)
    total = 0.0
    for steer, duration in under_way:
        input_in_range("under_way", steer, -quarter, quarter)
        input_in_range("under_way", duration, 0.0, dead_time + slack)
        total += duration
    input_in_range("under_way", total, dead_time - slack, dead_time + slack)
    line = tuple((float(steer), float(duration)) for steer, duration in under_way)
    return line, wheel, learnt


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


def learn(
    actuator: Actuator,
    under_way: UnderWay,
    wheel: float,
    learnt: Learnt,
    last: float,
    vehicle: VehicleState,
    dt: float,
) -> Learnt:
    """Learn from `vehicle` as it is seen `dt` [s] after `last` was commanded.

    Examples
    --------
    >>> from popsteer.reference.vehicle.learning import Learnt
    >>> vehicle = VehicleState(0.0, 0.0, 0.1, 10.0)
    >>> learn(Actuator(learning_time=10.0), (), 0.0, Learnt(), 0.0, vehicle, 0.05).seen
    (0.1, 10.0)
    """
    if actuator.learning_time <= 0.0:
        return learnt
    before = vehicle.speed if learnt.seen is None else learnt.seen[1]
    speed = 0.5 * (before + vehicle.speed)
    wheelbase = actuator.wheelbase + actuator.understeer * speed * speed
    turn, gone = 0.0, dt
    for steer, duration in (*under_way, (last, dt)):
        part = min(duration, gone)
        turn += part * tan(_follow(actuator, wheel, steer, 0.5 * part))
        wheel = _follow(actuator, wheel, steer, part)
        gone -= part
    turn = turn * speed / wheelbase
    return learnt.after(vehicle, turn, dt, actuator.learning_time, actuator.most_delay)


def predict(
    actuator: Actuator,
    under_way: UnderWay,
    wheel: float,
    known: Learnt,
    last: float,
    vehicle: VehicleState,
    dt: float,
    learnt: Learnt,
) -> VehicleState:
    """Predict the vehicle at the time when a command given now reaches the wheels.

    If its acceleration stays as `learnt` since it was `known`: rolled forward through the commands
    `under_way` and `last`, the one given `dt` [s] ago, by a kinematic bicycle whose wheels follow
    them with the lag.

    Examples
    --------
    >>> from popsteer.reference.vehicle.learning import Learnt
    >>> actuator = Actuator(dead_time=0.2)
    >>> vehicle = VehicleState(0.0, 0.0, 0.0, 10.0)
    >>> line = settled(actuator, 0.0)
    >>> predict(actuator, line, 0.0, Learnt(), 0.0, vehicle, 0.05, Learnt()).x
    2.0
    """
    speed = vehicle.speed
    wheelbase = actuator.wheelbase + actuator.understeer * speed * speed
    wheelbase = wheelbase / learnt.gain()
    # What reached the wheels since the last step moved them, and the vehicle is where it is.
    gone = _arrived(known, dt, learnt)
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
                pace = learnt.speed_after(speed, 0.5 * step)
                x, y, yaw, _ = kinematic_bicycle(
                    vehicle.x, vehicle.y, vehicle.yaw, pace, middle, 0.0, wheelbase, step
                )
                speed = learnt.speed_after(speed, step)
                vehicle = VehicleState(x, y, yaw, speed)
                wheel = _follow(actuator, wheel, steer, step)
    return vehicle


def elapse(
    actuator: Actuator,
    under_way: UnderWay,
    wheel: float,
    known: Learnt,
    last: float,
    dt: float,
    learnt: Learnt,
) -> tuple[UnderWay, float]:
    """Let `dt` [s] pass since `last` was commanded; return what is under way, and the wheels.

    `last` goes on its way, and the oldest commands reach the wheels. Commands shorter than a
    128th of the dead time are joined to their mean. A dead time that is `learnt` to be longer than
    it was `known` to be keeps commands under way for longer.

    Examples
    --------
    >>> from popsteer.reference.vehicle.learning import Learnt
    >>> line, nothing = ((0.1, 0.125), (0.2, 0.125)), Learnt()
    >>> elapse(Actuator(dead_time=0.25), line, 0.0, nothing, 0.3, 0.125, nothing)
    (((0.2, 0.125), (0.3, 0.125)), 0.1)
    """
    gone = _arrived(known, dt, learnt)
    line = list(under_way)
    joined = actuator.dead_time / RESOLUTION
    if line and line[-1][1] + dt <= joined:
        steer, duration = line[-1]
        total = duration + dt
        line[-1] = ((steer * duration + last * dt) / total, total)
    else:
        line.append((last, dt))
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


def _arrived(known: Learnt, dt: float, learnt: Learnt) -> float:
    """Tell for how long commands have reached the wheels in `dt` [s], by what is learnt since."""
    return dt - (learnt.delay - known.delay)


def _follow(actuator: Actuator, wheel: float, steer: float, time: float) -> float:
    """Return the wheels from `wheel` after `time` [s] of the command `steer`."""
    reached = steer + (wheel - steer) * decay(time, actuator.lag)
    return limit(actuator, wheel, reached, time) if time > 0.0 else wheel
