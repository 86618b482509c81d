"""The controllers by name: the one list that presets, comparisons and the command line share.

Examples
--------
>>> from popsteer import controllers
>>> controllers.names()
('pid', 'pure-pursuit', 'stanley', 'pop', 'preview-pop')
>>> controllers.get("pop").controller
<class 'popsteer.Pop'>
"""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias

from popsteer._core import (
    Pid,
    PidParams,
    Pop,
    PopParams,
    PreviewPop,
    PreviewPopParams,
    PurePursuit,
    PurePursuitParams,
    Stanley,
    StanleyParams,
)
from popsteer.ranges import check_known

__all__ = ["CONTROLLERS", "Controller", "Law", "Params", "get", "name_of", "names"]

Controller: TypeAlias = Pop | PreviewPop | Pid | PurePursuit | Stanley
"""A controller of popsteer, with its state, its path and its vehicle."""
Params: TypeAlias = PopParams | PreviewPopParams | PidParams | PurePursuitParams | StanleyParams
"""The parameters of a controller of popsteer."""
CONTROLLERS = (Pop, PreviewPop, Pid, PurePursuit, Stanley)
"""The classes of `Controller`, as `isinstance` takes them."""


class Law(NamedTuple):
    """What is to be known about a controller by those who deal with any of them."""

    name: str
    """Name on the command line and in files."""
    title: str
    """Name as a person reads it, in tables and figures."""
    controller: type[Controller]
    """The class that steers."""
    params: type[Params]
    """The class of its parameters."""
    axle: Literal["front", "rear", "no-slip"]
    """The tracked point; "no-slip" is the point that moves along the vehicle's heading."""


_LAWS = {
    law.name: law
    for law in (
        Law("pid", "PID", Pid, PidParams, "front"),
        Law("pure-pursuit", "Pure-Pursuit", PurePursuit, PurePursuitParams, "rear"),
        Law("stanley", "Stanley", Stanley, StanleyParams, "front"),
        Law("pop", "POP", Pop, PopParams, "front"),
        Law("preview-pop", "Preview POP", PreviewPop, PreviewPopParams, "no-slip"),
    )
}


def names() -> tuple[str, ...]:
    """Names of the controllers, from the plainest to preview POP.

    Returns
    -------
    tuple of str
        The names that `get` knows.

    Examples
    --------
    >>> names()
    ('pid', 'pure-pursuit', 'stanley', 'pop', 'preview-pop')
    """
    return tuple(_LAWS)


def get(name: str) -> Law:
    """Give a controller by its name.

    Parameters
    ----------
    name : str
        One of `names`.

    Returns
    -------
    Law
        Its classes, its title and its axle.

    Raises
    ------
    ConfigError
        No controller has this name.

    Examples
    --------
    >>> get("pure-pursuit").axle
    'rear'
    >>> get("lqr")
    Traceback (most recent call last):
    popsteer.errors.ConfigError: unknown controller 'lqr'; known: pid, pure-pursuit, \
stanley, pop, preview-pop
    """
    check_known("controller", name, _LAWS)
    return _LAWS[name]


def name_of(kind: type[object]) -> str:
    """Name of the controller of a class, or of a class of parameters.

    Parameters
    ----------
    kind : type
        One of the classes of `Controller` or `Params`.

    Returns
    -------
    str
        One of `names`.

    Raises
    ------
    TypeError
        The class belongs to no controller of popsteer.

    Examples
    --------
    >>> name_of(PurePursuit), name_of(PopParams)
    ('pure-pursuit', 'pop')
    """
    for law in _LAWS.values():
        if kind in (law.controller, law.params):
            return law.name
    raise TypeError(f"{kind.__name__} belongs to no controller of popsteer")
