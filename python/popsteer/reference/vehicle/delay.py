"""The commands in flight: what lies between a command and the wheels.

A controller that steers by the vehicle of now while its last commands are still in flight steers
too late. `InFlight.predict` rolls the vehicle forward through them, so that the controller sees it
as it will be when its next command reaches the wheels.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import copysign
from typing import TYPE_CHECKING, NamedTuple

from popsteer import errors
from popsteer.reference.error import input_in_range
from popsteer.reference.math import PI, ceil, decay, divide, saturate, tan
from popsteer.reference.vehicle.bicycle import advance

if TYPE_CHECKING:
    from popsteer.reference.vehicle import Vehicle
    from popsteer.reference.vehicle.estimator import Corrections
    from popsteer.reference.vehicle.state import VehicleState

__all__ = ["Commands", "InFlight", "Moved", "Reached", "move_wheel"]

Commands = tuple[tuple[float, float], ...]
"""Angles [rad], each with how long it was commanded [s]."""

RESOLUTION = 64
"""Commands are remembered apart down to this share of the dead time."""
CAPACITY = 3 * RESOLUTION + 4
"""The most commands in flight; shorter ones are joined, see `InFlight.elapse`."""
STEP = 0.05
"""The longest step of the prediction [s]."""


class Moved(NamedTuple):
    """Where the wheels come to, and their mean angle on the way."""

    wheel: float
    """Angle at the end [rad]."""
    mean: float
    """Mean angle [rad]."""


def move_wheel(vehicle: Vehicle, wheel: float, command: float, time: float) -> Moved:
    """Move the wheels from the angle `wheel` [rad] under a command that reaches them.

    A first-order response whose rate is limited, solved exactly. Farther from the commanded angle
    than max_steer_rate steer_lag the wheels turn at their rate, nearer they approach it
    exponentially.

    Parameters
    ----------
    vehicle : Vehicle
        Its steer_offset, steer_lag, max_steer and max_steer_rate count.
    wheel : float
        Angle of the wheels at the start [rad].
    command : float
        The command [rad].
    time : float
        How long it acts [s].

    Returns
    -------
    Moved
        The angle at the end, and the mean one [rad].

    Examples
    --------
    >>> from popsteer.reference import Vehicle
    >>> move_wheel(Vehicle(steer_lag=0.0, max_steer_rate=0.5), 0.0, 1.0, 0.5)
    Moved(wheel=0.25, mean=0.125)
    """
    lag, rate = vehicle.steer_lag, vehicle.max_steer_rate
    target = saturate(command + vehicle.steer_offset, -vehicle.max_steer, vehicle.max_steer)
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
        return Moved(
            rest.wheel,
            share * (0.5 * (wheel + start)) + (1.0 - share) * rest.mean,
        )
    return _approach(lag, wheel, target, time)


def _approach(lag: float, wheel: float, target: float, time: float) -> Moved:
    """Solve the exponential part of the response."""
    kept = decay(time, lag)
    excess = wheel - target
    return Moved(target + excess * kept, target + excess * (lag * (1.0 - kept) / time))


class Reached(NamedTuple):
    """What reached the wheels in a period: integrals over the time.

    They are for the speed 1 m/s and the turning length 1 m.
    """

    turn: float
    """Of tan(wheel) [s]."""
    slope: float
    """Of its derivative by the angle [s]."""


@dataclass(frozen=True)
class InFlight:
    """The commands that are given but have not reached the wheels, and the wheels.

    Attributes
    ----------
    commands : tuple of tuple of float
        Oldest first: angle [rad] and how long it was commanded [s].
    wheel : float
        Angle of the wheels by the vehicle's own figures, without an estimated offset [rad].

    Examples
    --------
    >>> from popsteer.reference import Vehicle
    >>> car = Vehicle(dead_time=0.25, steer_lag=0.0)
    >>> in_flight = InFlight.settled(car, 0.0)
    >>> for _ in range(3):
    ...     in_flight = in_flight.elapse(car, last=0.5, dt=0.125, longer=0.0)
    >>> in_flight
    InFlight(commands=((0.5, 0.125), (0.5, 0.125)), wheel=0.5)
    """

    commands: Commands
    wheel: float

    @classmethod
    def settled(cls, vehicle: Vehicle, steer: float) -> InFlight:
        """Return the wheels at rest under the command `steer` [rad], and that command in flight."""
        most = vehicle.max_steer
        wheel = saturate(steer + vehicle.steer_offset, -most, most)
        return cls(((steer, vehicle.dead_time),) if vehicle.dead_time > 0.0 else (), wheel)

    @classmethod
    def restore(cls, vehicle: Vehicle, commands: Commands, wheel: float, longer: float) -> InFlight:
        """Return commands in flight as they were.

        With a dead time that is `longer` than the vehicle's by so much [s].

        Raises
        ------
        InputError
            Where there are too many commands, and as `checked`.
        """
        count = len(commands)
        if count > CAPACITY:
            raise errors.InputError("commands_in_flight", count, errors.count_in_range(0, CAPACITY))
        return cls(commands, wheel).checked(vehicle, longer)

    def checked(self, vehicle: Vehicle, longer: float) -> InFlight:
        """Return the commands, as floats, where they can be in flight to the vehicle's wheels.

        Raises
        ------
        InputError
            Where they cannot: an angle beyond a quarter turn, a duration that is none, durations
            that do not add up to the dead time.
        """
        limit = 0.5 * PI
        field = "commands_in_flight"
        wheel = input_in_range("wheel", self.wheel, -limit, limit)
        dead_time = vehicle.dead_time + longer
        slack = 1e-9 * (1.0 + dead_time)
        total = 0.0
        commands = []
        for each in self.commands:
            steer = input_in_range(field, each[0], -limit, limit)
            duration = input_in_range(field, each[1], 0.0, dead_time + slack)
            commands.append((steer, duration))
            total += duration
        input_in_range(field, total, dead_time - slack, dead_time + slack)
        return InFlight(tuple(commands), wheel)

    def reaching(self, vehicle: Vehicle, last: float, dt: float) -> Reached:
        """Return what reaches the wheels in `dt` [s] after `last` [rad] was commanded."""
        turn, slope = 0.0, 0.0
        wheel, gone = self.wheel, dt
        for steer, duration in (*self.commands, (last, dt)):
            if gone <= 0.0:
                break
            part = duration if duration < gone else gone
            moved = move_wheel(vehicle, wheel, steer, part)
            tangent = tan(moved.mean)
            turn += part * tangent
            slope += part * (1.0 + tangent * tangent)
            wheel = moved.wheel
            gone -= part
        return Reached(turn, slope)

    def elapse(self, vehicle: Vehicle, last: float, dt: float, longer: float) -> InFlight:
        """Let `dt` [s] pass since `last` [rad] was commanded.

        It takes flight, and the oldest commands reach the wheels. With a dead time that turns out
        `longer` by so much [s] they reach them later. Commands shorter than a 64th of the dead
        time are joined to their mean.
        """
        gone = dt - longer
        joined = vehicle.dead_time / RESOLUTION
        commands = list(self.commands)
        if commands and commands[-1][1] + dt <= joined:
            steer, duration = commands[-1]
            total = duration + dt
            mean = (steer * duration + last * dt) / total
            commands[-1] = (mean, total)
        else:
            commands.append((last, dt))
        wheel = self.wheel
        while gone > 0.0 and commands:
            steer, duration = commands[0]
            if duration > gone:
                wheel = move_wheel(vehicle, wheel, steer, gone).wheel
                commands[0] = (steer, duration - gone)
                break
            wheel = move_wheel(vehicle, wheel, steer, duration).wheel
            commands.pop(0)
            gone -= duration
        return InFlight(tuple(commands), wheel)

    def predict(
        self, vehicle: Vehicle, state: VehicleState, estimate: Corrections
    ) -> tuple[VehicleState, float]:
        """Return vehicle and wheels as they will be when a command given now reaches the wheels.

        The vehicle is rolled forward through the commands in flight. The state is that of the
        point that does not slip; what the `estimate` knows better than `vehicle` counts.
        """
        start, time = state.speed, 0.0
        wheel = self.wheel
        length = vehicle.turning_length(state.speed) / estimate.gain
        for steer, duration in self.commands:
            steps = ceil(duration / STEP)
            step = divide(duration, steps)
            for _ in range(steps):
                moved = move_wheel(vehicle, wheel, steer, step)
                time += step
                speed = estimate.speed_after(start, time)
                travel = 0.5 * (state.speed + speed) * step
                angle = vehicle.at_wheels(moved.mean + estimate.steer_offset)
                curvature = tan(angle) / length
                slip = estimate.slip + estimate.slip_length * curvature
                state = replace(advance(state, travel, curvature, slip), speed=speed)
                wheel = moved.wheel
        return state, wheel
