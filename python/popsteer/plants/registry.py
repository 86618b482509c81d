"""The plants from elsewhere by name."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Protocol

from popsteer import own
from popsteer.errors import ConfigError
from popsteer.extras import require
from popsteer.plants.protocol import PythonPlant

if TYPE_CHECKING:
    from typing_extensions import Self

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


_MODELS = ("st", "std", "mb")
_VEHICLES = (1, 2, 3)
_MUJOCO = "mujoco-car"
_COMMONROAD = re.compile(r"commonroad-(st|std|mb)-([123])")


class Configurable(PythonPlant, Protocol):
    """A plant with parameters."""

    @property
    def params(self) -> Any:  # noqa: ANN401 - each has a class of its own
        """Its parameters."""
        ...

    def with_params(self, params: Any, /) -> Self:  # noqa: ANN401
        """Give another with these parameters."""
        ...


def names() -> tuple[str, ...]:
    """Names of the plants from elsewhere, whether the extra is installed or not.

    Returns
    -------
    tuple of str
        The names that `get` knows.

    Examples
    --------
    >>> names()[-1]
    'mujoco-car'
    """
    commonroad = (f"commonroad-{model}-{vehicle}" for model in _MODELS for vehicle in _VEHICLES)
    return (*commonroad, _MUJOCO)


def is_known(name: str) -> bool:
    """Whether `get` knows a name: one of `names`, or that of a plant of your own.

    Examples
    --------
    >>> is_known("mujoco-car"), is_known("mine.py:Car"), is_known("bicycle")
    (True, True, False)
    """
    return name in names() or own.is_named("plant", name)


def get(name: str) -> Configurable:
    """Make a plant.

    Parameters
    ----------
    name : str
        One of `names`, or one of your own as `popsteer.own` has it.

    Returns
    -------
    CommonRoad or MujocoCar or OwnPlant
        A new vehicle with the default parameters.

    Raises
    ------
    ConfigError
        No plant has this name.
    PopsteerError
        The extra ``plants`` is not installed.

    Examples
    --------
    >>> get("commonroad-mb-4")
    Traceback (most recent call last):
    popsteer.errors.ConfigError: unknown plant 'commonroad-mb-4'; known: commonroad-st-1, \
commonroad-st-2, commonroad-st-3, commonroad-std-1, commonroad-std-2, commonroad-std-3, \
commonroad-mb-1, commonroad-mb-2, commonroad-mb-3, mujoco-car
    """
    if name not in names() and own.is_named("plant", name):
        return OwnPlant(name)
    if name not in names():
        raise ConfigError.unknown("plant", name, names())
    require(f"plant {name}", "plants")
    if found := _COMMONROAD.fullmatch(name):
        from popsteer.plants.commonroad import CommonRoad

        return CommonRoad(found[1], int(found[2]))
    from popsteer.plants.mujoco_car import MujocoCar

    return MujocoCar()
