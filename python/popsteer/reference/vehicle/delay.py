"""The commands in flight: given, but not yet at the wheels.

A controller that steers by the present vehicle, while its last commands are still in flight, steers
too late. `InFlight.predict` rolls the vehicle forward through them, so that the controller steers
by its state when the next command reaches the wheels.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING

from popsteer.reference.error import input_in_range, input_within
from popsteer.reference.math import PI, saturate
from popsteer.reference.vehicle.bicycle import Rollout
from popsteer.reference.vehicle.timed import (
    Timed,
    checked_count,
    checked_entries,
    clipped,
    push_or_join,
    take,
)
from popsteer.reference.vehicle.wheels import WheelIntegrals, move_wheel

if TYPE_CHECKING:
    from popsteer.reference.vehicle import Vehicle
    from popsteer.reference.vehicle.estimate import Corrections
    from popsteer.reference.vehicle.state import VehicleState

__all__ = ["InFlight"]

RESOLUTION = 64
"""Commands are remembered apart down to this share of the dead time."""
CAPACITY = 3 * RESOLUTION + 4
"""The most commands in flight; shorter ones are joined, see `InFlight.elapse`."""


@dataclass(frozen=True)
class InFlight:
    """The commands that are given but have not reached the wheels, and the wheels.

    Attributes
    ----------
    commands : tuple of tuple of float
        Oldest first: angle [rad] and how long it was commanded [s].
    wheel : float
        Angle of the wheels by the vehicle's parameters, without an estimated offset [rad].

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

    commands: Timed
    wheel: float

    @classmethod
    def settled(cls, vehicle: Vehicle, steer: float) -> InFlight:
        """Return the wheels at rest under the command `steer` [rad], and that command in flight."""
        most = vehicle.max_steer
        wheel = saturate(steer + vehicle.steer_offset, -most, most)
        return cls(((steer, vehicle.dead_time),) if vehicle.dead_time > 0.0 else (), wheel)

    @classmethod
    def restore(cls, vehicle: Vehicle, commands: Timed, wheel: float, longer: float) -> InFlight:
        """Return commands in flight as they were.

        With a dead time that is `longer` than the vehicle's by so much [s].

        Raises
        ------
        InputError
            Where there are too many commands, and as `checked`.
        """
        commands = checked_count("commands_in_flight", commands, CAPACITY)
        return cls(commands, wheel).checked(vehicle, longer)

    def checked(self, vehicle: Vehicle, longer: float) -> InFlight:
        """Return the commands, as floats, where they can be in flight to the vehicle's wheels.

        Raises
        ------
        InputError
            Where they cannot: an angle beyond a quarter turn, a duration that is none, durations
            that do not add up to the dead time.
        """
        field = "commands_in_flight"
        wheel = input_within("wheel", self.wheel, 0.5 * PI)
        dead_time = vehicle.dead_time + longer
        slack = 1e-9 * (1.0 + dead_time)
        commands = checked_entries(field, self.commands, dead_time + slack)
        total = 0.0
        for _, duration in commands:
            total += duration
        input_in_range(field, total, dead_time - slack, dead_time + slack)
        return InFlight(commands, wheel)

    def reaching(self, vehicle: Vehicle, last: float, dt: float) -> WheelIntegrals:
        """Return what reaches the wheels in `dt` [s] after `last` [rad] was commanded."""
        reached, wheel = WheelIntegrals(), self.wheel
        for steer, time in clipped((*self.commands, (last, dt)), dt):
            moved = move_wheel(vehicle, wheel, steer, time)
            reached = reached.plus(moved.mean, time)
            wheel = moved.wheel
        return reached

    def elapse(self, vehicle: Vehicle, last: float, dt: float, longer: float) -> InFlight:
        """Let `dt` [s] pass since `last` [rad] was commanded.

        It takes flight, and the oldest commands reach the wheels. With a dead time that turns out
        `longer` by so much [s] they reach them later. Commands shorter than a 64th of the dead
        time are joined to their mean.
        """
        gone = dt - longer
        is_full = len(self.commands) == CAPACITY
        joined = inf if is_full else vehicle.dead_time / RESOLUTION
        commands = push_or_join(self.commands, last, dt, joined, CAPACITY)
        wheel = self.wheel
        while gone > 0.0 and commands:
            (steer, time), commands = take(commands, gone)
            wheel = move_wheel(vehicle, wheel, steer, time).wheel
            gone -= time
        return InFlight(commands, wheel)

    def predict(
        self, vehicle: Vehicle, state: VehicleState, estimate: Corrections
    ) -> tuple[VehicleState, float]:
        """Return vehicle and wheels as they will be when a command given now reaches the wheels.

        The vehicle is rolled forward through the commands in flight. The state is that of the
        no-slip point; the `estimate` corrects `vehicle`.
        """
        rollout = Rollout(vehicle, estimate, state)
        wheel = rollout.drive(self.wheel, self.commands)
        return rollout.state, wheel
