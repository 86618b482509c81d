"""The plants from elsewhere by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from popsteer import own
from popsteer.errors import ConfigError
from popsteer.extras import require
from popsteer.plants.protocol import Varied
from popsteer.ranges import check_known

if TYPE_CHECKING:
    from popsteer.parameters import Parameters
    from popsteer.plants.commonroad import CommonRoad
    from popsteer.plants.mujoco_car import MujocoCar

ASKED = ("name", "vehicle", "reverses", "reset", "advance")
"""What a plant has."""


class OwnPlant(Varied):
    """A plant that `popsteer.own.load` finds, with parameters and steering that can vary.

    Raises ConfigError where there is nothing of this name, or it is no plant, and OwnCodeError
    where its code raises.
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
        self.name, self._of = name, (name,)
        self.params = own.params_of(kind)() if params is None else params
        try:
            plant = own.called(kind, params=self.params)
        except Exception as error:
            raise own.OwnCodeError(name, error) from error
        if lacking := [asked for asked in ASKED if not hasattr(plant, asked)]:
            raise ConfigError("plant", name, f"a plant, which has {', '.join(lacking)}")
        self.vehicle = plant.vehicle
        given = {"dead_time": dead_time, "steer_offset": steer_offset}
        if changed := {k: v for k, v in given.items() if v is not None}:
            self.vehicle = self.vehicle.replace(**changed)
        self.reverses: bool = plant.reverses
        self.reset: Any = plant.reset
        self.advance: Any = plant.advance


_ELSEWHERE = (
    *(f"commonroad-{model}-{vehicle}" for model in ("st", "std", "mb") for vehicle in (1, 2, 3)),
    "mujoco-car",
)


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
    return _ELSEWHERE


def is_known(name: str) -> bool:
    """Whether `get` knows a name: one of `names`, or that of a plant of your own.

    Examples
    --------
    >>> is_known("mujoco-car"), is_known("mine.py:Car"), is_known("bicycle")
    (True, True, False)
    """
    return name in _ELSEWHERE or own.is_named("plant", name)


def get(name: str) -> CommonRoad | MujocoCar | OwnPlant:
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
    if name not in _ELSEWHERE and own.is_named("plant", name):
        return OwnPlant(name)
    check_known("plant", name, _ELSEWHERE)
    require(f"plant {name}", "plants")
    if name != "mujoco-car":
        from popsteer.plants.commonroad import CommonRoad

        _, model, vehicle = name.split("-")
        return CommonRoad(model, int(vehicle))
    from popsteer.plants.mujoco_car import MujocoCar

    return MujocoCar()
