"""Controllers that others would use, to compare with; they drive like one of your own.

``mpc``
    The model-predictive controller `popsteer.lab.opponents.mpc.Mpc`, on daqp. It needs the extra
    ``mpc``.

Examples
--------
>>> from popsteer.lab import baselines
>>> baselines.names()
('mpc',)
>>> baselines.get("mpc").title
'MPC'
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple, NoReturn

from popsteer import Path, Vehicle, own
from popsteer.errors import ConfigError
from popsteer.extras import MissingExtra
from popsteer.lab.opponents.mpc import Mpc
from popsteer.ranges import check_known
from popsteer.sim.steering import OwnSimpleController

__all__ = ["Baseline", "get", "names"]


class Baseline(NamedTuple):
    """What is to be known about a baseline by those who deal with any of them."""

    name: str
    """Name on the command line and in files."""
    title: str
    """Name as a person reads it, in tables and figures."""
    params: type[Any]
    """The class of its parameters."""
    controller: Callable[[Path, Vehicle | None, Any], OwnSimpleController]
    """Makes what steers, of path, vehicle and parameters; without a vehicle, of the plant's."""


class _Broken:
    def __init__(self, name: str, error: Exception) -> None:
        self.name, self._error = name, error

    def step(self, *_: float) -> NoReturn:
        """Raise what the constructor raised."""
        raise self._error


def _own(
    name: str, kind: Any, path: Path, vehicle: Vehicle | None, params: Any
) -> OwnSimpleController:
    try:
        made: OwnSimpleController = own.called(kind, path, vehicle, params=params)
    except MissingExtra:
        raise
    except Exception as error:  # noqa: BLE001 - anything can be raised there
        return _Broken(own.title(name), error)
    if not callable(getattr(made, "step", None)):
        raise ConfigError("controller", name, "one with a method step(x, y, yaw, speed, dt)")
    return made


_BASELINES = {"mpc": ("MPC", Mpc)}


def names() -> tuple[str, ...]:
    """Name the baselines, whether their extras are installed or not."""
    return tuple(_BASELINES)


def get(name: str) -> Baseline:
    """Give a baseline by its name: its title, its parameters, and what makes it.

    A name may be that of a controller of your own, as `popsteer.own` has it. Raises ConfigError
    where nothing has this name, and OwnCodeError where loading it raises. What its constructor
    raises, the first step of the controller raises.
    """
    if name not in names() and own.is_named("controller", name):
        title, kind = own.title(name), own.load("controller", name)
    else:
        check_known("baseline", name, _BASELINES)
        title, kind = _BASELINES[name]
    return Baseline(name, title, own.params_of(kind), partial(_own, name, kind))
