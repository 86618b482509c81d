"""What a step is told beside pose and speed: the angle that was really applied, the pose's age."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from popsteer.reference.error import input_in_range, input_within
from popsteer.reference.math import PI
from popsteer.reference.vehicle.past import MAX_POSE_AGE

if TYPE_CHECKING:
    from popsteer.reference.vehicle import Vehicle

__all__ = ["Reported"]


class Reported(NamedTuple):
    """The optional inputs of a step, besides pose and speed.

    Examples
    --------
    >>> from popsteer.reference.vehicle import Vehicle
    >>> Reported(1.3).checked(Vehicle(max_steer=0.6))
    Reported(applied_steer=0.6, pose_age=0.0)
    """

    applied_steer: float | None = None
    """The angle that was applied since the last step in place of the commanded one [rad]."""
    pose_age: float = 0.0
    """How long before the step pose and speed were measured [s]."""

    def checked(self, vehicle: Vehicle) -> Reported:
        """Return the same, within what `vehicle` can have done.

        An angle up to a quarter turn counts as the nearest one within `max_steer`.

        Raises
        ------
        InputError
            Naming the number that is not finite or beyond its bound.
        """
        applied = self.applied_steer
        if applied is not None:
            applied = _checked_steer(vehicle, applied)
        return Reported(applied, input_in_range("pose_age", self.pose_age, 0.0, MAX_POSE_AGE))


def _checked_steer(vehicle: Vehicle, steer: float) -> float:
    limit = 0.5 * PI
    return vehicle.at_wheels(input_within("applied_steer", steer, limit))
