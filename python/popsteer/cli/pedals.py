"""Who works the pedals of the runs that a command drives."""

from __future__ import annotations

from typing import TYPE_CHECKING

from popsteer.cli.assignments import assigned
from popsteer.errors import ConfigError
from popsteer.lab.common.longitudinal import LongitudinalParams, params_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from popsteer._core import Path

__all__ = ["longitudinal", "usual"]


def longitudinal(
    name: str | None,
    assignments: Sequence[str] | None,
    constant_speed: float | None,
    usual: str = "coupled",
) -> LongitudinalParams | None:
    """Give who works the pedals.

    Parameters
    ----------
    name : str or None
        Its name; by default `usual`.
    assignments : sequence of str or None
        ``NAME=VALUE`` each: its parameters.
    constant_speed : float or None
        The speed that is kept instead.
    usual : str, default "coupled"
        Who does where it is not said.

    Returns
    -------
    parameters or None
        Those of the controller; None where a constant speed is kept.

    Raises
    ------
    ConfigError
        No such controller or parameter is known, a value is refused, or both are given.

    Examples
    --------
    >>> longitudinal("speed-pid", ["kp=0.8"], None)
    SpeedPidParams(kp=0.8, ki=0.1, kd=0.0)
    """
    if constant_speed is not None:
        if name or assignments:
            raise ConfigError("--constant-speed", constant_speed, "given without --longitudinal")
        return None
    name = usual if name is None else name
    return assigned(params_of(name), assignments or [], name)


def usual(courses: Sequence[Path]) -> str:
    """Name who works the pedals where no option says it.

    Parameters
    ----------
    courses : sequence of Path
        What the user's own files have.

    Returns
    -------
    str
        ``speed-tracker`` where one of them has speeds, as `popsteer plan` writes them: they are
        there to be kept. Else the paper's ``coupled``.

    Examples
    --------
    >>> usual([])
    'coupled'
    """
    planned = any(course.speed is not None for course in courses)
    return "speed-tracker" if planned else "coupled"
