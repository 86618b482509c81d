"""A vehicle in a TOML file: what `Vehicle.load` reads and `Vehicle.save` writes.

A file has one key a field, each optional, and nothing else. What it leaves out has its default;
``inf`` is no limit.

Examples
--------
>>> print(as_toml(popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35)), end="")  # doctest: +ELLIPSIS
# A vehicle, as popsteer.Vehicle.load reads it. ...
<BLANKLINE>
# Distance of the axles L [m]; the default lengths of all parameters scale with it.
wheelbase = 2.7
# How far ahead of the pose's point the rear axle lies [m]: 0 where the pose is the rear axle's,
# negative where it is of a point ahead of that.
rear_axle = -1.35
...
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from popsteer._core import Vehicle
from popsteer.errors import ConfigError
from popsteer.files import write_text_atomic
from popsteer.toml_file import check, in_file, keys, read

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping

_HEAD = """\
# A vehicle, as popsteer.Vehicle.load reads it. SI units and radians; x forward, y left, angles of
# the front wheels positive to the left. A pose is that of the vehicle's point, wherever you measure
# it. What is left out has its default.
"""

_LIMITS = ("max_steer_rate", "max_lateral_acceleration", "max_speed")
"""Fields for which None is no limit, and which a file may set to ``inf``."""


def load(file: str | os.PathLike[str]) -> Vehicle:
    """Read a vehicle from a TOML file; what it leaves out has its default.

    Raises ConfigError, which names file, key and value, where the file cannot be read or is no
    TOML, or a key is unknown, or its value of the wrong type or out of range.
    """
    fields = read(file, "vehicle file")
    check(file, fields, Vehicle().as_dict())
    unlimited = {key: None for key in _LIMITS if fields.get(key) == math.inf}
    try:
        return Vehicle(**fields | unlimited)
    except ConfigError as error:
        raise in_file(file, error) from None


def save(vehicle: Vehicle, file: str | os.PathLike[str]) -> None:
    """Write a vehicle to a TOML file, whole or not at all; raises OSError."""
    write_text_atomic(file, as_toml(vehicle))


def as_toml(vehicle: Vehicle, unknown: Mapping[str, str] | None = None) -> str:
    """Word a vehicle as the text of a TOML file, with the meaning and the unit of each field.

    `unknown` are fields that nobody has measured, and why: they get a comment, and are comments
    themselves where their value is the default. A field that is None is a comment.
    """
    return "\n".join([_HEAD, *keys(vehicle, unknown)]) + "\n"
