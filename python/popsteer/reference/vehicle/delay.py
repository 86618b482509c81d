"""The commands in flight: given, but not yet at the wheels.

A controller that steers by the present vehicle, while its last commands are still in flight, steers
too late. `InFlight.predict` rolls the vehicle forward through them, so that the controller steers
by its state when the next command reaches the wheels.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING

from popsteer.reference.vehicle.bicycle import Rollout
from popsteer.reference.vehicle.wheels import move_wheel

if TYPE_CHECKING:
    from popsteer.reference.vehicle import Vehicle
    from popsteer.reference.vehicle.estimate import Estimate
    from popsteer.reference.vehicle.state import VehicleState

RESOLUTION = 64
"""Commands are remembered apart down to this share of the dead time."""
CAPACITY = 3 * RESOLUTION + 4
"""The most commands in flight; shorter ones are joined, see `InFlight.elapse`."""

Timed = tuple[tuple[float, float], ...]
"""Angles [rad], oldest first, and how long each lasts [s]."""


@dataclass(frozen=True)
class InFlight:
    """The commands that are given but have not reached the wheels, and the wheels."""

    commands: Timed  # oldest first: angle [rad] and how long it was commanded [s]
    wheel: float  # angle by the vehicle's parameters, without an estimated offset [rad]

    @classmethod
    def settled(cls, vehicle: Vehicle, steer: float) -> InFlight:
        """Return the wheels at rest under the command `steer` [rad], and that command in flight."""
        wheel = vehicle.at_wheels(steer + vehicle.steer_offset)
        return cls(((steer, vehicle.dead_time),) if vehicle.dead_time > 0.0 else (), wheel)

    def elapse(self, vehicle: Vehicle, last: float, dt: float) -> InFlight:
        """Let `dt` [s] pass since `last` [rad] was commanded.

        It takes flight, and the oldest commands reach the wheels. Commands shorter than a 64th of
        the dead time are joined to their mean.
        """
        is_full = len(self.commands) == CAPACITY
        joined = inf if is_full else vehicle.dead_time / RESOLUTION
        commands = _push(self.commands, last, dt, joined)
        wheel, gone = self.wheel, dt
        while gone > 0.0 and commands:
            (steer, time), commands = _take(commands, gone)
            wheel = move_wheel(vehicle, wheel, steer, time).wheel
            gone -= time
        return InFlight(commands, wheel)

    def predict(
        self, vehicle: Vehicle, state: VehicleState, estimate: Estimate
    ) -> tuple[VehicleState, float]:
        """Return vehicle and wheels as they will be when a command given now reaches the wheels.

        The vehicle is rolled forward through the commands in flight. The state is that of the
        no-slip point; the `estimate` corrects `vehicle`.
        """
        rollout = Rollout(vehicle, estimate, state)
        wheel = rollout.drive(self.wheel, self.commands)
        return rollout.state, wheel


def _push(timed: Timed, angle: float, duration: float, shortest: float) -> Timed:
    """Add an angle, or join it to the newest where both last `shortest` [s] at most: their mean.

    Examples
    --------
    >>> _push(((1.0, 0.25),), 4.0, 0.5, 0.75)
    ((3.0, 0.75),)
    >>> _push(((1.0, 0.5), (2.0, 0.5)), 4.0, 0.5, 0.75)
    ((1.0, 0.5), (2.0, 0.5), (4.0, 0.5))
    """
    if timed:
        mean, lasted = timed[-1]
        total = lasted + duration
        if total <= shortest:
            # Written so, it lies between the two however short they are.
            return (*timed[:-1], (mean + (angle - mean) * (duration / total), total))
    return (*timed, (angle, duration))


def _take(timed: Timed, time: float) -> tuple[tuple[float, float], Timed]:
    """Take off the oldest angle, or the first `time` [s] of one that lasts longer."""
    angle, duration = timed[0]
    if duration > time:
        return (angle, time), ((angle, duration - time), *timed[1:])
    return (angle, duration), timed[1:]
