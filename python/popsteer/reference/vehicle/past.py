"""The recent angles of the wheels, to roll an old pose forward to the present.

A localisation has a delay of its own, besides that of the steering. `Past.advance` rolls the
vehicle forward from where it was measured, through the angles of its wheels since.
"""

from __future__ import annotations

from dataclasses import dataclass
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
)
from popsteer.reference.vehicle.wheels import WheelIntegrals, move_wheel

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from popsteer.reference.vehicle import Vehicle
    from popsteer.reference.vehicle.estimate import Corrections
    from popsteer.reference.vehicle.state import VehicleState

__all__ = ["MAX_POSE_AGE", "Past"]

MAX_POSE_AGE = 1.0
"""The oldest pose that a step takes [s]."""
RESOLUTION = 64
"""Angles are remembered apart down to this share of `MAX_POSE_AGE`.

A 32nd would halve the memory, but preview POP at 100 Hz on poses 0.1 s old then keeps within 11 mm
of its path instead of 3 mm (root mean square).
"""
CAPACITY = 2 * RESOLUTION + 2
"""The most angles.

Two neighbours are together longer than a share, so half as many shares are remembered.
"""
MAX_SINCE = 1e6
"""Bound of the time since the last pose [s], which no valid input reaches."""


@dataclass(frozen=True)
class Past:
    """The angles of the wheels by the vehicle's parameters over the last second.

    Attributes
    ----------
    angles : tuple of tuple of float
        Oldest first: mean angle [rad] and for how long [s].
    wheel : float
        Angle now [rad].
    since : float
        How long ago the last pose that was taken in was measured [s].

    Examples
    --------
    Half a second at 10 m/s:

    >>> from popsteer.reference.vehicle import Vehicle
    >>> from popsteer.reference.vehicle.state import VehicleState
    >>> from popsteer.reference.vehicle.estimate import Corrections
    >>> seen = VehicleState(0.0, 0.0, 0.0, 10.0)
    >>> Past.settled(0.0).advance(Vehicle(), seen, 0.5, Corrections())
    VehicleState(x=5.0, y=0.0, yaw=0.0, speed=10.0)
    """

    angles: Timed
    wheel: float
    since: float = 0.0

    @classmethod
    def settled(cls, wheel: float) -> Past:
        """Return the past of wheels that have stood at the angle `wheel` [rad] for long."""
        return cls(((wheel, MAX_POSE_AGE),), wheel)

    @classmethod
    def restore(cls, angles: Timed, wheel: float, since: float) -> Past:
        """Return a past as it was.

        Raises
        ------
        InputError
            Where there are too many angles, and as `checked`.
        """
        angles = checked_count("past_angles", angles, CAPACITY)
        return cls(angles, wheel, since).checked()

    def checked(self) -> Past:
        """Return the same, as floats, where wheels can have such a past.

        Raises
        ------
        InputError
            Where they cannot: an angle beyond a quarter turn, a duration that is negative.
        """
        wheel = input_within("past_wheel", self.wheel, 0.5 * PI)
        since = input_in_range("past_since", self.since, 0.0, MAX_SINCE)
        return Past(checked_entries("past_angles", self.angles, MAX_SINCE), wheel, since)

    def elapse(
        self, vehicle: Vehicle, commands: Iterable[tuple[float, float]], wheel: float, dt: float
    ) -> Past:
        """Let `dt` [s] pass, in which `commands` reached the wheels from the angle `wheel` [rad].

        Those in flight, and then the last one. Angles that last shorter than a 64th of
        `MAX_POSE_AGE` are joined to their mean.
        """
        past, joined = self.angles, MAX_POSE_AGE / RESOLUTION
        for steer, time in clipped(commands, dt):
            moved = move_wheel(vehicle, wheel, steer, time)
            past = push_or_join(past, moved.mean, time, joined, CAPACITY)
            wheel = moved.wheel
        return Past(past, wheel, saturate(self.since + dt, 0.0, MAX_SINCE))

    def reached(self, age: float) -> WheelIntegrals:
        """Return what the wheels did from the last pose taken in until `age` [s] ago."""
        reached = WheelIntegrals()
        for angle, time in self._between(self.since, age):
            reached = reached.plus(angle, time)
        return reached

    def advance(
        self, vehicle: Vehicle, state: VehicleState, age: float, estimate: Corrections
    ) -> VehicleState:
        """Return a vehicle that was at `state` `age` [s] ago, as it is now.

        The state is that of the no-slip point; the `estimate` corrects `vehicle`.
        """
        rollout = Rollout(vehicle, estimate, state)
        for angle, time in self._between(age, 0.0):
            rollout.turn(angle, time)
        return rollout.state

    def _between(self, start: float, end: float) -> Iterator[tuple[float, float]]:
        """Give the angles from `start` [s] ago until `end` [s] ago, and for how long each [s]."""
        ago = 0.0
        for _, duration in self.angles:
            ago += duration
        for angle, duration in self.angles:
            since = ago if ago < start else start
            ago -= duration
            time = since - (ago if ago > end else end)
            if time > 0.0:
                yield angle, time
