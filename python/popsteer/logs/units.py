"""Units of the columns of a log, as options name them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from popsteer.logs.log import LogError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

UNITS: dict[str, dict[str, float]] = {
    "t": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "x": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "y": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "yaw": {
        "rad": 1.0,
        "deg": math.pi / 180.0,
        "rad-north": -1.0,
        "deg-north": -math.pi / 180.0,
    },
    "speed": {"m/s": 1.0, "km/h": 1.0 / 3.6, "mph": 0.44704, "kn": 1852.0 / 3600.0, "cm/s": 1e-2},
    "steer": {"rad": 1.0, "deg": math.pi / 180.0},
    "throttle": {"1": 1.0, "%": 1e-2},
    "brake": {"1": 1.0, "%": 1e-2},
    "acceleration_command": {"m/s²": 1.0, "g": 9.80665},
    "speed_command": {"m/s": 1.0, "km/h": 1.0 / 3.6, "mph": 0.44704},
    "z": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
}
"""What each column may be measured in, and what one of it is in the unit of popsteer. Those of a
heading from north are clockwise, with x to the east."""


def converted(column: str, unit: str, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bring the values of a column into popsteer's unit; LogError where the unit is not known.

    Examples
    --------
    >>> import numpy as np
    >>> np.degrees(converted("yaw", "deg-north", np.array([90.0, 30.0]))).round(9).tolist()
    [0.0, 60.0]
    """
    east = 0.5 * math.pi if unit.endswith("-north") else 0.0
    return east + factor(column, unit) * values


def factor(column: str, unit: str) -> float:
    """Give what a number in a unit is to be multiplied by.

    `column` is one of `COLUMNS`, `unit` one of `UNITS`, a number, or either of them over a number:
    ``deg/15.5`` for the hand wheel's angle with a ratio of 15.5. A minus before it turns the sign.
    Raises LogError where one is not known.

    Examples
    --------
    >>> factor("speed", "km/h") == 1 / 3.6, factor("steer", "-1"), factor("steer", "rad/20")
    (True, -1.0, 0.05)
    """
    if column not in UNITS:
        raise LogError(f"unknown column {column!r}; known: {', '.join(UNITS)}")
    known = UNITS[column]
    if unit in known:
        return known[unit]
    sign, text = (-1.0, unit[1:]) if unit.startswith("-") else (1.0, unit)
    name, _, ratio = text.partition("/") if text not in known else (text, "", "")
    try:
        size = known[name] if name in known else float(name)
        found = sign * size / (float(ratio) if ratio else 1.0)
    except (ValueError, ZeroDivisionError):
        found = 0.0
    if not math.isfinite(found) or found == 0.0:
        raise LogError(
            f"unit of {column} must be {', '.join(known)}, a number, or one of them over a number,"
            f" got {unit!r}"
        )
    return found
