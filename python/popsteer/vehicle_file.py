"""A vehicle in a TOML file: what `Vehicle.load` reads and `Vehicle.save` writes.

A file has one key a field, each optional, and a table ``[pedals]``, which is for
`popsteer.sim.PedalMap.load`. What it leaves out has its default; ``inf`` is no limit.

Examples
--------
>>> print(as_toml(popsteer.Vehicle(wheelbase=2.7, rear_axle=-1.35)), end="")  # doctest: +ELLIPSIS
# A vehicle, as popsteer.Vehicle.load reads it. ...
<BLANKLINE>
# Distance of the axles L [m]; the default lengths of all parameters scale with it.
wheelbase = 2.7
# Width over all [m]: how far beside its path is too far scales with it. Absent if it is two thirds
# of the wheelbase, as of a car.
# width =
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
    fields.pop("pedals", None)
    check(file, fields, Vehicle().as_dict())
    unlimited = {key: None for key in _LIMITS if fields.get(key) == math.inf}
    try:
        return Vehicle(**fields | unlimited)
    except ConfigError as error:
        raise in_file(file, error) from None


def save(vehicle: Vehicle, file: str | os.PathLike[str]) -> None:
    """Write a vehicle to a TOML file, whole or not at all; raises OSError."""
    write_text_atomic(file, as_toml(vehicle))


def as_toml(
    vehicle: Vehicle,
    unknown: Mapping[str, str] | None = None,
    said: Mapping[str, str] | None = None,
    pedals: Mapping[str, tuple[float, str]] | None = None,
) -> str:
    """Word a vehicle as the text of a TOML file, with the meaning and the unit of each field.

    `unknown` are fields that nobody has measured, and why: they get a comment, and are comments
    themselves where their value is the default. A field that is None is a comment. Where it is
    `said` of some how well they are known, the others are said to be given, or default, which is a
    comment. `pedals` are the numbers of a map of pedals, and what is said of them.
    """
    lines = [_HEAD, *keys(vehicle, unknown, said)]
    if pedals:
        lines += ["", "# What the pedals do, as popsteer.sim.PedalMap.load reads it.", "[pedals]"]
        lines += [f"{name} = {value!r}  # {words}" for name, (value, words) in pedals.items()]
    return "\n".join(lines) + "\n"


def defaults(
    file: str | os.PathLike[str], speed: float, turning: float = 0.0, *, stops: bool = False
) -> list[str]:
    """Name what a file leaves at its default and what a drive of a speed [m/s] hangs on.

    The wheelbase always matters, `understeer` where 0.003 s²/m, that of a car, is 3 % of it, the
    delay where the vehicle drives 0.1 wheelbases in the meantime, the limit of the rate where the
    wheels are asked for a `turning` of 0.3 rad/s, which slow ones do not reach; those of the drive
    matter where it `stops`.
    """
    there, car = read(file, "vehicle file"), load(file)
    matter = ["wheelbase", *(("drive_delay", "drive_lag") if stops else ())]
    if speed * 0.2 > 0.1 * car.wheelbase:
        matter += ["dead_time", "steer_lag"]
    if 0.003 * speed * speed > 0.03 * car.wheelbase:
        matter.append("understeer")
    if turning > 0.3:
        matter.append("max_steer_rate")
    return [name for name in Vehicle().as_dict() if name in matter and name not in there]
