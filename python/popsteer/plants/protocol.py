"""What a plant in Python is."""

from __future__ import annotations

from typing import NamedTuple, Protocol, runtime_checkable

__all__ = ["Geometry", "PlantState", "PythonPlant", "follow"]


class Geometry(NamedTuple):
    """Where the axles lie ahead of the point whose pose the laws are given."""

    front_offset: float
    """Front axle ahead of that point [m]."""
    rear_offset: float
    """Rear axle ahead of that point [m]; negative behind it."""
    wheelbase: float
    """Distance of the axles, as the laws take it [m]."""


class PlantState(NamedTuple):
    """What a plant reports after a control step."""

    x: float
    """Position along x of the point whose pose the laws are given [m]."""
    y: float
    """Position along y of that point [m]."""
    yaw: float
    """Heading [rad], counter-clockwise from x."""
    speed: float
    """Speed along the heading [m/s]."""
    yaw_rate: float
    """Yaw rate [rad/s]."""
    steer: float
    """Angle of the front wheels as they stand [rad]."""


@runtime_checkable
class PythonPlant(Protocol):
    """A vehicle written in Python, that a run may drive.

    It holds its own state. `popsteer.sim.run` and `popsteer.sim.Simulation` take such an object
    wherever they take the name of a plant.
    """

    @property
    def name(self) -> str:
        """What it is called in tables and files."""
        ...

    @property
    def geometry(self) -> Geometry:
        """Where its axles lie."""
        ...

    def reset(self, x: float, y: float, yaw: float, speed: float, /) -> None:
        """Stand, or roll, in this pose [m, m, rad] at this speed [m/s].

        Raises
        ------
        InputError
            The vehicle cannot start like that.
        """
        ...

    def advance(
        self, steer: float, throttle: float, brake: float, dt: float, substeps: int, /
    ) -> PlantState:
        """Move on by `substeps` steps of `dt` [s], or finer ones that take as long.

        The command stays the same meanwhile: the angle of the front wheels [rad] that is asked
        for, and the pedals, 0 to 1.

        Raises
        ------
        PlantLimit
            The model does not reach further; the run ends there.
        """
        ...


def follow(wanted: float, angle: float, fastest: float, dt: float) -> float:
    """Give the rate at which the wheels turn towards the angle that is asked for.

    The wheels take the shortest time that the limit of their rate allows, and stand still once
    there: rate = saturate((wanted - angle) / dt, ±fastest).

    Parameters
    ----------
    wanted : float
        Angle asked for [rad].
    angle : float
        Angle of the wheels [rad].
    fastest : float
        Limit of the rate [rad/s].
    dt : float
        Time for which the rate will be kept [s].

    Returns
    -------
    float
        Rate [rad/s].

    Examples
    --------
    >>> follow(0.5, 0.0, 0.4, 0.005), follow(0.001, 0.0, 0.4, 0.005)
    (0.4, 0.2)
    """
    return min(max((wanted - angle) / dt, -fastest), fastest)
