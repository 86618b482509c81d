"""Units of the columns of a log, as options name them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from popsteer.errors import PopsteerError, unknown
from popsteer.logs.log import COLUMNS, SIGNALS, LogError
from popsteer.tables.quantities import factor as _factor
from popsteer.tables.quantities import spelled

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

UNITS = {column: spelled(column) for column in COLUMNS + SIGNALS}
"""What each column may be measured in, one spelling of each. Those of a heading from north are
clockwise, with x to the east."""


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
    """Give what a number in a unit is multiplied by, as `popsteer.tables.quantities.factor`.

    `column` is one of `UNITS`. Raises LogError where one is not known.

    Examples
    --------
    >>> factor("speed", "km/h") == 1 / 3.6, factor("steer", "-1"), factor("steer", "rad/20")
    (True, -1.0, 0.05)
    """
    if column not in UNITS:
        raise LogError(unknown("column", column, UNITS))
    try:
        return _factor(column, unit)
    except PopsteerError as error:
        raise LogError(str(error)) from None
