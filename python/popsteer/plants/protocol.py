"""What a plant in Python is."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol, runtime_checkable

if TYPE_CHECKING:
    from popsteer._core import Vehicle


class PlantState(NamedTuple):
    """What a plant reports after a control step."""

    x: float
    """Position along x of the vehicle's point [m]."""
    y: float
    """Position along y of that point [m]."""
    yaw: float
    """Heading [rad], counter-clockwise from x."""
    speed: float
    """Speed along the heading [m/s]; negative while rolling backwards."""
    yaw_rate: float
    """Yaw rate [rad/s]."""
    steer: float
    """Angle of the front wheels as they stand [rad]."""


@runtime_checkable
class PythonPlant(Protocol):
    """A vehicle written in Python, that a run may drive.

    It holds its own state. `popsteer.sim.run` and `popsteer.sim.Simulation` take such an object
    wherever they take the name of a plant.

    The closed loop applies `dead_time` and `steer_offset` of the plant's vehicle to the commands
    before `advance` is given them. Lag, limits and turning are the plant's own.
    """

    @property
    def name(self) -> str:
        """What it is called in tables and files."""
        ...

    @property
    def vehicle(self) -> Vehicle:
        """What it is, and where the point lies whose pose it reports."""
        ...

    @property
    def reverses(self) -> bool:
        """Whether it drives backwards when commanded to."""
        ...

    def reset(self, x: float, y: float, yaw: float, speed: float, /) -> None:
        """Stand, or roll, in this pose of the vehicle's point [m, m, rad] at this speed [m/s].

        Raises
        ------
        InputError
            The vehicle cannot start like that.
        """
        ...

    def advance(
        self,
        steer: float,
        throttle: float,
        brake: float,
        dt: float,
        substeps: int,
        reverse: bool,  # noqa: FBT001 - as the closed loop gives it, by place
        /,
    ) -> PlantState:
        """Move on by `substeps` steps of `dt` [s], or finer ones that take as long.

        The command stays the same meanwhile: the angle of the front wheels [rad] that is asked
        for, the pedals, 0 to 1, and whether the throttle drives backwards.

        Raises
        ------
        PlantLimit
            The model does not reach further; the run ends there.
        """
        ...


def follow(wanted: float, angle: float, fastest: float, dt: float) -> float:
    """Give the rate [rad/s] at which the wheels turn from `angle` to the `wanted` one [rad].

    The wheels take the shortest time that the limit of their rate, `fastest`, allows, and stand
    still once there: rate = saturate((wanted - angle) / dt, ±fastest), kept for `dt` [s].
    """
    return min(max((wanted - angle) / dt, -fastest), fastest)
