"""What the way of a vehicle teaches about the model that predicts it.

A model's wheelbase that is wrong turns it too much or too little, by the same factor always; a dead
time that is wrong turns it too early or too late. Both are found by least squares: how much of the
turns that the model expects is measured, and how much of the change of these turns is left over.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeAlias

from popsteer.reference.error import input_in_range
from popsteer.reference.math import exp, saturate, wrap
from popsteer.reference.path.view import MAX_SPEED
from popsteer.reference.vehicle.state import MAX_YAW

if TYPE_CHECKING:
    from popsteer.reference.vehicle.state import VehicleState

__all__ = ["Learnt", "Lesson"]

ACCELERATION_TIME = 0.1
"""Time over which the acceleration is taken [s]."""
MAX_ACCELERATION = 20.0
"""The largest acceleration that is believed [m/s²]."""
OF_TURNS = 1e-3
"""Evidence as sure as the model is of itself: squares of turns [rad²]."""
OF_CHANGES = 1e-2
"""The same of the rates of their change [rad²/s²]."""
MAX_SUM = 1e100
"""More than the sums come to within the bounds of the input."""
MAX_TURN = 1e30
"""More than a turn comes to, and little enough that the squares of its changes keep to that."""

Lesson: TypeAlias = tuple[float, float, float, float, float, float]
"""The numbers of `Learnt` after `seen`, in their order."""


@dataclass(frozen=True, kw_only=True)
class Learnt:
    """What a prediction has learnt, and what it needs to learn on.

    Attributes
    ----------
    seen : tuple of float or None
        Heading [rad] and speed [m/s] at the last step; None before the first.
    acceleration : float
        Acceleration [m/s²].
    expected : float
        Squares of the turns that the model expected, the old ones forgotten [rad²].
    measured : float
        The same turns times those that were measured [rad²].
    turn : float
        The turn expected for the last step [rad].
    change : float
        Squares of the rates at which such turns changed, the old ones forgotten [rad²/s²].
    delay : float
        How much longer the dead time is than the actuator says [s].

    Examples
    --------
    >>> Learnt(expected=0.099, measured=0.119).gain()
    1.2
    """

    seen: tuple[float, float] | None = None
    acceleration: float = 0.0
    expected: float = 0.0
    measured: float = 0.0
    turn: float = 0.0
    change: float = 0.0
    delay: float = 0.0

    @classmethod
    def of(cls, seen: tuple[float, float] | None, lesson: Lesson) -> Learnt:
        """Put together what a state remembers apart."""
        acceleration, expected, measured, turn, change, delay = lesson
        return cls(
            seen=seen,
            acceleration=acceleration,
            expected=expected,
            measured=measured,
            turn=turn,
            change=change,
            delay=delay,
        )

    @property
    def lesson(self) -> Lesson:
        """All but `seen`."""
        return (
            self.acceleration,
            self.expected,
            self.measured,
            self.turn,
            self.change,
            self.delay,
        )

    def gain(self) -> float:
        """Tell how many times more the vehicle turns than the model says, a half to twice."""
        return saturate((self.measured + OF_TURNS) / (self.expected + OF_TURNS), 0.5, 2.0)

    def speed_after(self, speed: float, time: float) -> float:
        """Return the speed `time` [s] on from `speed` [m/s]; a vehicle that brakes stops."""
        following = speed + self.acceleration * time
        if speed >= 0.0:
            return saturate(following, 0.0, MAX_SPEED)
        return saturate(following, -MAX_SPEED, 0.0)

    def after(
        self, vehicle: VehicleState, turn: float, dt: float, time: float, most_delay: float
    ) -> Learnt:
        """Learn that `vehicle` is seen `dt` [s] after a step for which `turn` [rad] was expected.

        The old counts for less by exp(-dt / time); the delay stays within `most_delay` [s], and
        moves by no more than `dt`. No sample counts for more than a turn thrice as large as
        expected, or the longest delay: a jump of the localisation is no lesson.
        """
        following = replace(self, seen=(vehicle.yaw, vehicle.speed), turn=turn)
        if self.seen is None:
            return following
        yaw, speed = self.seen
        kept = exp(-dt / time)
        error = wrap(vehicle.yaw - yaw) - turn
        most = 2.0 * abs(turn)
        following = replace(
            following,
            expected=self.expected * kept + turn * turn,
            measured=self.measured * kept + turn * (turn + saturate(error, -most, most)),
        )

        change = (self.turn - turn) / dt
        left = error + (1.0 - following.gain()) * turn
        most = abs(change) * most_delay
        changes = self.change * kept + change * change
        late = saturate(left, -most, most) * change / (changes + OF_CHANGES)
        late = saturate(late, -dt, dt)
        delay = saturate(self.delay + late, -most_delay, most_delay)

        weight = 1.0 - exp(-dt / ACCELERATION_TIME)
        gained = (vehicle.speed - speed) / dt - self.acceleration
        most = MAX_ACCELERATION
        acceleration = saturate(self.acceleration + weight * gained, -most, most)
        return replace(following, change=changes, delay=delay, acceleration=acceleration)

    def checked(self, most_delay: float) -> Learnt:
        """Return what was learnt, where it could be so with delays of up to `most_delay` [s].

        Raises
        ------
        InputError
            Naming `seen` or `learnt`.
        """
        seen = None
        if self.seen is not None:
            yaw, speed = self.seen
            seen = (
                input_in_range("seen", yaw, -MAX_YAW, MAX_YAW),
                input_in_range("seen", speed, -MAX_SPEED, MAX_SPEED),
            )
        bounds = (
            (self.acceleration, -MAX_ACCELERATION, MAX_ACCELERATION),
            (self.expected, 0.0, MAX_SUM),
            (self.measured, -MAX_SUM, MAX_SUM),
            (self.turn, -MAX_TURN, MAX_TURN),
            (self.change, 0.0, MAX_SUM),
            (self.delay, -most_delay, most_delay),
        )
        acceleration, expected, measured, turn, change, delay = (
            input_in_range("learnt", value, low, high) for value, low, high in bounds
        )
        return Learnt.of(seen, (acceleration, expected, measured, turn, change, delay))
