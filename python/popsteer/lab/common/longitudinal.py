"""Who works the pedals in an experiment, by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from popsteer._core import (
    CoupledLongitudinal,
    CoupledLongitudinalParams,
    SpeedPid,
    SpeedPidParams,
    SpeedTracker,
    SpeedTrackerParams,
)
from popsteer.errors import ConfigError
from popsteer.sim.closed_loop import at_constant_speed
from popsteer.sim.pedals import PedalMap

if TYPE_CHECKING:
    from popsteer._core import Path, Vehicle
    from popsteer.sim import Plant
    from popsteer.sim.pedals import Longitudinal

LongitudinalParams: TypeAlias = CoupledLongitudinalParams | SpeedPidParams | SpeedTrackerParams
"""Parameters of a longitudinal controller, of one class each."""
KINDS: dict[str, type[LongitudinalParams]] = {
    "coupled": CoupledLongitudinalParams,
    "speed-pid": SpeedPidParams,
    "speed-tracker": SpeedTrackerParams,
}
"""The parameters of each longitudinal controller by its name."""


def params_of(name: str) -> LongitudinalParams:
    """Give the default parameters of a longitudinal controller, one of `KINDS`.

    Raises ConfigError where none has this name.
    """
    if name not in KINDS:
        raise ConfigError.unknown("longitudinal controller", name, KINDS)
    return KINDS[name]()


def name_of(params: LongitudinalParams) -> str:
    """Give the name of the longitudinal controller that has these parameters."""
    return next(name for name, kind in KINDS.items() if isinstance(params, kind))


def made(params: LongitudinalParams | None, path: Path, vehicle: Vehicle) -> Longitudinal | None:
    """Make the longitudinal controller of a run, as `popsteer.sim.run` takes it.

    Without parameters it is None, which stands for the paper's. A `SpeedTracker` plans for the path
    and the vehicle.
    """
    if params is None:
        return None
    if isinstance(params, SpeedTrackerParams):
        return SpeedTracker(path, vehicle, params)
    return SpeedPid(params) if isinstance(params, SpeedPidParams) else CoupledLongitudinal(params)


def road(
    params: LongitudinalParams | None, path: Path, vehicle: Vehicle, constant_speed: float | None
) -> tuple[Path, Longitudinal | None]:
    """Give the path that is driven, and what works the pedals: None for those of the paper."""
    if constant_speed is None:
        return path, made(params, path, vehicle)
    return at_constant_speed(path, constant_speed)


def pedals(
    params: LongitudinalParams | None, plant: Plant, constant_speed: float | None
) -> PedalMap | None:
    """Give the pedals for accelerations where they are commanded: of the plant, unvaried."""
    planned = isinstance(params, SpeedTrackerParams) and constant_speed is None
    return PedalMap.of(plant) if planned else None
