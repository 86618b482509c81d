"""Units of the columns of a log, as options name them."""

from __future__ import annotations

from popsteer.errors import PopsteerError, unknown
from popsteer.logs.log import COLUMNS, SIGNALS, LogError
from popsteer.tables.quantities import factor as _factor
from popsteer.tables.quantities import spelled

UNITS = {column: spelled(column) for column in COLUMNS + SIGNALS}
"""What each column may be measured in, one spelling of each. Those of a heading from north are
clockwise, with x to the east."""


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
