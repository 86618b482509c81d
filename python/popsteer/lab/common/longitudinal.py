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

if TYPE_CHECKING:
    from popsteer._core import Path, Vehicle
    from popsteer.sim.pedals import Longitudinal

__all__ = ["KINDS", "LongitudinalParams", "made", "name_of", "params_of"]

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
