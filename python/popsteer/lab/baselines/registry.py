"""The baselines by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from popsteer.errors import ConfigError
from popsteer.extras import require
from popsteer.lab.baselines.mpc_params import MpcParams

if TYPE_CHECKING:
    from collections.abc import Callable

    from popsteer import Path, Vehicle
    from popsteer.sim.steering import OwnSimpleController

__all__ = ["Baseline", "get", "names"]


class Baseline(NamedTuple):
    """What is to be known about a baseline by those who deal with any of them."""

    name: str
    """Name on the command line and in files."""
    title: str
    """Name as a person reads it, in tables and figures."""
    params: type[MpcParams]
    """The class of its parameters."""
    controller: Callable[[Path, Vehicle | None, MpcParams | None], OwnSimpleController]
    """Makes what steers, of path, vehicle and parameters; without a vehicle, of the plant's."""


def _mpc(
    path: Path, vehicle: Vehicle | None = None, params: MpcParams | None = None
) -> OwnSimpleController:
    require("controller mpc", "mpc")
    from popsteer.lab.baselines.mpc import Mpc

    return Mpc(path, vehicle, params)


_BASELINES = {"mpc": Baseline("mpc", "MPC", MpcParams, _mpc)}


def names() -> tuple[str, ...]:
    """Name the baselines, whether their extras are installed or not.

    Examples
    --------
    >>> names()
    ('mpc',)
    """
    return tuple(_BASELINES)


def get(name: str) -> Baseline:
    """Give a baseline by its name: its title, its parameters, and what makes it.

    Raises ConfigError where no baseline has this name.

    Examples
    --------
    >>> get("mpc").params().stages
    20
    """
    if name not in names():
        raise ConfigError.unknown("baseline", name, names())
    return _BASELINES[name]
