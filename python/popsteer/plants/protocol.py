"""What a plant in Python is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

from popsteer._core import Vehicle

if TYPE_CHECKING:
    from typing_extensions import Self


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


class Varied:
    """What plants share whose parameters and steering can vary."""

    vehicle: Vehicle
    params: Any
    _of: tuple[object, ...] = ()
    """What such a plant is made of, before its parameters."""

    def with_params(self, params: Any) -> Self:  # noqa: ANN401 - each has a class of its own
        """Give the same plant with other parameters."""
        car = self.vehicle
        return self._made(params, dead_time=car.dead_time, steer_offset=car.steer_offset)

    def with_steering(self, *, dead_time: float, steer_offset: float) -> Self:
        """Give the same plant with another dead time [s] and steering offset [rad]."""
        return self._made(self.params, dead_time=dead_time, steer_offset=steer_offset)

    def _made(self, params: object, **steering: float) -> Self:
        return type(self)(*self._of, params, **steering)  # type: ignore[call-arg]


def follow(wanted: float, angle: float, fastest: float, dt: float) -> float:
    """Give the rate [rad/s] at which the wheels turn from `angle` to the `wanted` one [rad].

    The wheels take the shortest time that the limit of their rate, `fastest`, allows, and stand
    still once there: rate = saturate((wanted - angle) / dt, ±fastest), kept for `dt` [s].
    """
    return min(max((wanted - angle) / dt, -fastest), fastest)


STEER_LAG = 0.1
"""Lag of the wheels that a plant from elsewhere is taken to have [s]: nothing is fitted to it."""
GRIP_SHARE = 0.8
"""Share of the tyres' grip that a command may ask for: a bend must leave some for the way back."""
OVERTURNING_SHARE = 0.71
"""Share of g T / (2 h), at which a rigid vehicle lifts its inner wheels. Its body rolls, and
braking shifts the load: on circuits with 4 m/s² of braking wheels lift from 0.75 of it on."""


def published(*, grip: float, overturning: float, **fields: Any) -> Vehicle:  # noqa: ANN401
    """Give a vehicle of published `fields`, whose pose is that of the middle of its rear axle.

    Its lateral acceleration [m/s²] is `GRIP_SHARE` of the tyres' `grip`, but at most
    `OVERTURNING_SHARE` of that which lifts the inner wheels of a rigid vehicle.
    """
    return Vehicle(
        # On ice without any grip at all nothing may be asked for; the vehicle wants a number.
        max_lateral_acceleration=max(min(GRIP_SHARE * grip, OVERTURNING_SHARE * overturning), 1e-3),
        steer_lag=STEER_LAG,
        **fields,
    )
