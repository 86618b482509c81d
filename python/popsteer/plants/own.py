"""A plant of your own, by its name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from popsteer import own
from popsteer.errors import ConfigError

if TYPE_CHECKING:
    from popsteer._core import Vehicle
    from popsteer.parameters import Parameters
    from popsteer.plants.protocol import PlantState

ASKED = ("name", "vehicle", "reverses", "reset", "advance")
"""What a plant has."""


class OwnPlant:
    """A plant that `popsteer.own.load` finds, with parameters and steering that can vary.

    `dead_time` and `steer_offset` are what the closed loop adds [s, rad]; that of its vehicle by
    default. Raises ConfigError where there is nothing of this name, or it is no plant, and
    OwnCodeError where its code raises.
    """

    def __init__(
        self,
        name: str,
        params: Parameters | None = None,
        *,
        dead_time: float | None = None,
        steer_offset: float | None = None,
    ) -> None:
        kind = own.load("plant", name)
        self.name = name
        self.params = own.params_of(kind)() if params is None else params
        try:
            self._plant: Any = own.called(kind, params=self.params)
        except Exception as error:
            raise own.OwnCodeError(name, error) from error
        if lacking := [asked for asked in ASKED if not hasattr(self._plant, asked)]:
            raise ConfigError("plant", name, f"a plant, which has {', '.join(lacking)}")
        self.vehicle: Vehicle = self._plant.vehicle
        given = {"dead_time": dead_time, "steer_offset": steer_offset}
        if changed := {k: v for k, v in given.items() if v is not None}:
            self.vehicle = self.vehicle.replace(**changed)
        self.reverses: bool = self._plant.reverses

    def with_params(self, params: Parameters) -> OwnPlant:
        """Give the same plant with other parameters."""
        dead_time, offset = self.vehicle.dead_time, self.vehicle.steer_offset
        return OwnPlant(self.name, params, dead_time=dead_time, steer_offset=offset)

    def with_steering(self, *, dead_time: float, steer_offset: float) -> OwnPlant:
        """Give the same plant with another dead time [s] and steering offset [rad]."""
        return OwnPlant(self.name, self.params, dead_time=dead_time, steer_offset=steer_offset)

    def reset(self, x: float, y: float, yaw: float, speed: float, /) -> None:
        """Stand, or roll, in this pose, as `PythonPlant.reset`."""
        self._plant.reset(x, y, yaw, speed)

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
        """Move on, as `PythonPlant.advance`."""
        state: PlantState = self._plant.advance(steer, throttle, brake, dt, substeps, reverse)
        return state
