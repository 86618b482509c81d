"""Numbers and logarithmic axes of the figures of a page."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable

_MANY = 2.5  # decades from which on 2 and 5 are left out


def rounded(values: Iterable[float], digits: int = 4) -> list[float]:
    """Round numbers to as many digits as can be seen, which keeps a page small."""
    return [float(f"{value:.{digits}g}") for value in values]


def log_axis(title: str, low: float, high: float) -> dict[str, Any]:
    """Describe a logarithmic axis from `low` to `high` for plotly.

    It has marks at 1, 2 and 5 of each decade, or at 1 alone where there are many.
    """
    steps = (1,) if math.log10(high / low) > _MANY else (1, 2, 5)
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    marks = [step * 10.0**power for power in range(first, last + 1) for step in steps]
    marks = [float(f"{mark:.1g}") for mark in marks if 0.999 * low <= mark <= 1.001 * high]
    axis: dict[str, Any] = {"type": "log", "title": {"text": title}}
    if len(marks) > 1:
        axis |= {"tickvals": marks, "ticktext": [f"{mark:g}" for mark in marks]}
    return axis
